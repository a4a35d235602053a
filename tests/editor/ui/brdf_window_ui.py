"""The BRDF explorer in a real window: `brdf_window_ui.py FOLDER`; run by test_brdf_window.py."""

from __future__ import annotations

import json
import sys
import traceback
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

from imgui_bundle import hello_imgui, immapp  # noqa: E402  (the path is set above)
from imgui_bundle.immapp import testing  # noqa: E402  (needs the path above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)

from editor.app import App  # noqa: E402  (needs the path above)
from editor.builtin_operations import builtin_operations  # noqa: E402  (needs the path above)
from editor.host import EngineHost  # noqa: E402  (needs the path above)
from editor.panels.brdf_explorer import BrdfExplorerPanel  # noqa: E402  (needs the path above)
from editor.preferences import Preferences  # noqa: E402  (needs the path above)
from editor.screenshot import save_window  # noqa: E402  (needs the path above)
from editor.session import Session  # noqa: E402  (needs the path above)

COATED = """name = "red"
effect = "layered"
features = ["clearcoat", "masking_walter"]
[params]
base_color = [0.8, 0.05, 0.05, 1.0]
metallic = 0.0
roughness = 0.5
clearcoat_roughness = 0.25
"""


def steps(ctx: Any, app: App, seen: dict[str, Any]) -> None:
    session = app.ui.session
    for _ in range(600):
        if session.document is not None and session.image.frame is not None:
            break
        ctx.yield_()
    assert session.document is not None, session.ui.error_bar
    panel = app.panel(BrdfExplorerPanel)
    session.ui.focus_panel = panel.title
    ctx.yield_(4)
    seen["nothing"] = panel.plots is None
    session.document.select(session.document.runtime.scene.find("cube").row)
    ctx.yield_(4)
    first = panel.plots
    assert first is not None, "no curves"
    seen["parts"] = list(first.polar)
    seen["pairs"] = [text for text, _ in first.pairs]
    ctx.yield_(4)
    seen["kept"] = panel.plots is first  # nothing changed: nothing is computed
    material = session.document.runtime.residency.materials.records
    number = next(i for i, r in enumerate(material) if r.asset.name == "red")
    session.document.runtime.residency.set_material_param(number, "roughness", 0.9)
    ctx.yield_(4)
    assert panel.plots is not None
    seen["flatter"] = float(panel.plots.d[0]) < float(first.d[0])
    ctx.item_click(f"//###{panel.title}/###pin")
    ctx.yield_(2)
    session.document.select(-1)
    ctx.yield_(4)
    seen["pinned"] = panel.plots is not None and panel.pinned == number
    session.document.select(session.document.runtime.scene.find("cube").row)
    ctx.yield_(3)


def run(folder: Path) -> dict[str, Any]:
    scene = write_small_scene(folder)
    (folder / "boxes.red.material.toml").write_text(COATED, encoding="utf-8")
    session = Session(EngineHost(), Preferences(welcome_seen=True, adaptive_resolution=False))
    session.save_preferences = False
    app = App(session, builtin_operations(), size=(1300, 820), remember_layout=False)
    session.open(scene)
    seen: dict[str, Any] = {"error": ""}

    def guarded(ctx: Any) -> None:
        try:
            steps(ctx, app, seen)
        except BaseException:  # an exception must not unwind into the engine's coroutine
            seen["error"] = traceback.format_exc()

    try:
        testing.run(test_function=guarded, runner_params=app.params, add_ons_params=immapp.AddOnsParams())
    except RuntimeError as error:
        seen["error"] = f"{seen['error']}\n{error}"
    save_window(folder / "brdf.png", hello_imgui.final_app_window_screenshot())
    return seen


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(run(Path(sys.argv[1]))) + "\n")
