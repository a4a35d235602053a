"""Start Lucarna from a checkout: `python3 packaging/run.py [lucarna's arguments]`.

The first start sets everything up. Without arguments it makes a project from project_template/ in ./lucarna-sample
(LUCARNA_SAMPLE_DIR overrides; an existing one is kept) and opens the editor on it; on a machine without a display it
converts and renders that project and says where the pictures are.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import _interpreter  # first of ours: leaves when this Python is too old
import bootstrap

#: file name, and the arguments of `lucarna render` that make it
PICTURES = (
    ("orrery.png", ["--camera", "main"]),
    ("orrery-close.png", ["--camera", "close", "--time", "0.4"]),
)


def lucarna(setup: bootstrap.Setup, arguments: list[str]) -> int:
    """Run one command of Lucarna and return its exit code."""
    return subprocess.run([setup.script("lucarna"), *arguments], check=False).returncode


def become(setup: bootstrap.Setup, arguments: list[str]) -> int:
    """Hand over to Lucarna: its exit code, signals and terminal are the caller's."""
    command = [setup.script("lucarna"), *arguments]
    if os.name == "posix":
        sys.stdout.flush()
        os.execv(command[0], command)
    return subprocess.run(command, check=False).returncode


def sample_folder() -> Path:
    return Path(os.environ.get("LUCARNA_SAMPLE_DIR") or "lucarna-sample").absolute()


def render_sample(setup: bootstrap.Setup, sample: Path) -> int:
    """Without a display: convert the sample and make its pictures in `sample`/out."""
    out = sample / "out"
    code = lucarna(setup, ["convert", str(sample / "assets" / "orrery.glb"), "--out", str(out)])
    if code or sys.platform == "darwin":
        return code
    made = []
    for name, arguments in PICTURES:
        path = out / name
        code = lucarna(
            setup,
            ["render", str(out / "orrery.scene.json"), "--out", str(path), "--size", "1280x720", *arguments],
        )
        if code:
            print("No picture: `python3 packaging/run.py doctor` says what this machine lacks.", file=sys.stderr)
            return code
        made.append(path)
    print("There is no display, so the editor stays closed. The sample project and its pictures:")
    for path in (sample, *made):
        print(f"  {path}")
    return 0


def prepare() -> bootstrap.Setup:
    """Lucarna with all optional packages; without them where one of them cannot be installed. Raises SetupError."""
    try:
        return bootstrap.prepare(extras=("full",), tests=False)
    except bootstrap.SetupError as error:
        bootstrap.say(f"the optional packages could not be installed, so they are left out: {error}")
        return bootstrap.prepare(extras=(), tests=False)


def main(arguments: list[str]) -> int:
    _interpreter.require()
    try:
        setup = prepare()
    except bootstrap.SetupError as error:
        bootstrap.say(str(error))
        return 3
    if arguments:
        return become(setup, arguments)
    sample = sample_folder()
    if not (sample / "project.toml").is_file():
        code = lucarna(setup, ["new", str(sample)])
        if code:
            return code
    if bootstrap.has_display() and sys.platform != "darwin":
        return become(setup, ["edit", str(sample)])
    return render_sample(setup, sample)


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
