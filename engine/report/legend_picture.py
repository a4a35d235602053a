"""A legend drawn into a picture: a ramp with numbers below it, on a dark ground at the bottom left."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

#: smaller pictures get none: it would cover them
LEAST = (200, 120)
GROUND, TEXT, DIM = (13, 14, 17), (235, 236, 240), (160, 163, 172)


def draw_legend(
    picture: NDArray[np.uint8], heading: str, ticks: Sequence[tuple[float, str]], ramp: NDArray[np.float64],
    note: str = "",
) -> NDArray[np.uint8]:  # fmt: skip
    """Return a copy of u1[h,w,3|4] with a legend; `ticks`: (place in 0..1, text), `ramp` f8[n,3] sRGB in 0..1.

    A picture below LEAST comes back as it is."""
    from PIL import Image, ImageDraw, ImageFont

    height, width = picture.shape[:2]
    if width < LEAST[0] or height < LEAST[1]:
        return picture
    em = max(11, min(round(height / 30), 64))
    font, small = ImageFont.load_default(em), ImageFont.load_default(max(round(0.85 * em), 10))
    pad, bar = round(0.7 * em), round(0.9 * em)
    wide = min(width - 4 * pad, max(26 * em, 200))
    high = round(1.35 * em) + bar + round(1.6 * em)
    left, top = pad, height - high - 3 * pad
    image = Image.fromarray(np.ascontiguousarray(picture[..., :3]))
    cover = Image.new("RGB", image.size, GROUND)
    mask = Image.new("L", image.size, 0)
    ImageDraw.Draw(mask).rounded_rectangle(
        (left, top, left + wide + 2 * pad, top + high + 2 * pad), round(0.4 * em), 220
    )
    image.paste(cover, mask=mask)
    draw = ImageDraw.Draw(image)
    x, y = left + pad, top + round(0.8 * pad)
    draw.text((x, y), heading, TEXT, font)
    if note and font.getlength(heading) + small.getlength(note) + em < wide:
        draw.text((x + wide, y + round(0.1 * em)), note, DIM, small, anchor="ra")
    y += round(1.5 * em)
    at = np.minimum((np.arange(wide) / max(wide - 1, 1) * len(ramp)).astype(int), len(ramp) - 1)
    colors = np.clip(np.round(np.asarray(ramp)[at] * 255.0), 0, 255).astype(np.uint8)
    image.paste(Image.fromarray(np.repeat(colors[None], bar, axis=0)), (x, y))
    last = x + wide - small.getlength(ticks[-1][1]) - 0.5 * em if ticks else 0.0  # where the last label's room begins
    for i, (place, label) in enumerate(ticks):
        across = x + round(place * (wide - 1))
        draw.line((across, y + bar, across, y + bar + round(0.25 * em)), DIM, max(em // 12, 1))
        anchor = "la" if i == 0 else "ra" if i == len(ticks) - 1 else "ma"
        if anchor != "ma" or across + 0.5 * small.getlength(label) < last:
            draw.text((across, y + bar + round(0.35 * em)), label, TEXT, small, anchor=anchor)
    result = picture.copy()
    result[..., :3] = np.asarray(image)
    return result
