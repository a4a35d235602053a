"""UI tests of mouse, trackpad and keys in the viewport, by keymap preset; run by test_ui_pointer.py in a process of its
own."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
from imgui_bundle import imgui  # noqa: E402  (needs the path above)
from ui_harness import fresh, main  # noqa: E402  (needs the path above)

from editor import physical_keys  # noqa: E402  (needs the path above)
from editor.app import App  # noqa: E402  (needs the path above)
from editor.camera_controls import OrbitCamera  # noqa: E402  (needs the path above)
from editor.navigation import PRESETS  # noqa: E402  (needs the path above)
from editor.panels.viewport import ViewportPanel  # noqa: E402  (needs the path above)

BUTTONS = {"left": 0, "right": 1, "middle": 2}
MODIFIERS = {"ctrl": imgui.Key.mod_ctrl, "shift": imgui.Key.mod_shift, "alt": imgui.Key.mod_alt}
#: what two fingers alone do
FINGERS = {"industry": "pan", "blender": "orbit", "viewer": "pan"}


def moved(before: OrbitCamera, after: OrbitCamera) -> str:
    """The motion that leads from one camera to the other."""
    if after == before:
        return ""
    if not np.isclose(after.distance, before.distance, rtol=1e-9):
        return "zoom"
    if np.allclose(after.target, before.target, atol=1e-9):
        return "orbit"
    if (after.yaw, after.pitch) == (before.yaw, before.pitch):
        return "pan"
    return "look" if np.allclose(after.eye(), before.eye(), atol=1e-6) else "mixed"


def free_spot(app: App) -> tuple[float, float]:
    """A place in the picture where nothing else takes a press."""
    x, y, width, height = app.panel(ViewportPanel).area
    return x + 0.3 * width, y + 0.75 * height


def hold(ctx: Any, modifiers: Iterable[str], down: bool) -> None:
    for name in modifiers:
        (ctx.key_down if down else ctx.key_up)(MODIFIERS[name])
    ctx.yield_()


def with_preset(app: App, preset: str, pointer: str = "mouse") -> None:
    app.ui.session.preferences.keymap, app.ui.session.preferences.pointer = preset, pointer
    app.ui.session.preferences.reverse_scroll = False


def drag(ctx: Any, app: App, button: str, modifiers: Iterable[str]) -> str:
    """The motion of a drag to the right and up."""
    session = app.ui.session
    x, y = free_spot(app)
    ctx.mouse_move_to_pos((x, y))
    ctx.yield_(2)
    before = session.camera
    light = float(getattr(session.settings, "environment_rotation", 0.0))
    hold(ctx, modifiers, True)
    ctx.mouse_down(BUTTONS[button])
    ctx.mouse_move_to_pos((x + 60, y - 40))
    ctx.yield_(2)
    ctx.mouse_up(BUTTONS[button])
    hold(ctx, modifiers, False)
    found = moved(before, session.camera)
    if not found and float(getattr(session.settings, "environment_rotation", 0.0)) != light:
        found = "environment"
    session.camera = before
    return found


def wheel(ctx: Any, app: App, x: float, y: float, modifiers: Iterable[str] = ()) -> tuple[OrbitCamera, OrbitCamera]:
    """The camera before and after the wheel, or two fingers, over the picture."""
    session = app.ui.session
    ctx.mouse_move_to_pos(free_spot(app))
    ctx.yield_()
    before = session.camera
    hold(ctx, modifiers, True)
    ctx.mouse_wheel((x, y))
    ctx.yield_(2)
    hold(ctx, modifiers, False)
    after = session.camera
    session.camera = before
    return before, after


def every_binding_of_every_preset_moves_as_it_says(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    expected = {
        "orbit": "orbit", "pan": "pan", "dolly": "zoom", "fly": "look", "environment": "environment", "select": "",
    }  # fmt: skip
    for preset, bindings in PRESETS.items():
        with_preset(app, preset)
        for binding in bindings:
            seen = drag(ctx, app, binding.button, binding.modifiers)
            assert seen == expected[binding.motion], f"{preset}: {binding} gave {seen!r}"


def one_finger_with_alt_stands_for_three_buttons(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    for preset in PRESETS:
        with_preset(app, preset, "trackpad")
        assert drag(ctx, app, "left", ("alt",)) == "orbit", preset
        assert drag(ctx, app, "left", ("alt", "shift")) == "pan", preset
        assert drag(ctx, app, "left", ("ctrl", "alt")) == "zoom", preset


def two_fingers_do_what_the_keymap_says(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    for preset, motion in FINGERS.items():
        with_preset(app, preset, "trackpad")
        assert moved(*wheel(ctx, app, 0.4, 0.7)) == motion, preset
        assert moved(*wheel(ctx, app, 0.0, 0.7, ("ctrl",))) == "zoom", f"{preset}: a pinch"
        assert moved(*wheel(ctx, app, 0.4, 0.7, ("shift",))) == "pan", preset
        assert moved(*wheel(ctx, app, 0.4, 0.7, ("alt",))) == "orbit", preset
        with_preset(app, preset, "mouse")
        assert moved(*wheel(ctx, app, 0.0, 1.0)) == "zoom", preset


def what_two_fingers_move_follows_them_unless_reversed(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    with_preset(app, "industry", "trackpad")
    before, after = wheel(ctx, app, 1.0, 0.0)
    right = before.rotation()[:, 0]
    step = float((np.asarray(after.target) - np.asarray(before.target)) @ right)
    assert step < 0.0, "the picture follows to the right: the camera goes left"
    app.ui.session.preferences.reverse_scroll = True
    before, after = wheel(ctx, app, 1.0, 0.0)
    assert float((np.asarray(after.target) - np.asarray(before.target)) @ right) > 0.0
    with_preset(app, "industry")
    before, nearer = wheel(ctx, app, 0.0, 1.0)
    app.ui.session.preferences.reverse_scroll = True
    before, farther = wheel(ctx, app, 0.0, 1.0)
    assert nearer.distance < before.distance < farther.distance


def flying_goes_by_the_place_of_the_keys(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    with_preset(app, "industry")
    session = app.ui.session
    start = session.camera = replace(session.camera, pitch=0.0)
    french = {**{c: c for c in "bcdefghijklmnoprstuvxy"}, "w": "z", "z": "w", "a": "q", "q": "a"}
    read, physical_keys.read_layout = physical_keys.read_layout, lambda: french
    physical_keys._known = (-1e9, {})
    try:
        for key, axis, sign in ((imgui.Key.z, 2, -1.0), (imgui.Key.q, 0, -1.0), (imgui.Key.d, 0, 1.0)):
            ctx.mouse_move_to_pos(free_spot(app))
            ctx.mouse_down(1)
            ctx.yield_(2)
            ctx.key_down(key)
            ctx.yield_(3)
            ctx.key_up(key)
            ctx.mouse_up(1)
            ctx.yield_()
            step = session.camera.eye() - start.eye()
            assert float(step @ start.rotation()[:, axis]) * sign > 0.0, f"{key.name}: {step}"
            session.camera = start
    finally:
        physical_keys.read_layout, physical_keys._known = read, (-1e9, {})


def a_flight_needs_no_button(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    with_preset(app, "industry", "trackpad")
    session = app.ui.session
    ctx.mouse_move_to_pos(free_spot(app))
    ctx.yield_(2)
    start = session.camera
    app.ui.operations.run("view.fly", session)
    ctx.yield_(2)
    x, y = free_spot(app)
    ctx.mouse_move_to_pos((x + 40, y))
    assert moved(start, session.camera) == "look"
    looking = session.camera
    ctx.key_down(imgui.Key.w)
    ctx.yield_(3)
    ctx.key_up(imgui.Key.w)
    ahead = session.camera.eye() - looking.eye()
    assert float(ahead @ looking.rotation()[:, 2]) < 0.0
    ctx.key_press(imgui.Key.escape)
    ctx.yield_(2)
    assert not session.tools.flying
    rests = session.camera
    ctx.mouse_move_to_pos((x - 40, y))
    assert session.camera == rests


def measures() -> dict[str, Any]:
    """All sizes of the style in use."""
    style = imgui.get_style()
    values = {name: getattr(style, name) for name in dir(style) if not name.startswith("_")}
    plain = {n: (v.x, v.y) if isinstance(v, imgui.ImVec2) else v for n, v in values.items()}
    return {n: np.round(v, 3).tolist() for n, v in plain.items() if isinstance(v, (float, tuple))}


def the_interface_comes_back_from_every_scale(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    session = app.ui.session
    app.ui.operations.run("view.scale-reset", session)
    ctx.yield_(2)
    before = measures()
    for _ in range(30):
        app.ui.operations.run("view.scale-up", session)
    ctx.yield_(2)
    assert session.preferences.ui_scale == 3.0
    assert measures()["frame_padding"] == [24.0, 12.0]
    for _ in range(30):
        app.ui.operations.run("view.scale-down", session)
        ctx.yield_()
    assert session.preferences.ui_scale == 0.75
    app.ui.operations.run("view.scale-reset", session)
    ctx.yield_(2)
    after = measures()
    assert after == before, {n: (before[n], after[n]) for n in before if before[n] != after[n]}


def the_pointer_is_chosen_by_operation(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    session = app.ui.session
    app.ui.operations.run("help.pointer-trackpad", session)
    assert session.preferences.pointer == "trackpad"
    app.ui.operations.run("help.pointer-mouse", session)
    app.ui.operations.run("view.background-stop", session)
    assert (session.preferences.pointer, session.preferences.in_background) == ("mouse", "stop")
    app.ui.operations.run("view.fps-limit", session, fps=30)
    assert session.preferences.fps_limit == 30
    app.ui.operations.run("view.fps-limit", session, fps=0)
    app.ui.operations.run("view.background-slow", session)


TESTS = {
    f.__name__: f
    for f in (
        every_binding_of_every_preset_moves_as_it_says,
        one_finger_with_alt_stands_for_three_buttons,
        two_fingers_do_what_the_keymap_says,
        what_two_fingers_move_follows_them_unless_reversed,
        flying_goes_by_the_place_of_the_keys,
        a_flight_needs_no_button,
        the_interface_comes_back_from_every_scale,
        the_pointer_is_chosen_by_operation,
    )
}

if __name__ == "__main__":
    main(TESTS)
