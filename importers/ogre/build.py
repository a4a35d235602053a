"""An OgreMesh becomes one MeshAsset: all geometries in one run of vertices, one submesh of ours for each of its own.

part = geometry (shared or own) -> checked -> [normals] -> [tangents] -> influences -> streams
indices -> range check -> plain lists -> one run per submesh
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import STREAMS, MeshAsset, MorphTarget, Submesh
from engine.core.findings import Findings
from engine.math.color import srgb_to_linear
from importers.geometry.normals import fill_normals, flat_normals, unit
from importers.geometry.quantize import snorm16_vectors, unorm16
from importers.geometry.skin import normalise_influences
from importers.geometry.tangents import tangent_frames
from importers.geometry.topology import MODES, to_list, zero_area
from importers.ogre.data import OPERATIONS, Assignments, Floats, Geometry, Indices, OgreMesh
from importers.ogre.morphs import Offsets
from importers.ogre.skeletons import Rig

_NEUTRAL = {"color": [65535] * 4, "tangent": [32767, 0, 0, 32767], "weights": [65535, 0, 0, 0]}
_VALUES_PER_ELEMENT = {"triangles": 3, "lines": 2, "points": 1}
Rows = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Wanted:
    """What a submesh's material asks of its vertices: `normal_uv` the uv set of a normal map (None: no tangents),
    `color` whether it shows vertex colours."""

    normal_uv: int | None = None
    color: bool = False


@dataclass(slots=True)
class _Part:
    """Some vertices of one geometry: `target` as in poses (0 shared, i + 1 submesh i), `source` rows of it."""

    target: int
    source: Rows
    position: Floats
    normal: Floats
    broken: NDArray[np.bool_]
    tangent: Floats | None = None
    uv: dict[int, Floats] = field(default_factory=dict)
    color: Floats | None = None

    def gather(self, rows: Rows) -> _Part:
        def take(a: Any) -> Any:
            return None if a is None else a[rows]

        return _Part(
            self.target, self.source[rows], self.position[rows], self.normal[rows], self.broken[rows],
            take(self.tangent), {k: v[rows] for k, v in self.uv.items()}, take(self.color),
        )  # fmt: skip


class MeshBuilder:
    """Builds one MeshAsset of `mesh`. `wanted[s]`: what the material of submesh s wants of its vertices."""

    def __init__(
        self, mesh: OgreMesh, name: str, rig: Rig | None, wanted: Sequence[Wanted], findings: Findings
    ) -> None:
        self._mesh = mesh
        self._name = name
        self._rig = rig
        self._wanted = wanted
        self._findings = findings
        self._clean: dict[int, _Part] = {}
        self._collapsed = 0
        self._thin = 0

    def build(self, morphs: Sequence[Offsets]) -> tuple[MeshAsset | None, list[int]]:
        """The mesh (None where nothing can be drawn) and, for each submesh of ours, which one of the source it is.

        `morphs`: the morph targets, over the source's vertices."""
        parts: list[tuple[object, _Part]] = []
        bases: dict[object, int] = {}
        runs: list[Indices] = []
        submeshes: list[Submesh] = []
        origin: list[int] = []
        total = first = 0
        for number in range(len(self._mesh.submeshes)):
            made = self._submesh(number)
            if made is None:
                continue
            key, part, indices, topology = made
            if key not in bases:
                bases[key] = total
                total += len(part.position)
                parts.append((key, part))
            used = part.position[indices]
            low, high = used.min(axis=0).tolist(), used.max(axis=0).tolist()
            submeshes.append(
                Submesh(first, len(indices), len(origin), topology, (low[0], low[1], low[2]),
                        (high[0], high[1], high[2]))
            )  # fmt: skip
            runs.append(indices.astype("<u4") + np.uint32(bases[key]))
            first += len(indices)
            origin.append(number)
        self._report()
        if not runs:
            self._findings.error("ogre.empty-mesh", "nothing of the mesh can be drawn", hint="export it again")
            return None, []
        plain = [part for _, part in parts]
        streams = self._streams(plain)
        skeleton = self._rig.skeleton if self._rig is not None and "joints" in streams else None
        targets = [_morph_target(morph, plain) for morph in morphs]
        return MeshAsset(self._name, streams, np.concatenate(runs), submeshes, skeleton, targets), origin

    # --- one submesh ---

    def _submesh(self, number: int) -> tuple[object, _Part, Indices, str] | None:
        """(which part, its vertices, a plain list of indices into them, topology); None where nothing is left."""
        source, where = self._mesh.submeshes[number], f"submeshes[{number}]"
        target = 0 if source.geometry is None else number + 1
        geometry = self._mesh.shared if source.geometry is None else source.geometry
        if geometry is None:
            self._findings.error("ogre.geometry", "uses the shared geometry, which the file lacks; left out", where)
            return None
        if not geometry.count:
            self._findings.warn("ogre.geometry", "has no vertices; left out", where)
            return None
        part = self._checked(target, geometry, where)
        indices = self._indices(source.indices, OPERATIONS[source.operation], part, where)
        if not len(indices):
            return None
        topology = MODES[OPERATIONS[source.operation]][1]
        wanted = self._wanted[number]
        key: object = target
        if topology != "triangles":
            return key, part, indices, topology
        triangles = indices.reshape(-1, 3)
        if geometry.normal is None:
            # only what it uses: several submeshes may share the vertices
            part, triangles = _compact(part, triangles)
            rows, normals, triangles = flat_normals(part.position, triangles)
            part, key = part.gather(rows), (target, number)
            part.normal = normals
        elif not part.normal.any(axis=1).all():
            if target == 0:
                part, triangles = _compact(part, triangles)
                key = (target, number)
            part.normal = fill_normals(part.normal, part.position, triangles)
        if wanted.normal_uv is not None:
            part, triangles, key = self._with_tangents(part, triangles, number, wanted.normal_uv)
        if part.color is not None and not wanted.color and any(w.color for w in self._wanted):
            # another submesh shows its colours; this one's material does not
            if key == target:
                part, triangles = _compact(part, triangles)
                key = (target, number)
            part.color = None
        return key, part, triangles.reshape(-1), topology

    def _with_tangents(
        self, part: _Part, triangles: Indices, number: int, uv_set: int
    ) -> tuple[_Part, Indices, object]:
        part, triangles = _compact(part, triangles)
        if part.tangent is not None and part.tangent[:, :3].any(axis=1).all() and uv_set in part.uv:
            part.tangent[:, 3] = _handedness(part, triangles, uv_set)
            return part, triangles, (part.target, number)
        if uv_set not in part.uv:
            self._findings.warn(
                "ogre.no-uv", f"the material's normal map wants uv set {uv_set}, which the mesh lacks",
                f"submeshes[{number}]", "unwrap the mesh, or remove the normal map",
            )  # fmt: skip
            part.tangent = None
            return part, triangles, (part.target, number)
        rows, tangents, triangles = tangent_frames(part.position, part.normal, part.uv[uv_set], triangles)
        part = part.gather(rows)
        part.tangent = tangents
        return part, triangles, (part.target, number)

    def _checked(self, target: int, geometry: Geometry, where: str) -> _Part:
        """The geometry's vertices, mended where a value makes no sense; once for each geometry."""
        if target in self._clean:
            return self._clean[target]
        count, findings = geometry.count, self._findings
        # squared lengths must still fit float32
        broken = np.asarray(~(np.abs(geometry.position) < 1e18).all(axis=1))
        position = geometry.position
        if broken.any():
            findings.error(
                "ogre.not-finite",
                f"{int(broken.sum()):,} of {count:,} positions are no usable numbers (first: vertex "
                f"{int(np.argmax(broken))}); what they belong to is left out", where, "export the mesh again",
            )  # fmt: skip
            position = np.where(broken[:, None], np.float32(0), position)
        up = np.tile(np.array([0, 0, 1], np.float32), (count, 1))
        normal = up if geometry.normal is None else self._directions(geometry.normal, "normals", where)
        part = _Part(target, np.arange(count), position.astype("<f4"), normal, broken)
        if geometry.tangent is not None and geometry.normal is not None:
            part.tangent = geometry.tangent.copy()
            part.tangent[:, :3] = self._directions(geometry.tangent[:, :3], "tangents", where)
        part.uv = {k: self._finite(uv, f"uv set {k}", where) for k, uv in geometry.uv.items()}
        if geometry.color is not None and any(w.color for w in self._wanted):
            color = np.clip(self._finite(geometry.color, "vertex colours", where), 0, 1)
            color[:, :3] = srgb_to_linear(color[:, :3])
            part.color = color.astype(np.float32)
        self._clean[target] = part
        return part

    def _directions(self, values: Floats, what: str, where: str) -> Floats:
        """Vectors of length 1; zero where there is no direction."""
        wide = values.astype(np.float64)
        with np.errstate(over="ignore", invalid="ignore"):
            length = np.sqrt((wide * wide).sum(axis=1))
        bad = ~np.isfinite(length) | (length < 1e-6)
        off = ~bad & (np.abs(length - 1) > 0.02)
        if bad.any():
            self._findings.warn(
                f"ogre.{what}", f"{int(bad.sum()):,} of {len(values):,} {what} have no direction; made anew", where
            )
        if off.any():
            self._findings.info(
                f"ogre.{what}", f"{int(off.sum()):,} of {len(values):,} {what} are not of length 1; normalised", where
            )
        return unit(np.where(bad[:, None], 0.0, wide), (0.0, 0.0, 0.0)).astype(np.float32)

    def _finite(self, values: Floats, what: str, where: str) -> Floats:
        usable = np.abs(values) < 1e18
        if usable.all():
            return values
        count = int((~usable).any(axis=1).sum())
        self._findings.error("ogre.not-finite", f"{count:,} {what} are no usable numbers; taken as 0", where)
        return np.where(usable, values, np.float32(0))

    def _indices(self, raw: Indices, mode: int, part: _Part, where: str) -> Indices:
        """A plain list; what points outside, or at broken vertices, is dropped."""
        count, (name, topology, _) = len(part.position), MODES[mode]
        given = raw if len(raw) else np.arange(count, dtype=np.uint32)
        listed = to_list(given, mode)
        size = _VALUES_PER_ELEMENT[topology]
        if not len(listed):
            self._findings.error("ogre.indices", f"{len(given)} indices are too few for {name}; left out", where)
            return listed
        if mode in (1, 4) and len(given) % size:
            self._findings.warn("ogre.indices", f"{len(given):,} indices are no whole number of {name}", where)
        elements = listed.reshape(-1, size)
        outside = (elements >= count).any(axis=1)
        if outside.any():
            self._findings.error(
                "ogre.index-range",
                f"{int(outside.sum()):,} of {len(elements):,} {topology} use an index up to {int(elements.max()):,}, "
                f"beyond the {count:,} vertices; left out", where, "export the mesh again",
            )  # fmt: skip
            elements = elements[~outside]
        elements = elements[~part.broken[elements].any(axis=1)]
        if size == 3:
            a, b, c = elements[:, 0], elements[:, 1], elements[:, 2]
            collapsed = (a == b) | (b == c) | (c == a)
            elements = elements[~collapsed]
            # in strips they are how runs are joined
            self._collapsed += int(collapsed.sum()) if mode == 4 else 0
            self._thin += int(zero_area(part.position, elements).sum())
        return np.asarray(elements.reshape(-1))

    def _report(self) -> None:
        for count, what in ((self._collapsed, "name a vertex twice; left out"), (self._thin, "have no area; kept")):
            if count:
                self._findings.info("ogre.zero-area", f"{count:,} triangles {what}")

    # --- all together ---

    def _streams(self, parts: list[_Part]) -> dict[str, NDArray[np.generic]]:
        columns: list[dict[str, NDArray[Any]]] = []
        tangents = any(w.normal_uv is not None for w in self._wanted)
        for part in parts:
            own: dict[str, NDArray[Any]] = {"position": part.position, "normal": snorm16_vectors(part.normal)}
            if tangents and part.tangent is not None:
                own["tangent"] = snorm16_vectors(part.tangent[:, :3], part.tangent[:, 3])
            for number, uv in part.uv.items():
                own[f"uv{number}"] = uv.astype("<f4")
            if part.color is not None:
                own["color"] = unorm16(part.color)
            if self._rig is not None:
                own |= self._influences(part, self._rig)
            columns.append(own)
        present = [stream for stream in STREAMS if any(stream in own for own in columns)]
        return {
            stream: np.concatenate(
                [own[stream] if stream in own else _neutral(stream, len(own["position"])) for own in columns]
            )
            for stream in present
        }

    def _influences(self, part: _Part, rig: Rig) -> dict[str, NDArray[Any]]:
        target = part.target
        rows = self._mesh.assignments if target == 0 else self._mesh.submeshes[target - 1].assignments
        if not len(rows):
            return {}
        where = "the shared geometry" if target == 0 else f"submeshes[{target - 1}]"
        geometry = self._mesh.shared if target == 0 else self._mesh.submeshes[target - 1].geometry
        assert geometry is not None
        joints, weights = self._table(rows, rig, geometry.count, where)
        result = normalise_influences(joints, weights)
        if result.renormalised:
            self._findings.warn(
                "ogre.weights", f"{result.renormalised:,} of {geometry.count:,} vertices' weights do not sum to 1; "
                "renormalised", where,
            )  # fmt: skip
        if result.without_weight:
            self._findings.warn(
                "ogre.weights", f"{result.without_weight:,} vertices have no weight; bound to the first joint", where
            )
        if result.cut:
            self._findings.warn("ogre.weights", f"{result.cut:,} vertices have over 8 influences; the least are cut",
                                where)  # fmt: skip
        streams: dict[str, NDArray[Any]] = {
            "joints": np.ascontiguousarray(result.joints[part.source, :4]),
            "weights": np.ascontiguousarray(result.weights[part.source, :4]),
        }
        if result.joints.shape[1] == 8:
            streams["joints1"] = np.ascontiguousarray(result.joints[part.source, 4:])
            streams["weights1"] = np.ascontiguousarray(result.weights[part.source, 4:])
        return streams

    def _table(
        self, rows: Assignments, rig: Rig, count: int, where: str
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Assignments in any order -> joints i8[n,m] and weights f8[n,m], m the most that one vertex has (at most 32;
        of more, the greatest)."""
        lookup = np.full(0x10000, -1, np.int64)
        for handle, row in rig.rows.items():
            lookup[handle] = row
        joint = lookup[rows.bone]
        outside, unknown = rows.vertex >= count, joint < 0
        for wrong, what in ((outside, f"vertices beyond the {count:,}"), (unknown, "bones the skeleton lacks")):
            if wrong.any():
                self._findings.error(
                    "ogre.assignment", f"{int(wrong.sum()):,} bone assignments name {what}; ignored", where,
                    "export mesh and skeleton together",
                )  # fmt: skip
        good = ~outside & ~unknown
        vertex, joint = rows.vertex[good].astype(np.int64), joint[good]
        weight = rows.weight[good].astype(np.float64)
        order = np.lexsort((-np.nan_to_num(weight), vertex))
        vertex, joint, weight = vertex[order], joint[order], weight[order]
        place = np.arange(len(vertex)) - np.searchsorted(vertex, vertex)
        most = min(int(place.max(initial=0)) + 1, 32)
        kept = place < most
        joints, weights = np.zeros((count, most), np.int64), np.zeros((count, most))
        joints[vertex[kept], place[kept]] = joint[kept]
        weights[vertex[kept], place[kept]] = weight[kept]
        return joints, weights


def _compact(part: _Part, triangles: Indices) -> tuple[_Part, Indices]:
    """Only the vertices that `triangles` use, in their order."""
    rows, flat = np.unique(triangles.reshape(-1), return_inverse=True)
    return part.gather(rows.astype(np.int64)), flat.reshape(-1, 3).astype(np.uint32)


def _handedness(part: _Part, triangles: Indices, uv_set: int) -> NDArray[np.float64]:
    """f8[n], 1 or -1: the w that makes w * cross(normal, tangent) follow shrinking v, as `tangent_frames` has it.

    Exporters differ in what they write there, if they write it at all; the uv tell it. dP/dv of a triangle with edges
    e1, e2 and uv edges (u1, v1), (u2, v2) is (u1 e2 - u2 e1) / (u1 v2 - u2 v1); its vertices get the sum."""
    p, uv = part.position.astype(np.float64)[triangles], part.uv[uv_set].astype(np.float64)[triangles]
    e1, e2, t1, t2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0], uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = t1[:, 0] * t2[:, 1] - t2[:, 0] * t1[:, 1]
    with np.errstate(over="ignore", invalid="ignore"):
        along = (t1[:, :1] * e2 - t2[:, :1] * e1) * np.sign(area)[:, None]
    along = np.repeat(unit(along, (0.0, 0.0, 0.0)), 3, axis=0)
    flat = triangles.reshape(-1)
    sums = np.stack([np.bincount(flat, along[:, k], len(part.position)) for k in range(3)], 1)
    assert part.tangent is not None
    across = np.cross(part.normal.astype(np.float64), part.tangent[:, :3].astype(np.float64))
    return np.where((across * sums).sum(axis=1) > 0, -1.0, 1.0)


def _neutral(stream: str, count: int) -> NDArray[Any]:
    dtype, components = STREAMS[stream]
    return np.tile(np.asarray(_NEUTRAL.get(stream) or [0] * components, dtype), (count, 1))


def _morph_target(morph: Offsets, parts: list[_Part]) -> MorphTarget:
    """One morph target over all parts; those of other geometries do not move."""
    streams: dict[str, Floats] = {}
    for name in ("position", "normal"):
        values = getattr(morph, name)
        if values is None:
            continue
        streams[name] = np.concatenate(
            [
                values[part.source] if part.target == morph.target else np.zeros((len(part.position), 3), "<f4")
                for part in parts
            ]
        ).astype("<f4")
    return MorphTarget(morph.name, streams)
