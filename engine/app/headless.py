"""Rendering without a window: a runtime and a view become an array."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.app.runtime import Runtime
from engine.render.frame import Frame
from engine.render.view import View
from engine.report.legend_picture import draw_legend


def render_image(runtime: Runtime, view: View) -> tuple[NDArray[np.uint8], Frame]:
    """u1[h,w,4], sRGB-encoded, top row first, and the frame it came from."""
    frame = runtime.render(view)
    return np.asarray(frame.color.read(), np.uint8), frame


def with_legend(picture: NDArray[np.uint8], frame: Frame) -> NDArray[np.uint8]:
    """The picture of a debug view with what its colours mean, where they are a ramp."""
    legend = frame.legend
    if legend is None:
        return picture
    ramp = np.array([legend.color(place) for place in np.linspace(0.0, 1.0, 256)])
    return draw_legend(picture, legend.heading, legend.ticks(), ramp, legend.note)


def render_hdr(runtime: Runtime, view: View) -> tuple[NDArray[np.float32], Frame]:
    """f4[h,w,4], scene-linear Rec.709 without exposure, top row first, and the frame it came from."""
    frame = runtime.render(view, hdr=True)
    assert frame.hdr is not None
    return np.asarray(frame.hdr.read(), np.float32), frame
