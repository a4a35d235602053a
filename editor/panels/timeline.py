"""The bar under the picture: play, pause, scrub, mode, speed. Shown when the scene has an animation."""

from __future__ import annotations

from imgui_bundle import imgui

from editor import icons
from editor.flowing import flow_field
from editor.param_widgets import filled_slider
from editor.ui import Ui
from editor.widgets import em, flow, icon_button, mono, tooltip

MODE_ICONS = {"loop": icons.LOOP, "once": icons.ONCE, "ping-pong": icons.PING_PONG}


def draw(ui: Ui) -> None:
    """One line over the width of the window."""
    session, playback = ui.session, ui.session.playback
    imgui.set_cursor_pos((em(0.5), imgui.get_cursor_pos_y() + em(0.2)))
    if icon_button(f"{icons.START}##start", "Go to start"):
        session.seek(playback.start)
    imgui.same_line(0, 0)
    if icon_button(f"{icons.STEP_BACK}##back", "Previous frame  ,    previous key  Shift+,"):
        ui.operations.run("play.previous", session)
    imgui.same_line(0, 0)
    if icon_button(f"{icons.PAUSE if playback.playing else icons.PLAY}###play", "Play or pause  Space"):
        playback.toggle()
    imgui.same_line(0, 0)
    if icon_button(f"{icons.STEP}##next", "Next frame  .    next key  Shift+."):
        ui.operations.run("play.next", session)
    imgui.same_line(0, 0)
    if icon_button(f"{MODE_ICONS[playback.mode]}###loop", f"{playback.mode.capitalize()}; click for the next  Ctrl+L",
                   active=playback.mode != "once"):  # fmt: skip
        playback.next_mode()
    flow_field(3.6, gap=0.3)
    changed, speed = imgui.drag_float("##speed", playback.speed, 0.01, -100.0, 100.0, "× %.2f")
    if changed:
        playback.speed = float(speed)
    tooltip("Speed; negative plays backwards")
    flow(em(16), 0.6)
    with mono(ui):
        imgui.align_text_to_frame_padding()
        imgui.text_unformatted(f"{playback.time:6.2f}")
        total = f"{playback.duration:.2f} s"
        imgui.same_line(0, em(0.6))
        imgui.set_next_item_width(imgui.get_content_region_avail().x - imgui.calc_text_size(total).x - em(1.2))
        changed, time = filled_slider("##time", playback.time, 0.0, playback.duration, "")
        if changed:
            playback.playing = False
            session.seek(float(time))
        imgui.same_line(0, em(0.6))
        imgui.align_text_to_frame_padding()
        imgui.text_unformatted(total)
