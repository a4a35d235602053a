"""UI tests of what edits the scene: gizmo, tree drags, history, selection; run by test_ui_editing.py in a process of
its own."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
from imgui_bundle import imgui  # noqa: E402  (needs the path above)
from ui_harness import fresh, main, settle  # noqa: E402  (needs the path above)

from editor.app import App  # noqa: E402  (needs the path above)
from editor.camera_controls import OrbitCamera, project  # noqa: E402  (needs the path above)
from editor.journal import pending  # noqa: E402  (needs the path above)
from editor.panels.lights import LightsPanel  # noqa: E402  (needs the path above)
from editor.panels.viewport import ViewportPanel  # noqa: E402  (needs the path above)
from engine.scene.lights import LIGHT_TYPES  # noqa: E402  (needs the path above)


def prepare(ctx: Any, app: App, *rows: int, mode: str = "move") -> Any:
    """A document seen from the front with `rows` selected."""
    document = fresh(ctx, app)
    session = app.ui.session
    session.tools.mode, session.tools.local = mode, False
    session.camera = OrbitCamera((0.0, 1.0, 0.0), 0.0, 0.0, distance=5.0)
    document.selection = rows
    ctx.mouse_move_to_pos((5, 5))
    ctx.yield_(3)
    return document


def on_screen(app: App, point: Any, x: float = 0.0, y: float = 0.0) -> Any:
    """The window position of a world point, moved by a share of the picture's width."""
    left, top, width, height = app.panel(ViewportPanel).area
    pixels, _depth = project(app.ui.session.camera, np.array([point], float), width, height)
    return imgui.ImVec2(left + float(pixels[0, 0]) + x * width, top + float(pixels[0, 1]) + y * width)


def drag(ctx: Any, start: Any, end: Any) -> None:
    ctx.mouse_move_to_pos(start)
    ctx.yield_(4)
    ctx.mouse_down(0)
    ctx.yield_(2)
    ctx.mouse_move_to_pos(end)
    ctx.yield_(2)
    ctx.mouse_up(0)
    ctx.yield_(3)


def the_gizmo_moves_along_an_axis_as_one_entry(ctx: Any, app: App) -> None:
    document = prepare(ctx, app, 2)
    nodes = document.runtime.scene.nodes
    grip, away = on_screen(app, (0, 1, 0), 0.05), on_screen(app, (0, 1, 0), 0.2, 0.03)
    drag(ctx, grip, away)
    moved = nodes.translation[2]
    assert moved[0] > 0.2, moved
    assert abs(moved[1] - 1.0) < 1e-6, moved
    assert abs(moved[2]) < 1e-6, moved
    assert [e.describe() for e in document.history.entries] == ["Move lid"]
    assert document.selection == (2,), "a drag on a handle selects nothing"
    app.ui.session.undo()
    assert nodes.translation[2].tolist() == [0.0, 1.0, 0.0]


def two_gizmo_drags_are_two_entries(ctx: Any, app: App) -> None:
    document = prepare(ctx, app, 2)
    for _ in range(2):
        at = document.runtime.scene.nodes.world_matrix(2)[:3, 3]
        drag(ctx, on_screen(app, at, 0.05), on_screen(app, at, 0.1))
    assert [e.describe() for e in document.history.entries] == ["Move lid", "Move lid"]


def ctrl_snaps_to_whole_steps(ctx: Any, app: App) -> None:
    document = prepare(ctx, app, 2)
    ctx.key_down(imgui.Key.mod_ctrl)
    drag(ctx, on_screen(app, (0, 1, 0), 0.05), on_screen(app, (0, 1, 0), 0.21))
    ctx.key_up(imgui.Key.mod_ctrl)
    x = document.runtime.scene.nodes.translation[2][0]
    assert x > 0.2, x
    assert abs(x / 0.1 - round(x / 0.1)) < 1e-3, x


def a_selection_of_many_moves_together(ctx: Any, app: App) -> None:
    document = prepare(ctx, app, 3, 4)  # lamp and eye, both at the origin
    nodes = document.runtime.scene.nodes
    document.edit("nodes", "translation", (3, 4), ((0.5, 1.0, 0.0), (-0.5, 1.0, 0.0)))
    ctx.yield_(2)
    drag(ctx, on_screen(app, (0, 1, 0), 0.05), on_screen(app, (0, 1, 0), 0.15))
    assert nodes.translation[3][0] - nodes.translation[4][0] == 1.0
    assert nodes.translation[3][0] > 0.6
    assert len(document.history.entries) == 2


