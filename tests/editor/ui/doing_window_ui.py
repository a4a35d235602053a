"""What an artist does, done in the real window, one picture a step, to be looked at: selecting, gizmos, many at once,
hanging elsewhere, isolating, measuring, comparing, look-dev, assets, palette, keys, layouts.

`doing_window_ui.py FOLDER [--only select,compare]`: works on a small project that it writes. Pictures:
FOLDER/NN-step.png.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support"), str(ROOT / "tests" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
from imgui_bundle import imgui  # noqa: E402  (needs the path above)
from PIL import Image  # noqa: E402  (needs the path above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)
from window_run import WindowRun  # noqa: E402  (needs the path above)

from editor.baking import surroundings_waiting  # noqa: E402  (needs the path above)
from editor.camera_controls import project  # noqa: E402  (needs the path above)
from editor.panels.viewport import ViewportPanel  # noqa: E402  (needs the path above)


class Doing:
    """A run with shorthands for hands: `op` an operation, `point` a place in the picture, `drag`, `click`, `key`."""

    def __init__(self, run: WindowRun) -> None:
        self.run, self.ctx, self.session = run, run.ctx, run.session
        #: what the steps found out, for the test
        self.seen: dict[str, Any] = {}

    @property
    def document(self) -> Any:
        assert self.session.document is not None
        return self.session.document

    def op(self, id: str, **arguments: Any) -> None:
        self.run.do(lambda: self.run.app.ui.operations.run(id, self.session, **arguments))
        self.ctx.yield_(3)

    def point(self, row: int, x: float = 0.0, y: float = 0.0) -> Any:
        """The window position of a node, moved by shares of the picture's width."""
        left, top, width, height = self.run.app.panel(ViewportPanel).area
        place = self.document.runtime.scene.nodes.world_matrix(row)[:3, 3]
        pixels, _depth = project(self.session.camera, place[None], width, height)
        return imgui.ImVec2(left + float(pixels[0, 0]) + x * width, top + float(pixels[0, 1]) + y * width)

    def drag(self, start: Any, end: Any) -> None:
        self.ctx.mouse_move_to_pos(start)
        self.ctx.yield_(4)
        self.ctx.mouse_down(0)
        self.ctx.yield_(2)
        for share in (0.3, 0.7, 1.0):
            self.ctx.mouse_move_to_pos(
                imgui.ImVec2(start.x + share * (end.x - start.x), start.y + share * (end.y - start.y))
            )
            self.ctx.yield_(2)

    def drop(self) -> None:
        self.ctx.mouse_up(0)
        self.ctx.yield_(3)

    def click(self, where: Any) -> None:
        self.ctx.mouse_move_to_pos(where)
        self.ctx.yield_(2)
        self.ctx.mouse_click(0)
        self.ctx.yield_(4)

    def away(self) -> None:
        self.ctx.mouse_move_to_pos(imgui.ImVec2(4, 4))
        self.ctx.yield_(2)

    def show(self, title: str) -> None:
        self.session.ui.focus_panel = title
        self.ctx.yield_(5)


def select(do: Doing) -> None:
    """A click, a box, what lies behind, a gizmo that snaps, many at once."""
    do.click(do.point(2, 0.0, -0.01))
    do.seen["clicked"] = do.session.node_name(do.document.primary)
    do.run.shot("clicked")
    left, top, width, height = do.run.app.panel(ViewportPanel).area
    do.drag(imgui.ImVec2(left + 6, top + 6), imgui.ImVec2(left + width - 6, top + height - 6))
    do.run.shot("box")
    do.drop()
    do.seen["boxed"] = len(do.document.selection)
    do.ctx.key_down(imgui.Key.mod_alt)
    do.click(do.point(2, 0.0, 0.0))
    do.ctx.key_up(imgui.Key.mod_alt)
    do.ctx.yield_(4)
    do.run.shot("pick-list")
    do.ctx.key_press(imgui.Key.escape)
    do.document.select(2)
    do.op("tool.move")
    before = do.document.runtime.scene.nodes.translation[2].copy()
    do.ctx.key_down(imgui.Key.mod_ctrl)
    do.drag(do.point(2, 0.06), do.point(2, 0.22))
    do.run.shot("move-snapped")
    do.drop()
    do.ctx.key_up(imgui.Key.mod_ctrl)
    do.seen["moved"] = (do.document.runtime.scene.nodes.translation[2] - before).round(4).tolist()
    for tool in ("rotate", "scale"):
        do.op(f"tool.{tool}")
        do.run.shot(f"tool-{tool}")
    do.op("tool.local")
    do.op("tool.move")
    do.run.shot("local-axes")
    do.op("edit.undo")
    do.op("edit.duplicate")
    do.op("edit.move-by", offset=(0.9, 0.0, 0.0))
    do.document.select(2)
    do.document.select(4, toggle=True)
    do.show("Inspector")
    do.run.shot("many-at-once")


