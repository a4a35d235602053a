"""UI tests of the panels; run by test_ui_panels.py in a process of its own."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

from imgui_bundle import imgui  # noqa: E402  (the path is set above)
from ui_harness import fresh, main, settle  # noqa: E402  (needs the path above)

from editor.app import App  # noqa: E402  (needs the path above)


def click_selects_node(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    ctx.item_click("//###Scene/**/##lid-2")
    assert document.selection == (2,)
    assert app.ui.session.node_name(document.primary) == "lid"


def ctrl_click_adds(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    ctx.item_click("//###Scene/**/##body-1")
    ctx.key_down(imgui.Key.mod_ctrl)
    ctx.item_click("//###Scene/**/##lamp-3")
    ctx.key_up(imgui.Key.mod_ctrl)
    assert document.selection == (1, 3)


def eye_hides_and_undo_shows(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    nodes = document.runtime.scene.nodes
    ctx.item_click("//###Scene/**/###eye1")
    assert not nodes.visible[1]
    assert document.dirty
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.z)
    assert nodes.visible[1]
    assert not document.dirty
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.y)
    assert not nodes.visible[1]


def slider_drag_is_one_entry_and_changes_the_picture(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    session = app.ui.session
    ctx.item_click("//###Scene/**/##body-1")
    ctx.yield_(2)
    before = session.image.pixels().copy()
    value = document.runtime.residency.records[0].asset.params["roughness"]
    ctx.item_drag_with_delta("//###Inspector/**/roughness/##value", (60, 0))
    ctx.yield_(2)
    after = document.runtime.residency.records[0].asset.params["roughness"]
    assert after != value
    assert len(document.history.entries) == 1, [c.describe() for c in document.history.entries]
    assert (session.image.pixels() != before).any(), "the picture follows the slider"
    session.undo()
    ctx.yield_(2)
    assert document.runtime.residency.records[0].asset.params["roughness"] == value
    assert (session.image.pixels() == before).all()


def two_drags_are_two_entries(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    ctx.item_click("//###Scene/**/##body-1")
    for delta in (40, -70):
        ctx.item_drag_with_delta("//###Inspector/**/roughness/##value", (delta, 0))
        ctx.yield_(2)
    assert len(document.history.entries) == 2


def transform_is_edited_and_named_in_the_history(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    ctx.item_click("//###Scene/**/##lid-2")
    ctx.item_drag_with_delta("//###Inspector/transform/##rotation/$$1", (30, 0))
    ctx.yield_(2)
    q = document.runtime.scene.nodes.rotation[2]
    assert abs(q[1]) > 0.01, q
    assert abs(q[0]) + abs(q[2]) < 1e-9, q
    assert document.history.undo_label == "Rotate lid"


def reset_button_restores_the_default(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    ctx.item_click("//###Scene/**/##body-1")
    ctx.item_drag_with_delta("//###Inspector/**/metallic/##value", (-80, 0))
    ctx.yield_(2)
    params = document.runtime.residency.records[0].asset.params
    assert params["metallic"] < 1.0
    ctx.item_click("//###Inspector/**/metallic/###reset")
    ctx.yield_(2)
    assert params["metallic"] == 1.0


def search_filters_the_tree(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    from editor.panels.scene_tree import SceneTreePanel

    panel = app.panel(SceneTreePanel)
    ctx.item_input_value("//###Scene/##search", "LID")
    ctx.yield_(2)
    assert [r.row for r in panel._rows] == [0, 1, 2], "the match with its ancestors"
    ctx.item_input_value("//###Scene/##search", "")
    ctx.yield_(2)
    assert len(panel._rows) == 5


def nothing_changes_nothing_is_rendered(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    ctx.mouse_move_to_pos((5, 5))
    ctx.yield_(10)
    image = app.ui.session.image
    before = image.renders
    ctx.yield_(30)
    assert image.renders == before, f"{image.renders - before} renders while idle"
    app.ui.session.settings.exposure = 1.0
    ctx.yield_(5)
    assert image.renders == before + 1
    app.ui.session.reset_settings()


def palette_runs_an_operation(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    document.select(1)
    ctx.yield_()
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.mod_shift | imgui.Key.p)
    ctx.yield_(2)
    ctx.key_chars("hide or")
    ctx.yield_()
    ctx.key_press(imgui.Key.enter)
    ctx.yield_(2)
    assert not document.runtime.scene.nodes.visible[1]


def typing_in_a_field_runs_no_shortcut(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    document.select(1)
    ctx.item_click("//###Scene/##search")
    ctx.key_chars("h")
    ctx.yield_(2)
    assert document.runtime.scene.nodes.visible[1]
    ctx.item_input_value("//###Scene/##search", "")


def viewport_click_picks_and_drag_orbits(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    document.runtime.picked = 2
    ctx.item_click("//###Viewport/##picture")
    assert document.selection == (2,)
    camera = app.ui.session.camera
    ctx.mouse_move("//###Viewport/##picture")
    ctx.key_down(imgui.Key.mod_alt)
    ctx.mouse_down(0)
    ctx.mouse_move_to_pos(imgui.ImVec2(imgui.get_io().mouse_pos.x + 80, imgui.get_io().mouse_pos.y))
    ctx.mouse_up(0)
    ctx.key_up(imgui.Key.mod_alt)
    turned = app.ui.session.camera
    assert turned.yaw != camera.yaw
    assert turned.target == camera.target
    assert document.selection == (2,), "a drag selects nothing"
    ctx.mouse_wheel_y(2)
    ctx.yield_()
    assert app.ui.session.camera.distance < turned.distance


def a_bad_file_keeps_the_document(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    session = app.ui.session
    for name in ("bad.glb", "broken.glb"):
        session.open(Path(f"/nowhere/{name}"))
        while session.job is not None:
            ctx.yield_()
        ctx.yield_(2)
        assert session.document is document
        assert session.ui.error_bar
        ctx.item_click("//##error-bar/Dismiss")
        assert not session.ui.error_bar
    assert session.messages.counts()


def a_slow_file_can_be_cancelled(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    session = app.ui.session
    session.open(Path("/nowhere/slow.glb"))
    ctx.sleep_no_skip(0.5, 0.05)
    ctx.item_click("//###progress/Cancel")
    for _ in range(200):
        if session.job is None:
            break
        ctx.yield_()
    assert session.job is None
    assert session.document is document


def unsaved_changes_are_asked_about(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    session = app.ui.session
    session.set_visible((1,), False)
    app.ui.operations.run("file.close", session)
    ctx.yield_(2)
    ctx.item_click("//Unsaved changes/Cancel")
    ctx.yield_(2)
    assert session.document is document
    app.ui.operations.run("file.close", session)
    ctx.yield_(2)
    ctx.item_click("//Unsaved changes/Discard")
    ctx.yield_(2)
    assert session.document is None
    assert document.runtime.closed


def documents_have_tabs(ctx: Any, app: App) -> None:
    first = fresh(ctx, app)
    session = app.ui.session
    session.set_visible((1,), False)
    app.dropped([Path("/nowhere/other.glb"), Path("/nowhere/third.glb")])
    for _ in range(400):
        if len(session.tabs) == 3 and session.job is None:
            break
        ctx.yield_()
    ctx.yield_(3)
    third = session.document
    assert third.source.name == "third.glb"
    ctx.item_click(f"//###Viewport/##documents/###document{id(first)}")
    ctx.yield_(3)
    assert session.document is first
    assert session.document.history.undo_label
    ctx.key_press(imgui.Key.mod_ctrl.value | imgui.Key.mod_shift.value | imgui.Key.tab.value)
    ctx.yield_(3)
    assert session.document is third
    ctx.key_press(imgui.Key.mod_ctrl.value | imgui.Key.tab.value)
    ctx.yield_(3)
    assert session.document is first


def menu_undo_names_the_edit(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    app.ui.session.set_visible((1,), False)
    ctx.menu_click("//##MainMenuBar/Edit/###edit.undo")
    assert app.ui.session.document.runtime.scene.nodes.visible[1]


def every_panel_draws_every_selection(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    for row in (-1, 0, 1, 2, 3, 4):
        document.select(row)
        ctx.yield_(2)
    ctx.window_focus("//###Render settings")
    ctx.yield_(2)
    app.ui.session.close()
    ctx.yield_(3)


def a_node_can_be_renamed(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    ctx.item_click("//###Scene/**/##lid-2")
    ctx.item_input_value("//###Inspector/##name", "cover")
    ctx.yield_(2)
    assert document.runtime.scene.nodes.name[2] == "cover"
    assert document.history.undo_label == "Rename lid"
    app.ui.session.undo()
    assert document.runtime.scene.nodes.name[2] == "lid"


def undo_in_a_text_field_is_the_field_s(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    app.ui.session.set_visible((1,), False)
    ctx.item_click("//###Scene/##search")
    ctx.key_chars("x")
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.z)
    ctx.yield_(2)
    assert not document.runtime.scene.nodes.visible[1]
    ctx.item_input_value("//###Scene/##search", "")


def the_open_dialog_lists_and_cancels(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.o)
    ctx.yield_(3)
    ctx.item_click("//Open/Cancel")
    ctx.yield_(2)
    assert app.ui.session.document is document


def layout_comes_back(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    windows = {w.label.split("###")[1]: w for w in app.params.docking_params.dockable_windows}
    windows["Log"].is_visible = False
    ctx.yield_(3)
    app.ui.operations.run("view.reset-layout", app.ui.session)
    ctx.yield_(3)
    assert windows["Log"].is_visible


def without_a_document_every_panel_says_what_to_do(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    app.ui.session.close()
    app.ui.session.preferences.recent = ["/nowhere/thing.glb"]
    ctx.yield_(3)
    ctx.item_click("//###Viewport/###recent0")
    settle(ctx, app)
    assert app.ui.session.document is not None


TESTS = {
    f.__name__: f
    for f in (
        click_selects_node,
        ctrl_click_adds,
        eye_hides_and_undo_shows,
        slider_drag_is_one_entry_and_changes_the_picture,
        two_drags_are_two_entries,
        transform_is_edited_and_named_in_the_history,
        reset_button_restores_the_default,
        search_filters_the_tree,
        nothing_changes_nothing_is_rendered,
        palette_runs_an_operation,
        typing_in_a_field_runs_no_shortcut,
        viewport_click_picks_and_drag_orbits,
        a_bad_file_keeps_the_document,
        a_slow_file_can_be_cancelled,
        unsaved_changes_are_asked_about,
        documents_have_tabs,
        menu_undo_names_the_edit,
        a_node_can_be_renamed,
        undo_in_a_text_field_is_the_field_s,
        the_open_dialog_lists_and_cancels,
        layout_comes_back,
        without_a_document_every_panel_says_what_to_do,
        every_panel_draws_every_selection,
    )
}

if __name__ == "__main__":
    main(TESTS)
