"""A resolved Ogre material becomes the `surface` effect: the classic lighting model in terms of base colour, roughness.

    diffuse            -> base_color (display-referred, so decoded from sRGB; its alpha kept)
    specular, shininess n -> roughness = (2 / (n + 2))^(1/4): GGX's alpha^2 = 2 / (n + 2) has the same lobe as
                          Blinn-Phong's exponent (Walter et al., 2007, section 5.4; Karis, 2013), alpha = roughness^2.
                          Its brightest component is the strength `specular`, its colour `specular_color`;
                          black, Ogre's default: roughness 1
    emissive           -> emissive, emissive_strength
    alpha_rejection    -> queue alpha_test, cutoff / 255       scene_blend alpha_blend -> queue transparent
    cull_hardware none -> double_sided                          lighting off            -> unlit
    texture_unit       -> base_color_map; with rtshader_system normal_map -> normal_map

All that has no place in it is named in one finding a material. Source: Ogre manual, material scripts, RTSS properties.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from engine.assets.material import MaterialAsset, TextureRef
from engine.core.findings import Findings
from engine.math.color import srgb_to_linear
from importers.model import ImportedMaterial, TextureUse
from importers.ogre.inheritance import Library
from importers.ogre.script import Node, Property
from importers.ogre.units import read_unit

#: properties that change nothing that we show, or whose value says what we do anyway
_HARMLESS = {
    "scheme", "lod_index", "lod_values", "lod_strategy", "receive_shadows", "gpu_vendor_rule", "gpu_device_rule",
    "max_lights", "start_light", "iteration", "shading", "illumination_stage", "normalise_normals", "light_scissor",
    "light_clip_planes", "transparent_sorting", "cull_software", "polygon_mode_overrideable", "fog_override",
    "shadow_caster_material", "shadow_receiver_material", "transparency_casts_shadows", "colour_write", "ambient",
}  # fmt: skip
_DEFAULTS = {
    ("depth_write", "on"), ("depth_check", "on"), ("depth_func", "less_equal"), ("cull_hardware", "clockwise"),
    ("polygon_mode", "solid"), ("lighting", "on"), ("depth_bias", "0"), ("point_sprites", "off"),
    ("alpha_to_coverage", "off"),
}  # fmt: skip
_READ = {
    "diffuse", "specular", "emissive", "self_illumination", "shininess", "alpha_rejection", "scene_blend",
    "separate_scene_blend", "cull_hardware", "lighting",
}  # fmt: skip
_PROGRAMS = ("fragment_program_ref", "vertex_program_ref", "geometry_program_ref")
_NORMAL_NAME = re.compile(r"(?:^|[_\-. ])(?:n|nm|nh|nrm|norm|normal|normals|normalmap|normalheight|bump)$|normal", re.I)
#: variables of the ready-made PBR parents that come with Ogre -> slot and role
_PBR_VARIABLES = {
    "$albedo": ("base_color_map", "color"), "$normal": ("normal_map", "normal"),
    "$emissive": ("emissive_map", "color"), "$metalroughness": ("metal_rough_map", "metal_rough"),
    "$ambientocclusion": ("occlusion_map", "occlusion"),
}  # fmt: skip

#: name of a texture, place in the source -> number of the image, or None (a finding says why)
FindImage = Callable[[str, str], int | None]


@dataclass(slots=True)
class Mapped:
    """`vertex_color`: the material shows the mesh's vertex colours."""

    material: ImportedMaterial
    vertex_color: bool = False


@dataclass(slots=True)
class _Mapping:
    library: Library
    aliases: Mapping[str, str]
    find: FindImage
    findings: Findings
    where: str
    result: ImportedMaterial
    unused: dict[str, None] = field(default_factory=dict)
    vertex_color: bool = False

    def unknown(self, what: str) -> None:
        self.unused.setdefault(what)


def default_material(name: str) -> ImportedMaterial:
    """What Ogre draws without a script: white, without a highlight."""
    asset = MaterialAsset(name)
    asset.params |= {"metallic": 0.0, "roughness": 1.0}
    return ImportedMaterial(asset)


