"""Setting up a checkout: when the stamp serves, when it does not, and what is said then."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

PACKAGING = Path(__file__).resolve().parents[2] / "packaging"

PYPROJECT = b"""
[build-system]
requires = ["hatchling"]
[project]
name = "x"
dependencies = ["numpy>=2"]
[tool.ruff]
line-length = 120
"""


def load(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """A script of packaging/ as a module under a name of its own (`test` and `run` are too common)."""
    monkeypatch.syspath_prepend(str(PACKAGING))
    spec = importlib.util.spec_from_file_location(f"lucarna_packaging_{name}", PACKAGING / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def bootstrap(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    return load("bootstrap", monkeypatch)


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout whose environment looks ready."""
    (tmp_path / "pyproject.toml").write_bytes(PYPROJECT)
    binaries = tmp_path / ".venv" / ("Scripts" if sys.platform == "win32" else "bin")
    binaries.mkdir(parents=True)
    (binaries / ("python.exe" if sys.platform == "win32" else "python")).write_bytes(b"")
    (tmp_path / ".venv" / "pyvenv.cfg").write_text("home = somewhere\nversion = 3.12.4\n")
    return tmp_path


def test_the_key_follows_what_is_installed_and_nothing_else(bootstrap: ModuleType, tmp_path: Path) -> None:
    key = bootstrap.install_key(PYPROJECT, "3.12.4", tmp_path)
    assert key == bootstrap.install_key(PYPROJECT, "3.12.4", tmp_path)
    assert key == bootstrap.install_key(PYPROJECT.replace(b"120", b"100"), "3.12.4", tmp_path), "a lint rule"
    assert key != bootstrap.install_key(PYPROJECT.replace(b"numpy>=2", b"numpy>=3"), "3.12.4", tmp_path)
    assert key != bootstrap.install_key(PYPROJECT.replace(b"hatchling", b"flit"), "3.12.4", tmp_path)
    assert key != bootstrap.install_key(PYPROJECT, "3.13.0", tmp_path)
    assert key != bootstrap.install_key(PYPROJECT, "3.12.4", tmp_path / "moved")


def test_a_stamp_with_more_extras_serves(bootstrap: ModuleType, tmp_path: Path) -> None:
    path = tmp_path / "stamp.json"
    assert bootstrap.read_stamp(path) == {}
    bootstrap.write_stamp(path, "k", ["dev"])
    stamp = bootstrap.read_stamp(path)
    assert bootstrap.is_current(stamp, "k", [])
    assert bootstrap.is_current(stamp, "k", ["dev"])
    assert not bootstrap.is_current(stamp, "other", [])
    bootstrap.write_stamp(path, "k", [])
    assert not bootstrap.is_current(bootstrap.read_stamp(path), "k", ["dev"])


@pytest.mark.parametrize("text", ["", "{", "[]", '"x"', '{"key": "k", "extras": 3}'])
def test_a_damaged_stamp_counts_as_none(bootstrap: ModuleType, tmp_path: Path, text: str) -> None:
    path = tmp_path / "stamp.json"
    path.write_text(text)
    assert not bootstrap.is_current(bootstrap.read_stamp(path), "k", [])


