"""Materials: Lambert, Phong and the PBR models of 3ds Max, Maya, Arnold and Blender become the `surface` effect.

ufbx already maps each shader's properties to one list of PBR maps (base, metalness, roughness, …); here their values
and textures become our parameters. A texture replaces the value of its property and is scaled by the property's
factor, as FBX has it; in glTF materials it multiplies the value.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from engine.assets.material import MaterialAsset, TextureRef
from importers.fbx import images as pack
from importers.fbx.document import FbxDocument, Json
from importers.fbx.images import Images
from importers.fbx.uv_transforms import apply_matrix
from importers.model import ImportedMaterial, TextureUse

_NORMAL_WORDS = ("normal", "nrm", "norm", "_n.", "_nor", "_nm")
#: maps that are kept as text and not shown
_KEPT = ("transmission", "subsurface", "sheen", "coat", "thin_film", "specular_anisotropy", "displacement_map")
_PLAIN_SHADERS = ("fbx_lambert", "fbx_phong", "blender_phong", "wavefront_mtl", "unknown")


@dataclass(slots=True)
class _Source:
    """One material on its way; `uv_sets`: names of the uv sets of the meshes that use it."""

    doc: FbxDocument
    images: Images
    entry: Json
    uv_sets: list[str]
    result: ImportedMaterial
    where: str

    def map(self, name: str, group: str = "pbr") -> Json | None:
        found: Json | None = self.entry[group].get(name)
        return found

    def value(self, name: str, default: float, group: str = "pbr") -> float:
        entry = self.map(name, group)
        return float(entry["value"][0]) if entry is not None and entry["has_value"] else default

    def color(self, name: str, default: tuple[float, float, float], group: str = "pbr") -> tuple[float, float, float]:
        entry = self.map(name, group)
        if entry is None or not entry["has_value"]:
            return default
        r, g, b = (float(v) for v in entry["value"][:3])
        return (r, r, r) if entry["components"] == 1 else (r, g, b)

    def texture(self, *names: str, group: str = "pbr") -> int:
        """The file texture that the first of these maps shows, or -1."""
        for name in names:
            entry = self.map(name, group)
            if entry is not None and entry["texture"] >= 0:
                return self._file(int(entry["texture"]), name)
        return -1

    def _file(self, texture: int, name: str) -> int:
        """The texture itself, or the first file below a layered or procedural one."""
        entry = self.doc.textures[texture]
        layers = [int(layer) for layer in entry["layers"]]
        if entry["type"] == "file" or not layers:
            return texture
        if len(layers) > 1:
            self.doc.findings.info(
                "fbx.layers", f"{name}: of {len(layers)} layered textures only the first is shown", self.where
            )
        return layers[0]


def read_material(doc: FbxDocument, images: Images, index: int, uv_sets: list[str]) -> ImportedMaterial:
    """Material `index` for the `surface` effect; what it cannot show is kept in `extensions` and named."""
    entry = doc.materials[index]
    asset = MaterialAsset(str(entry["name"]) or f"material_{index}")
    source = _Source(doc, images, entry, uv_sets, ImportedMaterial(asset), f"materials[{asset.name}]")
    _base_color(source)
    _metal_rough(source)
    _specular(source)
    _emissive(source)
    _relief(source)
    if "double_sided" in entry["features"]:
        asset.features.append("double_sided")
    if "unlit" in entry["features"]:
        asset.features.append("unlit")
    _opacity(source)
    _keep(source)
    return source.result


def _base_color(source: _Source) -> None:
    texture = source.texture("base_color")
    factor = source.value("base_factor", 1.0)
    color = source.color("base_color", (0.8, 0.8, 0.8))
    if texture >= 0:
        if source.entry["shader"] != "gltf_material" and "texture_times_color" not in source.entry["features"]:
            color = (1.0, 1.0, 1.0)
        # a factor of 0 under a texture is what careless exporters write
        factor = factor if factor > 0 else 1.0
        _use(source, "base_color_map", texture, "color")
    r, g, b = (_clamp(v * factor) for v in color)
    source.result.asset.params["base_color"] = (r, g, b, 1.0)


def _metal_rough(source: _Source) -> None:
    params, entry = source.result.asset.params, source.entry
    glossy = source.map("roughness") is None and source.map("glossiness") is not None
    rough_name = "glossiness" if glossy or "roughness_as_glossiness" in entry["features"] else "roughness"
    if source.map(rough_name) is None:
        rough_name = "glossiness" if source.map("glossiness") is not None else "roughness"
    glossy = rough_name == "glossiness"
    lambert = entry["shader"] in ("fbx_lambert", "unknown")
    rough = source.value(rough_name, 0.0 if glossy else 1.0 if lambert else 0.5)
    metal = source.value("metalness", 0.0)
    rough_map, metal_map = source.texture(rough_name), source.texture("metalness")
    scales = entry["shader"] == "gltf_material"
    params["roughness"] = _clamp(1.0 - rough if glossy else rough)
    params["metallic"] = _clamp(metal)
    if rough_map < 0 and metal_map < 0:
        return
    first = source.images.plain(rough_map) if rough_map >= 0 else -1
    second = source.images.plain(metal_map) if metal_map >= 0 else -1
    if rough_map >= 0 and not scales:
        params["roughness"] = 1.0
    if metal_map >= 0 and not scales:
        params["metallic"] = 1.0
    reference = rough_map if rough_map >= 0 else metal_map
    _reference(source, "metal_rough_map", reference)
    if first < 0 and second < 0:
        return
    if first == second and not glossy:
        number = first  # one image for both holds them as glTF does: G roughness, B metallic
    else:
        number = source.images.packed("metal_gloss" if glossy else "metal_rough", (first, second),
                                      pack.metal_gloss if glossy else pack.metal_rough)  # fmt: skip
        source.doc.findings.info(
            "fbx.packed", f"{rough_name} and metalness are packed into one texture", source.where
        )  # fmt: skip
    source.result.images["metal_rough_map"] = TextureUse(number, "metal_rough")


def _specular(source: _Source) -> None:
    params, entry = source.result.asset.params, source.entry
    ior = source.map("specular_ior")
    if ior is not None and ior["has_value"] and ior["value"][0] > 0:
        params["ior"] = min(max(float(ior["value"][0]), 1.0), 4.0)
    if entry["shader"] == "blender_phong":
        # Blender writes half of its own value, of which 0.5 is a dielectric's 4 %
        params["specular"] = _clamp(4.0 * source.value("specular_factor", 0.25, "fbx"))
    if entry["shader"] in _PLAIN_SHADERS:
        return  # what Phong calls specular is no reflectance of a dielectric
    if source.map("specular_factor") is not None:
        params["specular"] = _clamp(source.value("specular_factor", 1.0))
    if "specular" in entry["features"] and source.map("specular_color") is not None:
        r, g, b = source.color("specular_color", (1.0, 1.0, 1.0))
        if entry["shader"] == "e3ds_max_pbr_spec_gloss":
            source.doc.findings.info(
                "fbx.spec-gloss", "specular-glossiness is shown as a dielectric with a tinted reflection", source.where,
                "convert the material to metallic-roughness for an exact match",
            )  # fmt: skip
            r, g, b = (v / 0.04 for v in (r, g, b))
        params["specular_color"] = tuple(min(max(v, 0.0), 100.0) for v in (r, g, b))
    if source.texture("specular_factor", "specular_color") >= 0:
        source.doc.findings.info("fbx.material", "the specular texture is not shown", source.where)


def _emissive(source: _Source) -> None:
    params = source.result.asset.params
    factor = max(source.value("emission_factor", 1.0), 0.0)
    if source.entry["shader"] == "openpbr_material":
        factor /= 1000.0  # candela per square metre; 1000 is a white screen at full brightness
    color = source.color("emission_color", (0.0, 0.0, 0.0))
    texture = source.texture("emission_color")
    if texture >= 0:
        if source.entry["shader"] != "gltf_material":
            color = (1.0, 1.0, 1.0)
        _use(source, "emissive_map", texture, "color")
    color = tuple(max(v, 0.0) for v in color)  # type: ignore[assignment]  # three stay three
    strength = max(*color, 1.0) * factor
    scaled = max(strength, 1e-9)
    params["emissive"] = tuple(_clamp(v * factor / scaled) for v in color) if factor > 0 else (0.0, 0.0, 0.0)
    params["emissive_strength"] = min(strength, 1e4) if factor > 0 else 1.0


def _relief(source: _Source) -> None:
    texture = source.texture("normal_map")
    bump = source.texture("bump", group="fbx")
    if texture < 0:
        texture = source.texture("normal_map", group="fbx")
    if texture < 0 and bump >= 0:
        names = " ".join(str(n) for n in source.doc.textures[bump]["files"]).lower()
        if any(word in names for word in _NORMAL_WORDS):
            texture = bump
            source.doc.findings.info("fbx.bump", "the bump map is taken for a normal map, for its name", source.where)
        else:
            source.doc.findings.info(
                "fbx.bump", "the bump map holds heights, which are not shown", source.where, "bake it to a normal map"
            )  # fmt: skip
    if texture >= 0:
        _use(source, "normal_map", texture, "normal")
    occlusion = source.texture("ambient_occlusion")
    if occlusion >= 0:
        _use(source, "occlusion_map", occlusion, "occlusion")


def _opacity(source: _Source) -> None:
    """Alpha from the opacity map, or from Phong's transparency = colour * factor."""
    asset, result = source.result.asset, source.result
    mask, inverted = source.texture("opacity"), False
    alpha = source.value("opacity", 1.0)
    entry = source.map("opacity")
    if entry is not None and entry["has_value"] and entry["components"] >= 3:
        alpha = sum(float(v) for v in entry["value"][:3]) / 3
    if entry is None:
        color = source.color("transparency_color", (0.0, 0.0, 0.0), "fbx")
        alpha = 1.0 - sum(color) / 3 * source.value("transparency_factor", 1.0, "fbx")
        mask, inverted = source.texture("transparency_color", group="fbx"), True
        if mask >= 0:
            alpha = 1.0
    elif mask >= 0:
        alpha = 1.0
    if alpha <= 0.0:
        source.doc.findings.info("fbx.opacity", "the material would be invisible; taken as opaque", source.where)
        alpha = 1.0
    r, g, b, _ = asset.params["base_color"]
    asset.params["base_color"] = (r, g, b, _clamp(alpha))
    if alpha < 0.999:
        asset.queue = "transparent"
    if mask < 0:
        return
    shown = result.images.get("base_color_map")
    number = source.images.plain(mask)
    if number < 0:
        return
    # a map of the colours' own image means that image's alpha
    if shown is None or shown.image != number:
        first = -1 if shown is None else shown.image
        kind, function = ("transparency", pack.color_without) if inverted else ("opacity", pack.color_with_alpha)
        number = source.images.packed(kind, (first, number), function)
        if shown is None:
            _reference(source, "base_color_map", mask)
        source.doc.findings.info("fbx.packed", f"the {kind} map is packed into the base colour's alpha", source.where)
    asset.queue = "alpha_test"
    asset.params["alpha_cutoff"] = 0.5
    use = TextureUse(number, "color")
    result.images["base_color_map"] = replace(use, alpha_cutoff=0.5)


