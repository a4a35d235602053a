"""The worker's task with Assimp: one file becomes the document that the host reads, in Assimp's +Y up."""

from __future__ import annotations

import ctypes as c
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import FormatError
from engine.math.transform import compose, decompose
from importers.fallback import structs
from importers.fallback.assimp_animation import read_stacks
from importers.fallback.assimp_materials import read_materials, read_textures
from importers.fallback.entries import F8, I8, Json, Output, Polygons, mesh_entry, node_entry
from importers.fallback.file_access import FileAccess
from importers.fallback.library import open_library

_MAX_DEPTH = 1000
_FACE = np.dtype([("count", "<u4"), ("_", "<u4"), ("indices", "<u8")])
_WEIGHT = np.dtype([("vertex", "<u4"), ("weight", "<f4")])
#: shapes of one mesh are numbered from a multiple of this
SHAPES = 10_000


def extract(request: Json) -> tuple[Json, dict[str, NDArray[Any]]]:
    """Read `request["path"]` by the library `request["library"]`. Raises FormatError where Assimp refuses it.

    Other keys: `crease` in radians for meshes without normals; `srgb_colors` whether vertex colours are sRGB;
    `outside` and `max_bytes` say which other files may be opened.
    """
    path = str(request["path"])
    library, version = open_library(str(request["library"]))
    access = FileAccess(Path(path), bool(request["outside"]), int(request["max_bytes"]))
    properties = library.aiCreatePropertyStore()
    # else a scene without meshes is given one that draws its nodes
    library.aiSetImportPropertyInteger(properties, b"IMPORT_NO_SKELETON_MESHES", 1)
    encoded = path.encode("utf-8", "surrogateescape")
    pointer = library.aiImportFileExWithProperties(encoded, 0, c.byref(access.io), properties)
    if not pointer or not pointer.contents.root:
        text = str(library.aiGetErrorString() or b"", "utf-8", "replace").strip()
        text = text.replace(path, Path(path).name).replace(str(Path(path).parent) + "/", "")
        raise FormatError(f"Assimp cannot read it: {text or 'it does not say why'}"[:500], hint="export it again")
    scene = pointer.contents
    out = Output()
    for name in access.refused:
        out.warn(f"{name!r} lies outside the source's folder and is not read")
    nodes = _Nodes(scene, out)
    out.data["textures"], embedded = [], read_textures(scene, out)
    out.data["materials"] = read_materials(scene, out, embedded, Path(path).suffix.lower())
    meshes, shape_owners = _meshes(scene, nodes, out, float(request["crease"]), bool(request["srgb_colors"]))
    out.data["meshes"] = meshes
    nodes.hang_lights(scene)
    nodes.hang_cameras(scene)
    out.data["stacks"] = read_stacks(scene, nodes.index, shape_owners, out, structs.quat_key_size(version))
    nodes.write()
    out.data |= header(out, f"Assimp {version[0]}.{version[1]}") | {"side_files": access.seen}
    return out.data, out.arrays


def header(out: Output, reader: str) -> Json:
    """What the document says about the file as a whole."""
    return {
        "version": 0, "ascii": False, "big_endian": False, "creator": reader, "application": "", "frame_rate": 30.0,
        "unit_meters": 1.0, "up_axis": "+y", "default_camera": "", "cache_files": [], "left_out": [],
        "side_files": {}, "warnings": [[text, count] for text, count in out.warnings.items()],
    }  # fmt: skip


