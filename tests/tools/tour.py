"""The tour in pictures: the first five minutes of a new user, walked through in a real window (a virtual one without a
display), written as small pictures and a page.

python -m tests.tools.tour [--out docs/tour]
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from engine.core.atomic import atomic_path, write_text
from tests.support.ui_scripts import FOLDER, on_display

ROOT = Path(__file__).resolve().parents[2]
WIDTH, QUALITY = 960, 80
#: step -> (what one does, what one sees)
STEPS = {
    "welcome": ("Start `lucarna edit`", "An orrery that turns, and one card: mouse and keys, size, colours."),
    "dropped": ("Drop a folder on the window", "The model, and what came in: size in metres, parts, clips, warnings."),
    "view-normals": ("Press 2 to 9", "One input of the shading after the other; 1 is the lit picture again."),
    "light-turned": ("Shift + right drag", "The light goes round; Ctrl+Z takes it back."),
    "wiped": (
        "Ctrl+\\ takes a state, Shift+\\ wipes it over the present one",
        "With FLIP, the largest difference and milliseconds. \\ held down shows what was before.",
    ),
    "shader-broken": ("Open the effect, break a line", "The line is marked, the last good picture stays."),
    "blended": ("Two clips, one slider", "Walk and run by speed, in step."),
    "command-copied": ("Ctrl+Shift+C", "The same picture as a command line, for a script or CI."),
}


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="tests.tools.tour", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "tour", help="folder for page and pictures")
    args = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix="lucarna-tour-") as name:
        folder = Path(name)
        places = {"LUCARNA_CACHE": str(folder / "cache"), "LUCARNA_CONFIG": str(folder / "config")}
        command = on_display([sys.executable, str(FOLDER / "first_minutes_ui.py"), str(folder / "walk")])
        done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **places})
        lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
        seen = json.loads(lines[-1]) if lines else {"error": done.stderr[-3000:]}
        if seen["error"]:
            print(seen["error"], file=sys.stderr)
            return 3
        args.out.mkdir(parents=True, exist_ok=True)
        for number, shot in enumerate(seen["shots"], 1):
            shrink(folder / "walk" / f"{number:02d}-{shot}.png", args.out / f"{number:02d}-{shot}.jpg")
    write_text(args.out / "README.md", page(seen["shots"]))
    print(args.out / "README.md")
    return 0


def shrink(source: Path, target: Path) -> None:
    """A picture of the window, WIDTH pixels wide, as JPEG."""
    with Image.open(source) as image, atomic_path(target) as temporary:
        height = round(image.height * WIDTH / image.width)
        small = image.convert("RGB").resize((WIDTH, height), Image.Resampling.LANCZOS)
        small.save(temporary, format="JPEG", quality=QUALITY, optimize=True, subsampling=0)


def page(shots: list[str]) -> str:
    """The tour as markdown. Raises KeyError for a step that has no words."""
    lines = ["# The first five minutes", "", "Made by `python -m tests.tools.tour` from the editor's own window.", ""]
    for number, shot in enumerate(shots, 1):
        does, sees = STEPS[shot]
        lines += [f"## {number}. {does}", "", sees, "", f"![{does}]({number:02d}-{shot}.jpg)", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
