"""Entries of the document that the host reads (importers.fbx.document): what both readers here fill alike."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from importers.geometry.crease import crease_normals
from importers.geometry.triangulate import triangulate

Json = dict[str, Any]
F8 = NDArray[np.float64]
I8 = NDArray[np.int64]


@dataclass(slots=True)
class Output:
    """What is sent back. `put` stores an array under a name that the JSON can use."""

    data: Json = field(default_factory=dict)
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    warnings: dict[str, int] = field(default_factory=dict)

    def put(self, values: NDArray[Any]) -> str:
        name = f"a{len(self.arrays)}"
        self.arrays[name] = np.ascontiguousarray(values)
        return name

    def warn(self, text: str) -> None:
        self.warnings[text] = self.warnings.get(text, 0) + 1


@dataclass(slots=True)
class Polygons:
    """Geometry as read: `corner` i8[c] are rows of the vertex arrays, polygon p has `count[p]` corners in a row.

    `normal` f8[v,3], `color` f8[v,4] (scene-linear), `uvs` f8[v,2] each (origin bottom left), or None; zero rows of
    `normal` are unknown. `material` i8[p] is an index into `materials`. `bones`: (node, 3x4 bone from mesh, vertex
    rows, weights). `shapes`: (name, offsets f8[v,3], weight). `crease`: normals are made smooth up to this angle, in
    radians (0: flat).
    """

    name: str
    position: F8
    corner: I8
    count: I8
    material: I8
    materials: list[int]
    normal: F8 | None = None
    color: F8 | None = None
    uvs: list[F8] = field(default_factory=list)
    bones: list[tuple[int, F8, I8, F8]] = field(default_factory=list)
    shapes: list[tuple[str, F8, float]] = field(default_factory=list)
    crease: float = 0.0
    loose: int = 0


def mesh_entry(mesh: Polygons, out: Output, element: int) -> Json:
    """The description of a mesh. Equal positions (with equal weights and offsets) become one control point. `element`
    numbers its shapes: `element + k` for shape k."""
    outside = (mesh.corner < 0) | (mesh.corner >= len(mesh.position))
    corner = np.where(outside, 0, mesh.corner)
    usable = mesh.count >= 3
    if outside.any():
        bad = np.isin(np.arange(len(mesh.count)), np.repeat(np.arange(len(mesh.count)), mesh.count)[outside])
        out.warn(f"{mesh.name!r}: {int(bad.sum()):,} faces name vertices that do not exist; left out")
        usable &= ~bad
    first = (np.cumsum(mesh.count) - mesh.count)[usable]
    with np.errstate(invalid="ignore"):
        corners = mesh.position[corner] if len(mesh.position) else np.zeros((len(corner), 3))
    triangles, owner = triangulate(corners, first, mesh.count[usable])
    point, source = _points(mesh)
    normal = mesh.normal
    generated = normal is None or not np.any(normal)
    described: Json = {
        "name": mesh.name,
        "positions": out.put(mesh.position[source]),
        "corner_vertex": out.put(point[corner].astype(np.uint32)),
        "triangles": out.put(triangles.astype(np.uint32)),
        "triangle_material": out.put(mesh.material[usable][owner].astype(np.uint32)),
        "materials": mesh.materials,
        "polygons": len(mesh.count),
        "lines": int((mesh.count == 2).sum()),
        "points": int((mesh.count == 1).sum()) + mesh.loose,
        "holes": 0,
        "subdivision": False,
        "generated_normals": generated,
        "normal": _attribute(normal, corner, out),
        "color": _attribute(mesh.color, corner, out),
        "uv_sets": [
            {"name": f"uv{k}", "uv": _attribute(uv, corner, out), "tangent": None, "bitangent": None}
            for k, uv in enumerate(mesh.uvs)
        ],
        "color_sets": int(mesh.color is not None),
        "skins": [_skin(mesh, point, source, out)] if mesh.bones else [],
        "channels": [_channel(mesh, k, source, element + k, out) for k in range(len(mesh.shapes))],
        "caches": [],
    }
    if generated and mesh.crease > 0.0 and len(triangles):
        values = crease_normals(corners[triangles], point[corner][triangles], mesh.crease)
        normals = np.zeros((len(corner), 3))
        normals[triangles.reshape(-1)] = values.reshape(-1, 3)
        described["normal"] = _attribute(normals, np.arange(len(corner)), out)
    return described


def _points(mesh: Polygons) -> tuple[I8, I8]:
    """`point` i8[v]: the control point of each vertex; `source` i8[p]: a vertex of each point, in their order."""
    columns = [mesh.position + 0.0]
    if mesh.bones:
        spread = np.zeros((len(mesh.position), 2))
        for number, (_, _, rows, weights) in enumerate(mesh.bones):
            inside = rows < len(spread)
            np.add.at(spread, rows[inside], weights[inside, None] * [1.0 + number, np.sin(1.0 + number)])
        columns.append(spread)
    columns += [offsets for _, offsets, _ in mesh.shapes]
    rows = np.ascontiguousarray(np.concatenate(columns, axis=1))
    keys = rows.view(np.dtype((np.void, rows.itemsize * rows.shape[1]))).reshape(-1)
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    rank = np.argsort(first, kind="stable")
    place = np.empty_like(rank)
    place[rank] = np.arange(len(rank))
    return place[inverse].astype(np.int64), first[rank].astype(np.int64)


def _attribute(values: F8 | None, corner: I8, out: Output) -> Json | None:
    if values is None:
        return None
    return {"values": out.put(values), "indices": out.put(corner.astype(np.uint32))}


def _skin(mesh: Polygons, point: I8, source: I8, out: Output) -> Json:
    """Each control point once: the weights of the vertex that stands for it."""
    kept = np.zeros(len(point), bool)
    kept[source] = True
    counts, vertices, weights = [], [], []
    for _, _, rows, values in mesh.bones:
        inside = rows < len(point)
        chosen = inside & kept[np.where(inside, rows, 0)]
        counts.append(int(chosen.sum()))
        vertices.append(point[rows[chosen]])
        weights.append(values[chosen])
    return {
        "name": mesh.name,
        "method": "linear",
        "bones": [node for node, _, _, _ in mesh.bones],
        "bone_from_geometry": out.put(np.array([matrix for _, matrix, _, _ in mesh.bones]).reshape(-1, 3, 4)),
        "world_from_geometry": None,
        "counts": counts,
        "vertices": out.put(np.concatenate(vertices).astype(np.uint32)),
        "weights": out.put(np.concatenate(weights)),
        "dq_vertices": out.put(np.zeros(0, np.uint32)),
        "dq_weights": out.put(np.zeros(0)),
    }


def _channel(mesh: Polygons, k: int, source: I8, element: int, out: Output) -> Json:
    name, offsets, weight = mesh.shapes[k]
    dense = offsets[source]
    moved = np.flatnonzero(dense.any(axis=1))
    key = {
        "name": name,
        "target": 100.0,
        "vertices": out.put(moved.astype(np.uint32)),
        "positions": out.put(dense[moved]),
        "normals": out.put(np.zeros((0, 3))),
        "weights": out.put(np.zeros(0)),
    }
    return {"name": name, "element": element, "weight": 100.0 * weight, "keys": [key]}


def node_entry(
    name: str, parent: int, mesh: int = -1, *, light: int = -1, camera: int = -1, root: bool = False
) -> Json:
    kind = "mesh" if mesh >= 0 else "light" if light >= 0 else "camera" if camera >= 0 else "empty"
    return {
        "name": name, "parent": parent, "kind": kind, "visible": True, "mesh": mesh, "light": light, "camera": camera,
        "materials": [], "root": root, "helper": "",
    }  # fmt: skip


def map_entry(value: tuple[float, ...] | None, texture: int = -1) -> Json:
    """A material's property: its value (None where only the texture is known)."""
    known = value or (1.0,)
    return {
        "value": [float(v) if np.isfinite(v) else 0.0 for v in (*known, 0.0, 0.0, 0.0)[:4]],
        "has_value": value is not None,
        "components": len(known),
        "texture": texture,
    }


def texture_entry(name: str, file: str, content: str = "", *, uv_set: int = 0) -> Json:
    return {
        "name": name, "type": "file", "files": [file, ""], "layers": [], "uv_set": f"uv{uv_set}",
        "clamp": [False, False], "matrix": None, "content": content,
    }  # fmt: skip


def rough_from_exponent(exponent: float) -> float:
    """Roughness of a Blinn-Phong exponent n: alpha^2 = 2 / (n + 2), alpha = roughness^2 (Walter et al., 2007, 5.4)."""
    return float((2.0 / (max(exponent, 0.0) + 2.0)) ** 0.25)
