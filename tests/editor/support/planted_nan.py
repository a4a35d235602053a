"""An effect override with a bug in it: some pixels of every surface become NaN."""

from __future__ import annotations

from pathlib import Path

from engine.core.paths import shaders_dir

SOUND = "o_color = vec4(sanitise(color), 1.0);"
#: the square root of a negative number, in a small square of the target
BROKEN = (
    SOUND + " if (all(lessThan(abs(gl_FragCoord.xy - vec2({x}, {y})), vec2(2.0)))) o_color.g = sqrt(-1.0 - o_color.r);"
)


def plant_nan(folder: Path, x: float = 250.0, y: float = 180.0) -> None:
    """Put a broken copy of the surface shader beside a scene's files; (x, y) is the middle of the square of 4x4."""
    text = (shaders_dir() / "effects" / "surface.frag").read_text(encoding="utf-8")
    assert SOUND in text, "the shader has changed: plant this bug in another way"
    (folder / "effects").mkdir(parents=True, exist_ok=True)
    (folder / "effects" / "surface.frag").write_text(text.replace(SOUND, BROKEN.format(x=x, y=y)), encoding="utf-8")
