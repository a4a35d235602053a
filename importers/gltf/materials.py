"""Materials: glTF's metallic-roughness model and its common extensions become the `surface` effect's parameters.

Source: glTF 2.0 specification (Khronos, 2021), section 3.9; KHR_texture_transform, KHR_materials_unlit,
KHR_materials_emissive_strength, KHR_materials_ior, KHR_materials_specular, KHR_materials_pbrSpecularGlossiness
(Khronos, 2017 to 2022).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from engine.assets.material import MaterialAsset, TextureRef
from importers.gltf.document import Document, JsonObject
from importers.gltf.uris import storable_text
from importers.model import ImportedMaterial, TextureUse

_WRAPS = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
_MAG = {9728: "nearest", 9729: "linear"}
_MIN = {
    9728: "nearest", 9729: "linear", 9984: "nearest_mip_nearest", 9985: "linear_mip_nearest",
    9986: "nearest_mip_linear", 9987: "linear_mip_linear",
}  # fmt: skip
_QUEUES = {"OPAQUE": "opaque", "MASK": "alpha_test", "BLEND": "transparent"}
_SHOWN = {
    "KHR_materials_unlit", "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_ior", "KHR_materials_specular",
}  # fmt: skip
#: image formats that a texture may name by an extension, and whether they can be decoded
_SOURCES = {"EXT_texture_webp": True, "KHR_texture_basisu": False, "MSFT_texture_dds": False, "EXT_texture_avif": False}


def read_material(doc: Document, index: int) -> ImportedMaterial:
    """Material `index` for the `surface` effect. Extensions that it cannot show are kept and named in a finding."""
    material, where = doc.objects("materials")[index], f"materials[{index}]"
    asset = MaterialAsset(doc.name(material, where, f"material_{index}"))
    result = ImportedMaterial(asset)
    params = asset.params
    pbr, place = doc.child(material, "pbrMetallicRoughness", where), f"{where}.pbrMetallicRoughness"
    params["base_color"] = _clamped(doc, pbr, "baseColorFactor", place, (1.0, 1.0, 1.0, 1.0))
    params["metallic"] = doc.number(pbr, "metallicFactor", place, 1.0, 0.0, 1.0)
    params["roughness"] = doc.number(pbr, "roughnessFactor", place, 1.0, 0.0, 1.0)
    _texture(doc, pbr, "baseColorTexture", place, result, "base_color_map", "color")
    _texture(doc, pbr, "metallicRoughnessTexture", place, result, "metal_rough_map", "metal_rough")
    normal = _texture(doc, material, "normalTexture", where, result, "normal_map", "normal")
    occlusion = _texture(doc, material, "occlusionTexture", where, result, "occlusion_map", "occlusion")
    _texture(doc, material, "emissiveTexture", where, result, "emissive_map", "color")
    params["normal_scale"] = doc.number(normal or {}, "scale", f"{where}.normalTexture", 1.0, -4.0, 4.0)
    params["occlusion_strength"] = doc.number(occlusion or {}, "strength", f"{where}.occlusionTexture", 1.0, 0.0, 1.0)
    params["emissive"] = _clamped(doc, material, "emissiveFactor", where, (0.0, 0.0, 0.0))
    params["emissive_strength"] = 1.0
    params["alpha_cutoff"] = doc.number(material, "alphaCutoff", where, 0.5, 0.0, 1.0)
    asset.queue = _QUEUES[doc.choice(material, "alphaMode", where, tuple(_QUEUES), "OPAQUE")]
    if doc.flag(material, "doubleSided", where):
        asset.features.append("double_sided")
    _extensions(doc, material, where, result)
    _keep_coverage(result)
    return result


def _keep_coverage(result: ImportedMaterial) -> None:
    """With an alpha test the base colour's mips keep its coverage: texture alpha * factor >= cutoff."""
    use, params = result.images.get("base_color_map"), result.asset.params
    if use is not None and result.asset.queue == "alpha_test" and 0 < params["alpha_cutoff"] < params["base_color"][3]:
        cutoff = float(params["alpha_cutoff"] / params["base_color"][3])
        result.images["base_color_map"] = replace(use, alpha_cutoff=cutoff)


def normal_map_uv(material: ImportedMaterial) -> int | None:
    """The uv set of the material's normal map, or None where it has none."""
    reference = material.asset.textures.get("normal_map")
    return None if reference is None else reference.uv_set


