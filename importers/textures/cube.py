"""Cube maps on the CPU: directions, filtered look-ups, and the way from an equirectangular image.

Faces +x -x +y -y +z -z, oriented as in OpenGL (4.6 core specification, table 8.19), row 0 at t = 0. Equirectangular
images: u = atan2(x, -z) / 2pi + 0.5 (the middle column looks along -Z, +X lies right of it), v = acos(y) / pi.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from importers.textures.mips import resample

Floats = NDArray[np.float32]

#: face -> direction = M @ (sc, tc, 1), with sc, tc in [-1, 1]
_FACES = np.array(
    [
        [[0, 0, 1], [0, -1, 0], [-1, 0, 0]],
        [[0, 0, -1], [0, -1, 0], [1, 0, 0]],
        [[1, 0, 0], [0, 0, 1], [0, 1, 0]],
        [[1, 0, 0], [0, 0, -1], [0, -1, 0]],
        [[1, 0, 0], [0, -1, 0], [0, 0, 1]],
        [[-1, 0, 0], [0, -1, 0], [0, 0, -1]],
    ],
    np.float64,
)


def directions(size: int, border: int = 0) -> NDArray[np.float64]:
    """Unit vectors through the texel centres of a cube: f8[6,n,n,3], n = size + 2 border."""
    c = (np.arange(-border, size + border) + 0.5) * (2.0 / size) - 1.0
    s, t = np.meshgrid(c, c)
    plane = np.stack([s, t, np.ones_like(s)], -1)
    d: NDArray[np.float64] = np.einsum("fij,hwj->fhwi", _FACES, plane)
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    return d


def faces_of(d: NDArray[Any]) -> tuple[NDArray[np.intp], NDArray[Any], NDArray[Any]]:
    """(face, sc, tc) of directions [n,3], with sc, tc in [-1, 1]."""
    x, y, z = d[:, 0], d[:, 1], d[:, 2]
    ax, ay, az = np.abs(x), np.abs(y), np.abs(z)
    is_x = (ax >= ay) & (ax >= az)
    is_y = ~is_x & (ay >= az)
    major = np.where(is_x, x, np.where(is_y, y, z))
    negative = major < 0
    face = np.where(is_x, 0, np.where(is_y, 2, 4)) + negative
    sign = np.where(negative, -1.0, 1.0).astype(d.dtype)
    sc = np.where(is_x, -z * sign, np.where(is_y, x, x * sign))
    tc = np.where(is_y, z * sign, -y)
    scale = 1.0 / np.abs(major)
    return face, sc * scale, tc * scale


@dataclass(slots=True)
class CubeChain:
    """A cube with its box-filtered mips, each face with a border of one texel from its neighbours.

    `levels[m]`: f4[6, n+2, n+2, 4] (rgb and a pad, so that one texel is one 16-byte gather).
    """

    levels: list[Floats]

    @classmethod
    def build(cls, faces: Floats) -> CubeChain:
        """From f4[6,n,n,3], n a power of two."""
        levels = []
        while True:
            levels.append(_bordered(faces))
            n = faces.shape[1]
            if n == 1:
                return cls(levels)
            faces = faces.reshape(6, n // 2, 2, n // 2, 2, 3).mean(axis=(2, 4), dtype=np.float32)

    def sample(self, d: Floats, lod: float) -> Floats:
        """Radiance f4[n,3] in directions f4[n,3], trilinear, seamless."""
        lod = min(max(lod, 0.0), len(self.levels) - 1.0)
        low = int(lod)
        place = faces_of(d)
        result: Floats = _bilinear(self.levels[low], place)
        part = np.float32(lod - low)
        if part > 0.0:
            result += (_bilinear(self.levels[low + 1], place) - result) * part
        rgb: Floats = result[:, :3]
        return rgb


def _bilinear(padded: Floats, place: tuple[NDArray[np.intp], NDArray[Any], NDArray[Any]]) -> Floats:
    face, sc, tc = place
    row = padded.shape[1]
    n = row - 2
    x = (sc + 1.0) * np.float32(0.5 * n) + np.float32(0.5)
    y = (tc + 1.0) * np.float32(0.5 * n) + np.float32(0.5)
    i = np.minimum(x.astype(np.int32), n)
    j = np.minimum(y.astype(np.int32), n)
    fx = (x - i).astype(np.float32)[:, None]
    fy = (y - j).astype(np.float32)[:, None]
    flat = padded.reshape(-1, 4)
    at = (face * row + j) * row + i
    a: Floats = flat[at]
    b: Floats = flat[at + 1]
    a += (b - a) * fx
    c, e = flat[at + row], flat[at + row + 1]
    c += (e - c) * fx
    a += (c - a) * fy
    return a


def _bordered(faces: Floats) -> Floats:
    """The faces with one texel around each, taken from the neighbours (nearest), corners averaged from theirs."""
    n = faces.shape[1]
    out = np.zeros((6, n + 2, n + 2, 4), np.float32)
    out[:, 1:-1, 1:-1, :3] = faces
    around = np.ones((n + 2, n + 2), bool)
    around[1:-1, 1:-1] = False
    around[[0, 0, -1, -1], [0, -1, 0, -1]] = False
    face, sc, tc = faces_of(directions(n, 1)[:, around].reshape(-1, 3))
    i = np.clip(((sc + 1.0) * 0.5 * n).astype(np.intp), 0, n - 1)
    j = np.clip(((tc + 1.0) * 0.5 * n).astype(np.intp), 0, n - 1)
    out[:, around, :3] = faces[face, j, i].reshape(6, -1, 3)
    for y, inner_y in ((0, 1), (-1, -2)):
        for x, inner_x in ((0, 1), (-1, -2)):
            # three faces meet in a corner: there is no fourth texel, so it gets the mean of the three
            out[:, y, x] = (out[:, y, inner_x] + out[:, inner_y, x] + out[:, inner_y, inner_x]) / 3.0
    return out


def from_equirect(image: Floats, size: int) -> Floats:
    """Cube faces f4[6,size,size,3] from f4[h,w,3], averaged down first where the image is finer than the cube."""
    height, width = image.shape[:2]
    if width > 6 * size:
        image = resample(image, 4 * size, 2 * size, "box")
        height, width = image.shape[:2]
    d = directions(size).reshape(-1, 3)
    u = (np.arctan2(d[:, 0], -d[:, 2]) / (2.0 * np.pi) + 0.5) * width - 0.5
    v = np.arccos(np.clip(d[:, 1], -1.0, 1.0)) / np.pi * height - 0.5
    i, j = np.floor(u).astype(np.intp), np.floor(v).astype(np.intp)
    fu, fv = (u - i)[:, None], (v - j)[:, None]
    j0, j1 = np.clip(j, 0, height - 1), np.clip(j + 1, 0, height - 1)
    i0, i1 = i % width, (i + 1) % width
    top = image[j0, i0] * (1 - fu) + image[j0, i1] * fu
    bottom = image[j1, i0] * (1 - fu) + image[j1, i1] * fu
    cube: Floats = (top * (1 - fv) + bottom * fv).astype(np.float32).reshape(6, size, size, 3)
    return cube