def test_a_second_start_installs_nothing(
    bootstrap: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed: list[list[str]] = []
    monkeypatch.setattr(bootstrap, "_install", lambda root, python, extras: installed.append(list(extras)))
    monkeypatch.setattr(bootstrap, "_make_venv", lambda venv: pytest.fail("the environment is fine"))
    bootstrap.ensure_environment(checkout, ["dev"])
    bootstrap.ensure_environment(checkout, ["dev"])
    bootstrap.ensure_environment(checkout, [])
    assert installed == [["dev"]]
    (checkout / "pyproject.toml").write_bytes(PYPROJECT.replace(b"numpy>=2", b"numpy>=3"))
    bootstrap.ensure_environment(checkout, [])
    assert installed == [["dev"], ["dev"]], "new dependencies, and the tools stay"


def test_a_failed_installation_leaves_no_stamp(
    bootstrap: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(root: Path, python: Path, extras: list[str]) -> None:
        raise bootstrap.SetupError("no network")

    monkeypatch.setattr(bootstrap, "_install", fail)
    with pytest.raises(bootstrap.SetupError):
        bootstrap.ensure_environment(checkout, [])
    assert not (checkout / ".venv" / bootstrap.STAMP_NAME).exists()


def test_an_old_or_broken_environment_is_made_anew(
    bootstrap: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Path] = []
    monkeypatch.setattr(bootstrap, "_install", lambda root, python, extras: None)
    monkeypatch.setattr(bootstrap, "_make_venv", made.append)
    (checkout / ".venv" / "pyvenv.cfg").write_text("version = 3.9.2\n")
    bootstrap.ensure_environment(checkout, [])
    bootstrap.venv_python(checkout / ".venv").unlink()
    bootstrap.ensure_environment(checkout, [])
    assert made == [checkout / ".venv"] * 2


def test_versions(bootstrap: ModuleType) -> None:
    assert bootstrap.is_supported("3.11.0")
    assert bootstrap.is_supported("3.14.0a1")
    assert not bootstrap.is_supported("3.9.18")
    assert not bootstrap.is_supported("")


def test_the_scripts_need_the_standard_library_only() -> None:
    """An interpreter without site-packages can load what runs before the environment exists."""
    code = "import sys; sys.path.insert(0, sys.argv[1]); import _interpreter, bootstrap; print(bootstrap.ROOT)"
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-c", code, str(PACKAGING)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(PACKAGING.parent)


def test_an_old_python_is_told_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    interpreter = load("_interpreter", monkeypatch)
    assert "3.9" in interpreter.message((3, 9, 2))
    assert "3.11 or newer" in interpreter.message((3, 9, 2))
    monkeypatch.setattr(interpreter, "MINIMUM", (99, 0))
    monkeypatch.setattr(interpreter.shutil, "which", lambda name: None)
    with pytest.raises(SystemExit, match=r"needs Python 99\.0"):
        interpreter.require()


def test_the_check_runs_every_step_in_order(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    check = load("test", monkeypatch)
    setup = check.bootstrap.Setup(tmp_path / "python", tmp_path)
    plan = check.steps(setup, ["-k", "one"], virtual_display=True)
    assert [step.name for step in plan] == ["format", "lint", "types", "layers", "tests"]
    assert plan[-1].command[0] == "xvfb-run"
    assert plan[-1].command[-2:] == ["-k", "one"]
    bare = check.steps(setup, [], virtual_display=False)[-1].command
    assert bare[1:3] == ["-m", "pytest"]
    assert bare[-2:] == ["--dist", "loadfile"], "the tests of a file share what is slow to make"


def test_the_check_goes_on_after_a_failure(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    check = load("test", monkeypatch)
    ran: list[str] = []

    def run(step: object, environment: object) -> object:
        name = step.name  # type: ignore[attr-defined]  # a Step of the script
        ran.append(name)
        return check.Outcome(name, 2 if name == "lint" else 0, 0.1)

    monkeypatch.setattr(check, "run", run)
    monkeypatch.setattr(check.bootstrap, "prepare", lambda **_: check.bootstrap.Setup(Path("p"), Path("s")))
    assert check.main([]) == 1
    assert ran == ["format", "lint", "types", "layers", "tests"]
    assert "FAILED (2)" in capsys.readouterr().out


def test_the_tests_render_in_software_unless_told(monkeypatch: pytest.MonkeyPatch) -> None:
    check = load("test", monkeypatch)
    assert check.test_environment({})["LIBGL_ALWAYS_SOFTWARE"] == "1"
    assert check.test_environment({"LIBGL_ALWAYS_SOFTWARE": "0"})["LIBGL_ALWAYS_SOFTWARE"] == "0"


def test_without_a_display_the_sample_is_rendered(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script = load("run", monkeypatch)
    calls: list[list[str]] = []

    def lucarna(setup: object, arguments: list[str]) -> int:
        calls.append(arguments)
        return 0

    monkeypatch.setattr(script, "lucarna", lucarna)
    monkeypatch.setattr(script, "become", lambda setup, arguments: lucarna(setup, ["become", *arguments]))
    monkeypatch.setattr(script.bootstrap, "prepare", lambda **_: None)
    monkeypatch.setattr(script.bootstrap, "has_display", lambda: False)
    monkeypatch.setattr(script.sys, "platform", "linux")
    monkeypatch.setenv("LUCARNA_SAMPLE_DIR", str(tmp_path / "sample"))
    assert script.main([]) == 0
    assert [c[0] for c in calls] == ["new", "convert", "render", "render"]
    assert str(tmp_path / "sample" / "out") in capsys.readouterr().out

    calls.clear()
    (tmp_path / "sample").mkdir()
    (tmp_path / "sample" / "project.toml").write_text("")
    monkeypatch.setattr(script.bootstrap, "has_display", lambda: True)
    assert script.main([]) == 0
    assert calls == [["become", "edit", str(tmp_path / "sample")]], "an existing sample is kept"

    calls.clear()
    assert script.main(["inspect", "x.glb"]) == 0
    assert calls == [["become", "inspect", "x.glb"]]


def test_a_failed_setup_is_a_message(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    script = load("run", monkeypatch)

    def fail(**_: object) -> None:
        raise script.bootstrap.SetupError("no network")

    monkeypatch.setattr(script.bootstrap, "prepare", fail)
    assert script.main([]) == 3
    assert "no network" in capsys.readouterr().err


def test_the_stamp_is_json(bootstrap: ModuleType, tmp_path: Path) -> None:
    bootstrap.write_stamp(tmp_path / "s", "k", ["b", "a", "b"])
    assert json.loads((tmp_path / "s").read_text()) == {"key": "k", "extras": ["a", "b"]}