def tree(do: Doing) -> None:
    """Group, hang elsewhere by a drag, hide, isolate, lock, measure, bookmarks."""
    do.document.select(2)
    do.op("edit.group")
    do.show("Scene")
    nodes = do.document.runtime.scene.nodes
    do.ctx.item_drag_and_drop("//###Scene/**/##lamp-3", "//###Scene/**/##plinth-1")
    do.ctx.yield_(3)
    do.seen["lamp hangs below"] = str(nodes.name[nodes.parent[3]])
    do.run.shot("reparented")
    do.document.select(2)
    do.op("edit.isolate")
    do.run.shot("isolated")
    do.op("edit.isolate")
    do.op("edit.lock")
    do.run.shot("locked")
    do.op("edit.lock")
    do.op("tool.measure")
    do.click(do.point(1, -0.1, 0.01))
    do.click(do.point(2, 0.0, 0.0))
    do.run.shot("measured")
    do.op("tool.measure")
    do.op("view.set-bookmark-1")
    do.op("view.top")
    do.run.shot("from-the-top")
    do.op("view.bookmark-1")
    do.run.shot("bookmark")


def compare(do: Doing) -> None:
    """A state against another, with numbers; a path against another."""
    do.op("compare.take")
    do.session.edit("materials", "base_color", (0,), ((0.1, 0.3, 0.8, 1.0),), label="Blue")
    do.op("compare.wipe")
    do.show("Compare")
    do.op("compare.measure")
    do.run.until(lambda: do.session.work is None)
    do.run.until(lambda: do.session.comparing.flip is not None)
    do.ctx.yield_(6)
    do.run.shot("wipe")
    do.seen["flip"] = do.session.comparing.flip
    do.seen["times"] = [round(t, 3) for t in do.session.comparing.times() if t]
    do.op("compare.difference")
    do.run.shot("difference")
    do.op("compare.clear")
    do.op("compare.path-deferred")
    do.run.until(lambda: do.session.work is None)
    do.ctx.yield_(8)
    do.run.shot("path-against-path")
    difference = do.session.comparing.difference
    do.seen["paths equal"] = difference is not None and difference.equal
    do.op("compare.clear")


def look(do: Doing) -> None:
    """Presets, the look card, the floor, a picture whose metadata say how it was seen, a dropped panorama."""
    do.op("view.look-card")
    do.run.until(lambda: not do.session.look_card.waiting)
    do.ctx.yield_(6)
    do.run.shot("look-card")
    for preset in ("blender", "khronos", "aces", "raw"):
        do.op(f"look.{preset}")
        do.run.shot(f"look-{preset}")
    do.op("look.scene")
    do.op("view.shadow-floor")
    do.run.shot("shadow-floor")
    do.op("view.look-card")
    do.op("file.screenshot")
    found = sorted((do.run.folder / "game").rglob("boxes*.png"))
    stamped = Image.open(found[-1]).text if found else {}  # type: ignore[attr-defined]  # of PNG files
    do.seen["stamp"] = sorted(k for k in stamped if k.startswith("lucarna.") and k.count(".") == 1)
    panorama = do.run.folder / "game/garden.hdr"
    _write_panorama(panorama)
    do.run.do(lambda: do.run.app.dropped([panorama]))
    do.run.until(lambda: do.document.runtime.scene.environment.kind == "image" and do.session.job is None)
    do.ctx.yield_(3)
    do.seen["baking"] = surroundings_waiting(do.session)
    do.run.shot("panorama-baking")
    do.run.until(lambda: not surroundings_waiting(do.session))
    do.ctx.yield_(8)
    do.run.shot("panorama-dropped")
    do.seen["environment"] = do.document.runtime.scene.environment.kind


