"""Turned, swept and cut shapes for the sample scene. Metres, +Y up, counter-clockwise seen from outside.

profile (r, y) -> lathe            path -> tube            teeth -> gear
Mesh: positions f8[n,3] m, normals f8[n,3], uvs f8[n,2] (origin top-left), triangles i8[m,3]
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Point = tuple[float, float]

#: Profile corners that turn more than this are rounded, gentler ones are part of a curve.
_CORNER = math.radians(24.0)
TAU = math.tau


@dataclass(slots=True)
class Mesh:
    positions: Array
    normals: Array
    uvs: Array
    triangles: NDArray[np.int64]
    colors: Array | None = None
    uvs1: Array | None = None

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Mesh:
        self.positions = self.positions + np.array([x, y, z])
        return self

    def turned(self, axis: str, angle: float) -> Mesh:
        """Rotated by `angle` (radians) about the axis x, y or z through the origin."""
        matrix = rotation(axis, angle)
        self.positions = self.positions @ matrix.T
        self.normals = self.normals @ matrix.T
        return self

    def with_uvs(self, function: Callable[[Array, Array], Array]) -> Mesh:
        """Replace uvs by `function(positions, normals)` -> f8[n,2]."""
        self.uvs = function(self.positions, self.normals)
        return self

    def tangents(self) -> Array:
        """f8[n,4]: xyz along growing u; w so that cross(normal, tangent) * w points up in the image (against v)."""
        a, b, c = (self.positions[self.triangles[:, i]] for i in range(3))
        ta, tb, tc = (self.uvs[self.triangles[:, i]] for i in range(3))
        edge1, edge2, uv1, uv2 = b - a, c - a, tb - ta, tc - ta
        area = uv1[:, :1] * uv2[:, 1:] - uv2[:, :1] * uv1[:, 1:]
        sign = np.where(area < 0, -1.0, 1.0)
        along_u = (edge1 * uv2[:, 1:] - edge2 * uv1[:, 1:]) * sign
        along_v = (edge2 * uv1[:, :1] - edge1 * uv2[:, :1]) * sign
        tangent, bitangent = np.zeros_like(self.positions), np.zeros_like(self.positions)
        for corner in range(3):
            np.add.at(tangent, self.triangles[:, corner], along_u)
            np.add.at(bitangent, self.triangles[:, corner], along_v)
        tangent -= self.normals * np.sum(tangent * self.normals, axis=1, keepdims=True)
        length = np.linalg.norm(tangent, axis=1)
        lost = length < 1e-12  # at a pole, where u has no direction: any one across the normal serves
        fallback = np.cross(self.normals, np.where(np.abs(self.normals[:, 1:2]) > 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]]))
        tangent[lost] = fallback[lost]
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        up = np.sum(np.cross(self.normals, tangent) * -bitangent, axis=1)
        return np.concatenate([tangent, np.where(up < 0, -1.0, 1.0)[:, None]], axis=1)


def rotation(axis: str, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    rows = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(rows[axis], np.float64)


def merge(meshes: Sequence[Mesh]) -> Mesh:
    starts = np.cumsum([0, *(len(m.positions) for m in meshes)])
    return Mesh(
        np.concatenate([m.positions for m in meshes]),
        np.concatenate([m.normals for m in meshes]),
        np.concatenate([m.uvs for m in meshes]),
        np.concatenate([m.triangles + start for m, start in zip(meshes, starts, strict=False)]),
    )


# --- profiles ------------------------------------------------------------------------------------------------------


def rounded(points: Sequence[Point], bevel: float, steps: int = 4, *, closed: bool = False) -> tuple[Array, Array]:
    """Points f8[n,2] and outward normals of a polyline whose sharp corners are rounded by `bevel` (m).

    The outside is to the right of the walking direction. Where a curve is tangent to a flat, the flat keeps its normal:
    vertex normals are weighted by segment length.
    """
    raw = np.array(points, np.float64)
    keep = np.concatenate([[True], np.linalg.norm(np.diff(raw, axis=0), axis=1) > 1e-7])
    raw = raw[keep]  # an arc may end where the next point is
    count = len(raw)
    edges = (np.roll(raw, -1, 0) - raw) if closed else np.diff(raw, axis=0)
    lengths = np.linalg.norm(edges, axis=1)
    directions = edges / lengths[:, None]
    out: list[Array] = []
    normals: list[Array] = []

    def emit(point: Array, direction: Array) -> None:
        out.append(point)
        normals.append(np.array([direction[1], -direction[0]]) / np.linalg.norm(direction))

    for i in range(count):
        if not closed and i == 0:
            emit(raw[0], directions[0])
            continue
        if not closed and i == count - 1:
            emit(raw[-1], directions[-1])
            continue
        before, after = directions[i - 1], directions[i % len(directions)]
        turn = math.acos(float(np.clip(before @ after, -1, 1)))
        if turn < _CORNER:
            emit(raw[i], before * lengths[i - 1] + after * lengths[i % len(lengths)])
            continue
        trim = min(bevel, 0.49 * lengths[i - 1], 0.49 * lengths[i % len(lengths)])
        start, end = raw[i] - before * trim, raw[i] + after * trim
        for s in np.linspace(0, 1, steps + 1):
            point = (1 - s) ** 2 * start + 2 * s * (1 - s) * raw[i] + s**2 * end
            emit(point, (1 - s) * before + s * after)
    if closed:
        out.append(out[0])
        normals.append(normals[0])
    return np.array(out), np.array(normals)


def arc(center: Point, radius: float, start: float, end: float, steps: int = 6) -> list[Point]:
    """Points on a circle in the profile's plane, angles in degrees from +r towards +y."""
    angles = np.radians(np.linspace(start, end, steps + 1))
    return [(center[0] + radius * math.cos(a), center[1] + radius * math.sin(a)) for a in angles]


