"""Opening anything: a project, a scene, a source file. The one door of the CLI, the editor and the player."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from engine.app.project import load_project
from engine.app.runtime import Runtime
from engine.assets.scene import EnvironmentAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from importers.cache import scene_for
from importers.project.move_log import recover_around, told
from importers.settings import ImportSettings


def scene_path(
    path: Path, settings: ImportSettings, progress: Callable[[str, float], None] | None = None
) -> tuple[Path, Findings]:
    """The `*.scene.json` of a project folder, a scene or a source (converted through the cache), and what was noticed.

    Raises InputError when there is nothing to open, FormatError when the source is no sound file.
    """
    put_back = recover_around(path)
    if not path.exists():
        raise InputError("there is no such file or folder", where=path)
    if path.is_dir() or path.name == "project.toml":
        path = load_project(path).start
    scene, findings = scene_for(path, settings=settings, progress=progress)
    if put_back:
        findings.warn("project.interrupted-move", told(put_back), "", "move it again")
    return scene, findings


def baker_for(base: Path) -> Callable[[EnvironmentAsset], Path]:
    """Bakes environments (images relative to `base`) into the user's cache."""

    def bake(environment: EnvironmentAsset) -> Path:
        from importers.textures.environment import environment_file  # only scenes that need it pay for it

        return environment_file(environment, base)

    return bake


def open_path(
    runtime: Runtime, path: Path, *, settings: ImportSettings | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Findings:  # fmt: skip
    """Open `path` in `runtime`. Returns what import and load noticed; on an error the open scene stays."""
    scene, findings = scene_path(path, settings or ImportSettings(), progress)
    runtime.open(scene, baker=baker_for(scene.parent), root=path if path.is_dir() else path.parent)
    findings.items.extend(runtime.findings)
    return findings
