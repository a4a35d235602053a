"""Geometry in the worker: polygons to triangles, and per mesh the attributes, skin clusters and blend shapes as arrays.

A corner is one vertex of one polygon; attributes are stored as values and, per corner, an index into them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import ufbx

from importers.fbx.native import Handle, array
from importers.geometry.triangulate import triangulate

if TYPE_CHECKING:
    from importers.fbx.extract import Output


def read_mesh(mesh: Handle, out: Output) -> dict[str, Any]:
    """The description of a mesh; arrays are named in it."""
    positions = array(mesh.vertices, np.float64, 3)
    corner_vertex = array(mesh.vertex_indices, np.uint32)
    faces = array(mesh.faces, np.uint32, 2).astype(np.int64)
    holes = array(mesh.face_hole, np.bool_)
    usable = faces[:, 1] >= 3
    if len(holes) == len(faces):
        usable &= ~holes
    safe = np.minimum(corner_vertex, max(len(positions) - 1, 0))
    kept = faces[usable]
    corners = positions[safe] if len(positions) else np.zeros((len(safe), 3))
    triangles, face = triangulate(corners, kept[:, 0], kept[:, 1])
    materials = array(mesh.face_material, np.uint32)
    numbers = np.flatnonzero(usable)[face]
    described: dict[str, Any] = {
        "name": mesh.name,
        "positions": out.put(positions),
        "corner_vertex": out.put(corner_vertex),
        "triangles": out.put(triangles.astype(np.uint32)),
        "triangle_material": out.put(
            materials[numbers] if len(materials) == len(faces) else np.zeros(len(numbers), np.uint32)
        ),
        "materials": [int(m.typed_id) if m is not None else -1 for m in mesh.materials],
        "polygons": len(faces),
        "lines": int((faces[:, 1] == 2).sum()),
        "points": int((faces[:, 1] == 1).sum()),
        "holes": int(holes.sum()) if len(holes) == len(faces) else 0,
        "subdivision": bool(int(mesh.subdivision_display_mode) != 0),
        "generated_normals": mesh.generated_normals,
        "normal": _attribute(mesh.vertex_normal, 3, out),
        "color": _attribute(mesh.vertex_color, 4, out),
        "uv_sets": [
            {
                "name": uv.name,
                "uv": _attribute(uv.vertex_uv, 2, out),
                "tangent": _attribute(uv.vertex_tangent, 3, out),
                "bitangent": _attribute(uv.vertex_bitangent, 3, out),
            }
            for uv in mesh.uv_sets
        ],
        "color_sets": len(mesh.color_sets),
        "skins": [_skin(skin, out) for skin in mesh.skin_deformers],
        "channels": [_channel(channel, out) for blend in mesh.blend_deformers for channel in blend.channels],
        "caches": [_cache(cache) for cache in mesh.cache_deformers],
    }
    return described


def _attribute(attribute: Handle, components: int, out: Output) -> dict[str, str] | None:
    if not attribute.exists:
        return None
    return {
        "values": out.put(array(attribute.values, np.float64, components)),
        "indices": out.put(array(attribute.indices, np.uint32)),
    }


def _skin(skin: Handle, out: Output) -> dict[str, Any]:
    clusters = [c for c in skin.clusters if c.bone_node is not None]
    counts = [len(c.vertices) for c in clusters]
    matrices = np.array([c.geometry_to_bone for c in clusters], np.float64).reshape(-1, 4, 3)
    method = ufbx.SkinningMethod(int(skin.skinning_method)).name.lower()
    return {
        "name": skin.name,
        "method": method,
        "bones": [int(c.bone_node.typed_id) for c in clusters],
        "bone_from_geometry": out.put(matrices.transpose(0, 2, 1)),
        # where the geometry stood when it was bound, by the first cluster
        "world_from_geometry": _bind(clusters[0]) if clusters else None,
        "counts": counts,
        "vertices": out.put(_joined([array(c.vertices, np.uint32) for c in clusters], np.uint32)),
        "weights": out.put(_joined([array(c.weights, np.float64) for c in clusters], np.float64)),
        "dq_vertices": out.put(array(skin.dq_vertices, np.uint32)),
        "dq_weights": out.put(array(skin.dq_weights, np.float64)),
    }


def _bind(cluster: Handle) -> list[list[float]]:
    """3x4, row by row."""
    world, local = np.eye(4), np.eye(4)
    world[:3] = np.array(cluster.bind_to_world, np.float64).T
    local[:3] = np.array(cluster.geometry_to_bone, np.float64).T
    with np.errstate(over="ignore", invalid="ignore"):
        matrix = np.nan_to_num(world @ local, posinf=0.0, neginf=0.0)
    rows: list[list[float]] = matrix[:3].tolist()
    return rows


def _channel(channel: Handle, out: Output) -> dict[str, Any]:
    return {
        "name": channel.name,
        "element": int(channel.element_id),
        "weight": float(channel.weight) if np.isfinite(channel.weight) else 0.0,
        "keys": [
            {
                "name": key.shape.name,
                "target": float(key.target_weight),
                "vertices": out.put(array(key.shape.offset_vertices, np.uint32)),
                "positions": out.put(array(key.shape.position_offsets, np.float64, 3)),
                "normals": out.put(array(key.shape.normal_offsets, np.float64, 3)),
                "weights": out.put(array(key.shape.offset_weights, np.float64)),
            }
            for key in channel.keyframes
        ],
    }


def _cache(cache: Handle) -> dict[str, Any]:
    file = cache.file
    return {
        "channel": cache.channel,
        "files": [] if file is None else [file.relative_filename, file.absolute_filename],
    }


def _joined(parts: list[Any], dtype: Any) -> Any:
    return np.concatenate(parts) if parts else np.zeros(0, dtype)
