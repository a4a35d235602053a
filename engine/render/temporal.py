"""Temporal anti-aliasing: how many frames a picture is gathered from, and which of them a frame is."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from engine.gpu.types import Caps
from engine.render.motion.jitter import pixel_jitter
from engine.render.settings import LIT_LOOK
from engine.render.view import View

if TYPE_CHECKING:
    from engine.render.motion.frame import FrameMotion


def taa_wanted(view: View, caps: Caps) -> bool:
    """With one sample a pixel, in views of light: values are no thing to mix."""
    settings = view.settings
    one = caps.samples_for(settings.samples) == 1
    return settings.antialias == "taa" and one and settings.shading_view in LIT_LOOK


def jitter_of(view: View, motion: FrameMotion) -> tuple[float, float]:
    """Pixels that this frame of a TAA view is shifted by."""
    return pixel_jitter(motion.frames, int(view.settings.taa_frames))


def shift_of(view: View, motion: FrameMotion, caps: Caps) -> tuple[float, float]:
    """Pixels that a frame is shifted by: as the view says, and for TAA by where in its pixels it looks."""
    x, y = jitter_of(view, motion) if taa_wanted(view, caps) else (0.0, 0.0)
    return view.shift[0] + x, view.shift[1] + y


#: first part of the key of a run that is made for one picture
RUN = "gathered"


def follows(view: View) -> bool:
    """Whether its pictures follow one another on and on: what comes to rest after many frames has the time for it. A
    run that is made for one picture is short, so each of its frames has all of its light by itself."""
    alone = isinstance(view.key, tuple) and view.key[:1] == (RUN,)
    return view.seconds is not None and not alone


def gathered(view: View, caps: Caps) -> list[View]:
    """The frames to make for one picture that depends on nothing but the scene: the view itself, or for TAA a run of
    `taa_frames` that begins with a cut, with time standing still."""
    if view.seconds is not None or not taa_wanted(view, caps):
        return [view]
    key = (RUN, view.key)  # what a window gathers goes on as it was
    return [replace(view, seconds=0.0, key=key, cut=index == 0) for index in range(int(view.settings.taa_frames))]
