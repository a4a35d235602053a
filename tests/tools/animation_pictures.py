"""Pictures of the editor's animation tools on a character: timeline, dope sheet, curves, onion skin, masks, root
motion, blend spaces, state graph, skeleton, weights, morph targets. In a real window; a virtual one without a display.

python -m tests.tools.animation_pictures --out DIR [--scene FILE]
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

from tests.support.ui_scripts import FOLDER, on_display

ASSETS = Path(os.environ.get("LUCARNA_ASSETS", Path(__file__).resolve().parents[2].parent / "shared" / "assets"))
#: what is shown without --scene, where it is there
PREFERRED = ASSETS / "ogre" / "models" / "ninja.mesh"


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="tests.tools.animation_pictures", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures")
    parser.add_argument(
        "--scene", type=Path, help="an animated model or scene; default: ninja.mesh, else a test figure"
    )
    args = parser.parse_args(arguments)
    scene = args.scene or (PREFERRED if PREFERRED.is_file() else None)
    args.out.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, str(FOLDER / "animation_window_ui.py"), str(args.out.resolve())]
    command += [str(scene.resolve())] if scene is not None else []
    done = subprocess.run(on_display(command), capture_output=True, text=True, check=False)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if not lines:
        print(f"it did not finish:\n{done.stderr[-3000:]}", file=sys.stderr)
        return 3
    seen = json.loads(lines[-1])
    for name in seen["pictures"]:
        print(args.out / f"{name}.png")
    if seen["error"]:
        print(seen["error"], file=sys.stderr)
    return 1 if seen["error"] else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
