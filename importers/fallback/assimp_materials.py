"""Materials in the worker: Assimp's properties by their keys, as the maps that the host knows."""

from __future__ import annotations

import ctypes as c
import io
import struct
from typing import Any

import numpy as np

from importers.fallback import structs
from importers.fallback.entries import Json, Output, map_entry, rough_from_exponent, texture_entry

#: our map -> Assimp's texture types in the order tried (material.h, aiTextureType)
_MAPS = {
    "base_color": (12, 1), "normal_map": (6, 13), "bump": (5,), "emission_color": (14, 4), "opacity": (8,),
    "metalness": (15,), "roughness": (16,), "ambient_occlusion": (17, 10),
}  # fmt: skip
_NAMES = {2: "specular", 3: "ambient", 7: "shininess", 9: "displacement", 11: "reflection", 18: "unknown",
          19: "sheen", 20: "clearcoat", 21: "transmission"}  # fmt: skip
_Key = tuple[str, int, int]


def read_textures(scene: structs.Scene, out: Output) -> dict[str, tuple[str, str]]:
    """Embedded textures: by `*0` and by their names, (title, name of the array with an image file's bytes)."""
    found: dict[str, tuple[str, str]] = {}
    for i in range(scene.texture_count):
        texture = scene.textures[i].contents
        if not texture.data:
            continue
        if texture.height == 0:
            data = c.string_at(texture.data, int(texture.width))
        else:
            data = _png(texture)
        title = texture.name.text().replace("\\", "/").rpartition("/")[2].rpartition(".")[0] or f"texture_{i}"
        stored = out.put(np.frombuffer(data, np.uint8))
        found[f"*{i}"] = (title, stored)
        if texture.name.length:
            found.setdefault(texture.name.text(), (title, stored))
    return found


def _png(texture: structs.Texture) -> bytes:
    """An uncompressed texture of BGRA texels as a PNG file."""
    from PIL import Image

    width, height = int(texture.width), int(texture.height)
    if width * height > 1 << 28:
        raise MemoryError
    texels = np.frombuffer(c.string_at(texture.data, width * height * 4), np.uint8).reshape(height, width, 4)
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(texels[..., [2, 1, 0, 3]])).save(file, "PNG", compress_level=1)
    return file.getvalue()


def read_materials(scene: structs.Scene, out: Output, embedded: dict[str, tuple[str, str]], suffix: str) -> list[Json]:
    return [_material(scene.materials[i].contents, i, out, embedded, suffix) for i in range(scene.material_count)]


def _material(
    material: structs.Material, number: int, out: Output, embedded: dict[str, tuple[str, str]], suffix: str
) -> Json:
    values = _properties(material)
    name = str(values.get(("?mat.name", 0, 0), "")) or f"material_{number}"
    textures = {}
    for key in _MAPS:
        for semantic in _MAPS[key]:
            if ("$tex.file", semantic, 0) in values:
                textures[key] = _texture(values, semantic, out, embedded)
                break
    used = {semantic for semantics in _MAPS.values() for semantic in semantics}
    for (key, semantic, _), file in values.items():
        if key == "$tex.file" and semantic not in used and str(file):
            out.warn(f"material {name!r}: its {_NAMES.get(semantic, 'further')} texture is not shown")
        elif key == "$tex.file" and (semantic, 0) != (semantic, _):
            out.warn(f"material {name!r}: of several textures for one purpose only the first is shown")
    pbr: Json = {}
    fbx: Json = {}
    base = _color(values, "$clr.base") or _color(values, "$clr.diffuse") or (0.8, 0.8, 0.8)
    black = max(base[:3]) <= 0.0
    texture = textures.get("base_color", -1)
    pbr["base_color"] = map_entry((1.0, 1.0, 1.0) if texture >= 0 and black else base[:3], texture)
    shine, strength = _number(values, "$mat.shininess"), _number(values, "$mat.shinpercent")
    shiny = max(_color(values, "$clr.specular") or (0.0,)) * (1.0 if strength is None else strength)
    rough = 1.0
    if _number(values, "$mat.roughnessFactor") is not None:
        rough = float(_number(values, "$mat.roughnessFactor") or 0.0)
    elif shine is not None and shine > 0.0 and shiny > 0.0:
        rough = rough_from_exponent(shine)
    pbr["roughness"] = map_entry((rough,), textures.get("roughness", -1))
    pbr["metalness"] = map_entry((_number(values, "$mat.metallicFactor") or 0.0,), textures.get("metalness", -1))
    glow = _color(values, "$clr.emissive")
    if glow is not None or "emission_color" in textures:
        pbr["emission_color"] = map_entry((glow or (0.0, 0.0, 0.0))[:3], textures.get("emission_color", -1))
    opacity = _number(values, "$mat.opacity")
    if "opacity" in textures or (opacity is not None and opacity < 1.0):
        pbr["opacity"] = map_entry((1.0 if opacity is None else opacity,), textures.get("opacity", -1))
    for key in ("normal_map", "ambient_occlusion"):
        if key in textures:
            pbr[key] = map_entry(None, textures[key])
    if "bump" in textures:
        fbx["bump"] = map_entry(None, textures["bump"])
    ior = _number(values, "$mat.refracti")
    if ior is not None and 1.05 <= ior <= 4.0:
        pbr["specular_ior"] = map_entry((ior,))
    features = ["double_sided"] if values.get(("$mat.twosided", 0, 0)) else []
    # only Wavefront says that colour and texture are multiplied, and its exporters keep to it
    features += ["texture_times_color"] if suffix == ".obj" else []
    return {
        "name": name, "shader": "wavefront_mtl", "model": "", "fbx": fbx, "pbr": pbr, "features": features,
    }  # fmt: skip