def lathe(
    points: Sequence[Point],
    segments: int,
    bevel: float = 0.001,
    *,
    closed: bool = False,
    steps: int = 3,
    u_repeat: float = 1.0,
    v_per_metre: float = 1.0,
) -> Mesh:
    """Turn the profile (r, y) about +Y. u runs around (to the right from outside), v down along the profile."""
    profile, profile_normals = rounded(points, bevel, steps, closed=closed)
    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    angle = np.linspace(0, TAU, segments + 1)
    sin, cos = np.sin(angle)[None, :], np.cos(angle)[None, :]
    sin[0, -1], cos[0, -1] = sin[0, 0], cos[0, 0]
    r, y = profile[:, :1], profile[:, 1:]
    nr, ny = profile_normals[:, :1], profile_normals[:, 1:]
    flat = np.ones_like(sin)
    positions = np.stack([r * sin, y * flat, r * cos], -1).reshape(-1, 3)
    normals = np.stack([nr * sin, ny * flat, nr * cos], -1).reshape(-1, 3)
    u = np.broadcast_to(angle / TAU * u_repeat, (len(profile), segments + 1))
    v = np.broadcast_to(((walked[-1] - walked) * v_per_metre)[:, None], u.shape)
    triangles = _grid(len(profile), segments + 1)
    # rows on the axis have no width: drop the triangles that would be empty
    on_axis = np.repeat(profile[:, 0] < 1e-9, segments + 1)
    first, second, third = on_axis[triangles].T
    empty = (first & second) | (second & third) | (first & third)
    return _compact(Mesh(positions, normals, np.stack([u, v], -1).reshape(-1, 2), triangles[~empty]))


def _grid(rows: int, columns: int) -> NDArray[np.int64]:
    """Two triangles per cell of a grid whose rows go up and columns go right."""
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b = index[:-1, :-1].ravel(), index[:-1, 1:].ravel()
    d, c = index[1:, :-1].ravel(), index[1:, 1:].ravel()
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def _compact(mesh: Mesh) -> Mesh:
    used = np.unique(mesh.triangles)
    renumber = np.zeros(len(mesh.positions), np.int64)
    renumber[used] = np.arange(len(used))
    return Mesh(mesh.positions[used], mesh.normals[used], mesh.uvs[used], renumber[mesh.triangles])


