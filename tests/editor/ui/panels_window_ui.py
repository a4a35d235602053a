"""A walk through every panel of the real window, one picture a step, to be looked at.

`panels_window_ui.py FOLDER [--asset PATH] [--scale 2.0] [--theme high-contrast] [--language zh] [--size 1400x900]
[--only textures,graph]`: without an asset it writes a small project into FOLDER. The pictures are FOLDER/NN-step.png.
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

from small_scene import write_small_scene  # noqa: E402  (needs the path above)
from window_run import WindowRun  # noqa: E402  (needs the path above)

from editor.texture_sources import list_sources  # noqa: E402  (needs the path above)

#: panels that the walk opens, in the order of its pictures
PANELS = (
    "Scene", "Assets", "Inspector", "Lights", "Render settings", "Log", "Timings", "Variants", "Shader editor",
    "Timeline", "State graph", "Blend space", "Masks", "History", "Frame graph", "Textures", "Report",
    "Asset report", "Numbers", "Console", "Plug-ins", "Preferences", "Material preview", "BRDF explorer", "Compare",
)  # fmt: skip

#: what the steps found out, for the test
SEEN: dict[str, Any] = {"unread": [], "clicked": ""}


def show(run: WindowRun, title: str) -> None:
    run.session.ui.focus_panel = title
    run.ctx.yield_(5)


def window(run: WindowRun, title: str) -> Any:
    """The dockable window of a panel."""
    return next(w for w in run.app.params.docking_params.dockable_windows if w.label.endswith(f"###{title}"))


def panels(run: WindowRun) -> None:
    """Each panel where it stands."""
    document = run.session.document
    meshes = document.runtime.scene.instances.node
    document.select(int(meshes[0]))
    for title in PANELS:
        opened = window(run, title).is_visible
        show(run, title)
        run.shot(title.lower().replace(" ", "-"))
        if not opened:  # as it was, or the docks fill up
            window(run, title).is_visible = False
            run.ctx.yield_(2)


def textures(run: WindowRun) -> None:
    """The texture viewer: every source once, channels, mips, faces, zoom, values."""
    show(run, "Textures")
    viewer = run.panel("Textures")
    sources = list_sources(run.session)
    for source in sources:
        run.do(lambda one=source: viewer._take(one))
        if not run.until(lambda: viewer.image is not None or viewer.problem) or viewer.problem:
            SEEN["unread"].append(f"{source.kind} {source.name}: {viewer.problem}")
        run.shot(f"texture-{source.kind}-{source.name}".replace("_", "-").replace(" ", "-"))
    colored = next((s for s in sources if s.kind == "material"), sources[-1])
    viewer._take(colored)
    run.ctx.yield_(4)
    for channels in ("r", "luma", "normal"):
        viewer.channels = channels
        run.ctx.yield_(2)
        run.shot(f"channel-{channels}")
    viewer.channels, viewer.stops = "rgb", 2.0
    run.ctx.yield_(2)
    run.shot("texture-brighter")
    viewer.stops = 0.0
    at = run.ctx.item_info("//###Textures/##canvas").rect_full.get_center()
    run.ctx.mouse_move_to_pos(at)
    run.ctx.mouse_wheel_y(14)
    run.ctx.yield_(4)
    run.shot("texture-zoomed")


def assets(run: WindowRun) -> None:
    """The asset report page by page; a texture of it is looked at, a material of it selected."""
    for page in ("All", "Meshes", "Textures", "Materials", "Findings"):
        show(run, "Asset report")
        run.ctx.item_click(f"//###Asset report/report/{page}" + ("" if page == "All" else "##tab"))
        run.ctx.yield_(3)
        run.shot(f"report-{page.lower()}")


def graph(run: WindowRun) -> None:
    """The frame graph over the middle; a click on a pass shows what it writes."""
    show(run, "Frame graph")
    run.shot("graph")
    run.ctx.mouse_move("//###Frame graph/**/##pass-opaque")
    run.ctx.sleep_no_skip(1.0, 0.05)
    run.shot("graph-hovered")
    run.ctx.item_click("//###Frame graph/**/##pass-opaque")
    run.ctx.yield_(6)
    run.until(lambda: run.panel("Textures").image is not None)
    run.ctx.yield_(4)
    SEEN["clicked"] = run.panel("Textures").source.name
    run.shot("graph-clicked")


STEPS: dict[str, Callable[[WindowRun], None]] = {
    "panels": panels, "textures": textures, "assets": assets, "graph": graph,
}  # fmt: skip


def steps(run: WindowRun, path: Path, chosen: argparse.Namespace) -> None:
    session, only = run.session, [n for n in chosen.only.split(",") if n]
    run.do(lambda: session.open(path))
    assert run.until(lambda: session.document is not None and session.image.frame is not None), session.ui.error_bar
    session.playback.playing = False
    run.ctx.yield_(8)
    run.shot("opened")
    session.ui.import_card = False
    if chosen.scale != 1.0:  # the panels as they stand in a window of so few letters
        session.ui.reset_layout = True
        run.ctx.yield_(4)
    for name, step in STEPS.items():
        if not only or name in only:
            step(run)


def main(argv: list[str]) -> dict[str, Any]:
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("--asset", type=Path)
    parser.add_argument("--scale", type=float, default=1.0)
    parser.add_argument("--theme", default="dark")
    parser.add_argument("--language", default="en")
    parser.add_argument("--size", default="1400x860")
    parser.add_argument("--only", default="")
    chosen = parser.parse_args(argv)
    path = chosen.asset or write_small_scene(chosen.folder / "game")
    width, height = (int(n) for n in chosen.size.split("x"))
    run = WindowRun(chosen.folder, size=(width, height))
    preferences = run.session.preferences
    preferences.ui_scale, preferences.theme, preferences.language = chosen.scale, chosen.theme, chosen.language
    run.play(lambda r: steps(r, path, chosen))
    return {**SEEN, "shots": run.shots, "error": run.error}


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(main(sys.argv[1:])) + "\n")
