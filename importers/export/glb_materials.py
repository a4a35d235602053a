"""Materials of `surface` and `layered` as glTF materials, with their images embedded as PNG or JPEG, each once.

Source: glTF 2.0 specification (Khronos, 2021), section 3.9, and the KHR_materials_* extensions named below.
"""

from __future__ import annotations

import copy
from typing import Any

from engine.assets.material import MaterialAsset, TextureRef
from importers.export.glb_writer import GlbWriter
from importers.export.source import ExportSource, Picture
from importers.gltf.layers import SLOTS, write_layers

_WRAPS = {"repeat": 10497, "mirror": 33648, "clamp": 33071}
_FILTERS = {
    "nearest": 9728, "linear": 9729, "nearest_mip_nearest": 9984, "linear_mip_nearest": 9985,
    "nearest_mip_linear": 9986, "linear_mip_linear": 9987,
}  # fmt: skip
_MODES = {"alpha_test": "MASK", "transparent": "BLEND"}


class MaterialWriter:
    """Writes a material when its number is first asked for."""

    def __init__(self, source: ExportSource, writer: GlbWriter) -> None:
        self._source = source
        self._writer = writer
        self._numbers: dict[int, int] = {}

    def index(self, material: int) -> int:
        """The number in the file of a material of the source."""
        if material not in self._numbers:
            entry = self._material(material, self._source.materials[material])
            self._numbers[material] = self._writer.append("materials", entry)
        return self._numbers[material]

    def _material(self, number: int, asset: MaterialAsset) -> dict[str, Any]:
        if asset.effect not in ("surface", "layered"):
            self._source.findings.warn(
                "export.effect",
                f"glTF has no effect {asset.effect!r}; what it shares with `surface` is written",
                asset.name,
            )
        params = asset.params
        pbr: dict[str, Any] = {
            "baseColorFactor": [*params.get("base_color", (1.0, 1.0, 1.0, 1.0))],
            "metallicFactor": params.get("metallic", 1.0), "roughnessFactor": params.get("roughness", 1.0),
        }  # fmt: skip
        entry: dict[str, Any] = {"name": asset.name, "pbrMetallicRoughness": pbr}
        places = (
            ("base_color_map", pbr, "baseColorTexture"), ("metal_rough_map", pbr, "metallicRoughnessTexture"),
            ("normal_map", entry, "normalTexture"), ("occlusion_map", entry, "occlusionTexture"),
            ("emissive_map", entry, "emissiveTexture"),
        )  # fmt: skip
        for slot, owner, key in places:
            if slot in asset.textures:
                info = self._texture(number, slot, asset.textures[slot], asset.name)
                if info is not None:
                    owner[key] = info
        for slot in asset.textures.keys() - {slot for slot, _, _ in places} - SLOTS:
            self._source.findings.warn("export.texture", f"glTF has no place for {slot}; left out", asset.name)
        if "normalTexture" in entry and params.get("normal_scale", 1.0) != 1.0:
            entry["normalTexture"]["scale"] = params["normal_scale"]
        if "occlusionTexture" in entry and params.get("occlusion_strength", 1.0) != 1.0:
            entry["occlusionTexture"]["strength"] = params["occlusion_strength"]
        if any(params.get("emissive", (0.0,))):
            entry["emissiveFactor"] = [*params["emissive"]]
        if asset.queue in _MODES:
            entry["alphaMode"] = _MODES[asset.queue]
        if asset.queue == "alpha_test" or params.get("alpha_cutoff", 0.5) != 0.5:
            entry["alphaCutoff"] = params.get("alpha_cutoff", 0.5)
        if "double_sided" in asset.features:
            entry["doubleSided"] = True
        extensions = self._extensions(number, asset)
        if extensions:
            entry["extensions"] = extensions
            for name in extensions:
                self._writer.use(name)
        if isinstance(asset.extensions.get("extras"), dict):
            entry["extras"] = asset.extensions["extras"]
        return entry

    def _extensions(self, number: int, asset: MaterialAsset) -> dict[str, Any]:
        params = asset.params
        result: dict[str, Any] = {}
        for name, value in asset.extensions.items():
            # what was converted at import would be shown twice
            if name.startswith(("KHR_", "EXT_")) and name != "KHR_materials_pbrSpecularGlossiness":
                result[name] = self._kept(value, asset.name)
        result |= write_layers(asset, lambda slot: self._texture(number, slot, asset.textures[slot], asset.name))
        if "unlit" in asset.features:
            result["KHR_materials_unlit"] = {}
        if params.get("emissive_strength", 1.0) != 1.0:
            result["KHR_materials_emissive_strength"] = {"emissiveStrength": params["emissive_strength"]}
        if params.get("ior", 1.5) != 1.5:
            result["KHR_materials_ior"] = {"ior": params["ior"]}
        factor, tint = params.get("specular", 1.0), [*params.get("specular_color", (1.0, 1.0, 1.0))]
        if factor != 1.0 or tint != [1.0, 1.0, 1.0]:
            kept = result.get("KHR_materials_specular", {})
            result["KHR_materials_specular"] = kept | {"specularFactor": factor, "specularColorFactor": tint}
        return result

    def _kept(self, value: Any, where: str) -> Any:
        """An extension as the source had it; its textures get their new numbers."""
        value = copy.deepcopy(value)
        for key, info in list(value.items()) if isinstance(value, dict) else ():
            if not key.endswith("Texture") or not isinstance(info, dict):
                continue
            image = info.pop("image", None)
            info.pop("image_name", None)
            picture = self._source.kept_picture(image) if isinstance(image, int) else None
            if picture is None:
                self._source.findings.warn("export.texture", f"the image of {key} is not at hand; left out", where)
                del value[key]
            else:
                info["index"] = self._writer.add("textures", {"source": self._image(picture)})
                for name in info.get("extensions", {}):
                    self._writer.use(name)
        return value

    def _texture(self, material: int, slot: str, reference: TextureRef, where: str) -> dict[str, Any] | None:
        picture = self._source.picture(material, slot)
        if picture is None:
            self._source.findings.warn("export.texture", f"the image of {slot} is not at hand; left out", where)
            return None
        sampler = {
            "magFilter": _FILTERS[reference.mag_filter], "minFilter": _FILTERS[reference.min_filter],
            "wrapS": _WRAPS[reference.wrap_u], "wrapT": _WRAPS[reference.wrap_v],
        }  # fmt: skip
        texture = {"sampler": self._writer.add("samplers", sampler), "source": self._image(picture)}
        info: dict[str, Any] = {"index": self._writer.add("textures", texture)}
        if reference.uv_set:
            info["texCoord"] = reference.uv_set
        transform: dict[str, Any] = {}
        if tuple(reference.offset) != (0.0, 0.0):
            transform["offset"] = list(reference.offset)
        if reference.rotation:
            transform["rotation"] = reference.rotation
        if tuple(reference.scale) != (1.0, 1.0):
            transform["scale"] = list(reference.scale)
        if transform:
            info["extensions"] = {"KHR_texture_transform": transform}
            self._writer.use("KHR_texture_transform")
        return info

    def _image(self, picture: Picture) -> int:
        entry: dict[str, Any] = {"bufferView": self._writer.view(picture.data), "mimeType": picture.mime}
        if picture.name:
            entry["name"] = picture.name
        return self._writer.add("images", entry)
