"""Material layers: KHR_materials_* extensions that the `layered` effect draws, as its features, params, textures.

Source: KHR_materials_clearcoat, _sheen, _anisotropy, _iridescence, _transmission, _volume, _dispersion, _specular
(Khronos, 2020 to 2024). A layer that shows nothing (its strength is 0) is not switched on: it is kept as
the file has it, as unknown ones are.

    extensions ─► LAYERS: number -> param, texture -> slot ─► effect "layered", features, params ─► extensions
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from engine.assets.material import MaterialAsset
from importers.gltf.document import Document, JsonObject
from importers.model import ImportedMaterial

#: doc, owner, key, path, result, slot, role -> the textureInfo
TextureReader = Callable[[Document, JsonObject, str, str, ImportedMaterial, str, str], "JsonObject | None"]


@dataclass(frozen=True, slots=True)
class Layer:
    """`numbers`, `colors`: key of the file -> (param, default, least, most); `textures`: key -> (slot, role).
    `strength`: the params of which one above 0 switches the feature on ('': it has none of its own)."""

    feature: str = ""
    strength: str = ""
    numbers: dict[str, tuple[str, float, float, float]] = field(default_factory=dict)
    colors: dict[str, tuple[str, tuple[float, float, float], float]] = field(default_factory=dict)
    textures: dict[str, tuple[str, str]] = field(default_factory=dict)
    #: feature that must be on for this one to show anything
    within: str = ""


_FAR = 1e6
LAYERS: dict[str, Layer] = {
    "KHR_materials_clearcoat": Layer(
        "clearcoat", "clearcoat",
        {
            "clearcoatFactor": ("clearcoat", 0.0, 0.0, 1.0),
            "clearcoatRoughnessFactor": ("clearcoat_roughness", 0.0, 0.0, 1.0),
        },
        textures={
            "clearcoatTexture": ("clearcoat_map", "data"),
            "clearcoatRoughnessTexture": ("clearcoat_roughness_map", "data"),
            "clearcoatNormalTexture": ("clearcoat_normal_map", "normal"),
        },
    ),
    "KHR_materials_sheen": Layer(
        "sheen", "sheen_color", {"sheenRoughnessFactor": ("sheen_roughness", 0.0, 0.0, 1.0)},
        {"sheenColorFactor": ("sheen_color", (0.0, 0.0, 0.0), 1.0)},
        {"sheenColorTexture": ("sheen_color_map", "color"), "sheenRoughnessTexture": ("sheen_roughness_map", "data")},
    ),
    "KHR_materials_anisotropy": Layer(
        "anisotropy", "anisotropy",
        {
            "anisotropyStrength": ("anisotropy", 0.0, 0.0, 1.0),
            "anisotropyRotation": ("anisotropy_rotation", 0.0, -2 * math.pi, 2 * math.pi),
        },
        textures={"anisotropyTexture": ("anisotropy_map", "data")},
    ),
    "KHR_materials_iridescence": Layer(
        "iridescence", "iridescence",
        {
            "iridescenceFactor": ("iridescence", 0.0, 0.0, 1.0), "iridescenceIor": ("iridescence_ior", 1.3, 1.0, 4.0),
            "iridescenceThicknessMinimum": ("iridescence_thickness_min", 100.0, 0.0, 1e4),
            "iridescenceThicknessMaximum": ("iridescence_thickness_max", 400.0, 0.0, 1e4),
        },
        textures={
            "iridescenceTexture": ("iridescence_map", "data"),
            "iridescenceThicknessTexture": ("iridescence_thickness_map", "data"),
        },
    ),
    "KHR_materials_transmission": Layer(
        "transmission", "transmission", {"transmissionFactor": ("transmission", 0.0, 0.0, 1.0)},
        textures={"transmissionTexture": ("transmission_map", "data")},
    ),
    "KHR_materials_volume": Layer(
        numbers={
            "thicknessFactor": ("thickness", 0.0, 0.0, 1e4),
            "attenuationDistance": ("attenuation_distance", 0.0, 0.0, _FAR),
        },
        colors={"attenuationColor": ("attenuation_color", (1.0, 1.0, 1.0), 1.0)},
        textures={"thicknessTexture": ("thickness_map", "data")}, within="transmission",
    ),
    "KHR_materials_dispersion": Layer(
        "dispersion", "dispersion", {"dispersion": ("dispersion", 0.0, 0.0, 20.0)}, within="transmission",
    ),
}  # fmt: skip

#: of KHR_materials_specular, whose numbers every surface has
SPECULAR_TEXTURES = {
    "specularTexture": ("specular_map", "data"),
    "specularColorTexture": ("specular_color_map", "color"),
}

#: slots that belong to an extension
SLOTS = frozenset(slot for layer in LAYERS.values() for slot, _ in layer.textures.values()) | {
    slot for slot, _ in SPECULAR_TEXTURES.values()
}


def read_layers(
    doc: Document, material: JsonObject, where: str, result: ImportedMaterial, texture: TextureReader,
    keep: Callable[[Document, Any], Any],
) -> None:  # fmt: skip
    """Switch on the layers that the material has; those that show nothing are kept, and named in a finding."""
    asset = result.asset
    unlit = "unlit" in asset.features
    specular = None if unlit else doc.extension(material, "KHR_materials_specular", where)
    place = f"{where}.extensions.KHR_materials_specular"
    for key, (slot, role) in SPECULAR_TEXTURES.items():
        if specular is not None and key in specular:
            asset.effect = "layered"
            texture(doc, specular, key, place, result, slot, role)
    for name, layer in LAYERS.items():
        value = doc.extension(material, name, where)
        if value is None:
            continue
        place = f"{where}.extensions.{name}"
        params = _params(doc, value, layer, place)
        strength = params.get(layer.strength, 1.0)
        reason = ""
        if unlit:
            reason = "the material is unlit"
        elif layer.within and layer.within not in asset.features:
            reason = f"without {layer.within}"
        elif not any(strength if isinstance(strength, tuple) else (strength,)):
            reason = "its strength is 0"
        if reason:
            asset.extensions[name] = keep(doc, value)
            doc.findings.info("gltf.extension", f"{name} is imported and kept, but shows nothing: {reason}", place)
            continue
        asset.effect = "layered"
        asset.params |= params
        if layer.feature:
            asset.features.append(layer.feature)
        for key, (slot, role) in layer.textures.items():
            if key in value:
                info = texture(doc, value, key, place, result, slot, role)
                if key == "clearcoatNormalTexture":
                    scale = doc.number(info or {}, "scale", f"{place}.{key}", 1.0, -4.0, 4.0)
                    asset.params["clearcoat_normal_scale"] = scale


def _params(doc: Document, value: JsonObject, layer: Layer, place: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, (param, default, least, most) in layer.numbers.items():
        found[param] = doc.number(value, key, place, default, least, most)
    for key, (param, color, most) in layer.colors.items():
        found[param] = tuple(min(max(v, 0.0), most) for v in doc.vector(value, key, place, color))
    return found


def write_layers(asset: MaterialAsset, texture: Callable[[str], JsonObject | None]) -> dict[str, JsonObject]:
    """The layers of a material as extensions, defaults left out; `texture`: slot -> textureInfo."""
    result: dict[str, JsonObject] = {}
    params = asset.params
    for name, layer in LAYERS.items():
        if (layer.feature or layer.within) not in asset.features:
            continue
        value: JsonObject = {}
        for key, (param, default, *_) in layer.numbers.items():
            if params.get(param, default) != default:
                value[key] = params[param]
        for key, (param, color, _) in layer.colors.items():
            if tuple(params.get(param, color)) != color:
                value[key] = [*params[param]]
        for key, (slot, _) in layer.textures.items():
            info = texture(slot) if slot in asset.textures else None
            if info is not None:
                if key == "clearcoatNormalTexture" and params.get("clearcoat_normal_scale", 1.0) != 1.0:
                    info["scale"] = params["clearcoat_normal_scale"]
                value[key] = info
        if value or layer.feature:
            result[name] = value
    for key, (slot, _) in SPECULAR_TEXTURES.items():
        info = texture(slot) if slot in asset.textures else None
        if info is not None:
            result.setdefault("KHR_materials_specular", {})[key] = info
    return result