def the_gizmo_turns_and_scales(ctx: Any, app: App) -> None:
    document = prepare(ctx, app, 2, mode="scale")
    nodes = document.runtime.scene.nodes
    drag(ctx, on_screen(app, (0, 1, 0), 0.055), on_screen(app, (0, 1, 0), 0.1))
    assert nodes.scale[2][0] > 1.2, nodes.scale[2]
    assert nodes.scale[2][1:].tolist() == [1.0, 1.0]
    assert document.history.undo_label == "Scale lid"
    app.ui.session.undo()
    app.ui.session.tools.mode = "rotate"
    ctx.yield_(2)
    # seen from the front, the ring round Z is a circle
    drag(ctx, on_screen(app, (0, 1, 0), 0.08), on_screen(app, (0, 1, 0), 0.03, -0.08))
    assert document.history.undo_label == "Turn lid"
    assert nodes.translation[2].tolist() == [0.0, 1.0, 0.0]
    assert nodes.scale[2].tolist() == [1.0, 1.0, 1.0]
    assert abs(float((nodes.rotation[2] ** 2).sum()) - 1.0) < 1e-9


def what_is_edited_is_set_for_all_selected(ctx: Any, app: App) -> None:
    document = prepare(ctx, app, 3, 2)
    nodes = document.runtime.scene.nodes
    ctx.item_drag_with_delta("//###Inspector/transform/##translation/$$0", (40, 0))
    ctx.yield_(2)
    x = nodes.translation[2][0]
    assert x != 0.0
    assert nodes.translation[3].tolist() == [x, 0.0, 0.0], "only the component that was edited"
    assert nodes.translation[2].tolist() == [x, 1.0, 0.0]
    assert [e.describe() for e in document.history.entries] == ["Move 2 nodes"]


def the_console_runs_what_is_entered(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    app.ui.session.ui.focus_panel = "Console"
    ctx.yield_(3)
    ctx.item_click("//###Console/##line")
    ctx.key_chars_append_enter("edit('nodes', 'name', [2], ['typed'])")
    ctx.yield_(3)
    assert document.runtime.scene.nodes.name[2] == "typed"
    ctx.key_press(imgui.Key.up_arrow)
    ctx.yield_(2)
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.z)
    ctx.yield_(2)
    assert document.runtime.scene.nodes.name[2] == "typed", "undo in the line is the line's"


def alt_drag_orbits_although_the_gizmo_is_there(ctx: Any, app: App) -> None:
    document = prepare(ctx, app, 2)
    yaw = app.ui.session.camera.yaw
    ctx.key_down(imgui.Key.mod_alt)
    drag(ctx, on_screen(app, (0, 1, 0), 0.05), on_screen(app, (0, 1, 0), 0.2))
    ctx.key_up(imgui.Key.mod_alt)
    assert app.ui.session.camera.yaw != yaw
    assert not document.dirty


def keys_choose_the_tool(ctx: Any, app: App) -> None:
    prepare(ctx, app, 2)
    tools = app.ui.session.tools
    for key, mode in ((imgui.Key.q, "select"), (imgui.Key.e, "rotate"), (imgui.Key.r, "scale"), (imgui.Key.w, "move")):
        ctx.key_press(key)
        ctx.yield_()
        assert tools.mode == mode
    ctx.key_press(imgui.Key.x)
    ctx.yield_()
    assert tools.local
    tools.local = False


def delete_duplicate_and_undo_by_key(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    nodes = document.runtime.scene.nodes
    ctx.item_click("//###Scene/**/##body-1")
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.d)
    ctx.yield_(2)
    (copy,) = document.selection
    assert nodes.name[copy] == "body 2"
    ctx.item_click("//###Scene/**/##body-1")
    ctx.key_press(imgui.Key.delete)
    ctx.yield_(2)
    assert not nodes.alive[1]
    assert not nodes.alive[2]
    assert document.selection == ()
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.z)
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.z)
    ctx.yield_(2)
    assert nodes.alive.tolist() == [True] * 5
    assert not document.dirty