def map_material(
    node: Node, name: str, aliases: Mapping[str, str], library: Library, find: FindImage, findings: Findings
) -> Mapped:
    """The material `node`, resolved, as one of ours called `name`. `aliases`: the mesh's textures by alias."""
    m = _Mapping(library, aliases, find, findings, f"material {name!r}", default_material(name))
    for prop in node.properties:
        if prop.name in ("set_texture_alias", "texture_alias") and len(prop.values) == 2:
            m.aliases = {prop.values[0]: prop.values[1], **m.aliases}
    technique = _technique(node, m)
    if technique is None:
        _pbr_variables(node, m)
    else:
        passes = [p for p in technique.of("pass") if p.properties or p.children] or technique.of("pass")
        if passes:
            main = next((p for p in passes if _is_lit(p)), passes[0])
            _values(main, passes[0], m)
            _textures([main, *(p for p in passes if p is not main)], m)
            if len(passes) > 1:
                m.unknown(f"{len(passes)} passes (made one)")
    _finish(m)
    return Mapped(m.result, m.vertex_color)


def _technique(node: Node, m: _Mapping) -> Node | None:
    """The first technique of the default scheme that needs no program of its own, or else the first."""
    techniques = node.of("technique")

    def scheme(technique: Node) -> str:
        found = technique.get("scheme")
        return found.values[0].lower() if found and found.values else "default"

    plain = [t for t in techniques if scheme(t) == "default"] or techniques
    if len(techniques) > 1:
        m.unknown(f"{len(techniques)} techniques (one is taken)")

    def programs(technique: Node) -> bool:
        return any(child.kind in _PROGRAMS for p in technique.of("pass") for child in p.children)

    return next((t for t in plain if not programs(t)), plain[0] if plain else None)


def _is_lit(node: Node) -> bool:
    """Whether a pass shows the material itself: not one that only lays down ambient light."""
    lights, diffuse = node.get("max_lights"), node.get("diffuse")
    black = diffuse is not None and not any(_numbers(diffuse.values[:3], 3, 0.0))
    return not (lights is not None and lights.values[:1] == ("0",)) and not (black and node.get("emissive") is None)


# --- values ---


def _values(node: Node, first: Node, m: _Mapping) -> None:
    asset = m.result.asset
    params = asset.params
    for prop in node.properties:
        value = " ".join(prop.values).lower()
        known = prop.name in _READ or prop.name in _HARMLESS or (prop.name, value) in _DEFAULTS
        if not known:
            m.unknown(f"{prop.name} {value}".strip()[:60])
    lit = _word(node, "lighting", "on") != "off"
    if not lit:
        asset.features.append("unlit")
    diffuse = node.get("diffuse")
    if not lit:
        # without lighting Ogre shows vertex colours and textures only
        m.vertex_color = True
    elif diffuse is not None:
        if diffuse.values[:1] == ("vertexcolour",):
            m.vertex_color = True
        else:
            params["base_color"] = _color4(diffuse)
    _specular(node, m)
    _emission(node, m)
    cull = _word(node, "cull_hardware", "clockwise")
    if cull == "none":
        asset.features.append("double_sided")
    elif cull == "anticlockwise":
        m.unknown("cull_hardware anticlockwise")
    _alpha(node, first, m)


def _specular(node: Node, m: _Mapping) -> None:
    params = m.result.asset.params
    specular, shininess = node.get("specular"), node.get("shininess")
    color, exponent = (0.0, 0.0, 0.0), 0.0
    if specular is not None and specular.values[:1] == ("vertexcolour",):
        m.unknown("specular vertexcolour")
        exponent = _numbers(specular.values[1:2], 1, 0.0)[0]
        color = (1.0, 1.0, 1.0)
    elif specular is not None:
        numbers = _numbers(specular.values[:5], max(min(len(specular.values), 5), 3), 0.0)
        color = (numbers[0], numbers[1], numbers[2])
        exponent = numbers[-1] if len(numbers) > 3 else 0.0
    if shininess is not None:
        exponent = _numbers(shininess.values[:1], 1, 0.0)[0]
    stages = _stages(node)
    if "metal_roughness" in stages:
        if len(stages["metal_roughness"]) >= 2:
            params |= {"metallic": 1.0, "roughness": 1.0}
        else:
            params |= {"roughness": _clamp(color[0]), "metallic": _clamp(color[1])}
        return
    strength = max(color)
    if strength > 0:
        params["roughness"] = roughness_of(exponent)
        if strength < 1:
            params["specular"] = strength
        if min(color) < strength:
            params["specular_color"] = tuple(_linear(_clamp(c / strength)) for c in color)