def assets(do: Doing) -> None:
    """Pictures of the files, search, one sort, the texture of one, rename."""
    do.show("Assets")
    do.session.preferences.assets_view = "grid"
    do.session.preferences.assets_size = 96.0
    panel = do.run.panel("Assets")
    do.ctx.yield_(4)
    do.run.until(
        lambda: not do.session.asset_pictures.waiting if hasattr(do.session.asset_pictures, "waiting") else True
    )
    do.ctx.sleep_no_skip(6.0, 0.1)
    do.run.shot("assets-grid")
    panel.needle = "red"
    do.ctx.yield_(6)
    do.run.shot("assets-search")
    panel.needle = ""
    do.session.preferences.assets_view = "tree"
    do.ctx.yield_(3)


def window(do: Doing) -> None:
    """Palette, keys, preferences, workspaces, an own layout, reset."""
    do.away()
    do.op("help.palette")
    do.ctx.yield_(3)
    do.ctx.key_chars("isola")
    do.ctx.yield_(3)
    do.run.shot("palette")
    do.ctx.key_press(imgui.Key.escape)
    do.op("help.keys")
    do.ctx.yield_(3)
    do.run.shot("keys")
    do.ctx.key_press(imgui.Key.escape)
    do.ctx.yield_(3)
    for workspace in ("animate", "shade", "review", "edit"):
        do.op(f"layout.{workspace}")
        do.ctx.yield_(8)
        do.run.shot(f"workspace-{workspace}")
    do.op("view.theme-high-contrast")
    do.run.shot("high-contrast")
    do.op("view.theme-dark")
    do.op("view.reset-layout")
    do.run.shot("layout-reset")


STEPS: dict[str, Callable[[Doing], None]] = {
    "select": select, "tree": tree, "compare": compare, "look": look, "assets": assets, "window": window,
}  # fmt: skip


def _write_panorama(path: Path) -> None:
    """A warm sky over a dark ground, as Radiance RGBE (Ward 1991), not compressed."""
    height, width = 32, 64
    pixels = np.zeros((height, width, 4), np.uint8)
    pixels[: height // 2] = (181, 141, 90, 129)  # (181, 141, 90) / 256 * 2^1
    pixels[height // 2 :] = (40, 60, 40, 127)
    path.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width) + pixels.tobytes())


def steps(run: WindowRun, scene: Path, only: list[str], seen: dict[str, Any]) -> None:
    session = run.session
    run.do(lambda: session.open(scene))
    assert run.until(lambda: session.document is not None and session.image.frame is not None), session.ui.error_bar
    session.camera = type(session.camera)((0.0, 0.0, 0.0), 0.4, -0.35, distance=5.0)
    run.ctx.yield_(6)
    do = Doing(run)
    do.seen = seen
    for name, step in STEPS.items():
        if not only or name in only:
            step(do)
    seen["said"] = [m.line() for m in session.messages.snapshot() if m.severity.value != "info"]


def main(argv: list[str]) -> dict[str, Any]:
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", default="")
    chosen = parser.parse_args(argv)
    game = chosen.folder / "game"
    scene = write_small_scene(game / "scenes")
    (game / "project.toml").write_text('[project]\nname = "Game"\nstart = "scenes/boxes.scene.json"\n')
    run, seen = WindowRun(chosen.folder, size=(1400, 860)), {}
    run.play(lambda r: steps(r, scene, [n for n in chosen.only.split(",") if n], seen))
    return {**seen, "shots": run.shots, "error": run.error}


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(main(sys.argv[1:])) + "\n")
