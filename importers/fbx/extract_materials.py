"""Materials and textures in the worker: every map that ufbx knows, as value and texture, by ufbx's own names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import ufbx

from importers.fbx.native import Handle

if TYPE_CHECKING:
    from importers.fbx.extract import Output


def read_textures(scene: Handle, out: Output) -> list[dict[str, Any]]:
    return [_texture(texture, out) for texture in scene.textures]


def read_cache_files(scene: Handle) -> list[list[str]]:
    """The names of the point caches that the scene refers to."""
    return [[cache.relative_filename, cache.absolute_filename] for cache in scene.cache_files]


def read_materials(scene: Handle) -> list[dict[str, Any]]:
    return [_material(material) for material in scene.materials]


def _texture(texture: Handle, out: Output) -> dict[str, Any]:
    matrix = texture.uv_to_texture
    described: dict[str, Any] = {
        "name": texture.name,
        "type": ufbx.TextureType(int(texture.type)).name.lower(),
        # as they stand in the file; ufbx's own `filename` depends on where the file lies
        "files": [texture.relative_filename, texture.absolute_filename],
        "layers": [int(layer.typed_id) for layer in texture.file_textures],
        "uv_set": texture.uv_set,
        "clamp": [int(texture.wrap_u) == 1, int(texture.wrap_v) == 1],
        # 2x3 affine, on uv with the origin at the bottom left
        "matrix": [[_finite(matrix[c][r]) for c in (0, 1, 3)] for r in (0, 1)] if texture.has_uv_transform else None,
        "content": "",
    }
    data = texture.content or (texture.video.content if texture.video is not None else b"")
    if data:
        described["content"] = out.put(np.frombuffer(data, np.uint8))
    return described


def _material(material: Handle) -> dict[str, Any]:
    return {
        "name": material.name,
        "shader": ufbx.ShaderType(int(material.shader_type)).name.lower(),
        "model": material.shading_model_name,
        "fbx": _maps(material.fbx, ufbx.MaterialFbxMap),
        "pbr": _maps(material.pbr, ufbx.MaterialPbrMap),
        "features": [
            feature.name.lower()
            for feature in ufbx.MaterialFeature
            if getattr(material.features, feature.name.lower()).enabled
        ],
    }


def _maps(maps: Handle, names: Any) -> dict[str, Any]:
    """Only those that are set: {"value": [x, y, z, w], "texture": index or -1}."""
    found = {}
    for name in (member.name.lower() for member in names):
        entry = getattr(maps, name)
        texture = entry.texture
        if entry.has_value or texture is not None:
            found[name] = {
                "value": [_finite(v) for v in entry.value_vec4],
                "has_value": entry.has_value,
                "components": int(entry.value_components),
                "texture": int(texture.typed_id) if texture is not None and entry.texture_enabled else -1,
            }
    return found


def _finite(value: float) -> float:
    return float(value) if np.isfinite(value) else 0.0