def sphere(radius: float, segments: int = 48, rings: int = 24) -> Mesh:
    """u around, v from the north pole (0) to the south pole (1)."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)[:, None]
    # each pole vertex takes the middle of its fan in u: no twist there
    longitude = np.linspace(0, TAU, segments + 1)[None, :]
    x, z = np.cos(latitude) * np.sin(longitude), np.cos(latitude) * np.cos(longitude)
    normals = np.stack([x, np.broadcast_to(np.sin(latitude), x.shape), z], -1)
    normals[:, -1] = normals[:, 0]
    u = np.broadcast_to(longitude / TAU, x.shape).copy()
    u[[0, -1]] += 0.5 / segments
    v = np.broadcast_to(0.5 - latitude / np.pi, x.shape)
    triangles = _grid(rings + 1, segments + 1)
    flat = normals.reshape(-1, 3)
    mesh = Mesh(flat * radius, flat, np.stack([u, v], -1).reshape(-1, 2), triangles)
    mesh.triangles = _not_empty(mesh)
    return _compact(mesh)


def _not_empty(mesh: Mesh) -> NDArray[np.int64]:
    a, b, c = (mesh.positions[mesh.triangles[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    kept: NDArray[np.int64] = mesh.triangles[area > 1e-14]
    return kept


def ring(radius: float, width: float, height: float, segments: int, bevel: float, **options: float) -> Mesh:
    """A flat ring with rectangular section around +Y: `width` across (r), `height` along y, centred at y = 0."""
    r0, r1, h = radius - width / 2, radius + width / 2, height / 2
    return lathe([(r0, -h), (r1, -h), (r1, h), (r0, h)], segments, bevel, closed=True, **options)  # type: ignore[arg-type]  # the options are lathe's


def annulus(inner: float, outer: float, segments: int, u_repeat: float = 1.0) -> Mesh:
    """One flat face looking up (+Y); u around, v from the outer (0) to the inner (1) edge."""
    mesh = lathe([(outer, 0.0), (inner, 0.0)], segments, 0.0, u_repeat=u_repeat)
    mesh.uvs[:, 1] = (outer - np.linalg.norm(mesh.positions, axis=1)) / (outer - inner)
    return mesh


def tube(path: Sequence[Sequence[float]] | Array, radii: float | Sequence[float] | Array, sides: int = 12) -> Mesh:
    """A round bar along `path` f8[n,3], closed by half-round ends. u around, v along (1 per 0.1 m)."""
    points = np.array(path, np.float64)
    radius = np.broadcast_to(np.array(radii, np.float64), (len(points),)).copy()
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    side = np.cross(tangents[0], [0.0, 1.0, 0.0] if abs(tangents[0][1]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    rows: list[tuple[Array, Array, Array, float, float]] = []  # centre, side, tangent, radius, lean of the normal

    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    slope = np.gradient(radius, walked)
    for i, (point, tangent) in enumerate(zip(points, tangents, strict=True)):
        # parallel transport: the frame turns with the path and never about it
        side = side - tangent * (side @ tangent)
        side /= np.linalg.norm(side)
        if i == 0:
            rows += [
                (point - tangent * radius[0] * math.cos(a), side, tangent, radius[0] * math.sin(a), -math.cos(a))
                for a in np.linspace(0.05, np.pi / 2, 4)[:-1]
            ]
        rows.append((point, side, tangent, radius[i], float(-slope[i])))
        if i == len(points) - 1:
            rows += [
                (point + tangent * radius[i] * math.cos(a), side, tangent, radius[i] * math.sin(a), math.cos(a))
                for a in np.linspace(np.pi / 2, 0.05, 4)[1:]
            ]
    angle = np.linspace(0, TAU, sides + 1)
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    positions, normals, uvs = [], [], []
    length, previous = 0.0, rows[0][0]
    for centre, across, tangent, r, lean in rows:
        other = np.cross(tangent, across)
        outward = cos * across + sin * other
        positions.append(centre + outward * r)
        level = math.sqrt(max(0.0, 1 - lean * lean)) if abs(lean) < 1 else 0.0
        normals.append(outward * level + tangent * lean)
        length += float(np.linalg.norm(centre - previous))
        previous = centre
        uvs.append(np.stack([angle / TAU, np.full(sides + 1, -length * 10)], 1))
    mesh = Mesh(
        np.concatenate(positions),
        np.concatenate(normals),
        np.concatenate(uvs),
        _grid(len(rows), sides + 1),
    )
    mesh.normals /= np.linalg.norm(mesh.normals, axis=1, keepdims=True)
    return mesh


def bezier(points: Sequence[Sequence[float]], steps: int) -> Array:
    """Points on the Bézier curve of these control points (de Casteljau)."""
    t = np.linspace(0, 1, steps + 1)[:, None, None]
    level = np.broadcast_to(np.array(points, np.float64), (steps + 1, len(points), len(points[0])))
    while level.shape[1] > 1:
        level = (1 - t) * level[:, :-1] + t * level[:, 1:]
    return np.array(level[:, 0])


# --- gears ---------------------------------------------------------------------------------------------------------


def gear(teeth: int, module: float, thickness: float, bore: float, spokes: int = 5) -> Mesh:
    """A spur gear around +Y centred at the origin: toothed rim, spokes, hub. Pitch radius = teeth * module / 2 (m)."""
    pitch = teeth * module / 2
    root, tip = pitch - 1.2 * module, pitch + 0.95 * module
    step = TAU / teeth
    outline = []
    for tooth in range(teeth):
        # half widths of a tooth at root and tip, as parts of the step: a trapezoid near the involute's shape
        for part, radius in ((-0.34, root), (-0.13, tip), (0.13, tip), (0.34, root)):
            outline.append((tooth * step + part * step, radius))
    rim_inner = root - max(2.2 * module, 0.12 * pitch)
    angles = np.array([a for a, _ in outline])
    radii = np.array([r for _, r in outline])
    bevel = 0.22 * module
    half = thickness / 2
    parts = [polar(_toothed_rim(angles, radii, rim_inner, half, bevel), around=3.0, per_metre=12.0)]
    hub = max(1.9 * bore, 0.16 * pitch)
    if spokes and rim_inner > hub * 1.3:
        for i in range(spokes):
            length = np.linspace(hub * 0.8, rim_inner + module * 0.5, 7)
            swell = 0.5 + 0.5 * np.abs(np.linspace(-1, 1, 7)) ** 2
            spoke = tube([(0, 0, d) for d in length], half * 1.25 * swell, 8)
            parts.append(spoke.turned("y", i * TAU / spokes))
    parts.append(
        lathe(
            [(bore, -half * 1.5), (hub, -half * 1.5), (hub, half * 1.5), (bore, half * 1.5)],
            28, bevel, closed=True, v_per_metre=12,
        )
    )  # fmt: skip
    return merge(parts)


def _toothed_rim(angles: Array, radii: Array, inner: float, half: float, bevel: float) -> Mesh:
    """A prism between the closed outline (angle, radius) and a circle, flat-shaded with bevelled edges."""

    def loop(r: Array, y: float) -> Array:
        return np.stack([r * np.sin(angles), np.full_like(angles, y), r * np.cos(angles)], 1)

    hole = np.full_like(radii, inner)
    loops = [
        (loop(hole, -half), loop(radii - bevel, -half), False),
        (loop(radii - bevel, -half), loop(radii, -half + bevel), False),
        (loop(radii, -half + bevel), loop(radii, half - bevel), False),
        (loop(radii, half - bevel), loop(radii - bevel, half), False),
        (loop(radii - bevel, half), loop(hole, half), False),
        (loop(hole, half), loop(hole, -half), True),
    ]
    positions, normals, triangles = [], [], []
    count = 0
    for low, high, smooth in loops:
        a, b = low, np.roll(low, -1, 0)
        c, d = np.roll(high, -1, 0), high
        face = np.cross(c - a, d - b)
        face /= np.linalg.norm(face, axis=1, keepdims=True)
        corner_normals = [face] * 4
        if smooth:
            outward = low * [-1.0, 0.0, -1.0]
            outward /= np.linalg.norm(outward, axis=1, keepdims=True)
            following = np.roll(outward, -1, 0)
            corner_normals = [outward, following, following, outward]
        n = len(a)
        for corner, normal in zip((a, b, c, d), corner_normals, strict=True):
            positions.append(corner)
            normals.append(normal)
        i = np.arange(n) + count
        triangles += [np.stack([i, i + n, i + 2 * n], 1), np.stack([i, i + 2 * n, i + 3 * n], 1)]
        count += 4 * n
    everything = np.concatenate(positions)
    return Mesh(everything, np.concatenate(normals), np.zeros((len(everything), 2)), np.concatenate(triangles))


def polar(mesh: Mesh, around: float, per_metre: float) -> Mesh:
    """uvs for brushing in circles: u by the angle about +Y (`around` repeats a turn), v along the radius on faces that
    look up or down, along y elsewhere. Vertices of triangles across the seam are doubled."""
    turn = np.arctan2(mesh.positions[:, 0], mesh.positions[:, 2]) / TAU
    corner = turn[mesh.triangles]
    wrapped = (corner.max(1) - corner.min(1) > 0.5)[:, None] & (corner < 0)
    doubled = np.unique(mesh.triangles[wrapped])
    renumber = np.zeros(len(mesh.positions), np.int64)
    renumber[doubled] = len(mesh.positions) + np.arange(len(doubled))
    mesh.triangles = np.where(wrapped, renumber[mesh.triangles], mesh.triangles)
    mesh.positions = np.concatenate([mesh.positions, mesh.positions[doubled]])
    mesh.normals = np.concatenate([mesh.normals, mesh.normals[doubled]])
    turn = np.concatenate([turn, turn[doubled] + 1.0])
    radius = np.linalg.norm(mesh.positions[:, [0, 2]], axis=1)
    along = np.where(np.abs(mesh.normals[:, 1]) > 0.5, -radius, -mesh.positions[:, 1])
    mesh.uvs = np.stack([turn * around, along * per_metre], 1)
    return mesh


def planar_uvs(per_metre: float, lean: float = 0.0) -> Callable[[Array, Array], Array]:
    """Projection from above; `lean` mixes y into both, so that sides are not stretched."""

    def project(positions: Array, normals: Array) -> Array:
        return (
            np.stack([positions[:, 0] + lean * positions[:, 1], positions[:, 2] - lean * positions[:, 1]], 1)
            * per_metre
        )

    return project
