"""A `texture_unit`: which image it shows and how it is sampled.

Source: Ogre manual, material scripts (texture units); the uv transform is scale about the centre, scroll, then rotation
about the centre.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from engine.assets.material import TextureRef
from importers.ogre.inheritance import Library
from importers.ogre.script import Node

_WRAPS = {"wrap": "repeat", "clamp": "clamp", "mirror": "mirror", "border": "clamp"}
_HARMLESS = {
    "max_anisotropy", "mipmap_bias", "colour_op_multipass_fallback", "binding_type", "texture_alias", "alpha_op_ex",
    "tex_border_colour", "unordered_access_mip", "content_type", "num_mipmaps", "gamma", "compare_test",
}  # fmt: skip
_READ = {
    "texture", "anim_texture", "cubic_texture", "tex_coord_set", "tex_address_mode", "filtering", "scale", "scroll",
    "rotate", "colour_op", "colour_op_ex", "env_map", "sampler_ref", "transform",
}  # fmt: skip


@dataclass(slots=True)
class Unit:
    """`texture`: the image's name, '' where there is none to show. `operation`: how it is put on what is below.
    `normal_space`: it is a normal map in that space. `unused`: what could not be understood."""

    texture: str
    reference: TextureRef
    operation: str = ""
    normal_space: str = ""
    unused: list[str] = field(default_factory=list)


def read_unit(node: Node, aliases: Mapping[str, str], library: Library) -> Unit:
    """The unit `node`; `aliases` replace the textures of units by alias or name."""
    unit = Unit(_texture(node), TextureRef(""))
    alias = node.get("texture_alias")
    for name in (alias.values[0] if alias and alias.values else "", node.name):
        if name and name in aliases:
            unit.texture = aliases[name]
            break
    sampler = node.get("sampler_ref")
    sources = [node]
    if sampler is not None:
        found = library.find("sampler", " ".join(sampler.values))
        sources = [*(library.resolve(f, []) for f in found[:1]), node]
    for source in sources:
        _sampling(source, unit)
    _transform(node, unit)
    _meaning(node, unit)
    for prop in node.properties:
        if prop.name not in _READ and prop.name not in _HARMLESS:
            unit.unused.append(f"{prop.name} {' '.join(prop.values)}"[:60].strip())
    for system in node.of("rtshader_system"):
        for prop in system.properties:
            if prop.name == "normal_map":
                unit.normal_space = prop.values[0].lower() if prop.values else "tangent_space"
            else:
                unit.unused.append(f"{prop.name} {' '.join(prop.values)}"[:60].strip())
    return unit


def _texture(node: Node) -> str:
    """The last image that the unit names; the first frame of an animated one."""
    found = node.get("texture", "anim_texture", "cubic_texture")
    if found is None or not found.values:
        return ""
    name = found.values[0]
    if found.name == "anim_texture" and len(found.values) == 3 and found.values[1].isdigit():
        stem, dot, extension = name.rpartition(".")
        return f"{stem}_0{dot}{extension}" if dot else f"{name}_0"
    return name


def _meaning(node: Node, unit: Unit) -> None:
    """What the unit is for; units that are no plain 2D image lose their texture."""
    found = node.get("texture", "anim_texture", "cubic_texture")
    reasons = []
    if found is not None:
        kinds = {value.lower() for value in found.values[1:]}
        if found.name == "cubic_texture" or "cubic" in kinds:
            reasons.append("cubic")
        if kinds & {"1d", "3d", "2darray"}:
            reasons.append("not 2D")
        if found.name == "anim_texture":
            unit.unused.append(f"anim_texture {found.values[0]} (its first frame is shown)" if found.values else "")
    env = node.get("env_map")
    if env is not None and env.values[:1] != ("off",):
        reasons.append(f"env_map {' '.join(env.values)}".strip())
    content = node.get("content_type")
    if content is not None and content.values[:1] != ("named",):
        reasons.append(f"content_type {' '.join(content.values)}".strip())
    if reasons:
        unit.unused.append(f"texture {unit.texture} ({', '.join(reasons)})".replace("  ", " "))
        unit.texture = ""
    operation = node.get("colour_op", "colour_op_ex")
    if operation is not None and operation.values:
        unit.operation = operation.values[0].lower()
        plain = operation.name == "colour_op" or set(operation.values[1:3]) <= {"src_texture", "src_current"}
        if unit.operation not in ("modulate", "replace", "add", "alpha_blend") or not plain:
            unit.unused.append(f"{operation.name} {' '.join(operation.values)}"[:60])


def _sampling(node: Node, unit: Unit) -> None:
    reference = unit.reference
    modes = node.get("tex_address_mode")
    if modes is not None and modes.values:
        names = [value.lower() for value in modes.values]
        names += names[:1] * (2 - len(names))
        reference.wrap_u, reference.wrap_v = (_WRAPS.get(name, "repeat") for name in names[:2])
        if "border" in names[:2]:
            unit.unused.append("tex_address_mode border (clamped)")
    filtering = node.get("filtering")
    if filtering is not None and filtering.values:
        values = [value.lower() for value in filtering.values]
        if len(values) >= 2:
            low, high = ("nearest" if value in ("none", "point") else "linear" for value in values[:2])
        else:
            low = high = "nearest" if values[0] == "none" else "linear"
        # Between mips always linear, unless there is no filter at all: "bilinear" is what every old script says
        reference.min_filter = "nearest_mip_nearest" if low == "nearest" else "linear_mip_linear"
        reference.mag_filter = high
    coordinates = node.get("tex_coord_set")
    if coordinates is not None and coordinates.values:
        number = coordinates.values[0]
        if number in ("0", "1"):
            reference.uv_set = int(number)
        else:
            unit.unused.append(f"tex_coord_set {number}")


def _transform(node: Node, unit: Unit) -> None:
    """uv' = R (S (uv - 1/2) + 1/2 + scroll - 1/2) + 1/2 with S = 1 / scale, R counter-clockwise in u, v; as offset,
    rotation and scale of a TextureRef, whose rotation runs the other way (its v points down)."""

    def pair(name: str, default: float) -> tuple[float, float]:
        found = node.get(name)
        words = found.values if found is not None else ()
        values = [default, default]
        for k, word in enumerate(words[:2]):
            try:
                number = float(word)
            except ValueError:
                continue
            values[k] = number if math.isfinite(number) and abs(number) < 1e6 else default
        return values[0], values[1]

    if node.get("transform") is not None:
        unit.unused.append("transform")
    (su, sv), (mu, mv) = pair("scale", 1.0), pair("scroll", 0.0)
    angle = math.radians(pair("rotate", 0.0)[0])
    if (su, sv, mu, mv, angle) == (1.0, 1.0, 0.0, 0.0, 0.0):
        return
    if su == 0 or sv == 0:
        unit.unused.append("scale 0")
        su, sv = su or 1.0, sv or 1.0
    kx, ky = 1 / su, 1 / sv
    # the point that (0, 0) goes to
    x, y = 0.5 - 0.5 * kx + mu - 0.5, 0.5 - 0.5 * ky + mv - 0.5
    c, s = math.cos(angle), math.sin(angle)
    unit.reference.offset = (c * x - s * y + 0.5, s * x + c * y + 0.5)
    unit.reference.rotation = -angle
    unit.reference.scale = (kx, ky)
