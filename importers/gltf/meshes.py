"""Meshes: primitives of any mode become one MeshAsset with submeshes.

Source: glTF 2.0 specification (Khronos, 2021), section 3.7 (meshes, topology, morph targets).

    attributes -> vertices (checked) -> flat normals if none -> tangents if a normal map wants them -> streams
    indices    -> range check -> lists of triangles, lines, points -> one index run per primitive
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import STREAMS, MeshAsset, MorphTarget, Skeleton, Submesh
from importers.geometry.normals import fill_normals, flat_normals
from importers.geometry.quantize import snorm16_vectors, unorm16
from importers.geometry.skin import normalise_influences
from importers.geometry.tangents import tangent_frames
from importers.geometry.topology import MODES, to_list, zero_area
from importers.gltf import draco
from importers.gltf.accessors import Accessors
from importers.gltf.attributes import VertexData, read_vertices
from importers.gltf.document import Document, JsonObject
from importers.gltf.extras import MESH_KEYS, read_extras
from importers.gltf.skins import Skin
from importers.gltf.variants import EXTRAS, Mapping, Variants

Indices = NDArray[np.uint32]
Morphs = list[dict[str, NDArray[np.float32]]]
_MORPH_STREAMS = {"POSITION": "position", "NORMAL": "normal", "TANGENT": "tangent"}
_VALUES_PER_ELEMENT = {"triangles": 3, "lines": 2, "points": 1}


@dataclass(frozen=True, slots=True)
class Slot:
    """A material slot: the material's index (-1: the default one), and whether it is unlit for want of normals, and
    what it shows in the file's variants."""

    material: int
    unlit: bool = False
    variants: Mapping = ()


@dataclass(slots=True)
class _Primitive:
    """One primitive on its way: indices (a plain list) into its own `vertices`."""

    vertices: VertexData
    morphs: Morphs
    indices: Indices
    topology: str
    slot: Slot
    shared: object