def roughness_of(exponent: float) -> float:
    """Perceptual roughness of a Blinn-Phong exponent (see the module)."""
    return float((2.0 / (max(exponent, 0.0) + 2.0)) ** 0.25)


def _emission(node: Node, m: _Mapping) -> None:
    emissive = node.get("emissive", "self_illumination")
    if emissive is None:
        return
    if emissive.values[:1] == ("vertexcolour",):
        m.unknown("emissive vertexcolour")
        return
    color = [_linear(max(c, 0.0)) for c in _numbers(emissive.values[:3], 3, 0.0)]
    if any(color):
        strength = max(1.0, *color)
        m.result.asset.params["emissive"] = tuple(c / strength for c in color)
        if strength > 1:
            m.result.asset.params["emissive_strength"] = strength


def _alpha(node: Node, first: Node, m: _Mapping) -> None:
    asset = m.result.asset
    blend = first.get("scene_blend", "separate_scene_blend")
    kind = " ".join(blend.values[:2]).lower() if blend is not None else "replace"
    if kind in ("alpha_blend", "src_alpha one_minus_src_alpha", "alpha_blend alpha_blend", "one one_minus_src_alpha"):
        asset.queue = "transparent"
    elif kind not in ("replace", "one zero", "replace replace"):
        asset.queue = "transparent"
        m.unknown(f"scene_blend {kind} (drawn as alpha_blend)")
    test = node.get("alpha_rejection")
    if test is None or not test.values or test.values[0].lower() == "always_pass":
        return
    function = test.values[0].lower()
    value = _numbers(test.values[1:2], 1, 0.0)[0]
    if function not in ("greater", "greater_equal"):
        m.unknown(f"alpha_rejection {function}")
        return
    if asset.queue == "transparent":
        m.unknown("alpha_rejection with scene_blend")
        return
    asset.queue = "alpha_test"
    # alpha has 8 bits: above v means v + 1 or more, and half a step lower is safe from rounding
    asset.params["alpha_cutoff"] = _clamp((value + (0.5 if function == "greater" else 0.0)) / 255.0)


# --- textures ---


def _stages(node: Node) -> dict[str, tuple[str, ...]]:
    """The lighting stages of a pass's rtshader_system: name -> what follows."""
    result: dict[str, tuple[str, ...]] = {}
    for system in node.of("rtshader_system"):
        for prop in system.properties:
            if prop.name == "lighting_stage" and prop.values:
                result[prop.values[0]] = prop.values[1:]
    return result


def _textures(passes: list[Node], m: _Mapping) -> None:
    slots = m.result.asset.textures
    for number, node in enumerate(passes):
        programs = any(child.kind in _PROGRAMS for child in node.children)
        if programs and number == 0:
            m.unknown("its own GPU programs")
        late_add = any(
            p.values[:1] == ("late_add_blend",)
            for system in node.of("rtshader_system") for p in system.properties if p.name == "texturing_stage"
        )  # fmt: skip
        for unit_node in node.of("texture_unit"):
            unit = read_unit(unit_node, m.aliases, m.library)
            for what in unit.unused:
                m.unknown(what)
            if not unit.texture:
                continue
            if unit.normal_space:
                if unit.normal_space != "tangent_space":
                    m.unknown(f"normal_map {unit.normal_space}")
                else:
                    _fill(m, "normal_map", "normal", unit.texture, unit.reference)
            elif "base_color_map" not in slots and unit.operation != "add":
                _fill(m, "base_color_map", "color", unit.texture, unit.reference)
            elif unit.operation == "add" and (late_add or re.search(r"emissi|glow|illum", unit.texture, re.I)):
                if _fill(m, "emissive_map", "color", unit.texture, unit.reference):
                    m.result.asset.params["emissive"] = (1.0, 1.0, 1.0)
            elif programs and "normal_map" not in slots and _NORMAL_NAME.search(unit.texture.rpartition(".")[0]):
                if _fill(m, "normal_map", "normal", unit.texture, unit.reference):
                    m.findings.info(
                        "ogre.guess", f"{unit.texture!r} is taken for a normal map, by its name", m.where,
                        "the material's own program decides in Ogre",
                    )  # fmt: skip
            else:
                m.unknown(f"texture {unit.texture} ({unit.operation or 'modulate'})")
        for stage, values in _stages(node).items():
            _stage_texture(stage, values, m)
        for system in node.of("rtshader_system"):
            for prop in system.properties:
                if prop.name not in ("lighting_stage", "texturing_stage"):
                    m.unknown(f"{prop.name} {' '.join(prop.values)}"[:60])


