"""Specular-glossiness materials as metallic-roughness ones: factors, and textures texel by texel.

The conversion is the one of the extension's own appendix (KHR_materials_pbrSpecularGlossiness, Khronos, 2017):
metallic from the two brightnesses (a quadratic), base colour blended from the diffuse and the specular colour by
metallic squared, roughness = 1 - glossiness. All colours are scene-linear.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.math.color import linear_to_srgb, srgb_to_linear
from importers.settings import ImportSettings

Floats = NDArray[np.float64]

#: reflectance of a dielectric at normal incidence
F0 = 0.04
METHOD = "by the quadratic of the extension's appendix, texel by texel"


def convert(diffuse: Floats, specular: Floats) -> tuple[Floats, Floats]:
    """(base colour f8[...,3], metallic f8[...]) of diffuse and specular colours f8[...,3]."""

    def brightness(c: Floats) -> Floats:
        return np.sqrt(0.299 * c[..., 0] ** 2 + 0.587 * c[..., 1] ** 2 + 0.114 * c[..., 2] ** 2)

    d, s = brightness(diffuse), brightness(specular)
    rest = 1.0 - specular.max(axis=-1)
    b = d * rest / (1.0 - F0) + s - 2.0 * F0
    root = np.sqrt(np.maximum(b * b - 4.0 * F0 * (F0 - s), 0.0))
    metallic = np.where(s < F0, 0.0, np.clip((root - b) / (2.0 * F0), 0.0, 1.0))
    m = metallic[..., None]
    from_diffuse = diffuse * (rest / (1.0 - F0))[..., None] / np.maximum(1.0 - m, 1e-4)
    from_specular = (specular - F0 * (1.0 - m)) / np.maximum(m, 1e-4)
    # where nothing is metal the diffuse colour stays: what a weak gloss spares would only brighten it
    base = np.where(m > 0.0, from_diffuse + (from_specular - from_diffuse) * m * m, diffuse)
    return np.clip(base, 0.0, 1.0), metallic


class TexturePair:
    """The two images of a material converted together, once; `base_color` and `metal_rough` give PNG files."""

    def __init__(
        self, diffuse: Callable[[], bytes | None] | None, specular: Callable[[], bytes | None] | None,
        factors: tuple[tuple[float, ...], tuple[float, ...], float], place: str, settings: ImportSettings,
    ) -> None:  # fmt: skip
        self._sources = diffuse, specular
        self._factors = factors
        self._place = place
        self._settings = settings
        self._made: tuple[bytes, bytes] | None = None

    def base_color(self) -> bytes | None:
        return self._pair(0)

    def metal_rough(self) -> bytes | None:
        return self._pair(1)

    def _pair(self, which: int) -> bytes | None:
        if self._made is None:
            images = []
            for source in self._sources:
                data = None if source is None else source()
                if data is None and source is not None:
                    return None
                images.append(None if data is None else self._decode(data))
            self._made = self._convert(images[0], images[1])
        return self._made[which]

    def _decode(self, data: bytes) -> Floats:
        """f8[h,w,4]: linear rgb, alpha as stored."""
        from importers.textures.image import decode  # Pillow, for these files only

        pixels = decode(data, self._place, self._settings)
        values = pixels.astype(np.float64) / (float(np.iinfo(pixels.dtype).max) if pixels.dtype.kind == "u" else 1.0)
        values[..., :3] = srgb_to_linear(values[..., :3])
        return values

    def _convert(self, diffuse: Floats | None, specular: Floats | None) -> tuple[bytes, bytes]:
        from importers.textures.mips import resample

        color, tint, gloss = self._factors
        sizes = [image.shape[:2] for image in (diffuse, specular) if image is not None]
        height, width = max(sizes, key=lambda size: size[0] * size[1])

        def fit(image: Floats | None) -> Any:
            if image is None:
                return np.ones((1, 1, 4))
            same = image.shape[:2] == (height, width)
            return image if same else resample(image.astype(np.float32), width, height, "box").astype(np.float64)

        one, two = fit(diffuse), fit(specular)
        base, metallic = convert(*np.broadcast_arrays(one[..., :3] * color[:3], two[..., :3] * tint))
        shape = (height, width)
        out = np.empty((*shape, 4))
        out[..., :3] = linear_to_srgb(np.broadcast_to(base, (*shape, 3)))
        out[..., 3] = one[..., 3]
        rough = np.zeros((*shape, 3))
        rough[..., 1] = 1.0 - two[..., 3] * gloss
        rough[..., 2] = metallic
        return _png(out), _png(rough)


def _png(values: Floats) -> bytes:
    from PIL import Image

    file = io.BytesIO()
    pixels = np.rint(np.clip(values, 0.0, 1.0) * 255.0).astype(np.uint8)
    Image.fromarray(pixels).save(file, "PNG", compress_level=1)
    return file.getvalue()
