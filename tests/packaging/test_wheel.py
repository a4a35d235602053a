"""The wheel holds everything that runs, nothing else, and works where there is no checkout."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("hatchling", reason="hatchling builds the wheel; packaging/test.py installs it")
    folder = tmp_path_factory.mktemp("wheel")
    done = subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    (path,) = folder.glob("lucarna-*.whl")
    return path


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel unpacked, as pip would do it; a pure wheel needs no more."""
    folder = tmp_path_factory.mktemp("site")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


def run(installed: Path, cwd: Path, code: str) -> subprocess.CompletedProcess[str]:
    """Run `code` with the unpacked wheel before this checkout on the path."""
    environment = {**os.environ, "PYTHONPATH": str(installed), "LUCARNA_CACHE": str(cwd / "cache")}
    command = [sys.executable, "-c", code]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)


def test_the_wheel_is_complete(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    for source in ("engine", "importers", "editor"):
        for path in (ROOT / source).rglob("*.py"):
            assert path.relative_to(ROOT).as_posix() in names
    for data in ("shaders", "project_template"):
        for path in (ROOT / data).rglob("*"):
            if path.is_file():
                assert f"lucarna_data/{path.relative_to(ROOT).as_posix()}" in names
    tops = {name.split("/")[0] for name in names}
    assert {t for t in tops if not t.endswith(".dist-info")} == {"engine", "importers", "editor", "lucarna_data"}
    assert any(name.endswith("licenses/LICENSE") for name in names)


def test_the_data_is_found(installed: Path, tmp_path: Path) -> None:
    code = "from engine.core.paths import shaders_dir, template_dir; print(shaders_dir()); print(template_dir())"
    done = run(installed, tmp_path, code)
    assert done.returncode == 0, done.stderr
    shaders, template = map(Path, done.stdout.splitlines())
    assert shaders == installed / "lucarna_data" / "shaders"
    assert (template / "project.toml").is_file()


def test_it_works_without_a_checkout(installed: Path, tmp_path: Path) -> None:
    """A project, and its conversion, from the wheel alone."""
    code = (
        "import sys; from importers.cli.main import main;"
        "sys.exit(main(['new', 'project']) or main(['convert', 'project/assets/orrery.glb', '--out', 'out',"
        " '--preset', 'draft', '--max-texture-size', '32']))"
    )
    done = run(installed, tmp_path, code)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "out" / "orrery.scene.json").is_file()
    assert (tmp_path / "project" / ".gitignore").is_file()
