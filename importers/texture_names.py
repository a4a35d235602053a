"""What a texture's file name says: whose it is, and what it holds.

wall_brick_NormalDX_2k.png -> base "wall brick", role normal (green pointing down)
"""

from __future__ import annotations

import re
from dataclasses import dataclass

#: the last words of a name -> what the image holds; two words first
_SUFFIXES: dict[str, str] = {}
for _role, _words in (
    ("color", "albedo basecolor base+color diffuse diff color colour col alb bc d"),
    ("normal", "normal normals nrm norm nor normalgl normal+gl nor+gl nrm+gl normalopengl n"),
    ("normal_dx", "normaldx normal+dx nor+dx nrm+dx normaldirectx"),
    ("rough", "roughness rough rgh r"),
    ("gloss", "glossiness gloss smoothness smooth"),
    ("metal", "metallic metalness metal mtl met m"),
    ("orm", "orm arm ao+rough+metal occlusionroughnessmetallic aorm"),
    ("metal_rough", "metallicroughness metal+rough roughmet rough+met rm"),
    ("occlusion", "ao occlusion ambientocclusion ambient+occlusion occ"),
    ("emissive", "emissive emission emit emis glow e"),
    ("height", "height displacement disp bump h"),
    ("opacity", "opacity alpha mask transparency"),
):  # fmt: skip
    _SUFFIXES |= dict.fromkeys(_words.split(), _role)

#: six faces of a cube by the last word of their names, in the order +x -x +y -y +z -z
FACES = (
    ("px", "posx", "right", "rt", "xpos", "x+", "+x"), ("nx", "negx", "left", "lf", "lt", "xneg", "x-", "-x"),
    ("py", "posy", "top", "up", "ypos", "y+", "+y"), ("ny", "negy", "bottom", "dn", "down", "yneg", "y-", "-y"),
    ("pz", "posz", "front", "ft", "fr", "zpos", "z+", "+z"), ("nz", "negz", "back", "bk", "zneg", "z-", "-z"),
)  # fmt: skip
_SIZE = re.compile(r"(\d{1,2}k|\d{3,5}|\d{3,5}x\d{3,5})$")
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+[kK]?(?:x\d+)?|[+-](?=[xyzXYZ]$)|[xyzXYZ][+-]$")


@dataclass(frozen=True, slots=True)
class TextureName:
    """`base`: without its suffix, words joined by spaces, lower case. `role`: "" where the suffix says none."""

    base: str
    role: str
    suffix: str = ""


def words_of(stem: str) -> list[str]:
    """Lower-case words of a name: parted at separators and at humps."""
    parts = [part for part in re.split(r"[\s_.\-()\[\]]+", stem) if part]
    return [word.lower() for part in parts for word in _WORDS.findall(part)] or [stem.lower()]


def read_name(stem: str) -> TextureName:
    """What the name of an image file (without its extension) says."""
    words = words_of(stem)
    while len(words) > 1 and _SIZE.match(words[-1]):
        words.pop()
    for count in (3, 2, 1):
        if len(words) > count:
            for tail in ("+".join(words[-count:]), "".join(words[-count:])):
                # a letter alone is a suffix only where a separator stands before it
                if tail in _SUFFIXES and (
                    len(tail) > 1 or re.search(r"[\s_.\-]" + tail + r"(?:[\s_.\-]\w+)?$", stem, re.I)
                ):
                    return TextureName(" ".join(words[:-count]), _SUFFIXES[tail], tail)
    return TextureName(" ".join(words), "")


def face_of(stem: str) -> tuple[str, int] | None:
    """(name without the face, number of the face) of a cube face's file name; None for others."""
    match = re.match(r"^(.*?)[\s_.\-]?([+-][xyz]|[xyz][+-]|[A-Za-z]+)$", stem)
    if match is None:
        return None
    tail = match[2].lower()
    for number, names in enumerate(FACES):
        if tail in names:
            return match[1], number
    return None


def plain(name: str) -> str:
    """A name as it is compared: letters and digits alone, without what only says that it is a material."""
    text = "".join(
        word for word in words_of(name) if word not in ("mat", "material", "mtl", "m", "mi", "sg", "tex", "t")
    )
    return re.sub(r"[^0-9a-z]", "", text)
