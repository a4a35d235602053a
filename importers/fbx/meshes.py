"""Meshes: control points and per-corner attributes become vertices, split where any attribute differs.

corners ─ equal (point, normal, tangent, uv0, uv1, colour) ─> vertices ─> missing normals, tangents ─> streams
triangles ─ by material ─> one run of indices per material slot
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import STREAMS, MeshAsset, MorphTarget, Submesh
from importers.fbx.document import LARGEST, FbxDocument, Json
from importers.fbx.morphs import read_morphs
from importers.fbx.skins import Skin
from importers.geometry.normals import fill_normals, flat_normals
from importers.geometry.quantize import snorm16_vectors, unorm16
from importers.geometry.skin import normalise_influences
from importers.geometry.tangents import tangent_frames

Ints = NDArray[np.int64]


@dataclass(slots=True)
class _Vertices:
    """`point` i8[n]: the control point of each vertex; the rest f4[n,k]."""

    point: Ints
    columns: dict[str, NDArray[np.float32]] = field(default_factory=dict)

    def gather(self, source: Ints) -> _Vertices:
        return _Vertices(self.point[source], {name: values[source] for name, values in self.columns.items()})


def build_mesh(
    doc: FbxDocument, index: int, materials: list[int], skin: Skin | None, normal_uv: list[int | None],
    frames: NDArray[np.float64],
) -> tuple[MeshAsset, list[int]] | None:  # fmt: skip
    """Mesh `index` with its slots' materials; `materials`: those of the node, by the mesh's material numbers.

    `normal_uv[m]`: the uv set of material m's normal map, or None. `frames` f8[k,points,3]: positions that become morph
    targets after those of the blend shapes. None (with a finding) where nothing can be drawn.
    """
    mesh = doc.meshes[index]
    name = str(mesh["name"]) or f"mesh_{index}"
    where = f"meshes[{name}]"
    _note_left_out(doc, mesh, where)
    positions, broken = _positions(doc, mesh, where)
    corners, number = _triangles(doc, mesh, positions, broken, where)
    if not len(corners):
        doc.findings.warn("fbx.empty-mesh", f"nothing of the mesh {name!r} can be drawn; left out", where)
        return None
    used = sorted({int(v) for v in np.unique(number)})
    slots = [materials[m] if m < len(materials) else -1 for m in used]
    wanted = next((normal_uv[m] for m in slots if m >= 0 and normal_uv[m] is not None), None)
    vertices, triangles = _weld(doc, mesh, corners, wanted, where)
    vertices, triangles = _shade(doc, positions, vertices, triangles, wanted, where)
    order = np.argsort(number, kind="stable")
    triangles, number = triangles[order], number[order]
    submeshes, first = [], 0
    final = positions[vertices.point].astype("<f4")
    for slot, value in enumerate(used):
        run = triangles[number == value]
        box = final[run.reshape(-1)]
        low, high = box.min(axis=0).tolist(), box.max(axis=0).tolist()
        submeshes.append(
            Submesh(first, run.size, slot, "triangles", (low[0], low[1], low[2]), (high[0], high[1], high[2]))
        )
        first += run.size
    asset = MeshAsset(name, _streams(doc, vertices, final, skin, where), triangles.reshape(-1).astype("<u4"), submeshes)
    if skin is not None:
        asset.skeleton = skin.skeleton
        if skin.method in ("dual_quaternion", "blended_dq_linear"):
            asset.extras["skinning"] = "dual_quaternion"
            if not (skin.dq_share == 1.0).all():
                asset.extras["dual_quaternion_share"] = [round(float(v), 6) for v in skin.dq_share[vertices.point]]
            doc.findings.info("fbx.skin", "dual-quaternion skinning is kept", where)
    asset.morphs = read_morphs(doc, mesh, vertices.point, where)
    for k, frame in enumerate(frames):
        offsets = np.ascontiguousarray((frame - positions)[vertices.point].astype("<f4"))
        asset.morphs.append(MorphTarget(f"frame_{k}", {"position": offsets}))
    return asset, slots


def _note_left_out(doc: FbxDocument, mesh: Json, where: str) -> None:
    loose = mesh["lines"] + mesh["points"]
    if loose:
        doc.findings.info("fbx.faces", f"{loose:,} faces of one or two corners are left out", where)
    if mesh["holes"]:
        doc.findings.info("fbx.faces", f"{mesh['holes']:,} faces are marked as holes; left out", where)
    if mesh["subdivision"]:
        doc.findings.info("fbx.subdivision", "the subdivision surface is imported as its control cage", where)
    if len(mesh["uv_sets"]) > 2:
        names = ", ".join(str(uv["name"]) for uv in mesh["uv_sets"][2:])
        doc.findings.info("fbx.uv-set", f"{len(mesh['uv_sets'])} uv sets; {names} left out", where)
    if mesh["color_sets"] > 1:
        doc.findings.info("fbx.color-set", f"{mesh['color_sets']} colour sets; the first is imported", where)
    if mesh["generated_normals"]:
        doc.findings.info("fbx.normals", "has no normals; made from the faces, smooth where they meet smoothly", where)


def _positions(doc: FbxDocument, mesh: Json, where: str) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    positions = np.asarray(doc.array(mesh["positions"]), np.float64)
    broken: NDArray[np.bool_] = np.asarray(~(np.abs(positions) < LARGEST).all(axis=1))
    if broken.any():
        doc.findings.error(
            "fbx.not-finite", f"{int(broken.sum()):,} of {len(broken):,} points are no numbers; their faces left out",
            where, "export the mesh again",
        )  # fmt: skip
        positions = np.where(broken[:, None], 0.0, positions)
    return positions, broken


def _triangles(
    doc: FbxDocument, mesh: Json, positions: NDArray[np.float64], broken: NDArray[np.bool_], where: str
) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """Corners u4[t,3] of the triangles that can be drawn, and each one's material number u4[t]."""
    corner_vertex = doc.array(mesh["corner_vertex"])
    corners, number = doc.array(mesh["triangles"]), doc.array(mesh["triangle_material"])
    points = corner_vertex[corners]
    outside = (points >= len(positions)).any(axis=1)
    if outside.any():
        doc.findings.error(
            "fbx.index-range", f"{int(outside.sum()):,} triangles use points beyond {len(positions):,}; left out",
            where, "export the mesh again",
        )  # fmt: skip
        corners, number, points = corners[~outside], number[~outside], points[~outside]
    a, b, c = points[:, 0], points[:, 1], points[:, 2]
    collapsed = (a == b) | (b == c) | (c == a)
    if collapsed.any():
        doc.findings.info("fbx.zero-area", f"{int(collapsed.sum()):,} triangles name a point twice; left out", where)
    good = ~collapsed & ~broken[points].any(axis=1)
    return corners[good], number[good]