def _extensions(doc: Document, material: JsonObject, where: str, result: ImportedMaterial) -> None:
    asset = result.asset
    for name, value in doc.child(material, "extensions", where).items():
        place = f"{where}.extensions.{name}"
        if name not in _SHOWN:
            asset.extensions[name] = _storable(value) if isinstance(value, dict) else {}
            doc.findings.info("gltf.extension", f"{name} is imported and kept, not shown yet", place)
    if doc.extension(material, "KHR_materials_unlit", where) is not None:
        asset.features.append("unlit")
    emissive = doc.extension(material, "KHR_materials_emissive_strength", where)
    if emissive is not None:
        place = f"{where}.extensions.KHR_materials_emissive_strength"
        asset.params["emissive_strength"] = doc.number(emissive, "emissiveStrength", place, 1.0, 0.0, 1e4)
    ior = doc.extension(material, "KHR_materials_ior", where)
    if ior is not None:
        # 0 stands for an infinite index there: all light is reflected
        value = doc.number(ior, "ior", f"{where}.extensions.KHR_materials_ior", 1.5, 0.0)
        asset.params["ior"] = min(max(value, 1.0), 4.0) if value else 4.0
    specular = doc.extension(material, "KHR_materials_specular", where)
    if specular is not None:
        place = f"{where}.extensions.KHR_materials_specular"
        asset.params["specular"] = doc.number(specular, "specularFactor", place, 1.0, 0.0, 1.0)
        tint = doc.vector(specular, "specularColorFactor", place, (1.0, 1.0, 1.0))
        asset.params["specular_color"] = tuple(min(max(v, 0.0), 100.0) for v in tint)
        if {"specularTexture", "specularColorTexture"} & specular.keys():
            asset.extensions["KHR_materials_specular"] = _storable(specular)
            doc.findings.info("gltf.extension", "KHR_materials_specular: its textures are kept, not shown yet", place)
    old = doc.extension(material, "KHR_materials_pbrSpecularGlossiness", where)
    if old is not None:
        _specular_glossiness(doc, material, old, where, result)


def _specular_glossiness(
    doc: Document, material: JsonObject, old: JsonObject, where: str, result: ImportedMaterial
) -> None:
    """Diffuse, specular, glossiness to base colour, metallic, roughness.

    Follows the relations of the extension's own conversion appendix (Khronos, 2017): base colour's diffuse share is
    diffuse * (1 - max(specular)) / (1 - 0.04) / (1 - metallic), metallic from the two brightnesses.
    """
    place = f"{where}.extensions.KHR_materials_pbrSpecularGlossiness"
    asset = result.asset
    asset.extensions["KHR_materials_pbrSpecularGlossiness"] = _storable(old)
    if "pbrMetallicRoughness" in material:
        doc.findings.info("gltf.spec-gloss", "the material's metallic-roughness fallback is shown instead", place)
        return
    diffuse = _clamped(doc, old, "diffuseFactor", place, (1.0, 1.0, 1.0, 1.0))
    specular = _clamped(doc, old, "specularFactor", place, (1.0, 1.0, 1.0))
    gloss = doc.number(old, "glossinessFactor", place, 1.0, 0.0, 1.0)
    _texture(doc, old, "diffuseTexture", place, result, "base_color_map", "color")
    textured = "specularGlossinessTexture" in old
    metallic = 0.0 if textured else _metallic(diffuse[:3], specular)
    color = list(diffuse[:3])
    if metallic > 0.0:
        from_diffuse = [d * (1 - max(specular)) / 0.96 / max(1 - metallic, 1e-4) for d in diffuse[:3]]
        from_specular = [(s - 0.04 * (1 - metallic)) / max(metallic, 1e-4) for s in specular]
        blend = metallic * metallic
        color = [
            min(max(d + (s - d) * blend, 0.0), 1.0) for d, s in zip(from_diffuse, from_specular, strict=True)
        ]  # fmt: skip
    asset.params |= {
        "base_color": (*color, diffuse[3]),
        "metallic": metallic,
        "roughness": 0.5 if textured else 1.0 - gloss,
    }
    lost = " The specular-glossiness texture is not converted: not metallic, roughness 0.5." if textured else ""
    doc.findings.warn(
        "gltf.spec-gloss", f"specular-glossiness is converted to metallic-roughness, roughly.{lost}", place,
        "convert the material in the authoring tool for an exact match",
    )  # fmt: skip


def _metallic(diffuse: tuple[float, ...], specular: tuple[float, ...]) -> float:
    """The metallic whose dielectric and metal parts have these brightnesses (a quadratic; Khronos, 2017)."""

    def brightness(c: tuple[float, ...]) -> float:
        return float((0.299 * c[0] ** 2 + 0.587 * c[1] ** 2 + 0.114 * c[2] ** 2) ** 0.5)

    f0 = 0.04
    d, s = brightness(diffuse), brightness(specular)
    if s < f0:
        return 0.0
    b = d * (1 - max(specular)) / (1 - f0) + s - 2 * f0
    c = f0 - s
    root = max(b * b - 4 * f0 * c, 0.0) ** 0.5
    return float(min(max((-b + root) / (2 * f0), 0.0), 1.0))


