"""Whether a font has the glyphs of a text: what it draws for them is not what it draws for what it lacks."""

from __future__ import annotations

from pathlib import Path

#: no font has a glyph for it: it is no character
_NOWHERE = "\uffff"


def lacking(path: Path, index: int, text: str) -> str | None:
    """The characters of `text` that face `index` of the font draws as missing, each once; None where the file is no
    font."""
    from PIL import ImageFont

    try:
        font = ImageFont.truetype(str(path), 32, index=index)
        missing = bytes(font.getmask(_NOWHERE))
        return "".join(c for c in dict.fromkeys(text) if not c.isspace() and bytes(font.getmask(c)) == missing)
    except (OSError, ValueError):
        return None