class MeshReader:
    """Builds MeshAssets. `normal_uv[m]`: the uv set that material m's normal map uses, or None."""

    def __init__(
        self, doc: Document, accessors: Accessors, normal_uv: Sequence[int | None], variants: Variants
    ) -> None:
        self._doc = doc
        self._accessors = accessors
        self._normal_uv = normal_uv
        self._variants = variants
        self._collapsed: list[tuple[str, int]] = []
        self._thin: list[tuple[str, int]] = []

    def report_zero_area(self) -> None:
        """One finding each for triangles that name a vertex twice and for thin ones: big files have thousands."""
        for found, what in (
            (self._collapsed, "name a vertex twice; left out"),
            (self._thin, "have no area; kept"),
        ):
            if found:
                total = sum(count for _, count in found)
                places = f", in {len(found)} primitives" if len(found) > 1 else ""
                self._doc.findings.info("gltf.zero-area", f"{total:,} triangles {what}{places}", found[0][0])

    def build(self, index: int, skin: Skin | None) -> tuple[MeshAsset, list[Slot]] | None:
        """Mesh `index`, bound to `skin`, and its material slots; None where nothing of it can be drawn."""
        where = f"meshes[{index}]"
        mesh = self._doc.objects("meshes")[index]
        name = self._doc.name(mesh, where, f"mesh_{index}")
        primitives = []
        cache: dict[object, tuple[VertexData, Morphs] | None] = {}
        for number, primitive in enumerate(self._doc.child_objects(mesh, "primitives", where)):
            read = self._primitive(primitive, f"{where}.primitives[{number}]", cache)
            if read is not None:
                primitives.append(read)
        if not primitives:
            self._doc.findings.error("gltf.empty-mesh", f"nothing of the mesh {name!r} can be drawn; left out", where)
            return None
        asset, slots = self._assemble(name, primitives, skin, where)
        self._name_morphs(asset, mesh, where)
        asset.extras |= read_extras(self._doc, mesh, where, MESH_KEYS)
        variants = self._variants.extras([slot.variants for slot in slots])
        if variants is not None:
            asset.extras[EXTRAS] = variants
        return asset, slots

    def _primitive(
        self, primitive: JsonObject, where: str, cache: dict[object, tuple[VertexData, Morphs] | None]
    ) -> _Primitive | None:
        doc = self._doc
        mode = doc.integer(primitive, "mode", where, 4)
        if mode not in MODES:
            doc.findings.error("gltf.value", f"mode {mode} is none of 0..6", f"{where}.mode")
            return None
        if doc.extension(primitive, draco.NAME, where) is not None and not self._unpack(primitive, where):
            return None
        material = doc.index(primitive, "material", where, "materials")
        material, variants = self._variants.read(primitive, -1 if material is None else material, where)
        attributes = doc.child(primitive, "attributes", where)
        targets = doc.child_objects(primitive, "targets", where)
        shared: object = (repr(sorted(attributes.items(), key=repr)), repr(targets))
        if shared not in cache:
            vertices = read_vertices(doc, self._accessors, attributes, f"{where}.attributes")
            cache[shared] = (
                None if vertices is None else (vertices, self._morphs(targets, len(vertices.position), where))
            )
        found = cache[shared]
        if found is None:
            return None
        vertices, morphs = found
        topology = MODES[mode][1]
        indices = self._indices(primitive, where, mode, vertices)
        # Bytes per corner at worst, when every corner becomes a vertex of its own
        if indices is None or not len(indices) or not self._accessors.charge(len(indices) * 80, where):
            return None
        if topology != "triangles":
            slot = Slot(material, vertices.normal is None, variants)
            if vertices.normal is None:
                vertices = vertices.gather(np.arange(len(vertices.position)))
                vertices.normal = np.tile(np.array([0, 0, 1], np.float32), (len(vertices.position), 1))
                shared = (shared, "unlit")
            return _Primitive(vertices, morphs, indices, topology, slot, shared)
        return self._shade(vertices, morphs, indices, Slot(material, False, variants), shared, where)

    def _shade(
        self, vertices: VertexData, morphs: Morphs, indices: Indices, slot: Slot, shared: object, where: str
    ) -> _Primitive:
        """Triangles with normals and, where the material has a normal map, tangents."""
        triangles = indices.reshape(-1, 3)
        if vertices.normal is None:
            source, normals, triangles = flat_normals(vertices.position, triangles)
            vertices, morphs, shared = vertices.gather(source), _gather(morphs, source), object()
            vertices.normal, vertices.tangent = normals, None
        elif not vertices.normal.any(axis=1).all():
            vertices = vertices.gather(np.arange(len(vertices.position)))
            assert vertices.normal is not None
            vertices.normal = fill_normals(vertices.normal, vertices.position, triangles)
            shared = object()
        # tangents serve whatever variant is shown: they follow the first normal map among the materials
        materials = [slot.material, *(material for _, material in slot.variants)]
        wanted = next((uv for m in materials if m >= 0 and (uv := self._normal_uv[m]) is not None), None)
        given = vertices.tangent is not None and vertices.tangent[:, :3].any(axis=1).all()
        if wanted is not None and not given:
            if wanted in vertices.uv:
                assert vertices.normal is not None
                source, tangents, triangles = tangent_frames(
                    vertices.position, vertices.normal, vertices.uv[wanted], triangles
                )
                vertices, morphs, shared = vertices.gather(source), _gather(morphs, source), object()
                vertices.tangent = tangents
            else:
                self._doc.findings.warn(
                    "gltf.no-uv", f"the material's normal map wants TEXCOORD_{wanted}, which the mesh lacks", where,
                    "unwrap the mesh, or remove the normal map",
                )  # fmt: skip
                vertices.tangent = None
        elif wanted is None or not given:
            vertices.tangent = None if not given else vertices.tangent
        return _Primitive(vertices, morphs, triangles.reshape(-1), "triangles", slot, shared)

    def _unpack(self, primitive: JsonObject, where: str) -> bool:
        """Decode a Draco primitive; where that cannot be done, whether there is plain data beside the stream."""
        doc = self._doc
        numbers = [v for v in doc.child(primitive, "attributes", where).values() if isinstance(v, int)]
        known = doc.objects("accessors")
        plain = all("bufferView" in known[n] for n in numbers if 0 <= n < len(known))
        if plain and draco.decoder() is None:
            return True
        return draco.read_draco(doc, self._accessors, primitive, where) or plain

    def _indices(self, primitive: JsonObject, where: str, mode: int, vertices: VertexData) -> Indices | None:
        """The primitive's indices as a plain list; what points outside, or at broken vertices, is dropped."""
        doc, count, name = self._doc, len(vertices.position), MODES[mode][0]
        place = f"{where}.indices"
        if "indices" in primitive:
            number = doc.index(primitive, "indices", where, "accessors")
            raw = None if number is None else self._accessors.raw(number)
            if raw is None:
                doc.findings.error("gltf.indices", "the indices cannot be read; the primitive is left out", place)
                return None
            if raw.dtype.kind != "u" or raw.shape[1] != 1:
                doc.findings.error("gltf.indices", "the indices are no unsigned integers; left out", place)
                return None
            listed = to_list(raw[:, 0].astype("<u4"), mode)
            given = len(raw)
        else:
            listed = to_list(np.arange(count, dtype="<u4"), mode)
            given = count
        if not len(listed):
            doc.findings.error("gltf.indices", f"{given} indices are too few for {name}; left out", where)
            return None
        size = _VALUES_PER_ELEMENT[MODES[mode][1]]
        if mode in (1, 4) and given % size:
            doc.findings.warn("gltf.indices", f"{given:,} indices are no whole number of {name}", where)
        elements = listed.reshape(-1, size)
        outside = elements >= count
        if outside.any():
            worst = int(elements.max())
            doc.findings.error(
                "gltf.index-range",
                f"{int(outside.any(axis=1).sum()):,} of {len(elements):,} {MODES[mode][1]} use an index up to "
                f"{worst:,}, beyond the {count:,} vertices; left out", place, "export the mesh again",
            )  # fmt: skip
            elements = elements[~outside.any(axis=1)]
        elements = elements[~vertices.broken[elements].any(axis=1)]
        if size == 3:
            elements = self._drop_collapsed(elements, vertices, mode, where)
        return np.asarray(elements.reshape(-1))

    def _drop_collapsed(self, triangles: Indices, vertices: VertexData, mode: int, where: str) -> Indices:
        a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
        collapsed = (a == b) | (b == c) | (c == a)
        kept = triangles[~collapsed]
        # In strips they are how runs are joined
        if mode == 4 and collapsed.any():
            self._collapsed.append((where, int(collapsed.sum())))
        thin = zero_area(vertices.position, kept)
        if thin.any():
            self._thin.append((where, int(thin.sum())))
        return np.asarray(kept)

    def _morphs(self, targets: list[JsonObject], count: int, where: str) -> Morphs:
        doc, result = self._doc, []
        for number, target in enumerate(targets):
            place = f"{where}.targets[{number}]"
            streams: dict[str, NDArray[np.float32]] = {}
            for name in target:
                if name not in _MORPH_STREAMS:
                    doc.findings.info("gltf.morph", f"the morph attribute {name[:60]!r} is not imported", place)
                    continue
                index = doc.index(target, name, place, "accessors")
                values = None if index is None else self._accessors.floats(index)
                if values is None or values.shape != (count, 3):
                    doc.findings.error("gltf.morph", f"{name} does not fit the {count:,} vertices; left out", place)
                    continue
                bad = ~(np.abs(values) < 1e18)
                if bad.any():
                    doc.findings.error("gltf.not-finite", f"{name} holds no usable numbers; taken as 0", place)
                    values = np.where(bad, np.float32(0), values)
                streams[_MORPH_STREAMS[name]] = values
            result.append(streams)
        return result

    def _assemble(
        self, name: str, primitives: list[_Primitive], skin: Skin | None, where: str
    ) -> tuple[MeshAsset, list[Slot]]:
        """Concatenate the primitives; those of one set of attributes share their vertices."""
        parts: list[tuple[VertexData, Morphs]] = []
        bases: dict[object, int] = {}
        slots: list[Slot] = []
        runs, submeshes, total, first = [], [], 0, 0
        for primitive in primitives:
            if primitive.shared not in bases:
                bases[primitive.shared] = total
                total += len(primitive.vertices.position)
                parts.append((primitive.vertices, primitive.morphs))
            if primitive.slot not in slots:
                slots.append(primitive.slot)
            used = primitive.vertices.position[primitive.indices]
            low, high = used.min(axis=0).tolist(), used.max(axis=0).tolist()
            submeshes.append(
                Submesh(first, len(primitive.indices), slots.index(primitive.slot), primitive.topology,
                        (low[0], low[1], low[2]), (high[0], high[1], high[2]))
            )  # fmt: skip
            runs.append(primitive.indices.astype("<u4") + np.uint32(bases[primitive.shared]))
            first += len(primitive.indices)
        streams = self._streams([vertices for vertices, _ in parts], skin, where)
        skeleton: Skeleton | None = skin.skeleton if skin is not None and "joints" in streams else None
        asset = MeshAsset(name, streams, np.concatenate(runs), submeshes, skeleton, _join_morphs(parts))
        return asset, slots

    def _streams(self, parts: list[VertexData], skin: Skin | None, where: str) -> dict[str, NDArray[np.generic]]:
        """All vertices in the layout of STREAMS; what one part lacks and another has gets a neutral value."""
        columns: list[dict[str, NDArray[Any]]] = []
        for part in parts:
            assert part.normal is not None
            own: dict[str, NDArray[Any]] = {
                "position": part.position.astype("<f4"),
                "normal": snorm16_vectors(part.normal),
            }
            if part.tangent is not None:
                own["tangent"] = snorm16_vectors(part.tangent[:, :3], part.tangent[:, 3])
            for number, uv in part.uv.items():
                own[f"uv{number}"] = uv.astype("<f4")
            if part.color is not None:
                own["color"] = unorm16(part.color)
            if skin is not None and part.joints is not None and part.weights is not None:
                own |= self._influences(part.joints, part.weights, skin, where)
            columns.append(own)
        present = [stream for stream in STREAMS if any(stream in own for own in columns)]
        return {
            stream: np.concatenate(
                [own[stream] if stream in own else _neutral(stream, len(own["position"])) for own in columns]
            )
            for stream in present
        }

    def _influences(
        self, joints: NDArray[np.int64], weights: NDArray[np.float64], skin: Skin, where: str
    ) -> dict[str, NDArray[Any]]:
        findings = self._doc.findings
        outside = (joints >= len(skin.order)) & (weights != 0)
        if outside.any():
            findings.error(
                "gltf.joint-range",
                f"{int(outside.any(axis=1).sum()):,} vertices name joints beyond the skin's {len(skin.order)}; ignored",
                where, "export the skin again",
            )  # fmt: skip
        weights = np.where(joints < len(skin.order), weights, 0.0)
        joints = skin.order[np.minimum(joints, len(skin.order) - 1)]
        result = normalise_influences(joints, weights)
        if result.renormalised:
            findings.warn(
                "gltf.weights", f"{result.renormalised:,} of {len(joints):,} vertices' weights do not sum to 1; "
                "renormalised", where,
            )  # fmt: skip
        if result.without_weight:
            findings.warn("gltf.weights", f"{result.without_weight:,} vertices have no weight; bound to a joint", where)
        if result.cut:
            findings.warn("gltf.weights", f"{result.cut:,} vertices have over 8 influences; the least are cut", where)
        streams: dict[str, NDArray[Any]] = {
            "joints": np.ascontiguousarray(result.joints[:, :4]),
            "weights": np.ascontiguousarray(result.weights[:, :4]),
        }
        if result.joints.shape[1] == 8:
            streams["joints1"] = np.ascontiguousarray(result.joints[:, 4:])
            streams["weights1"] = np.ascontiguousarray(result.weights[:, 4:])
        return streams

    def _name_morphs(self, asset: MeshAsset, mesh: JsonObject, where: str) -> None:
        extras = mesh.get("extras")
        names = extras.get("targetNames") if isinstance(extras, dict) else None
        for k, morph in enumerate(asset.morphs):
            given = names[k] if isinstance(names, list) and k < len(names) else None
            morph.name = given if isinstance(given, str) else f"target_{k}"


