"""Beside the state graph: parameters to steer by, the chosen state or transition, and the layers over the states."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from imgui_bundle import imgui

from editor import icons, theme
from editor.animating.editing import AnimationEditor
from editor.animating.following import animation_of, runtime_of
from editor.panels.timeline_menus import attempt, draw_reference
from editor.ui import Ui
from editor.widgets import em, icon_button, pretty, section, text, tooltip
from engine.animation.blend import CURVES

MODES = ("loop", "once", "ping-pong")
_WIDTH = 6.5


def draw_side(ui: Ui, editor: AnimationEditor) -> None:
    view = ui.session.animating
    if 0 <= view.transition < len(editor.model.transitions):
        _transition(ui, editor, view.transition)
    elif view.state in editor.model.states:
        _state(ui, editor, view.state)
    if section(ui, "Parameters"):
        _params(ui, editor)
    if section(ui, "Layers"):
        _layers(ui, editor)


def _params(ui: Ui, editor: AnimationEditor) -> None:
    """Each steers the character now; its menu changes the file."""
    animator = animation_of(ui.session).animator
    if not editor.model.params:
        text("None yet", theme.FAINT)
    for name, param in list(editor.model.params.items()):
        imgui.push_id(name)
        value = float(animator.machine.values[animator.machine.param(name), 0]) if animator is not None else 0.0
        new: float = value
        if param.type == "float":
            imgui.set_next_item_width(em(_WIDTH - 1.5))
            changed, new = imgui.drag_float(name, value, 0.02)
        elif param.type == "bool":
            changed, ticked = imgui.checkbox(name, value != 0.0)
            new = float(ticked)
        else:
            changed, new = imgui.button(name), 1.0
        tooltip("Steers the character now. Right click: its name, its default")
        if imgui.begin_popup_context_item("##param"):
            _param_menu(ui, editor, name, param)
            imgui.end_popup()
        if changed:
            attempt(ui, lambda name=name, new=new: editor.set_param(name, float(new)))
        imgui.pop_id()


def _param_menu(ui: Ui, editor: AnimationEditor, name: str, param: Any) -> None:
    entered, wanted = imgui.input_text("Name", name, imgui.InputTextFlags_.enter_returns_true)
    if entered and wanted.strip() not in ("", name):
        attempt(ui, lambda: editor.rename("params", name, wanted.strip()))
        imgui.close_current_popup()
    tooltip("Enter renames it wherever it is used")
    if param.type == "float":
        changed, value = imgui.drag_float("Default", float(param.default), 0.02)
        if changed:
            attempt(ui, lambda: editor.set_default(name, float(value), ("default", name)))
    elif param.type == "bool":
        changed, ticked = imgui.checkbox("Default", bool(param.default))
        if changed:
            attempt(ui, lambda: editor.set_default(name, bool(ticked)))
    if imgui.menu_item_simple("Delete parameter"):
        attempt(ui, lambda: editor.remove_param(name))


def _plays(ui: Ui, editor: AnimationEditor, user: Any, put: Callable[..., None]) -> None:
    """The clip or blend space that a state or layer plays."""
    imgui.set_next_item_width(em(_WIDTH))
    if imgui.begin_combo("Plays", user.clip or f"{user.blend} (blend)"):
        for blend in editor.model.blends:
            if imgui.selectable(f"{blend} (blend)", blend == user.blend)[0]:
                put(blend=blend, clip=None)
        for clip in runtime_of(ui.session).clips:
            key = next((k for k, c in editor.model.clips.items() if (c.source or k) == clip.name), "")
            if imgui.selectable(clip.name, bool(key) and key == user.clip)[0]:
                put(clip=clip.name, blend=None)
        imgui.end_combo()


def _state(ui: Ui, editor: AnimationEditor, name: str) -> None:
    view, state = ui.session.animating, editor.model.states[name]

    def put(gesture: Any = None, **values: Any) -> None:
        attempt(ui, lambda: editor.set_state(name, gesture=gesture, **values))

    if not section(ui, f"State {name}###state"):
        return
    imgui.set_next_item_width(em(_WIDTH))
    entered, wanted = imgui.input_text("Name", name, imgui.InputTextFlags_.enter_returns_true)
    if entered and wanted.strip() not in ("", name):
        attempt(ui, lambda: editor.rename("states", name, wanted.strip()))
        view.state = wanted.strip() if wanted.strip() in editor.model.states else name
        return
    _plays(ui, editor, state, put)
    imgui.set_next_item_width(em(_WIDTH))
    changed, speed = imgui.drag_float("Speed", state.speed, 0.01, -10.0, 10.0, "× %.2f")
    if changed:
        put(("speed", name), speed=float(speed))
    imgui.set_next_item_width(em(_WIDTH))
    changed, chosen = imgui.combo("At its end", MODES.index(state.mode), [pretty(m) for m in MODES])
    if changed:
        put(mode=MODES[chosen])
    changed, first = imgui.checkbox("Start here", editor.model.start == name)
    if changed:
        attempt(ui, lambda: editor.put((("start",), name if first else None), label=f"Start in {name}"))
    if imgui.small_button(f"{icons.TRASH} Delete state"):
        attempt(ui, lambda: editor.remove_state(name))
        view.state = ""


def _transition(ui: Ui, editor: AnimationEditor, number: int) -> None:
    t, view = editor.model.transitions[number], ui.session.animating

    def put(gesture: Any = None, **values: Any) -> None:
        attempt(ui, lambda: editor.set_transition(number, gesture=gesture, **values))

    if not section(ui, f"{t.source} → {t.target}###transition"):
        return
    text("Taken when", theme.DIM)
    imgui.set_next_item_width(-em(0.3))
    entered, words = imgui.input_text("##when", ", ".join(t.when), imgui.InputTextFlags_.enter_returns_true)
    tooltip("All must hold, a comma between: speed > 0.5, armed, !tired. Enter sets it. Empty: at once, or at its exit")
    if entered:
        put(when=[part.strip() for part in words.split(",") if part.strip()])
    imgui.set_next_item_width(em(_WIDTH))
    changed, fade = imgui.drag_float("Fade", t.fade, 0.01, 0.0, 10.0, "%.2f s")
    if changed:
        put(("fade", number), fade=float(fade))
    imgui.set_next_item_width(em(_WIDTH))
    changed, chosen = imgui.combo("Curve", CURVES.index(t.curve), [pretty(c) for c in CURVES])
    if changed:
        put(curve=CURVES[chosen])
    changed, waits = imgui.checkbox("Waits for the end", t.exit is not None)
    tooltip("It is taken only once the state has run so far")
    if changed:
        put(exit=1.0 if waits else None)
    if t.exit is not None:
        imgui.set_next_item_width(em(_WIDTH))
        changed, share = imgui.slider_float("From", 100.0 * t.exit, 0.0, 100.0, "%.0f %%")
        if changed:
            put(("exit", number), exit=min(max(float(share) / 100.0, 0.0), 1.0))
    changed, sync = imgui.checkbox("Start in step", t.sync)
    tooltip("The new state begins at the phase of the old one: feet fall together")
    if changed:
        put(sync=sync)
    if imgui.small_button(f"{icons.TRASH} Delete transition"):
        attempt(ui, lambda: editor.remove_transition(number))
        view.transition = -1


def _layers(ui: Ui, editor: AnimationEditor) -> None:
    """Motions over the states' pose, each with its mask and weight; a later one lies over those before it."""
    for number, layer in enumerate(editor.model.layers):
        imgui.push_id(number)
        about = [layer.mode, f"mask {layer.mask}" if layer.mask else "whole body"]
        opened = imgui.tree_node(f"{layer.name}###layer")
        tooltip(" · ".join(about))
        if opened:
            _layer(ui, editor, number)
            imgui.tree_pop()
        imgui.pop_id()
        if number >= len(editor.model.layers):  # deleted just now
            break
    if imgui.small_button(f"{icons.ADD} Layer"):
        imgui.open_popup("##layer")
    tooltip("A clip over the states, on the whole body or through a mask")
    if imgui.begin_popup("##layer"):
        for clip in runtime_of(ui.session).clips:
            if imgui.menu_item_simple(clip.name):
                attempt(ui, lambda name=clip.name: editor.add_layer(name))
        imgui.end_popup()