def _texture(values: dict[_Key, Any], semantic: int, out: Output, embedded: dict[str, tuple[str, str]]) -> int:
    """The number of the texture in the document, equal ones once."""
    file = str(values[("$tex.file", semantic, 0)])
    title, content = embedded.get(file, ("", ""))
    name = title or file.replace("\\", "/").rpartition("/")[2].rpartition(".")[0]
    uv_set = int(values.get(("$tex.uvwsrc", semantic, 0), 0) or 0)
    entry = texture_entry(name, "" if content else file, content, uv_set=uv_set)
    entry["clamp"] = [int(values.get((f"$tex.mapmode{axis}", semantic, 0), 0) or 0) in (1, 3) for axis in "uv"]
    transform = values.get(("$tex.uvtrafo", semantic, 0))
    if isinstance(transform, tuple) and len(transform) == 5 and np.isfinite(transform).all():
        entry["matrix"] = _matrix(*transform)
    listed: list[Json] = out.data["textures"]
    if entry not in listed:
        listed.append(entry)
    return listed.index(entry)


def _matrix(x: float, y: float, sx: float, sy: float, angle: float) -> list[list[float]] | None:
    """2x3 on uv with the origin at the bottom left: scaled, turned counter-clockwise about the middle, moved."""
    if (x, y, sx, sy, angle) == (0.0, 0.0, 1.0, 1.0, 0.0):
        return None
    cos, sin = float(np.cos(angle)), float(np.sin(angle))
    return [
        [cos * sx, -sin * sy, 0.5 - 0.5 * cos + 0.5 * sin + x],
        [sin * sx, cos * sy, 0.5 - 0.5 * sin - 0.5 * cos + y],
    ]


def _properties(material: structs.Material) -> dict[_Key, Any]:
    found: dict[_Key, Any] = {}
    for i in range(material.count):
        entry = material.properties[i].contents
        data = c.string_at(entry.data, int(entry.size)) if entry.data and entry.size < 1 << 20 else b""
        key = (entry.key.text(), int(entry.semantic), int(entry.index))
        found.setdefault(key, _value(data, int(entry.type)))
    return found


def _value(data: bytes, kind: int) -> Any:
    """kind as aiPropertyTypeInfo: 1 float, 2 double, 3 string, 4 int, 5 bytes."""
    if kind == 3:
        length = struct.unpack_from("<I", data)[0] if len(data) >= 4 else 0
        return data[4 : 4 + length].decode("utf-8", "replace")
    code, size = {1: ("f", 4), 2: ("d", 8), 4: ("i", 4)}.get(kind, ("", 0))
    if not size:
        return data[:1] != b"\0" if data else False
    numbers = struct.unpack(f"<{len(data) // size}{code}", data[: len(data) // size * size])
    return numbers[0] if len(numbers) == 1 else numbers


def _number(values: dict[_Key, Any], key: str) -> float | None:
    value = values.get((key, 0, 0))
    if isinstance(value, tuple):
        value = value[0] if value else None
    return float(value) if isinstance(value, int | float) and np.isfinite(value) else None


def _color(values: dict[_Key, Any], key: str) -> tuple[float, ...] | None:
    value = values.get((key, 0, 0))
    if not isinstance(value, tuple) or len(value) < 3 or not np.isfinite(value).all():
        return None
    return tuple(float(v) for v in value)
