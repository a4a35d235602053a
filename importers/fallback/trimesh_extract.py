"""The worker's task with trimesh: one file becomes the document that the host reads, axes and units as in the file."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from engine.core.errors import FormatError
from engine.math.color import srgb_to_linear
from engine.math.transform import decompose
from importers.fallback.assimp_extract import header
from importers.fallback.entries import (
    F8,
    Json,
    Output,
    Polygons,
    map_entry,
    mesh_entry,
    node_entry,
    rough_from_exponent,
    texture_entry,
)


def extract(request: Json) -> tuple[Json, dict[str, NDArray[Any]]]:
    """Read `request["path"]`; `crease` in radians for meshes without normals. Raises FormatError where trimesh
    cannot."""
    path = Path(str(request["path"]))
    try:
        # nothing merged, nothing sorted: the host does that alike for all formats
        scene = trimesh.load_scene(path, process=False, maintain_order=True, skip_materials=False)
    except MemoryError:
        raise
    except Exception as error:  # a foreign parser raises what it likes; the worker ends here
        reason = f"{type(error).__name__}: {error}".replace(str(path), path.name)
        raise FormatError(f"trimesh cannot read it ({reason[:300]})", hint="export it again") from error
    out = Output()
    out.data["textures"], out.data["materials"] = [], []
    reader = _Reader(out, float(request["crease"]))
    entries, matrices = [node_entry("", -1, root=True)], [np.eye(4)]
    numbers: dict[str, int] = {}
    meshes: list[Json] = []
    for name in sorted(scene.graph.nodes_geometry):
        matrix, geometry_name = scene.graph[name]
        geometry = scene.geometry[geometry_name]
        if geometry_name not in numbers:
            if not isinstance(geometry, trimesh.Trimesh):
                kind = "a cloud of points" if isinstance(geometry, trimesh.PointCloud) else "lines"
                out.warn(f"{geometry_name!r} is {kind}: not imported")
                continue
            numbers[geometry_name] = len(meshes)
            meshes.append(reader.mesh(geometry, str(geometry_name)))
        entries.append(node_entry(str(name), 0, numbers[geometry_name]))
        matrices.append(np.asarray(matrix, np.float64))
    translation, rotation, scale = decompose(np.nan_to_num(np.array(matrices)))
    out.data |= {
        "nodes": entries, "meshes": meshes, "lights": [], "cameras": [], "stacks": [],
        "translation": out.put(translation), "rotation": out.put(rotation), "scale": out.put(scale),
        "node_from_geometry": out.put(np.tile(np.eye(4)[:3], (len(entries), 1, 1))),
    }  # fmt: skip
    out.data |= header(out, f"trimesh {trimesh.__version__}")
    return out.data, out.arrays


class _Reader:
    """Meshes and their materials, each material once."""

    def __init__(self, out: Output, crease: float) -> None:
        self._out = out
        self._crease = crease
        self._materials: dict[int, int] = {}
        self._kept: list[Any] = []

    def mesh(self, mesh: trimesh.Trimesh, name: str) -> Json:
        faces = np.asarray(mesh.faces, np.int64).reshape(-1, 3)
        normals = mesh.vertex_normals if "vertex_normals" in mesh._cache else None
        visual = mesh.visual
        color: F8 | None = None
        uvs: list[F8] = []
        material = -1
        if visual is not None and visual.kind == "texture":
            uv = visual.uv
            if uv is not None and len(uv) == len(mesh.vertices):
                uvs.append(np.asarray(uv, np.float64)[:, :2])
            material = self._material(visual.material)
        elif visual is not None and visual.kind == "vertex":
            color = np.asarray(visual.vertex_colors, np.float64) / 255.0
            color[:, :3] = srgb_to_linear(color[:, :3])
        elif visual is not None and visual.kind == "face":
            self._out.warn(f"{name!r}: the colours of faces are not imported")
        polygons = Polygons(
            name, np.asarray(mesh.vertices, np.float64), faces.reshape(-1), np.full(len(faces), 3, np.int64),
            np.zeros(len(faces), np.int64), [material],
            None if normals is None else np.asarray(normals, np.float64), color, uvs, crease=self._crease,
        )  # fmt: skip
        return mesh_entry(polygons, self._out, 0)

    def _material(self, material: Any) -> int:
        if material is None:
            return -1
        if id(material) not in self._materials:
            self._materials[id(material)] = len(self._out.data["materials"])
            self._kept.append(material)
            self._out.data["materials"].append(self._entry(material))
        return self._materials[id(material)]

    def _entry(self, material: Any) -> Json:
        name = str(getattr(material, "name", "") or f"material_{len(self._out.data['materials'])}")
        diffuse = np.asarray(getattr(material, "main_color", (204, 204, 204, 255)), np.float64) / 255.0
        # the lines of an MTL that trimesh itself makes nothing of
        lines = getattr(material, "kwargs", {})
        gloss = float(getattr(material, "glossiness", 0.0) or 0.0)
        pbr = {
            "base_color": map_entry(
                tuple(_numbers(lines.get("kd")) or diffuse[:3]),
                self._texture(name, getattr(material, "image", None), lines.get("map_kd")),
            ),
            "roughness": map_entry((rough_from_exponent(gloss) if gloss > 1.0 else 1.0,)),
            "metalness": map_entry((0.0,)),
        }
        alpha = (_numbers(lines.get("d")) or [float(diffuse[3])])[0]
        mask = self._texture(name, None, lines.get("map_d"))
        if alpha < 1.0 or mask >= 0:
            pbr["opacity"] = map_entry((alpha,), mask)
        glow = _numbers(lines.get("ke"))
        glow_map = self._texture(name, None, lines.get("map_ke"))
        if glow or glow_map >= 0:
            pbr["emission_color"] = map_entry(tuple(glow or (0.0, 0.0, 0.0)), glow_map)
        normal = self._texture(name, None, lines.get("norm"))
        if normal >= 0:
            pbr["normal_map"] = map_entry(None, normal)
        bump = self._texture(name, None, lines.get("map_bump") or lines.get("bump"))
        fbx = {"bump": map_entry(None, bump)} if bump >= 0 else {}
        features = ["texture_times_color"] if lines else []
        return {"name": name, "shader": "wavefront_mtl", "model": "", "fbx": fbx, "pbr": pbr, "features": features}

    def _texture(self, name: str, image: Any, words: Any = None) -> int:
        """The number of a texture: a decoded image, or the words of an MTL's line, whose last is a file's name."""
        file, content = "", ""
        if words:
            file = str(words[-1] if isinstance(words, list) else words)
        elif image is not None:
            info = getattr(image, "info", {})
            file = Path(str(info.get("file_path") or getattr(image, "filename", "") or "")).name
            if not file and max(image.size) <= 2:
                return -1  # trimesh's own stand-in
            if not file:
                data = io.BytesIO()
                image.save(data, "PNG", compress_level=1)
                content = self._out.put(np.frombuffer(data.getvalue(), np.uint8))
        if not file and not content:
            return -1
        entry = texture_entry(Path(file.replace("\\", "/")).stem or name, file, content)
        listed: list[Json] = self._out.data["textures"]
        if entry not in listed:
            listed.append(entry)
        return listed.index(entry)


def _numbers(words: Any) -> list[float]:
    """Of a line's words; empty where they are none."""
    try:
        return [float(word) for word in words or []]
    except (TypeError, ValueError):
        return []
