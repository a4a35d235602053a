"""The timeline's menus: of a block, its clip's markers, a track, a marker; adding clips; root motion; frame rate."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from imgui_bundle import imgui

from editor import icons, theme
from editor.animating.editing import AnimationEditor
from editor.animating.following import animation_of, drive_of, runtime_of
from editor.ui import Ui
from editor.widgets import em, icon_button, pretty, text, tooltip
from engine.animation.blend import CURVES
from engine.core.errors import LucarnaError

RATES = (12.0, 15.0, 23.976, 24.0, 25.0, 29.97, 30.0, 48.0, 50.0, 60.0, 120.0)
#: of a block: field, label, format, what it means
_NUMBERS = (
    ("speed", "Speed", "× %.2f", "Of the clip; negative plays it backwards"),
    ("offset", "Begins at", "%.3f s", "Seconds into the clip at the block's start"),
    ("fade_in", "Fade in", "%.3f s", "Also: drag the block's upper left corner"),
    ("fade_out", "Fade out", "%.3f s", "Also: drag the block's upper right corner"),
)


def attempt(ui: Ui, change: Any) -> None:
    """What it refuses is logged and shown, and changes nothing."""
    try:
        change()
    except LucarnaError as error:
        ui.session.fail(error)


def draw_menu(ui: Ui, editor: AnimationEditor) -> None:
    """What a right click on the tracks opened."""
    if not imgui.begin_popup("##what"):
        return
    view, model = ui.session.animating, editor.model
    if model is not None and 0 <= view.marker < len(model.markers):
        _marker(ui, editor, model.markers[view.marker])
    elif model is not None and 0 <= view.track < len(model.tracks):
        track = model.tracks[view.track]
        if 0 <= view.block < len(track.blocks):
            _block(ui, editor, track.blocks[view.block])
            imgui.separator()
        _track(ui, editor, track)
    else:
        for id in ("animation.add-track", "animation.add-marker"):
            if imgui.menu_item_simple(ui.operations[id].label):
                ui.operations.run(id, ui.session)
    imgui.end_popup()


def _marker(ui: Ui, editor: AnimationEditor, marker: Any) -> None:
    view = ui.session.animating
    number = view.marker
    text("Marker of the timeline", theme.DIM)
    changed, name = imgui.input_text("Name", marker.name)
    if changed and name:
        attempt(ui, lambda: editor.set_marker(number, name=name, gesture=("marker name", number)))
    changed, time = imgui.drag_float("At", marker.time, 0.01, 0.0, 1e6, "%.3f s")
    if changed:
        attempt(ui, lambda: editor.set_marker(number, time=float(time), gesture=("marker time", number)))
    if imgui.menu_item_simple("Delete marker"):
        attempt(ui, lambda: editor.remove_marker(number))
        view.marker = -1


def _block(ui: Ui, editor: AnimationEditor, block: Any) -> None:
    view = ui.session.animating
    at = (view.track, view.block)

    def put(gesture: Any = None, **values: Any) -> None:
        attempt(ui, lambda: editor.set_block(*at, gesture=gesture, **values))

    text(f"Block of {block.clip}", theme.DIM)
    for name, label, unit, about in _NUMBERS:
        low, high = (0.0, block.length) if name.startswith("fade") else (-100.0, 100.0)
        imgui.set_next_item_width(em(8))
        changed, value = imgui.drag_float(label, getattr(block, name), 0.01, low, high, unit)
        tooltip(about)
        if changed:
            put(("block", *at, name), **{name: float(value)})
    imgui.set_next_item_width(em(8))
    changed, value = imgui.slider_float("Weight", block.weight, 0.0, 1.0)
    tooltip("Its share among the blocks of the track that play at the same time")
    if changed:
        put(("block", *at, "weight"), weight=float(value))
    for name, label, choices in (
        ("curve", "Fade curve", CURVES),
        ("play", "Beyond its end", ("loop", "once", "ping-pong")),
    ):
        imgui.set_next_item_width(em(8))
        known = list(choices)
        changed, chosen = imgui.combo(label, known.index(getattr(block, name)), [pretty(c) for c in known])
        if changed:
            put(**{name: known[chosen]})
    changed, sync = imgui.checkbox("In step with its neighbours", block.sync)
    tooltip("Steps fall together: blocks that are in step share one phase, whatever their clips' lengths")
    if changed:
        put(sync=sync or None)
    if imgui.menu_item_simple("Split here", "Shift+S"):
        ui.operations.run("animation.split", ui.session)
    if imgui.menu_item_simple("Delete block", "Shift+Delete"):
        ui.operations.run("animation.delete-block", ui.session)
    imgui.separator()
    _clip_markers(ui, editor, block.clip, at)


def _clip_markers(ui: Ui, editor: AnimationEditor, key: str, at: tuple[int, int]) -> None:
    """Markers that belong to the block's clip: they are passed wherever it plays."""
    text(f"Markers of {key}", theme.DIM)
    for number, marker in enumerate(editor.model.clips[key].markers):
        imgui.push_id(number)
        imgui.set_next_item_width(em(6))
        changed, name = imgui.input_text("##name", marker.name)
        if changed and name:
            attempt(ui, lambda n=number, name=name: editor.set_marker(n, key, name=name, gesture=("clip marker", n)))
        imgui.same_line()
        imgui.set_next_item_width(em(5))
        changed, time = imgui.drag_float("##time", marker.time, 0.005, 0.0, 1e6, "%.3f s")
        if changed:
            attempt(
                ui, lambda n=number, t=float(time): editor.set_marker(n, key, time=t, gesture=("clip marker time", n))
            )
        imgui.same_line()
        if icon_button(icons.TRASH, "Delete this marker"):
            attempt(ui, lambda n=number: editor.remove_marker(n, key))
        imgui.pop_id()
    if imgui.menu_item_simple("Add marker to the clip here"):
        sequence = animation_of(ui.session).sequence
        track = sequence.tracks[at[0]]
        now = sequence.clip_time(track, track.blocks[at[1]], np.array([ui.session.playback.time]))
        source = editor.model.clips[key].source or key
        attempt(ui, lambda: editor.add_marker("marker", round(float(now[0]), 4), source))