def _texture(
    doc: Document, owner: JsonObject, key: str, path: str, result: ImportedMaterial, slot: str, role: str
) -> JsonObject | None:
    """Fill `slot` from the textureInfo `owner[key]`; returns that object, or None where there is none."""
    if key not in owner:
        return None
    info, where = doc.child(owner, key, path), f"{path}.{key}"
    reference = TextureRef("")
    result.asset.textures[slot] = reference
    uv_set = doc.integer(info, "texCoord", where, 0)
    transform = doc.extension(info, "KHR_texture_transform", where)
    if transform is not None:
        place = f"{where}.extensions.KHR_texture_transform"
        offset = doc.vector(transform, "offset", place, (0.0, 0.0))
        scale = doc.vector(transform, "scale", place, (1.0, 1.0))
        reference.offset, reference.scale = (offset[0], offset[1]), (scale[0], scale[1])
        reference.rotation = doc.number(transform, "rotation", place, 0.0)
        uv_set = doc.integer(transform, "texCoord", place, uv_set)
    if uv_set not in (0, 1):
        doc.findings.warn("gltf.uv-set", f"TEXCOORD_{uv_set} is not imported; the texture uses TEXCOORD_0", where)
        uv_set = 0
    reference.uv_set = uv_set
    number = doc.index(info, "index", where, "textures")
    if number is None:
        if "index" not in info:
            doc.findings.error("gltf.value", "names no texture", where)
        return info
    texture, place = doc.objects("textures")[number], f"textures[{number}]"
    _sampler(doc, texture, place, reference)
    image = _image_of(doc, texture, place)
    if image is not None:
        result.images[slot] = TextureUse(image, role)
    return info


def _image_of(doc: Document, texture: JsonObject, where: str) -> int | None:
    """The image that a texture shows: the one of a known extension, else its plain source."""
    blocked = ""
    for name, readable in _SOURCES.items():
        extension = doc.extension(texture, name, where)
        if extension is not None and "source" in extension:
            if readable:
                return doc.index(extension, "source", f"{where}.extensions.{name}", "images")
            blocked = name
    if "source" in texture:
        return doc.index(texture, "source", where, "images")
    doc.findings.error(
        "gltf.texture", f"the image comes by {blocked}, which is not read" if blocked else "the texture names no image",
        where, "export the texture as PNG, JPEG or WebP",
    )  # fmt: skip
    return None


def _sampler(doc: Document, texture: JsonObject, path: str, reference: TextureRef) -> None:
    number = doc.index(texture, "sampler", path, "samplers")
    if number is None:
        return
    sampler, where = doc.objects("samplers")[number], f"samplers[{number}]"

    def pick(key: str, table: dict[int, str], default: str) -> str:
        value = doc.integer(sampler, key, where)
        if value is None:
            return default
        if value not in table:
            doc.findings.error("gltf.value", f"{value} is none of {', '.join(map(str, table))}", f"{where}.{key}")
            return default
        return table[value]

    reference.wrap_u = pick("wrapS", _WRAPS, "repeat")
    reference.wrap_v = pick("wrapT", _WRAPS, "repeat")
    reference.mag_filter = pick("magFilter", _MAG, "linear")
    reference.min_filter = pick("minFilter", _MIN, "linear_mip_linear")


def _storable(value: Any) -> Any:
    """Any JSON as TOML can hold it: numbers that are not finite or beyond 64 bits, and nulls, are left out.

    Recursion is safe: the container bounds the depth."""
    if isinstance(value, dict):
        items = {storable_text(k): _storable(v) for k, v in value.items()}
        return {k: v for k, v in items.items() if v is not None}
    if isinstance(value, list):
        return [v for v in map(_storable, value) if v is not None]
    if isinstance(value, str):
        return storable_text(value)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, int) and not -(2**63) <= value < 2**63:
        return None
    return value


def _clamped(
    doc: Document, owner: JsonObject, key: str, path: str, default: tuple[float, ...]
) -> tuple[float, ...]:  # fmt: skip
    """A colour factor within 0..1, where glTF allows nothing else."""
    values: tuple[Any, ...] = doc.vector(owner, key, path, default)
    if min(values) < 0 or max(values) > 1:
        doc.findings.warn("gltf.range", f"{[round(v, 4) for v in values]} is clamped to 0..1", f"{path}.{key}")
    return tuple(min(max(v, 0.0), 1.0) for v in values)
