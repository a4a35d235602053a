"""The light from all around as the path tracer has it: radiance by direction, sampled by its brightness."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.math.sphere import cube_solid_angles

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]

#: part of the samples that go everywhere alike, so that no direction is forgotten
EVERYWHERE = 0.05


def cube_texels(d: F8, size: int) -> tuple[I8, I8, I8]:
    """Face, row and column of the cube-map texel in directions `d` [n,3] (OpenGL 4.6, table 8.19)."""
    row = np.arange(len(d))
    axis = np.abs(d).argmax(axis=1)
    major = d[row, axis]
    sign = np.where(major < 0.0, -1.0, 1.0)
    x, y, z = d.T
    s = np.choose(axis, [-sign * z, x, sign * x]) / np.abs(major)
    t = np.choose(axis, [-y, sign * z, -y]) / np.abs(major)
    column, line = (np.clip(((v + 1.0) / 2.0 * size).astype(np.int64), 0, size - 1) for v in (s, t))
    return 2 * axis + (sign < 0.0), line, column


class Surroundings:
    """`faces` f[6,n,n,3]: radiance, one value for each texel of a cube; `turn`: radians about +Y, as the view block's.

    A uniform one has n = 1.
    """

    def __init__(self, faces: ArrayLike, turn: float = 0.0) -> None:
        self.faces = np.maximum(np.nan_to_num(np.asarray(faces, np.float64)), 0.0)
        self.size = self.faces.shape[1]
        self.dark = not bool(self.faces.any())
        #: cosine and sine of the turn
        self.turn = (float(np.cos(turn)), float(np.sin(turn)))
        solid = np.broadcast_to(cube_solid_angles(self.size), (6, self.size, self.size))
        power = (self.faces.max(axis=-1) * solid).reshape(-1)
        even = (solid / (4.0 * np.pi)).reshape(-1)
        part = (1.0 - EVERYWHERE) * power / power.sum() + EVERYWHERE * even if not self.dark else even
        #: density of `sample` over the square [-1, 1]^2 of a face
        self._density = part * (self.size * self.size / 4.0)
        self._until = np.cumsum(part)
        self._until[-1] = 1.0

    def radiance(self, d: F8) -> F8:
        """f8[n,3] from directions `d` [n,3], unit, world."""
        return self.faces[cube_texels(self._inside(d), self.size)]

    def density(self, d: F8) -> F8:
        """Density of `sample` at `d`, 1/sr, f8[n]."""
        face, line, column = cube_texels(self._inside(d), self.size)
        # a face's square is seen under cos^3 of its area, and the cosine is the largest component
        cosine = np.abs(self._inside(d)).max(axis=1)
        result: F8 = self._density[(face * self.size + line) * self.size + column] / cosine**3
        return result

    def sample(self, u: F8) -> F8:
        """Directions f8[n,3], world, for `u` [n,3] in [0, 1): a texel by its brightness, then a place in it."""
        index = np.minimum(np.searchsorted(self._until, u[:, 0], side="right"), len(self._until) - 1)
        face, rest = np.divmod(index, self.size * self.size)
        line, column = np.divmod(rest, self.size)
        x = (column + u[:, 1]) / self.size * 2.0 - 1.0
        y = (line + u[:, 2]) / self.size * 2.0 - 1.0
        one = np.ones_like(x)
        faces = [(one, -y, -x), (-one, -y, x), (x, one, y), (x, -one, -y), (x, -y, one), (-x, -y, -one)]
        d = np.choose(face[None], [np.stack(f) for f in faces]).T
        return self._outside(d / np.linalg.norm(d, axis=1, keepdims=True))

    def _inside(self, d: F8) -> F8:
        c, s = self.turn
        return np.stack([c * d[:, 0] - s * d[:, 2], d[:, 1], s * d[:, 0] + c * d[:, 2]], axis=1)

    def _outside(self, d: F8) -> F8:
        c, s = self.turn
        return np.stack([c * d[:, 0] + s * d[:, 2], d[:, 1], -s * d[:, 0] + c * d[:, 2]], axis=1)