class _Nodes:
    """All nodes, parents first, behind a root of ours; Assimp's own root stays where it says something."""

    def __init__(self, scene: structs.Scene, out: Output) -> None:
        self._out = out
        self.entries: list[Json] = [node_entry("", -1, root=True)]
        self.matrices: list[F8] = [np.eye(4)]
        self.meshes: list[tuple[int, ...]] = [()]
        self.index: dict[str, int] = {}
        self.lights: list[Json] = []
        self.cameras: list[Json] = []
        stack: list[tuple[Any, int, int]] = [(scene.root, 0, 0)]
        while stack:
            pointer, parent, depth = stack.pop()
            if depth > _MAX_DEPTH:
                raise FormatError(f"nodes are nested deeper than {_MAX_DEPTH}")
            node = pointer.contents
            matrix = np.array(node.matrix, np.float64).reshape(4, 4)
            held = tuple(int(node.meshes[i]) for i in range(node.mesh_count))
            row = parent
            plain = depth == 0 and np.array_equal(matrix, np.eye(4)) and not held
            if not plain:
                row = len(self.entries)
                self._add(node.name.text(), parent, matrix, held)
            self.index.setdefault(node.name.text(), row)
            stack.extend((node.children[i], row, depth + 1) for i in reversed(range(node.child_count)))

    def _add(self, name: str, parent: int, matrix: F8, meshes: tuple[int, ...] = ()) -> int:
        self.entries.append(node_entry(name, parent))
        self.matrices.append(matrix)
        self.meshes.append(meshes)
        return len(self.entries) - 1

    def hang_lights(self, scene: structs.Scene) -> None:
        kinds = {1: "directional", 2: "point", 3: "spot"}
        for i in range(scene.light_count):
            light = scene.lights[i].contents
            kind = kinds.get(int(light.type))
            owner = self.index.get(light.name.text())
            if kind is None or owner is None:
                self._out.warn("a light that is ambient, of an area, or without a node is left out")
                continue
            color = np.nan_to_num(np.array([light.diffuse.x, light.diffuse.y, light.diffuse.z], np.float64))
            strength = float(color.max(initial=0.0)) or 1.0
            decay = "quadratic" if light.quadratic > 0 else "linear" if light.linear > 0 else "none"
            position, direction = _vector(light.position), _vector(light.direction)
            row = self._child(owner, f"{light.name.text()}.light", position, direction, _vector(light.up))
            self.entries[row]["light"] = len(self.lights)
            self.lights.append(
                {
                    "name": light.name.text(),
                    "type": kind,
                    "decay": decay,
                    "color": (color / strength).tolist(),
                    "intensity": strength,
                    "inner_angle": float(np.degrees(light.inner)),
                    "outer_angle": float(np.degrees(light.outer)),
                    "on": True,
                }
            )  # fmt: skip

    def hang_cameras(self, scene: structs.Scene) -> None:
        for i in range(scene.camera_count):
            camera = scene.cameras[i].contents
            owner = self.index.get(camera.name.text())
            if owner is None:
                self._out.warn("a camera without a node is left out")
                continue
            aspect = float(camera.aspect) if np.isfinite(camera.aspect) and camera.aspect > 0 else 0.0
            across = float(np.clip(camera.fov, 0.01, 3.1)) if np.isfinite(camera.fov) else 0.8
            up = 2.0 * np.arctan(np.tan(across / 2.0) / aspect) if aspect else across
            position, look = _vector(camera.position), _vector(camera.look)
            row = self._child(owner, f"{camera.name.text()}.camera", position, look, _vector(camera.up))
            self.entries[row]["camera"] = len(self.cameras)
            wide = float(camera.ortho_width)
            self.cameras.append(
                {
                    "name": camera.name.text(),
                    "orthographic": wide > 0.0,
                    "size": [2 * wide, 2 * wide],
                    "fov_deg": [float(np.degrees(across)), float(np.degrees(up))],
                    "aspect": aspect,
                    "near": float(camera.near),
                    "far": float(camera.far),
                }
            )  # fmt: skip

    def _child(self, owner: int, name: str, position: F8, direction: F8, up: F8) -> int:
        """The node itself where it may hold the thing and looks along -Z, else a child of it that does."""
        entry = self.entries[owner]
        length = float(np.linalg.norm(direction))
        ahead = direction / length if length > 1e-9 else np.array([0.0, 0.0, -1.0])
        free = entry["light"] < 0 and entry["camera"] < 0 and entry["mesh"] < 0 and not entry["root"]
        if free and not position.any() and ahead[2] < -1.0 + 1e-9:
            return owner
        side = np.cross(ahead, up)
        if np.linalg.norm(side) < 1e-9:
            side = np.cross(ahead, [0.0, 1.0, 0.0] if abs(ahead[1]) < 0.9 else [1.0, 0.0, 0.0])
        side /= np.linalg.norm(side)
        matrix = np.eye(4)
        matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = side, np.cross(side, ahead), -ahead
        matrix[:3, 3] = position
        return self._add(name, owner, matrix)

    def write(self) -> None:
        matrices = np.array(self.matrices)
        bad = ~np.isfinite(matrices).all(axis=(1, 2))
        if bad.any():
            self._out.warn("a node's matrix is no number; taken as the identity")
            matrices[bad] = np.eye(4)
        translation, rotation, scale = decompose(matrices)
        off = np.abs(compose(translation, rotation, scale) - matrices).max(axis=(1, 2))
        if (off > 1e-4 * np.maximum(np.abs(matrices).max(axis=(1, 2)), 1.0)).any():
            self._out.warn("a node's matrix has shear, which is left out")
        data, put = self._out.data, self._out.put
        data["nodes"], data["lights"], data["cameras"] = self.entries, self.lights, self.cameras
        data["translation"], data["rotation"], data["scale"] = put(translation), put(rotation), put(scale)
        data["node_from_geometry"] = put(np.tile(np.eye(4)[:3], (len(matrices), 1, 1)))


