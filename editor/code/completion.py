"""What could be meant at the cursor of a shader file."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from engine.materials.effect import Effect

_INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]*)$')
_WORD = re.compile(r"[A-Za-z_]\w*$")
_MEMBER = re.compile(r"\bm\.(\w*)$")

#: of GLSL, what a surface shader is made of
BUILT_IN = [
    "abs",
    "acos",
    "asin",
    "atan",
    "ceil",
    "clamp",
    "cos",
    "cross",
    "dFdx",
    "dFdy",
    "degrees",
    "discard",
    "distance",
    "dot",
    "exp",
    "exp2",
    "faceforward",
    "floor",
    "fract",
    "fwidth",
    "inverse",
    "inversesqrt",
    "length",
    "log",
    "log2",
    "mat3",
    "mat4",
    "max",
    "min",
    "mix",
    "mod",
    "normalize",
    "pow",
    "radians",
    "reflect",
    "refract",
    "return",
    "round",
    "sign",
    "sin",
    "smoothstep",
    "sqrt",
    "step",
    "tan",
    "texelFetch",
    "texture",
    "textureLod",
    "textureSize",
    "transpose",
    "uint",
    "uvec2",
    "uvec3",
    "uvec4",
    "vec2",
    "vec3",
    "vec4",
    "ivec2",
    "ivec3",
    "ivec4",
    "bvec2",
    "float",
    "int",
    "bool",
    "const",
    "struct",
    "uniform",
    "in",
    "out",
    "inout",
    "layout",
    "location",
    "flat",
    "gl_FragCoord",
    "gl_FrontFacing",
    "gl_Position",
    "gl_VertexID",
    "gl_InstanceID",
]


def completions(before: str, text: str, includes: Sequence[str], effects: Iterable[Effect]) -> tuple[str, list[str]]:
    """(what is typed of it, candidates) for the cursor after `before` in its line of the file `text`."""
    include = _INCLUDE.match(before)
    if include:
        return include[1], _ranked(include[1], includes)
    member = _MEMBER.search(before)
    if member:
        return member[1], _ranked(member[1], (p.name for effect in effects for p in effect.params))
    word = _WORD.search(before)
    typed = word[0] if word else ""
    known: list[str] = []
    for effect in effects:
        known += [name.upper() for name in effect.features]
        known += [f"sample_{slot.name}" for slot in effect.textures]
        known += [p.name for p in effect.params]
    own = set(re.findall(r"[A-Za-z_]\w{2,}", text)) - {typed}
    return typed, _ranked(typed, [*known, *sorted(own), *BUILT_IN])


def include_names(search: Sequence[Path]) -> list[str]:
    """All files that can be included, as they are written in an #include."""
    found: dict[str, None] = {}
    for folder in search:
        for file in sorted(folder.glob("*/*.glsl")):
            found.setdefault(file.relative_to(folder).as_posix())
    return list(found)


def _ranked(typed: str, names: Iterable[str]) -> list[str]:
    """Those that begin with what is typed, then those that hold it; each once."""
    lowered = typed.lower()
    unique = list(dict.fromkeys(n for n in names if n != typed))
    starts = [n for n in unique if n.lower().startswith(lowered)]
    holds = [n for n in unique if lowered and lowered in n.lower() and n not in set(starts)]
    return starts + holds