def _layer(ui: Ui, editor: AnimationEditor, number: int) -> None:
    layer, model = editor.model.layers[number], editor.model

    def put(gesture: Any = None, **values: Any) -> None:
        attempt(ui, lambda: editor.set_layer(number, gesture=gesture, **values))

    width = em(_WIDTH - 1.0)
    imgui.set_next_item_width(width)
    entered, name = imgui.input_text("Name", layer.name, imgui.InputTextFlags_.enter_returns_true)
    if entered and name.strip():
        put(name=name.strip())
    _plays(ui, editor, layer, put)
    masks = ["", *model.masks]
    imgui.set_next_item_width(width)
    changed, chosen = imgui.combo("Mask", masks.index(layer.mask), ["Everything", *model.masks])
    if changed:
        put(mask=masks[chosen] or None)
    imgui.set_next_item_width(width)
    modes = ["override", "additive"]
    changed, chosen = imgui.combo("Mode", modes.index(layer.mode), ["Override", "Additive"])
    if changed:
        put(mode=modes[chosen], **({} if chosen else {"reference": None, "reference_time": None}))
    if layer.mode == "additive":
        draw_reference(editor, layer, put)
    floats = ["", *model.params]
    steered = layer.weight if isinstance(layer.weight, str) else ""
    imgui.set_next_item_width(width)
    changed, chosen = imgui.combo("Weight by", floats.index(steered), ["A number", *model.params])
    tooltip("A number, or the parameter that gives it")
    if changed:
        put(weight=floats[chosen] or 1.0)
    if not steered:
        imgui.set_next_item_width(width)
        changed, weight = imgui.slider_float("Weight", float(layer.weight), 0.0, 1.0)
        if changed:
            put(("layer weight", number), weight=float(weight))
    imgui.set_next_item_width(width)
    changed, speed = imgui.drag_float("Speed", layer.speed, 0.01, -10.0, 10.0, "× %.2f")
    if changed:
        put(("layer speed", number), speed=float(speed))
    imgui.set_next_item_width(width)
    changed, chosen = imgui.combo("At its end", MODES.index(layer.play), [pretty(m) for m in MODES])
    if changed:
        put(play=MODES[chosen])
    if icon_button(f"{icons.UP}##up", "Over the next one", enabled=number + 1 < len(model.layers)):
        attempt(ui, lambda: editor.move_layer(number, 1))
    imgui.same_line()
    if icon_button(f"{icons.TRASH}##delete", "Delete the layer"):
        attempt(ui, lambda: editor.remove_layer(number))