def _track(ui: Ui, editor: AnimationEditor, track: Any) -> None:
    number, view = ui.session.animating.track, ui.session.animating

    def put(gesture: Any = None, **values: Any) -> None:
        attempt(ui, lambda: editor.set_track(number, gesture=gesture, **values))

    text("Track", theme.DIM)
    imgui.set_next_item_width(em(10))
    changed, name = imgui.input_text("Name##track", track.name)
    if changed and name:
        put(("track name", number), name=name)
    imgui.set_next_item_width(em(10))
    changed, value = imgui.slider_float("Weight##track", track.weight, 0.0, 1.0)
    if changed:
        put(("track weight", number), weight=float(value))
    masks = ["", *editor.model.masks]
    imgui.set_next_item_width(em(10))
    changed, chosen = imgui.combo("Mask", masks.index(track.mask), ["Everything", *editor.model.masks])
    tooltip("The bones it moves; masks are made in the Masks panel")
    if changed:
        put(mask=masks[chosen] or None)
    imgui.set_next_item_width(em(10))
    modes = ["override", "additive"]
    changed, chosen = imgui.combo("Mode", modes.index(track.mode), ["Override", "Additive"])
    tooltip("Override: in place of what lies below. Additive: what differs from the reference pose is added to it")
    if changed:
        put(mode=modes[chosen], **({} if chosen else {"reference": None, "reference_time": None}))
    if track.mode == "additive":
        draw_reference(editor, track, put)
    if imgui.menu_item("Muted", "", track.muted)[0]:
        put(muted=None if track.muted else True)
    if imgui.menu_item("Move up", "", False, number + 1 < len(editor.model.tracks))[0]:
        attempt(ui, lambda: editor.move_track(number, 1))
        view.track = number + 1
    if imgui.menu_item("Move down", "", False, number > 0)[0]:
        attempt(ui, lambda: editor.move_track(number, -1))
        view.track = number - 1
    if imgui.menu_item_simple("Delete track"):
        attempt(ui, lambda: editor.remove_track(number))
        view.track = view.block = -1


def draw_reference(editor: AnimationEditor, layer: Any, put: Callable[..., None]) -> None:
    """What an additive track or layer is measured from: its own clip, the rest pose or another clip, at a time."""
    keys: list[str | None] = [None, "", *editor.model.clips]
    names = ["Its own clip", "Rest pose", *editor.model.clips]
    imgui.set_next_item_width(em(10))
    changed, chosen = imgui.combo("Measured from", keys.index(layer.reference), names)
    tooltip("The reference pose: what is added is how the clip differs from it")
    if changed:
        put(reference=keys[chosen])
    if layer.reference != "":
        imgui.set_next_item_width(em(10))
        changed, time = imgui.drag_float("At##reference", layer.reference_time, 0.01, 0.0, 1e6, "%.3f s")
        tooltip("Seconds into that clip")
        if changed:
            put(("reference time", layer.name), reference_time=float(time))


