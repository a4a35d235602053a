"""A project whose shader writes NaN, the frame graph and the report, in a real window: `numbers_window_ui.py FOLDER`;
run by test_numbers_window.py."""

from __future__ import annotations

import json
import sys
import traceback
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
from imgui_bundle import hello_imgui, immapp  # noqa: E402  (the path is set above)
from imgui_bundle.immapp import testing  # noqa: E402  (needs the path above)
from planted_nan import plant_nan  # noqa: E402  (needs the path above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)

from editor import numbers, report  # noqa: E402  (needs the path above)
from editor.app import App  # noqa: E402  (needs the path above)
from editor.builtin_operations import builtin_operations  # noqa: E402  (needs the path above)
from editor.host import EngineHost  # noqa: E402  (needs the path above)
from editor.panels.frame_graph import FrameGraphPanel  # noqa: E402  (needs the path above)
from editor.panels.report import ReportPanel  # noqa: E402  (needs the path above)
from editor.panels.texture_viewer import TextureViewerPanel  # noqa: E402  (needs the path above)
from editor.preferences import Preferences  # noqa: E402  (needs the path above)
from editor.screenshot import save_window  # noqa: E402  (needs the path above)
from editor.session import Session  # noqa: E402  (needs the path above)


def steps(ctx: Any, app: App, seen: dict[str, Any], grabs: list[Any]) -> None:
    session, operations = app.ui.session, app.ui.operations
    for _ in range(600):
        if session.document is not None and session.image.frame is not None:
            break
        ctx.yield_()
    assert session.document is not None, session.ui.error_bar
    ctx.yield_(3)
    seen["before"] = session.image.frame.numbers is not None
    operations.run("view.check-numbers", session)
    ctx.yield_(4)
    found = numbers.report(session)
    assert found is not None
    assert found.first is not None, "nothing was found"
    seen["pass"], seen["texture"], seen["nan"] = found.first.pass_name, found.first.resource, found.first.nan
    seen["summary"] = numbers.summary(found)
    renders = session.image.renders
    ctx.yield_(10)
    seen["idle_renders"] = session.image.renders - renders
    operations.run("view.mark-numbers", session)
    ctx.yield_(3)
    grabs.append(None)
    ctx.yield_(2)
    seen["marked"] = int((grabs[-1][..., :3] == (255, 0, 255)).all(axis=-1).sum())
    session.document.select(-1)
    index = found.rows.index(found.first)
    ctx.item_click(f"//###Numbers/**/##row{index}")
    ctx.yield_(6)
    viewer = app.panel(TextureViewerPanel)
    seen["shown"] = viewer.source.name if viewer.source is not None else ""
    seen["texel"] = viewer.marked == found.first.first[:2]
    inside = viewer._inside()
    seen["is_nan"] = inside is not None and bool(
        (viewer.values[inside[1], inside[0]] != viewer.values[inside[1], inside[0]]).any()
    )
    seen["selected"] = session.node_name(session.document.primary)
    ctx.yield_(3)

    operations.run("view.check-numbers", session)
    operations.run("view.measure-left-out", session)
    for _ in range(200):
        ctx.yield_()
        if session.work is None:
            break
    cost = session.forced_cost
    assert cost is not None
    boxes = app.panel(FrameGraphPanel).diagram.boxes
    seen["left_out"] = [box.name for box in boxes if box.reason]
    seen["costs"] = [cost.passes.get(name, -1.0) for name in seen["left_out"]]
    renders = session.image.renders
    ctx.mouse_move_to_pos((5, 5))
    ctx.yield_(12)
    seen["idle_graph"] = session.image.renders - renders
    # behind the graph the picture still follows
    session.settings.exposure = 1.0
    ctx.yield_(3)
    seen["live"] = session.image.renders - renders
    error_over_time(ctx, app, seen)


def error_over_time(ctx: Any, app: App, seen: dict[str, Any]) -> None:
    """The report on this view: measured in steps, called off, applied and taken back."""
    session, operations = app.ui.session, app.ui.operations
    assert session.document is not None
    operations.run("report.run", session)
    ctx.yield_(3)
    operations.run("view.cancel-work", session)
    seen["called_off"] = session.work is None and not session.reports
    operations.run("report.run", session)
    steps = 0
    while session.work is not None and steps < 3000:
        ctx.yield_()
        steps += 1
    ctx.yield_(3)
    result = session.reports["picture"]
    seen["steps"], seen["points"] = steps, len(result.points)
    panel = app.panel(ReportPanel)
    seen["plotted"] = sum(len(s.points) for s in panel.diagram.series)
    seen["now"] = panel.diagram.current is not None
    seen["answers"] = [a.question for a in panel._answers]
    renders = session.image.renders
    ctx.mouse_move_to_pos((5, 5))
    ctx.yield_(12)
    seen["idle_report"] = session.image.renders - renders
    before = session.settings.samples
    report.apply(session, "picture", {"setting": "samples", "value": 4})
    ctx.yield_(2)
    seen["applied"], seen["label"] = session.settings.samples, session.document.history.undo_label
    seen["dirty"] = session.document.dirty
    session.undo()
    ctx.yield_(2)
    seen["taken_back"] = session.settings.samples == before


def run(folder: Path) -> dict[str, Any]:
    scene = write_small_scene(folder)
    plant_nan(folder)
    session = Session(EngineHost(), Preferences(welcome_seen=True, adaptive_resolution=False))
    session.save_preferences = False
    app = App(session, builtin_operations(), size=(1100, 700), remember_layout=False)
    session.open(scene)
    seen: dict[str, Any] = {"error": ""}
    grabs: list[Any] = []  # pictures asked for (None) and taken: the test runs on a thread without the GL context
    end_frame = app.params.callbacks.post_render_dockable_windows

    def take_pictures() -> None:
        end_frame()
        if grabs and grabs[-1] is None:
            grabs[-1] = np.array(session.image.pixels())

    app.params.callbacks.post_render_dockable_windows = take_pictures

    def guarded(ctx: Any) -> None:
        try:
            steps(ctx, app, seen, grabs)
        except BaseException:  # an exception must not unwind into the engine's coroutine
            seen["error"] = traceback.format_exc()

    try:
        testing.run(test_function=guarded, runner_params=app.params, add_ons_params=immapp.AddOnsParams())
    except RuntimeError as error:
        seen["error"] = f"{seen['error']}\n{error}"
    save_window(folder / "numbers.png", hello_imgui.final_app_window_screenshot())
    return seen


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(run(Path(sys.argv[1]))) + "\n")
