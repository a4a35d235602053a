"""Materials: glTF's metallic-roughness model and its common extensions become the `surface` effect's parameters,
further layers (layers.py) those of `layered`.

Source: glTF 2.0 specification (Khronos, 2021), section 3.9; KHR_texture_transform, KHR_materials_unlit,
KHR_materials_emissive_strength, KHR_materials_ior, KHR_materials_specular, KHR_materials_pbrSpecularGlossiness
(Khronos, 2017 to 2022).
"""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any

import numpy as np

from engine.assets.material import MaterialAsset, TextureRef
from importers.gltf import spec_gloss
from importers.gltf.document import Document, JsonObject
from importers.gltf.extras import storable
from importers.gltf.layers import LAYERS, read_layers
from importers.gltf.uris import storable_text
from importers.model import ImportedMaterial, SourceImage, TextureUse
from importers.settings import ImportSettings
from importers.textures import ktx2

_WRAPS = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
_MAG = {9728: "nearest", 9729: "linear"}
_MIN = {
    9728: "nearest", 9729: "linear", 9984: "nearest_mip_nearest", 9985: "linear_mip_nearest",
    9986: "nearest_mip_linear", 9987: "linear_mip_linear",
}  # fmt: skip
_QUEUES = {"OPAQUE": "opaque", "MASK": "alpha_test", "BLEND": "transparent"}
_SHOWN = {
    "KHR_materials_unlit", "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_ior", "KHR_materials_specular", *LAYERS,
}  # fmt: skip
#: extensions that name another image than the plain one, best first
_SOURCES = ("KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_webp", "EXT_texture_avif")


class Images(list[SourceImage]):
    """The images of the file and those that conversions add. `settings`: limits for decoding them."""

    def __init__(self, images: list[SourceImage], settings: ImportSettings) -> None:
        super().__init__(images)
        self.settings = settings


def read_material(doc: Document, index: int, images: Images) -> ImportedMaterial:
    """Material `index` for the `surface` or `layered` effect. What neither can show is kept and named in a finding.

    `images`: all of the file; those that a conversion makes are appended."""
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
    if isinstance(material.get("extras"), dict):
        asset.extensions["extras"] = storable(material["extras"])
    _extensions(doc, material, where, result, images)
    _keep_coverage(result)
    return result


def _keep_coverage(result: ImportedMaterial) -> None:
    """With an alpha test the base colour's mips keep its coverage: texture alpha * factor >= cutoff."""
    use, params = result.images.get("base_color_map"), result.asset.params
    if use is not None and result.asset.queue == "alpha_test" and 0 < params["alpha_cutoff"] < params["base_color"][3]:
        cutoff = float(params["alpha_cutoff"] / params["base_color"][3])
        result.images["base_color_map"] = replace(use, alpha_cutoff=cutoff)


def normal_map_uv(material: ImportedMaterial) -> int | None:
    """The uv set that tangents follow: of the material's normal map, of its coat's, or of the grain of a stretched
    lobe; None where it needs none."""
    textures = material.asset.textures
    for slot in ("normal_map", "clearcoat_normal_map", "anisotropy_map"):
        if slot in textures:
            return textures[slot].uv_set
    return 0 if "anisotropy" in material.asset.features else None


def _extensions(doc: Document, material: JsonObject, where: str, result: ImportedMaterial, images: Images) -> None:
    asset = result.asset
    for name, value in doc.child(material, "extensions", where).items():
        place = f"{where}.extensions.{name}"
        if name not in _SHOWN:
            asset.extensions[name] = _kept(doc, value) if isinstance(value, dict) else {}
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
    old = doc.extension(material, "KHR_materials_pbrSpecularGlossiness", where)
    if old is not None:
        _specular_glossiness(doc, material, old, where, result, images)
    read_layers(doc, material, where, result, _texture, _kept)