def _neutral(stream: str, count: int) -> NDArray[Any]:
    dtype, components = STREAMS[stream]
    row = {"color": [65535] * 4, "tangent": [32767, 0, 0, 32767], "weights": [65535, 0, 0, 0]}.get(stream)
    return np.tile(np.asarray(row or [0] * components, dtype), (count, 1))


def _gather(morphs: Morphs, source: NDArray[np.int64]) -> Morphs:
    return [{name: values[source] for name, values in morph.items()} for morph in morphs]


def _join_morphs(parts: list[tuple[VertexData, Morphs]]) -> list[MorphTarget]:
    """Morph targets over all parts; a part without a target stays as it is."""
    result = []
    for k in range(max(len(morphs) for _, morphs in parts)):
        names = sorted({name for _, morphs in parts if k < len(morphs) for name in morphs[k]})
        streams = {}
        for name in names:
            columns = [
                morphs[k].get(name) if k < len(morphs) else None  # None: this part does not move
                for _, morphs in parts
            ]
            streams[name] = np.concatenate(
                [
                    np.zeros((len(vertices.position), 3), "<f4") if column is None else column.astype("<f4")
                    for column, (vertices, _) in zip(columns, parts, strict=True)
                ]
            )
        result.append(MorphTarget(f"target_{k}", streams))
    return result