def _meshes(
    scene: structs.Scene, nodes: _Nodes, out: Output, crease: float, srgb: bool
) -> tuple[list[Json], dict[str, list[int]]]:
    """One mesh for each set of Assimp's that hangs on a node; and by mesh or node name, the elements of its shapes."""
    known: dict[tuple[int, ...], int] = {}
    entries: list[Json] = []
    owners: dict[str, list[int]] = {}
    for row, held in enumerate(nodes.meshes):
        good = tuple(i for i in held if i < scene.mesh_count)
        if not good:
            continue
        if good not in known:
            name = scene.meshes[good[0]].contents.name.text() or nodes.entries[row]["name"]
            polygons = [_polygons(scene.meshes[i].contents, nodes, out, srgb) for i in good]
            joined = _joined(polygons, [int(scene.meshes[i].contents.material) for i in good], name, crease, out)
            known[good] = len(entries)
            element = SHAPES * (1 + len(entries))
            entries.append(mesh_entry(joined, out, element))
            elements = [element + k for k in range(len(joined.shapes))]
            for key in (name, *(scene.meshes[i].contents.name.text() for i in good)):
                owners.setdefault(key, elements)
        nodes.entries[row]["mesh"] = known[good]
        nodes.entries[row]["kind"] = "mesh"
        shapes = len(entries[known[good]]["channels"])
        owners.setdefault(nodes.entries[row]["name"], [SHAPES * (1 + known[good]) + k for k in range(shapes)])
    return entries, owners


def _polygons(mesh: structs.Mesh, nodes: _Nodes, out: Output, srgb: bool) -> Polygons:
    """One of Assimp's meshes; its material is number 0."""
    count = int(mesh.vertex_count)
    faces = _structs(mesh.faces, mesh.face_count, _FACE)
    sizes = faces["count"].astype(np.int64)
    read = c.string_at
    parts = [read(address, size * 4) for address, size in zip(faces["indices"].tolist(), sizes.tolist(), strict=True)]
    corner = np.frombuffer(b"".join(parts), "<u4").astype(np.int64)
    position = _floats(mesh.positions, count, 3)
    assert position is not None
    colors = _floats(mesh.colors[0], count, 4)
    if colors is not None and srgb:
        from engine.math.color import srgb_to_linear

        colors[:, :3] = srgb_to_linear(np.clip(np.nan_to_num(colors[:, :3]), 0.0, 1.0))
    uvs = [_floats(mesh.uvs[k], count, 3) for k in range(8)]
    result = Polygons(
        mesh.name.text(), position, corner, sizes, np.zeros(len(sizes), np.int64), [0],
        _floats(mesh.normals, count, 3), colors, [uv[:, :2] for uv in uvs if uv is not None],
    )  # fmt: skip
    for i in range(mesh.bone_count):
        bone = mesh.bones[i].contents
        node = nodes.index.get(bone.name.text())
        if node is None or nodes.entries[node]["root"]:
            out.warn("a bone without a node is left out")
            continue
        weights = _structs(bone.weights, bone.weight_count, _WEIGHT)
        matrix = np.array(bone.offset, np.float64).reshape(4, 4)[:3]
        result.bones.append((node, matrix, weights["vertex"].astype(np.int64), weights["weight"].astype(np.float64)))
    for i in range(mesh.anim_mesh_count):
        shape = mesh.anim_meshes[i].contents
        moved = _floats(shape.positions, min(int(shape.vertex_count), count), 3)
        if moved is None or len(moved) < count:
            out.warn("a morph target does not fit its mesh; left out")
            continue
        weight = float(shape.weight) if np.isfinite(shape.weight) else 0.0
        result.shapes.append((shape.name.text() or f"shape_{i}", moved - position, weight))
    return result