def _specular_glossiness(
    doc: Document, material: JsonObject, old: JsonObject, where: str, result: ImportedMaterial, images: Images
) -> None:
    """Diffuse, specular, glossiness to base colour, metallic, roughness (spec_gloss.py)."""
    place = f"{where}.extensions.KHR_materials_pbrSpecularGlossiness"
    asset = result.asset
    asset.extensions["KHR_materials_pbrSpecularGlossiness"] = _kept(doc, old)
    fallback = doc.child(material, "pbrMetallicRoughness", where)
    poorer = "diffuseTexture" in old and "baseColorTexture" not in fallback
    if fallback and not poorer:
        doc.findings.info("gltf.spec-gloss", "the material's metallic-roughness fallback is shown instead", place)
        return
    diffuse = _clamped(doc, old, "diffuseFactor", place, (1.0, 1.0, 1.0, 1.0))
    specular = _clamped(doc, old, "specularFactor", place, (1.0, 1.0, 1.0))
    gloss = doc.number(old, "glossinessFactor", place, 1.0, 0.0, 1.0)
    result.images.pop("metal_rough_map", None)
    asset.textures.pop("metal_rough_map", None)
    _texture(doc, old, "diffuseTexture", place, result, "base_color_map", "color")
    _texture(doc, old, "specularGlossinessTexture", place, result, "metal_rough_map", "metal_rough")
    uses = [result.images.get(slot) for slot in ("base_color_map", "metal_rough_map")]
    if uses[1] is None:
        asset.textures.pop("metal_rough_map", None)
        # without a texture of its own the metalness is one number, and so the base colour's image stays as it is
        color, metallic = spec_gloss.convert(np.array(diffuse[:3]), np.array(specular))
        if uses[0] is not None:
            color = np.array(diffuse[:3])
        asset.params |= {"metallic": float(metallic), "roughness": 1.0 - gloss}
        asset.params["base_color"] = (*(float(v) for v in color), diffuse[3])
    else:
        sources = [None if use is None else images[use.image].data for use in uses]
        pair = spec_gloss.TexturePair(
            sources[0], sources[1], (diffuse[:3], specular, gloss), place, images.settings
        )  # fmt: skip
        names = (f"{asset.name}.base_color", pair.base_color), (f"{asset.name}.metal_rough", pair.metal_rough)
        one, two = asset.textures.get("base_color_map"), asset.textures["metal_rough_map"]
        if one is None:
            asset.textures["base_color_map"] = copy.copy(two)
        elif (one.uv_set, one.offset, one.scale, one.rotation) != (two.uv_set, two.offset, two.scale, two.rotation):
            doc.findings.warn(
                "gltf.spec-gloss", "the two textures lie differently on the mesh; converted as if not", place
            )
        for slot, role, (name, data) in zip(
            ("base_color_map", "metal_rough_map"), ("color", "metal_rough"), names, strict=True
        ):
            result.images[slot] = TextureUse(len(images), role)
            images.append(SourceImage(name, data, place))
        asset.params |= {"base_color": (1.0, 1.0, 1.0, diffuse[3]), "metallic": 1.0, "roughness": 1.0}
    doc.findings.info(
        "gltf.spec-gloss", f"specular-glossiness is converted to metallic-roughness {spec_gloss.METHOD}", place,
        "highlights of coloured dielectrics may differ a little",
    )  # fmt: skip


def _kept(doc: Document, value: Any) -> Any:
    """An extension as the material keeps it: texture numbers, which mean nothing outside the file, name their image."""
    if isinstance(value, list):
        return [_kept(doc, item) for item in value]
    if not isinstance(value, dict):
        return storable(value)
    result = {k: _kept(doc, v) for k, v in value.items() if k.endswith("Texture") or not isinstance(v, (dict, list))}
    result |= {k: storable(v) for k, v in value.items() if k not in result}
    for key, info in result.items():
        if key.endswith("Texture") and isinstance(info, dict) and isinstance(info.get("index"), int):
            textures = doc.objects("textures")
            number = info.pop("index")
            source = textures[number].get("source") if 0 <= number < len(textures) else None
            if isinstance(source, int) and 0 <= source < len(doc.objects("images")):
                image = doc.objects("images")[source]
                info["image"] = source
                info["image_name"] = storable_text(str(image.get("name") or image.get("uri", ""))[:200])
    return {k: v for k, v in result.items() if v is not None}


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
    """The image that a texture shows: its plain source, or the one of an extension where that is better or alone."""
    plain = doc.index(texture, "source", where, "images") if "source" in texture else None
    blocked = ""
    for name in _SOURCES:
        extension = doc.extension(texture, name, where)
        if extension is None or "source" not in extension:
            continue
        if name == "KHR_texture_basisu" and not ktx2.can_transcode():
            blocked = name
            if plain is not None:
                continue
        # also where it cannot be decoded: the error then says what to install
        return doc.index(extension, "source", f"{where}.extensions.{name}", "images")
    if plain is not None:
        if blocked:
            doc.findings.info("gltf.texture", f"the plain image is used instead of {blocked}", where, ktx2.MISSING)
        return plain
    if "source" not in texture:
        doc.findings.error(
            "gltf.texture", "the texture names no image", where, "export the texture as PNG, JPEG or WebP"
        )
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


def _clamped(
    doc: Document, owner: JsonObject, key: str, path: str, default: tuple[float, ...]
) -> tuple[float, ...]:  # fmt: skip
    """A colour factor within 0..1, where glTF allows nothing else."""
    values: tuple[Any, ...] = doc.vector(owner, key, path, default)
    if min(values) < 0 or max(values) > 1:
        doc.findings.warn("gltf.range", f"{[round(v, 4) for v in values]} is clamped to 0..1", f"{path}.{key}")
    return tuple(min(max(v, 0.0), 1.0) for v in values)
