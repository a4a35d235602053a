"""A new project around a scene that code makes (engine.assets.samples)."""

from __future__ import annotations

import tempfile
from pathlib import Path

from engine.app.project import Project, new_project
from engine.assets.records import did_you_mean
from engine.assets.samples import CHARACTERS, SAMPLES
from engine.assets.samples.sample import DEFAULT_LIGHTS, make_sample, write_sample
from engine.core.errors import OutputError, UsageError

_PROJECT = """\
# A Lucarna project. Everything in assets/ is yours; .cache/ can be deleted at any time.

[project]
name = "{title}"
start = "assets/{name}.scene.json"  # the scene or source that opens first
engine = "0.0.0"                    # the version of Lucarna that wrote this project
"""
_README = """\
# {title}

{what}. Made by `lucarna new --sample {name}`: meshes, materials and motion come from code.

"""
_FILES = """
- `assets/{name}.scene.json`: one node a line; the lights are below the node `lights`.
- `assets/{name}.drift.lanim`: the clip that moves them.
"""
_CHARACTER = """
- `assets/{name}.scene.json`: one node a line.
- `assets/{name}.*.lanim`: its clips.
- `assets/{name}.animation.toml`: how they blend: a timeline, a blend space over the speed, masks and a layer.
"""


def new_sample_project(directory: Path, sample: str, *, lights: int | None = None) -> Project:
    """Make a project in `directory`, whole or not at all, that starts with one of SAMPLES or CHARACTERS.

    Raises UsageError for an unknown sample, a count of lights out of range or a folder in use; OutputError.
    """
    known = SAMPLES | CHARACTERS
    if sample not in known:
        names = ("orrery", *known)
        raise UsageError(
            f"there is no sample {sample!r}", hint=did_you_mean(sample, names) or f"samples: {', '.join(names)}"
        )
    if lights is not None and sample in CHARACTERS:
        raise UsageError(f"the sample {sample!r} has no lights to count", hint="leave out --lights")
    made = make_sample(sample, lights=DEFAULT_LIGHTS if lights is None else lights)
    texts = {"title": sample.capitalize(), "name": sample, "what": known[sample][1].capitalize()}
    try:
        with tempfile.TemporaryDirectory(prefix="lucarna-sample-") as folder:
            template = Path(folder)
            (template / "assets").mkdir()
            write_sample(made, template / "assets")
            (template / "project.toml").write_text(_PROJECT.format(**texts), encoding="utf-8", newline="\n")
            readme = (_README + (_CHARACTER if sample in CHARACTERS else _FILES).lstrip("\n")).format(**texts)
            (template / "README.md").write_text(readme, encoding="utf-8", newline="\n")
            return new_project(directory, template=template)
    except OSError as error:
        raise OutputError(f"cannot make the sample: {error.strerror or error}", where=directory) from error
