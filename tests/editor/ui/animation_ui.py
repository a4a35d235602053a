"""UI tests of animation: the timeline, blend space, state graph and masks; run by test_ui_animation.py in a process of
its own, on the real engine with a device that draws nothing."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
import ui_harness  # noqa: E402  (needs the path above)
from animated_scene import NullHost  # noqa: E402  (needs the path above)
from imgui_bundle import imgui  # noqa: E402  (needs the path above)
from ui_harness import fresh, main  # noqa: E402  (needs the path above)

from editor.animating.editing import AnimationEditor  # noqa: E402  (needs the path above)
from editor.app import App  # noqa: E402  (needs the path above)
from editor.panels.animation_timeline import ROW, TimelinePanel  # noqa: E402  (needs the path above)
from editor.panels.blend_space import BlendSpacePanel  # noqa: E402  (needs the path above)
from editor.panels.bone_masks import mask_weights  # noqa: E402  (needs the path above)
from editor.panels.state_graph import BOX, StateGraphPanel  # noqa: E402  (needs the path above)
from editor.widgets import em  # noqa: E402  (needs the path above)

FOLDER = Path(tempfile.mkdtemp())


def prepare(ctx: Any, app: App, *panels: str) -> AnimationEditor:
    """The figure as just opened, with those panels in front."""
    fresh(ctx, app)
    for panel in panels:
        app.ui.session.ui.focus_panel = panel
        ctx.yield_(3)
    app.ui.session.playback.playing = False
    return AnimationEditor(app.ui.session)


def drag(ctx: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    ctx.mouse_move_to_pos(imgui.ImVec2(*start))
    ctx.yield_(3)
    ctx.mouse_down(0)
    ctx.yield_(2)
    for share in (0.3, 0.6, 1.0):
        at = [a + share * (b - a) for a, b in zip(start, end, strict=True)]
        ctx.mouse_move_to_pos(imgui.ImVec2(*at))
        ctx.yield_(2)
    ctx.mouse_up(0)
    ctx.yield_(3)


def row_middle(app: App, editor: AnimationEditor, track: int) -> float:
    canvas = app.panel(TimelinePanel).canvas
    return canvas.y + canvas.ruler + (len(editor.model.tracks) - 0.4 - track) * em(ROW)


def scrubbing_the_ruler_moves_the_time_and_the_pose(ctx: Any, app: App) -> None:
    editor = prepare(ctx, app, "Timeline")
    session, canvas = app.ui.session, app.panel(TimelinePanel).canvas
    y = canvas.y + 0.3 * canvas.ruler
    drag(ctx, (canvas.px(0.1), y), (canvas.px(0.5), y))
    assert abs(session.playback.time - 0.5) < 0.02, session.playback.time
    assert editor.model is None, "scrubbing must not edit"
    assert not session.document.history.entries


def a_block_is_dragged_trimmed_and_undone_as_one_entry_each(ctx: Any, app: App) -> None:
    editor = prepare(ctx, app, "Timeline")
    session = app.ui.session
    editor.create()
    editor.add_block("run", 0)
    session.animating.fitted = session.animating.snap = False
    ctx.yield_(3)
    canvas, y = app.panel(TimelinePanel).canvas, row_middle(app, editor, 0)
    count = len(session.document.history.entries)
    drag(ctx, (canvas.px(1.3), y), (canvas.px(1.0), y))
    first, second = editor.model.tracks[0].blocks
    assert abs(second.start - 0.7) < 0.03, second.start
    assert abs(first.fade_out - (1.0 - second.start)) < 1e-6, first.fade_out
    assert len(session.document.history.entries) == count + 1
    end = second.start + second.length
    drag(ctx, (canvas.px(end) - 1, y), (canvas.px(end + 0.2), y))
    assert abs(editor.model.tracks[0].blocks[1].length - 0.8) < 0.03
    assert len(session.document.history.entries) == count + 2
    session.undo()
    session.undo()
    assert editor.model.tracks[0].blocks[1].start == 1.0
    assert editor.model.tracks[0].blocks[0].fade_out == 0.0


def a_block_snaps_to_its_neighbours_end(ctx: Any, app: App) -> None:
    editor = prepare(ctx, app, "Timeline")
    editor.create()
    editor.add_block("run", 0, start=1.5)
    app.ui.session.animating.fitted, app.ui.session.animating.snap = False, True
    ctx.yield_(3)
    canvas, y = app.panel(TimelinePanel).canvas, row_middle(app, editor, 0)
    drag(ctx, (canvas.px(1.8), y), (canvas.px(1.3) + 2, y))
    assert abs(editor.model.tracks[0].blocks[1].start - 1.0) < 1e-6, editor.model.tracks[0].blocks[1].start


def the_pages_show_keys_and_curves(ctx: Any, app: App) -> None:
    prepare(ctx, app, "Timeline")
    for page in ("dope", "curves", "tracks"):
        app.ui.session.animating.page = page
        ctx.yield_(3)
    assert app.ui.session.animating.channel == 0


def the_puck_blends_and_a_sample_is_moved_as_one_entry(ctx: Any, app: App) -> None:
    editor = prepare(ctx, app, "Blend space")
    session = app.ui.session
    editor.add_param("speed")
    editor.add_blend("move", ["speed"], [("walk", [0.0]), ("run", [1.0])])
    editor.add_state("moving", blend="move")
    editor.drive("states")
    ctx.yield_(3)
    panel = app.panel(BlendSpacePanel)
    x, y, width, height = panel.area
    share = (0.5 - panel.low[0]) / (panel.high[0] - panel.low[0])
    count = len(session.document.history.entries)
    drag(ctx, (x + 0.2 * width, y + 0.8 * height), (x + share * width, y + 0.8 * height))
    values = session.document.runtime.animation.animator.machine.values[0, 0]
    assert abs(values - 0.5) < 0.05, values
    assert len(session.document.history.entries) == count, "steering is no edit"
    px = panel._px(np.array([[1.0, 0.0]]))[0]
    ctx.key_down(imgui.Key.mod_ctrl)
    drag(ctx, tuple(px), (float(px[0]) - 0.2 * width, float(px[1])))
    ctx.key_up(imgui.Key.mod_ctrl)
    assert editor.model.blends["move"].samples[1].at[0] < 0.9
    assert len(session.document.history.entries) == count + 1


def states_are_moved_and_joined_in_the_graph(ctx: Any, app: App) -> None:
    editor = prepare(ctx, app, "State graph")
    session = app.ui.session
    editor.add_state("walking", "walk", at=[1.0, 1.0])
    editor.add_state("running", "run", at=[12.0, 1.0])
    ctx.yield_(3)
    panel = app.panel(StateGraphPanel)
    count = len(session.document.history.entries)
    start = panel._middle("walking")
    drag(ctx, start, (start[0] + panel._em(2), start[1] + panel._em(1)))
    np.testing.assert_allclose(editor.model.states["walking"].at, [3.0, 2.0], atol=0.1)
    assert len(session.document.history.entries) == count + 1
    ctx.key_down(imgui.Key.mod_shift)
    drag(ctx, panel._middle("walking"), panel._middle("running"))
    ctx.key_up(imgui.Key.mod_shift)
    assert [(t.source, t.target) for t in editor.model.transitions] == [("walking", "running")]
    session.undo()
    session.undo()
    assert editor.model.transitions == []
    assert editor.model.states["walking"].at == [1.0, 1.0]
    assert BOX[0] > 0
    # the middle button moves the whole graph along, a double click on nothing brings it back
    ctx.yield_(2)
    corner = panel.boxes["walking"]
    gap = corner[0] + panel._em(BOX[0] + 0.6), corner[1] + panel._em(0.5)
    ctx.mouse_move_to_pos(imgui.ImVec2(*gap))
    ctx.yield_(2)
    ctx.mouse_down(2)
    ctx.mouse_move_to_pos(imgui.ImVec2(gap[0] - em(3), gap[1] + em(1)))
    ctx.yield_(2)
    ctx.mouse_up(2)
    ctx.yield_(2)
    moved = [b - a for a, b in zip(corner, panel.boxes["walking"], strict=True)]
    np.testing.assert_allclose(moved, [-em(3), em(1)], atol=1.5)
    assert editor.model.states["walking"].at == [1.0, 1.0]
    ctx.mouse_move_to_pos(imgui.ImVec2(gap[0] - em(3), gap[1] + em(1)))
    ctx.mouse_double_click(0)
    ctx.yield_(2)
    assert panel.boxes["walking"] == corner


def a_bone_in_the_list_masks_its_subtree_and_undo_brings_it_back(ctx: Any, app: App) -> None:
    editor = prepare(ctx, app, "Masks")
    session = app.ui.session
    editor.add_mask("upper")
    session.animating.mask = "upper"
    for name, parent in (("wave", ""),):
        editor.add_track(name, mask="upper")
        editor.add_block("wave", 1)
        del parent
    ctx.yield_(3)
    ctx.item_click("**/arm")
    ctx.yield_(3)
    rig = session.document.runtime.animation.rig
    assert mask_weights(session, "upper")[rig.index("arm")] == 1.0
    assert mask_weights(session, "upper")[rig.index("leg")] == 0.0
    session.undo()
    assert mask_weights(session, "upper")[rig.index("arm")] == 0.0


def skeletons_ghosts_and_paths_are_drawn(ctx: Any, app: App) -> None:
    editor = prepare(ctx, app, "Timeline")
    editor.create()
    editor.put((("root",), "hips"), label="Root")
    view = app.ui.session.animating
    view.skeleton = view.names = view.axes = True
    view.ghosts = 3
    app.ui.session.seek(0.5)
    ctx.yield_(4)
    from editor.skeleton_overlay import ghost_places

    session = app.ui.session
    places, parent = ghost_places(session, np.array([0.25, 0.5]))
    scene = session.document.runtime.scene
    joints = np.unique(scene.skins.joint)
    np.testing.assert_allclose(places[1], scene.nodes.world[joints, :, 3], atol=1e-6)
    assert parent.tolist()[0] == -1
    view.skeleton = view.names = view.axes = False
    view.ghosts = 0


def the_weights_of_morph_targets_have_sliders(ctx: Any, app: App) -> None:
    prepare(ctx, app, "Inspector")
    session = app.ui.session
    scene = session.document.runtime.scene
    row = scene.nodes.name.index("skin")
    session.document.select(row)
    ctx.yield_(3)
    ctx.item_input_value("**/##morph0", 0.5)
    ctx.yield_(3)
    assert abs(scene.morphs.of_node(row)[0] - 0.5) < 1e-3, scene.morphs.of_node(row)
    session.undo()
    assert scene.morphs.of_node(row)[0] == 0.0


TESTS = {
    f.__name__: f
    for f in (
        scrubbing_the_ruler_moves_the_time_and_the_pose,
        a_block_is_dragged_trimmed_and_undone_as_one_entry_each,
        a_block_snaps_to_its_neighbours_end,
        the_pages_show_keys_and_curves,
        the_puck_blends_and_a_sample_is_moved_as_one_entry,
        states_are_moved_and_joined_in_the_graph,
        a_bone_in_the_list_masks_its_subtree_and_undo_brings_it_back,
        skeletons_ghosts_and_paths_are_drawn,
        the_weights_of_morph_targets_have_sliders,
    )
}

if __name__ == "__main__":
    ui_harness.FakeHost = lambda: NullHost(FOLDER)  # the harness makes its host by that name
    main(TESTS)
