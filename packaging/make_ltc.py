"""Makes the table of fitted lobes for area lights: `.venv/bin/python packaging/make_ltc.py [OUT.dds] [SIZE]`.

    engine.math.ltc.fit_table (float64, minutes) ─> rgba16f ─> shaders/data/ltc.dds

The same NumPy gives the same bytes. Size and format were chosen by the experiment `area_lights`.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[1]
if str(ROOT) not in sys.path:
    sys.path.append(str(ROOT))

from engine.assets.dds import write_dds  # noqa: E402  (found through the line above)
from engine.assets.texture import TextureAsset  # noqa: E402  (needs the path above)
from engine.math import ltc  # noqa: E402  (needs the path above)

OUT = ROOT / "shaders" / "data" / "ltc.dds"
SIZE = 64


def texture_of(table: NDArray[np.float64]) -> TextureAsset:
    """The table as the file holds it."""
    size = len(table)
    extras: dict[str, object] = {"content": "ggx-ltc", "x": "sqrt(1 - n_dot_v)", "y": "perceptual_roughness"}
    return TextureAsset("rgba16f", size, size, [[table.astype("<f2").tobytes()]], extras=extras)


def main(arguments: Sequence[str]) -> int:
    out = Path(arguments[0]) if arguments else OUT
    size = int(arguments[1]) if len(arguments) > 1 else SIZE
    write_dds(out, texture_of(ltc.fit_table(size)))
    print(f"{out}: {size} x {size}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