def _weld(
    doc: FbxDocument, mesh: Json, corners: NDArray[np.uint32], normal_uv: int | None, where: str
) -> tuple[_Vertices, NDArray[np.uint32]]:
    """One vertex for each set of equal corners; triangles u4[t,3]."""
    flat = corners.reshape(-1).astype(np.int64)
    point = doc.array(mesh["corner_vertex"])[flat].astype(np.int64)
    values: dict[str, NDArray[np.float32]] = {}
    for name, attribute, components in _attributes(mesh, normal_uv):
        found = _corner_values(doc, attribute, components, flat, f"{where}.{name}")
        if found is not None:
            values[name] = found
    if "bitangent" in values and "tangent" in values and "normal" in values:
        values["tangent"] = _with_sign(values["normal"], values["tangent"], values["bitangent"])
    else:
        values.pop("tangent", None)
    values.pop("bitangent", None)
    for name in ("uv0", "uv1"):
        if name in values:
            values[name] = np.stack([values[name][:, 0], np.float32(1.0) - values[name][:, 1]], axis=1)
    key = point
    for column in values.values():
        key = _dense(key * (len(column) + 1) + _row_numbers(column))
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    # numbered as they first appear, so that neighbours in the source stay neighbours
    rank = np.argsort(first, kind="stable")
    place = np.empty_like(rank)
    place[rank] = np.arange(len(rank))
    source = first[rank]
    vertices = _Vertices(point[source], {name: column[source] for name, column in values.items()})
    return vertices, place[inverse].reshape(-1, 3).astype(np.uint32)


def _attributes(mesh: Json, normal_uv: int | None) -> list[tuple[str, Json | None, int]]:
    sets = mesh["uv_sets"][:2]
    listed: list[tuple[str, Json | None, int]] = [("normal", mesh["normal"], 3)]
    listed += [(f"uv{k}", uv["uv"], 2) for k, uv in enumerate(sets)]
    listed.append(("color", mesh["color"], 4))
    if normal_uv is not None and normal_uv < len(sets):
        listed += [(name, sets[normal_uv][name], 3) for name in ("tangent", "bitangent")]
    return listed