def _stage_texture(stage: str, values: tuple[str, ...], m: _Mapping) -> None:
    if stage == "metal_roughness":
        if len(values) >= 2 and values[0] == "texture":
            _fill(m, "metal_rough_map", "metal_rough", values[1], TextureRef(""))
    elif stage == "normal_map" and values:
        if len(values) > 1 and values[1] != "tangent_space":
            m.unknown(f"normal_map {values[1]}")
        else:
            _fill(m, "normal_map", "normal", values[0], TextureRef(""))
    elif stage not in ("per_pixel", "ffp"):
        m.unknown(f"lighting_stage {stage}"[:60])


def _pbr_variables(node: Node, m: _Mapping) -> None:
    """A child of Ogre's own PBR materials, whose scripts are not at hand: its variables say enough."""
    for variable, texture in sorted(node.variables.items()):
        slot = _PBR_VARIABLES.get(variable.lower())
        if slot is not None and texture:
            _fill(m, slot[0], slot[1], texture, TextureRef(""))
    slots = m.result.asset.textures
    if not slots:
        m.findings.warn("ogre.material", "has no technique; drawn white", m.where)
        return
    if "metal_rough_map" in slots:
        m.result.asset.params |= {"metallic": 1.0, "roughness": 1.0}
    if "emissive_map" in slots:
        m.result.asset.params["emissive"] = (1.0, 1.0, 1.0)
    m.findings.info(
        "ogre.guess", f"its textures are taken from its variables: {', '.join(sorted(slots))}", m.where,
        "put the parent's script beside it for certainty",
    )  # fmt: skip


def _fill(m: _Mapping, slot: str, role: str, texture: str, reference: TextureRef) -> bool:
    """Show `texture` in `slot`, if that is free. A texture that is not there leaves the slot wanted but missing."""
    if slot in m.result.asset.textures:
        m.unknown(f"texture {texture} (a second {slot})")
        return False
    m.result.asset.textures[slot] = reference
    number = m.find(texture, m.where)
    if number is not None:
        m.result.images[slot] = TextureUse(number, role)
    return True


def _finish(m: _Mapping) -> None:
    """Keep the coverage of alpha-tested mips, and tell what was not understood."""
    asset, use = m.result.asset, m.result.images.get("base_color_map")
    alpha = asset.params.get("base_color", (1, 1, 1, 1))[3]
    cutoff = asset.params.get("alpha_cutoff", 0.0)
    if use is not None and asset.queue == "alpha_test" and 0 < cutoff < alpha:
        m.result.images["base_color_map"] = replace(use, alpha_cutoff=float(cutoff / alpha))
    if m.unused:
        listed = list(m.unused)
        more = f" and {len(listed) - 12} more" if len(listed) > 12 else ""
        m.findings.info("ogre.material", f"not shown: {', '.join(listed[:12])}{more}", m.where)


# --- small things ---


def _word(node: Node, name: str, default: str) -> str:
    found = node.get(name)
    return found.values[0].lower() if found and found.values else default


def _numbers(words: tuple[str, ...], count: int, default: float) -> list[float]:
    """`count` finite numbers; words that are none count as `default`."""
    result = []
    for k in range(count):
        try:
            value = float(words[k])
        except (IndexError, ValueError):
            value = default
        result.append(value if math.isfinite(value) else default)
    return result


def _clamp(value: float) -> float:
    return min(max(value, 0.0), 1.0)


def _linear(value: float) -> float:
    return float(srgb_to_linear(value))


def _color4(prop: Property) -> tuple[float, float, float, float]:
    r, g, b = (_linear(_clamp(v)) for v in _numbers(prop.values[:3], 3, 1.0))
    return r, g, b, _clamp(_numbers(prop.values[3:4], 1, 1.0)[0])