def a_row_dragged_onto_another_hangs_below_it(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    nodes = document.runtime.scene.nodes
    ctx.item_drag_and_drop("//###Scene/**/##lamp-3", "//###Scene/**/##lid-2")
    ctx.yield_(2)
    assert int(nodes.parent[3]) == 2
    assert nodes.world_matrix(3)[:3, 3].tolist() == [0.0, 0.0, 0.0], "it stays where it is"
    assert document.history.undo_label == "Move lamp below lid"
    ctx.item_drag_and_drop("//###Scene/**/##body-1", "//###Scene/**/##lid-2")
    ctx.yield_(2)
    assert app.ui.session.ui.error_bar, "a node cannot hang below its own child"
    assert int(nodes.parent[1]) == 0
    app.ui.session.ui.error_bar = ""


def f2_renames_in_the_tree(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    ctx.item_click("//###Scene/**/##lid-2")
    ctx.key_press(imgui.Key.f2)
    ctx.yield_(3)
    ctx.key_chars_replace_enter("cover")
    ctx.yield_(2)
    assert document.runtime.scene.nodes.name[2] == "cover"
    assert document.history.undo_label == "Rename lid"


def shift_click_selects_all_between(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    ctx.item_click("//###Scene/**/##body-1")
    ctx.key_down(imgui.Key.mod_shift)
    ctx.item_click("//###Scene/**/##lamp-3")
    ctx.key_up(imgui.Key.mod_shift)
    assert set(document.selection) == {1, 2, 3}
    assert document.primary == 3


def a_click_in_the_history_goes_there(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    session = app.ui.session
    session.ui.focus_panel = "History"
    for i in range(3):
        session.edit("nodes", "name", (1,), (f"n{i}",))
    ctx.yield_(3)
    ctx.item_click("//###History/**/##entry1")
    ctx.yield_(2)
    assert document.runtime.scene.nodes.name[1] == "n0"
    ctx.item_click("//###History/**/##entry3")
    ctx.yield_(2)
    assert document.runtime.scene.nodes.name[1] == "n2"
    ctx.item_click("//###History/**/##entry0")
    ctx.yield_(2)
    assert document.runtime.scene.nodes.name[1] == "body"
    assert not document.dirty


def a_box_selects_what_is_in_it(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    document.edit("nodes", "translation", (4,), ((0.0, 1.0, -100.0),))
    drag(ctx, on_screen(app, (0, 1, 0), -0.2, -0.12), on_screen(app, (0, 1, 0), 0.2, 0.12))
    assert document.selection == (2, 4), "the lid and the far camera's sign; the body's middle lies below"


def alt_click_lists_what_is_under_the_pointer(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    document.runtime.picked = 2
    ctx.mouse_move_to_pos(on_screen(app, (0, 1, 0), 0.15))
    ctx.key_down(imgui.Key.mod_alt)
    ctx.mouse_click(0)
    ctx.key_up(imgui.Key.mod_alt)
    ctx.yield_(3)
    ctx.item_click("//$FOCUSED/body##pick1")
    ctx.yield_(2)
    assert document.selection == (1,)


def measuring_takes_two_points(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    document.runtime.picked = 2
    session = app.ui.session
    ctx.key_press(imgui.Key.m)
    ctx.yield_(2)
    assert session.tools.measuring
    for x in (0.1, -0.1):
        ctx.mouse_move_to_pos(on_screen(app, (0, 1, 0), x))
        ctx.mouse_click(0)
        ctx.yield_(2)
    assert session.tools.distance == 0.0, "the fake has one surface point"
    assert document.selection == ()
    ctx.key_press(imgui.Key.m)
    ctx.yield_(2)
    assert not session.tools.measuring
    assert session.tools.points == []


def a_sign_selects_its_light(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    document.edit("nodes", "translation", (3,), ((1.0, 1.5, 0.0),))
    ctx.mouse_move_to_pos(on_screen(app, (1.0, 1.5, 0.0)))
    ctx.yield_(3)
    assert app.panel(ViewportPanel).marker == 3
    ctx.mouse_click(0)
    ctx.yield_(2)
    assert document.selection == (3,)


def isolating_hides_the_rest_and_brings_it_back(ctx: Any, app: App) -> None:
    document = prepare(ctx, app, 2)
    nodes = document.runtime.scene.nodes
    document.selection = (3,)
    ctx.key_press(imgui.Key.mod_shift | imgui.Key.h)
    ctx.yield_(2)
    assert not nodes.visible[1]
    assert not nodes.visible[2]
    assert nodes.visible[3]
    ctx.key_press(imgui.Key.mod_shift | imgui.Key.h)
    ctx.yield_(2)
    assert nodes.visible.all()


def what_a_dead_session_left_is_offered_and_restored(ctx: Any, app: App) -> None:
    session = app.ui.session
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "recovery"
        (Path(name) / "thing.scene.json").write_text("{}")
        session.recovery_folder = folder
        session.close()
        session.open(Path(name) / "thing.glb")
        settle(ctx, app)
        document = session.document
        session.edit("nodes", "name", (1,), ("kept",))
        assert session.journal is not None
        session.journal.leave()
        session.journal = None
        session.recovery_folder = None
        fresh(ctx, app)
        session.ui.recoveries = pending(folder)
        assert len(session.ui.recoveries) == 1
        ctx.yield_(3)
        ctx.item_click("//Unsaved edits/Restore")
        ctx.yield_(3)
        assert session.document is not None
        assert session.document is not document
        assert session.document.runtime.scene.nodes.name[1] == "kept"
        assert session.document.dirty
        assert list(folder.iterdir()) == []


def the_add_menu_adds(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    ctx.menu_click("//##MainMenuBar/Add/###add.spot-light")
    ctx.yield_(2)
    (row,) = document.selection
    assert document.runtime.scene.nodes.name[row] == "Spot light"
    assert document.runtime.scene.lights.alive_count == 2
    ctx.menu_click("//##MainMenuBar/Add/###add.camera")
    ctx.yield_(2)
    (row,) = document.selection
    eye = document.runtime.scene.nodes.world_matrix(row)[:3, 3]
    assert np.allclose(eye, app.ui.session.camera.eye())


def the_new_panels_draw_without_a_real_frame(ctx: Any, app: App) -> None:
    prepare(ctx, app, 2)
    for title in ("Frame graph", "Textures", "History"):
        app.ui.session.ui.focus_panel = title
        ctx.yield_(3)
    app.ui.session.close()
    ctx.yield_(3)
    app.ui.session.open(Path("/nowhere/thing.glb"))
    settle(ctx, app)
    app.ui.session.ui.focus_panel = "Viewport"
    ctx.yield_(3)


def lights_are_scattered_by_a_button(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    panel, table = app.panel(LightsPanel), document.runtime.scene.lights
    panel.settings.count = 7
    app.ui.session.ui.focus_panel = "Lights"
    ctx.yield_(3)
    ctx.item_click("//###Lights/###scatter")
    ctx.yield_(2)
    assert table.alive_count == 8
    assert [e.describe() for e in document.history.entries] == ["Scatter 7 lights"]
    document.selection = (3,)
    ctx.yield_(2)
    ctx.item_click("//###Lights/###array")
    ctx.yield_(2)
    assert table.alive_count == 10, "three of the lamp"
    assert [e.describe() for e in document.history.entries][-1] == "Line of 3"
    app.ui.session.undo()
    app.ui.session.undo()
    assert table.alive_count == 1
    app.ui.session.ui.focus_panel = "Inspector"
    ctx.yield_(2)


def every_kind_of_light_can_be_added_and_shown(ctx: Any, app: App) -> None:
    document = prepare(ctx, app)
    table = document.runtime.scene.lights
    app.ui.session.preferences.show_lights = True
    for kind in LIGHT_TYPES:
        app.ui.operations.run(f"add.{kind}-light", app.ui.session)
        ctx.yield_(3)
        row = int(np.flatnonzero(table.alive & (table.node == document.primary))[0])
        assert LIGHT_TYPES[table.type[row]] == kind
        assert ctx.item_info(f"//###Inspector/**/brightness{row}/##value").id_ != 0, kind
    app.ui.session.edit("lights", "profile", [row], ["no such.ies"])
    app.ui.session.edit("lights", "type", [row], ["point"])
    ctx.yield_(3)
    app.ui.session.preferences.show_lights = False


TESTS = {
    f.__name__: f
    for f in (
        lights_are_scattered_by_a_button,
        every_kind_of_light_can_be_added_and_shown,
        the_gizmo_moves_along_an_axis_as_one_entry,
        two_gizmo_drags_are_two_entries,
        ctrl_snaps_to_whole_steps,
        a_selection_of_many_moves_together,
        the_gizmo_turns_and_scales,
        what_is_edited_is_set_for_all_selected,
        the_console_runs_what_is_entered,
        alt_drag_orbits_although_the_gizmo_is_there,
        keys_choose_the_tool,
        delete_duplicate_and_undo_by_key,
        a_row_dragged_onto_another_hangs_below_it,
        f2_renames_in_the_tree,
        shift_click_selects_all_between,
        a_click_in_the_history_goes_there,
        a_box_selects_what_is_in_it,
        alt_click_lists_what_is_under_the_pointer,
        measuring_takes_two_points,
        a_sign_selects_its_light,
        isolating_hides_the_rest_and_brings_it_back,
        what_a_dead_session_left_is_offered_and_restored,
        the_add_menu_adds,
        the_new_panels_draw_without_a_real_frame,
    )
}

if __name__ == "__main__":
    main(TESTS)