def _corner_values(
    doc: FbxDocument, attribute: Json | None, components: int, corners: Ints, where: str
) -> NDArray[np.float32] | None:
    if attribute is None:
        return None
    values = doc.floats(attribute["values"], components).astype(np.float32)
    indices = doc.array(attribute["indices"])
    if not len(values) or (len(indices) and int(corners.max(initial=0)) >= len(indices)):
        doc.findings.error("fbx.attribute", "does not fit the mesh; left out", where)
        return None
    chosen = indices[corners]
    outside = chosen >= len(values)
    if outside.any():
        doc.findings.error("fbx.index-range", f"{int(outside.sum()):,} corners name no value; taken as 0", where)
    return np.where(outside[:, None], np.float32(0), values[np.where(outside, 0, chosen)])


def _with_sign(
    normal: NDArray[np.float32], tangent: NDArray[np.float32], bitangent: NDArray[np.float32]
) -> NDArray[np.float32]:
    """f4[n,4]: tangents with the handedness that the bitangents show."""
    side = np.einsum("ij,ij->i", np.cross(normal, tangent), bitangent)
    return np.concatenate([tangent, np.where(side < 0, -1.0, 1.0)[:, None]], axis=1).astype(np.float32)


def _row_numbers(rows: NDArray[np.float32]) -> Ints:
    """Equal numbers for equal rows."""
    bits = np.ascontiguousarray(rows + np.float32(0)).view(np.uint32)  # -0 becomes 0
    key = np.zeros(len(bits), np.int64)
    for column in bits.T:
        key = _dense(key * (len(bits) + 1) + _dense(column.astype(np.int64)))
    return key


def _dense(key: Ints) -> Ints:
    return np.unique(key, return_inverse=True)[1].reshape(-1).astype(np.int64)


def _shade(
    doc: FbxDocument, positions: NDArray[np.float64], vertices: _Vertices, triangles: NDArray[np.uint32],
    normal_uv: int | None, where: str,
) -> tuple[_Vertices, NDArray[np.uint32]]:  # fmt: skip
    """Normals where they are missing, and tangents where a normal map wants them."""
    place = positions[vertices.point].astype(np.float32)
    if "normal" not in vertices.columns:
        source, normals, triangles = flat_normals(place, triangles)
        vertices = vertices.gather(source)
        vertices.columns["normal"] = normals
        vertices.columns.pop("tangent", None)
        place = place[source]
    vertices.columns["normal"] = fill_normals(vertices.columns["normal"], place, triangles)
    if normal_uv is None:
        return vertices, triangles
    uv = vertices.columns.get(f"uv{normal_uv}")
    if uv is None:
        doc.findings.warn(
            "fbx.no-uv", f"the material's normal map wants uv set {normal_uv}, which the mesh lacks", where,
            "unwrap the mesh, or remove the normal map",
        )  # fmt: skip
        return vertices, triangles
    given = vertices.columns.get("tangent")
    if given is None or not given[:, :3].any(axis=1).all():
        vertices.columns.pop("tangent", None)
        source, tangents, triangles = tangent_frames(place, vertices.columns["normal"], uv, triangles)
        vertices = vertices.gather(source)
        vertices.columns["tangent"] = tangents
    return vertices, triangles


def _streams(
    doc: FbxDocument, vertices: _Vertices, position: NDArray[np.float32], skin: Skin | None, where: str
) -> dict[str, NDArray[np.generic]]:
    columns = vertices.columns
    own: dict[str, NDArray[Any]] = {"position": position, "normal": snorm16_vectors(columns["normal"])}
    if "tangent" in columns:
        own["tangent"] = snorm16_vectors(columns["tangent"][:, :3], columns["tangent"][:, 3])
    for name in ("uv0", "uv1"):
        if name in columns:
            own[name] = np.ascontiguousarray(columns[name].astype("<f4"))
    if "uv1" in own and "uv0" not in own:
        own["uv0"] = np.zeros((len(position), 2), "<f4")
    if "color" in columns:
        own["color"] = unorm16(columns["color"])
    if skin is not None:
        result = normalise_influences(skin.rows[vertices.point], skin.weights[vertices.point])
        if result.cut:
            doc.findings.warn(
                "fbx.weights", f"{result.cut:,} vertices have over 8 influences; the least are cut", where
            )
        if result.renormalised:
            doc.findings.info(
                "fbx.weights", f"{result.renormalised:,} of {len(position):,} vertices' weights do not sum to 1; "
                "renormalised", where,
            )  # fmt: skip
        own["joints"] = np.ascontiguousarray(result.joints[:, :4])
        own["weights"] = np.ascontiguousarray(result.weights[:, :4])
        if result.joints.shape[1] == 8:
            own["joints1"] = np.ascontiguousarray(result.joints[:, 4:])
            own["weights1"] = np.ascontiguousarray(result.weights[:, 4:])
    return {stream: own[stream] for stream in STREAMS if stream in own}