def _keep(source: _Source) -> None:
    """Keep what the effect has no word for."""
    if source.entry["shader"] in _PLAIN_SHADERS:
        return  # their transparency is alpha, and they have nothing else
    kept: dict[str, Any] = {}
    for name, entry in source.entry["pbr"].items():
        if (
            name.startswith(_KEPT)
            and entry["has_value"]
            and name.endswith(("_factor", "_map"))
            and entry["value"][0] > 0
        ):
            kept[name] = [float(v) for v in entry["value"][: max(entry["components"], 1)]]
    if kept:
        source.result.asset.extensions["fbx"] = kept
        source.doc.findings.info("fbx.material", f"{', '.join(kept)}: kept, not shown", source.where)


def _use(source: _Source, slot: str, texture: int, role: str) -> None:
    _reference(source, slot, texture)
    image = source.images.plain(texture)
    if image >= 0:
        source.result.images[slot] = TextureUse(image, role)


def _reference(source: _Source, slot: str, texture: int) -> None:
    """The slot's sampling, uv set and uv transform."""
    entry = source.doc.textures[texture]
    reference = TextureRef("")
    reference.wrap_u, reference.wrap_v = ("clamp" if clamped else "repeat" for clamped in entry["clamp"])
    name = str(entry["uv_set"])
    if name and name in source.uv_sets:
        reference.uv_set = source.uv_sets.index(name)
        if reference.uv_set > 1:
            source.doc.findings.warn("fbx.uv-set", f"uv set {name!r} is not imported; the first is used", source.where)
            reference.uv_set = 0
    if entry["matrix"] is not None and not apply_matrix(entry["matrix"], reference):
        source.doc.findings.info(
            "fbx.uv-transform", f"{slot}: the uv transform has shear, which is left out", source.where
        )
    source.result.asset.textures[slot] = reference


def _clamp(value: float) -> float:
    return min(max(value, 0.0), 1.0)