def _joined(parts: list[Polygons], materials: list[int], name: str, crease: float, out: Output) -> Polygons:
    """The meshes of one node as one, each with a material of its own."""
    base = np.cumsum([0, *(len(p.position) for p in parts)])
    slots = sorted(set(materials))
    uv_sets = max(len(p.uvs) for p in parts)

    def stacked(values: list[F8 | None], fill: list[float]) -> F8 | None:
        if all(v is None for v in values):
            return None
        blocks = [np.tile(fill, (len(p.position), 1)) if v is None else v for v, p in zip(values, parts, strict=True)]
        return np.concatenate(blocks)

    uvs = [stacked([p.uvs[k] if k < len(p.uvs) else None for p in parts], [0.0, 0.0]) for k in range(uv_sets)]
    result = Polygons(
        name,
        np.concatenate([p.position for p in parts]),
        np.concatenate([p.corner + b for p, b in zip(parts, base, strict=False)]),
        np.concatenate([p.count for p in parts]),
        np.concatenate(
            [np.full(len(p.count), slots.index(m), np.int64) for p, m in zip(parts, materials, strict=True)]
        ),
        slots,
        stacked([p.normal for p in parts], [0.0, 0.0, 0.0]),
        stacked([p.color for p in parts], [1.0, 1.0, 1.0, 1.0]),
        [uv for uv in uvs if uv is not None],
        crease=crease,
    )
    bones: dict[int, tuple[F8, list[I8], list[F8]]] = {}
    for part, first in zip(parts, base.tolist(), strict=False):
        for node, matrix, rows, weights in part.bones:
            held = bones.setdefault(node, (matrix, [], []))
            if np.abs(held[0] - matrix).max() > 1e-4 * max(float(np.abs(matrix).max()), 1.0):
                out.warn("parts of a mesh bind a bone differently; the first counts")
            held[1].append(rows + first)
            held[2].append(weights)
    result.bones = [(node, m, np.concatenate(r), np.concatenate(w)) for node, (m, r, w) in bones.items()]
    names = dict.fromkeys(shape[0] for part in parts for shape in part.shapes)
    for shape_name in names:
        blocks, weight = [], 0.0
        for part in parts:
            found = next((s for s in part.shapes if s[0] == shape_name), None)
            blocks.append(np.zeros_like(part.position) if found is None else found[1])
            weight = weight if found is None else found[2]
        result.shapes.append((shape_name, np.concatenate(blocks), weight))
    return result


def _structs(address: int | None, count: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    if not address or not count:
        return np.zeros(0, dtype)
    return np.frombuffer(c.string_at(address, int(count) * dtype.itemsize), dtype)


def _floats(address: int | None, count: int, components: int) -> F8 | None:
    """A copy f8[count, components] of packed floats; None where the pointer is null."""
    if not address:
        return np.zeros((count, components)) if not count else None
    data = c.string_at(address, count * components * 4)
    return np.frombuffer(data, "<f4").reshape(count, components).astype(np.float64)


def _vector(v: structs.Vector3) -> F8:
    return np.nan_to_num(np.array([v.x, v.y, v.z], np.float64))
