"""Materials in a real window: several edited at once, copied, reset, previewed, seen as thumbnails. After each step a
screenshot lies in FOLDER:  xvfb-run -a python tests/editor/ui/materials_ui.py FOLDER
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
from imgui_bundle import imgui  # noqa: E402  (needs the path above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)
from window_run import WindowRun  # noqa: E402  (needs the path above)

from editor.saving import edited_scene  # noqa: E402  (needs the path above)
from engine.report.image import save_png  # noqa: E402  (needs the path above)

#: an effect whose parameters declare all that a panel can show
MOSS = """\
name = "moss"
extends = "surface"

[params.roughness]
order = -1.0

[params.wetness]
type = "float"
default = 0.0
min = 0.0
max = 1.0
group = "Weather"
doc = "how wet it is"

[params.drying]
type = "float"
default = 2.0
min = 0.0
max = 60.0
unit = "s"
group = "Weather"
when = "wetness > 0.1"
doc = "until it is dry again"

[params.growth]
type = "enum"
default = "even"
choices = ["even", "patchy", "edges"]
group = "Moss"
doc = "where it grows"
"""


class MaterialsRun:
    def __init__(self, folder: Path) -> None:
        self.seen: dict[str, Any] = {}
        self.scene = write_small_scene(folder / "scene")
        effects = folder / "scene" / "effects"
        effects.mkdir(exist_ok=True)
        (effects / "moss.effect.toml").write_text(MOSS, encoding="utf-8")
        for name in ("red", "grey"):
            path = folder / "scene" / f"boxes.{name}.material.toml"
            path.write_text(path.read_text().replace('effect = "surface"', 'effect = "moss"'), encoding="utf-8")
        save_png(folder / "scene" / "paint.png", np.full((64, 64, 3), (60, 150, 220), np.uint8))
        (folder / "scene" / "broken.glb").write_bytes(b"glTF but not really")
        self.run = WindowRun(folder, size=(1280, 800))
        self.session = self.run.session
        self.session.settings.samples = 1
        self.session.settings.shadows = False
        self.session.open(self.scene)

    def steps(self, run: WindowRun) -> None:
        session = self.session
        opened = run.until(lambda: session.document is not None and session.image.frame is not None)
        assert opened, session.ui.error_bar
        self.first = run.picture()
        self.look_at_declarations()
        self.edit_several()
        self.copy_and_reset()
        self.preview()
        self.on_one_object()
        self.thumbnails()
        self.reload()
        self.undo_everything()

    def row(self, name: str) -> int:
        assert self.session.document is not None
        return list(self.session.document.runtime.scene.nodes.name).index(name)

    def params(self, name: str) -> dict[str, Any]:
        assert self.session.document is not None
        records = self.session.document.runtime.residency.materials.records
        return next(r.asset.params for r in records if r.asset.name == name)

    def exists(self, path: str) -> bool:
        return self.run.ctx.item_info(path, imgui.test_engine.TestOpFlags_.no_error).id_ != 0

    def look_at_declarations(self) -> None:
        run, session = self.run, self.session
        assert session.document is not None
        session.document.select(self.row("cube"))
        run.ctx.yield_(4)
        value = "//###Inspector/**/{}/##value"
        self.seen["grouped"] = self.exists(value.format("wetness"))
        self.seen["hidden_while_dry"] = not self.exists(value.format("drying"))
        run.ctx.item_drag_with_delta(value.format("wetness"), (40, 0))
        run.ctx.yield_(3)
        self.seen["shown_when_wet"] = self.exists(value.format("drying"))
        run.shot("groups-and-conditions")
        session.undo()

    def edit_several(self) -> None:
        run, session = self.run, self.session
        assert session.document is not None
        session.document.selection = (self.row("plinth"), self.row("cube"))
        run.ctx.yield_(4)
        run.shot("two-selected-mixed")
        self.edit_places()
        count = len(session.document.history.entries)
        before = (self.params("red")["roughness"], self.params("grey")["roughness"])
        run.ctx.item_drag_with_delta("//###Inspector/**/roughness/##value", (60, 0))
        run.ctx.yield_(3)
        after = (self.params("red")["roughness"], self.params("grey")["roughness"])
        entries = session.document.history.entries
        self.seen["several"] = (after[0] == after[1] != before[0], len(entries) - count, entries[-1].describe())
        run.shot("two-edited")
        session.undo()
        self.seen["several_undone"] = (self.params("red")["roughness"], self.params("grey")["roughness"]) == before

    def edit_places(self) -> None:
        """One component of both: the others, which differ, stay as they are."""
        run, session = self.run, self.session
        assert session.document is not None
        nodes = session.document.runtime.scene.nodes
        rows = [self.row("plinth"), self.row("cube")]
        before = nodes.translation[rows].copy()
        run.ctx.item_drag_with_delta("//###Inspector/transform/##translation/$$0", (30, 0))
        run.ctx.yield_(2)
        after = nodes.translation[rows]
        others = bool((after[:, 1:] == before[:, 1:]).all())
        self.seen["one_component"] = (
            bool(after[0, 0] == after[1, 0] != before[0, 0]),
            others,
            bool(before[0, 1] != before[1, 1]),
        )
        session.undo()

    def copy_and_reset(self) -> None:
        run, session = self.run, self.session
        assert session.document is not None
        session.document.select(self.row("cube"))
        run.ctx.yield_(4)
        run.ctx.item_click("//###Inspector/**/###copy")
        run.ctx.yield_(2)
        session.document.select(self.row("plinth"))
        run.ctx.yield_(4)
        run.ctx.item_click("//###Inspector/**/###paste")
        run.ctx.yield_(3)
        self.seen["pasted"] = self.params("grey")["base_color"] == self.params("red")["base_color"]
        run.shot("material-pasted")
        run.ctx.item_click("//###Inspector/**/###reset-all")
        run.ctx.yield_(3)
        self.seen["reset"] = (tuple(self.params("grey")["base_color"]), self.params("grey")["roughness"])
        run.shot("all-reset")
        session.undo()
        session.undo()

    def preview(self) -> None:
        run, session = self.run, self.session
        assert session.document is not None
        session.document.select(self.row("cube"))
        session.ui.focus_panel = "Material preview"
        assert run.until(lambda: session.preview.frame is not None), "no preview"
        run.ctx.yield_(3)
        renders = session.preview.renders
        run.ctx.yield_(12)
        self.seen["idle_preview"] = session.preview.renders - renders
        for shape in ("ball", "cloth", "plane", "cube", "selected"):
            session.preview.setup.shape = shape
            run.ctx.yield_(3)
            run.shot(f"preview-{shape}")
        session.preview.setup.shape = "ball"
        run.ctx.yield_(3)
        rotation, yaw = session.preview.setup.rotation, session.preview.setup.yaw
        self.drag(imgui.MouseButton_.right, 50, imgui.Key.mod_shift)
        self.drag(imgui.MouseButton_.left, 40)
        setup = session.preview.setup
        self.seen["gestures"] = (setup.rotation != rotation, setup.yaw != yaw)
        run.shot("preview-turned")
        self.seen["remembered"] = (
            session.preferences.preview.get("shape"),
            session.preferences.preview.get("rotation") == setup.rotation,
        )
        before = self.preview_pixels()
        run.do(lambda: session.edit("materials", "base_color", (self.material("red"),), ((0.0, 0.2, 0.9, 1.0),)))
        run.ctx.yield_(3)
        self.seen["edit_reaches_it"] = bool((self.preview_pixels() != before).any())
        run.shot("preview-edited")
        session.undo()

    def on_one_object(self) -> None:
        """A parameter of the cube alone, by a drag; the material keeps its own. Then as the material says again."""
        run, session = self.run, self.session
        document = session.document
        assert document is not None
        cube = self.row("cube")
        document.select(cube)
        run.ctx.yield_(4)
        run.ctx.item_click("//###Inspector/**/###only-object")
        said, picture = self.params("red")["roughness"], run.picture()
        count = len(document.history.entries)
        run.ctx.item_drag_with_delta("//###Inspector/**/roughness/##value", (-70, 0))
        run.ctx.yield_(3)
        session.ui.only_object = False
        run.ctx.item_drag_with_delta("//###Inspector/**/roughness/##value", (-10, 0))
        run.ctx.yield_(4)
        own = document.runtime.objects.values(cube, 0)
        entries = [entry.describe() for entry in document.history.entries[count:]]
        self.seen["own"] = (list(own), own["roughness"] < said, self.params("red")["roughness"] == said)
        self.seen["own_entries"] = entries
        self.seen["own_seen"] = bool((run.picture() != picture).any())
        run.shot("one-object")
        saved = edited_scene(document.runtime, document.overrides).nodes[cube].mesh
        self.seen["own_saved"] = saved is not None and list(saved.overrides[0]) == ["roughness"]
        run.ctx.item_click("//###Inspector/**/roughness/###reset")
        run.ctx.yield_(4)
        self.seen["own_reset"] = (document.runtime.objects.values(cube, 0), bool((run.picture() == picture).all()))
        session.undo()
        self.seen["own_undone"] = "roughness" in document.runtime.objects.values(cube, 0)
        while len(document.history.entries) and document.history.undo_label in (*entries, "Undo"):
            session.undo()

    def reload(self) -> None:
        """An edited effect reaches the preview and the thumbnails; a broken one leaves the last picture."""
        run, session = self.run, self.session
        assert session.document is not None
        file = self.scene.parent / "effects" / "moss.effect.toml"
        session.document.select(self.row("cube"))
        session.preview.setup.shape = "ball"
        session.ui.focus_panel = "Material preview"
        run.ctx.yield_(8)
        before, small = self.preview_pixels(), self.small("boxes.red.material.toml")

        def says(text: str) -> None:
            time.sleep(0.01)  # another time stamp, also where those are coarse
            file.write_text(text, encoding="utf-8")

        says(MOSS + '[technique]\ngbuffer = false\n[technique.forward]\nfragment = "effects/flat.frag"\n')
        self.seen["reload_preview"] = run.until(lambda: bool((self.preview_pixels() != before).any()))
        flat = self.preview_pixels()
        run.shot("reload-preview")
        session.ui.focus_panel = "Assets"
        self.seen["reload_thumbnail"] = run.until(
            lambda: (
                self.small("boxes.red.material.toml").shape == small.shape
                and bool((self.small("boxes.red.material.toml") != small).any())
            )
        )
        session.ui.focus_panel = "Material preview"
        says(MOSS + "[technique.forward]\nfragmnt = 3\n")
        self.seen["broken_badge"] = run.until(lambda: bool(session.shaders.badge))
        run.ctx.yield_(6)
        self.seen["broken_keeps"] = bool((self.preview_pixels() == flat).all())
        run.shot("reload-broken")
        says(MOSS)
        self.seen["mended"] = run.until(
            lambda: not session.shaders.badge and bool((self.preview_pixels() == before).all())
        )

    def small(self, name: str) -> Any:
        """The pixels of the newest thumbnail of a file; one black pixel while it is made."""
        known = self.session.asset_pictures._known  # the panel's own
        ready = [t for key, t in known.items() if key[0].name == name and t.texture is not None]
        found: list[Any] = [np.zeros((1, 1, 4), np.uint8)]
        if ready:
            self.run.do(lambda: found.append(np.array(ready[-1].texture.read())))
        return found[-1]

    def material(self, name: str) -> int:
        assert self.session.document is not None
        records = self.session.document.runtime.residency.materials.records
        return next(i for i, r in enumerate(records) if r.asset.name == name)

    def preview_pixels(self) -> Any:
        found: list[Any] = []
        self.run.do(lambda: found.append(np.array(self.session.preview.frame.color.read())))
        return found[0]

    def drag(self, button: int, dx: float, *keys: int) -> None:
        ctx = self.run.ctx
        ctx.mouse_move("//###Material preview/##preview")
        for key in keys:
            ctx.key_down(key)
        ctx.mouse_down(int(button))
        at = imgui.get_io().mouse_pos
        ctx.mouse_move_to_pos((at.x + dx, at.y))
        ctx.mouse_up(int(button))
        for key in keys:
            ctx.key_up(key)
        ctx.yield_(3)

    def thumbnails(self) -> None:
        run, session = self.run, self.session
        session.preferences.assets_view, session.preferences.assets_size = "grid", 64.0
        thumbnails = session.asset_pictures
        run.ctx.yield_(2)
        run.shot("thumbnails-waiting")
        known = thumbnails._known  # the panel's own: what it waits for
        wanted = {"boxes.red.material.toml", "paint.png", "broken.glb", "boxes.scene.json"}
        session.ui.focus_panel = "Assets"

        def there() -> bool:
            return wanted <= {key[0].name for key, t in known.items() if t.state in ("ready", "broken")}

        panel = run.panel("Assets")
        for needle in ("", "boxes", "paint"):
            panel.needle = needle
            run.ctx.yield_(3)
            run.until(lambda: there() or all(t.state in ("ready", "broken") for t in known.values()))
        panel.needle = ""
        run.ctx.yield_(3)
        states = {key[0].name: (t.state, t.error) for key, t in known.items()}
        self.seen["thumbnails"] = {name: states.get(name, ("", "")) for name in sorted(wanted)}
        run.shot("thumbnails")

    def undo_everything(self) -> None:
        run, session = self.run, self.session
        assert session.document is not None
        while session.document.history.undo_label:
            run.ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.z)
            run.ctx.yield_(2)
        session.document.select(-1)
        self.seen["undone"] = bool((run.picture() == self.first).all())
        self.seen["clean"] = not session.document.dirty


def main(folder: Path) -> dict[str, Any]:
    os.environ.setdefault("LUCARNA_CACHE", str(folder / "cache"))
    os.environ.setdefault("LUCARNA_CONFIG", str(folder / "config"))
    steps = MaterialsRun(folder)
    steps.run.play(steps.steps)
    return {**steps.seen, "error": steps.run.error, "shots": [steps.run.path(name).name for name in steps.run.shots]}


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(main(Path(sys.argv[1]).resolve())) + "\n")