def draw_clips(ui: Ui, editor: AnimationEditor) -> None:
    """A list of the scene's clips: to play one, or to add it to the chosen track."""
    session, view = ui.session, ui.session.animating
    runtime = runtime_of(session)
    active = [runtime.clips[i].name for i in runtime.deck.active]
    tracks = drive_of(session) == "timeline"
    if drive_of(session) == "states":
        return
    imgui.set_next_item_width(em(9))
    shown = "Add a clip…" if tracks else (", ".join(active) or "No clip")
    if imgui.begin_combo("##clips", shown, imgui.ComboFlags_.height_large):
        if tracks:
            _fade_of_new(view)
        for path, plays in runtime.instance_clips.animations().items() if not tracks else ():
            if imgui.selectable(f"{path.name.removesuffix('.scene.json')}: its own animation", plays)[0]:
                runtime.instance_clips.play_animation(path)
        for i, clip in enumerate(runtime.clips):
            if not runtime.instance_clips.stands(i):
                continue
            if imgui.selectable(f"{clip.name}   {clip.duration:.2f} s##{i}", clip.name in active and not tracks)[0]:
                if tracks:
                    at = max(view.track, 0)
                    attempt(ui, lambda at=at, name=clip.name: editor.add_block(
                        name, at, fade=view.new_fade, curve=view.new_curve, sync=view.new_sync))  # fmt: skip
                    view.fitted = view.fitted and view.zoomed
                elif imgui.get_io().key_ctrl and clip.name not in active:
                    runtime.play(*active, clip.name)
                else:
                    runtime.instance_clips.play(i)
        imgui.end_combo()
    tooltip("Adds to the selected track, after its last block" if tracks else "Ctrl: play it over those that play")


def _fade_of_new(view: Any) -> None:
    """How what is added cross-fades with the block before it."""
    imgui.set_next_item_width(em(5))
    changed, value = imgui.drag_float("##fade", view.new_fade, 0.01, 0.0, 60.0, "%.2f s")
    tooltip("Cross-fade with the block before it, this long; 0: none")
    if changed:
        view.new_fade = max(float(value), 0.0)
    imgui.same_line(0, em(0.3))
    imgui.set_next_item_width(em(6))
    changed, chosen = imgui.combo("cross-fade", CURVES.index(view.new_curve), [pretty(c) for c in CURVES])
    if changed:
        view.new_curve = CURVES[chosen]
    view.new_sync = bool(imgui.checkbox("In step with it", view.new_sync)[1])
    tooltip("Both blocks share one phase while they fade: feet fall together")
    imgui.separator()


def draw_root(ui: Ui, editor: AnimationEditor) -> None:
    """A button and its menu: whether root motion carries the character, along which node, and its path."""
    session = ui.session
    animation = animation_of(session)
    on = bool(animation is not None and animation.model.root and runtime_of(session).deck.root_motion)
    if icon_button(f"{icons.PATH}##root", "Root motion: what a clip walks moves the character itself", active=on):
        imgui.open_popup("##root-menu")
    if not imgui.begin_popup("##root-menu"):
        return
    if animation is None:
        text("Add a track first", theme.DIM)
        imgui.end_popup()
        return
    root = animation.model.root
    for id in ("animation.root-motion", "animation.show-root-path"):
        operation = ui.operations[id]
        ticked = operation.checked is not None and operation.checked(session)
        if imgui.menu_item(operation.label, "", ticked and bool(root), bool(root))[0]:
            ui.operations.run(id, session)
    imgui.separator()
    text("Carried by", theme.DIM)
    names = ["", *animation.rig.names]
    if imgui.begin_list_box("##roots", (em(14), min(len(names), 9) * imgui.get_text_line_height_with_spacing())):
        for i, name in enumerate(names):
            if imgui.selectable(f"{name or 'Nothing'}##{i}", name == root)[0] and name != root:
                attempt(ui, lambda name=name: editor.put((("root",), name or None), label=f"Root {name or 'none'}"))
        imgui.end_list_box()
    imgui.end_popup()


def draw_rate(ui: Ui) -> None:
    """The frames a second that steps and snapping go by."""
    playback = ui.session.playback
    imgui.set_next_item_width(em(4.6))
    if imgui.begin_combo("##rate", f"{playback.frame_rate:g} fps"):
        for rate in RATES:
            if imgui.selectable(f"{rate:g} fps", rate == playback.frame_rate)[0]:
                playback.frame_rate = rate
        imgui.end_combo()
    tooltip("Frames a second: what stepping and snapping go by")
