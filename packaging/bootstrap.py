"""Sets up a checkout: the virtual environment, its packages, and the system libraries. Standard library only.

run.py and test.py share it; it is found through their own folder (sys.path[0]), this folder is no package.

    check_python -> system libraries -> .venv -> pip install -e . (only when the stamp differs) -> Setup(python)

The stamp (.venv/lucarna-stamp.json) holds a digest of what decides the installation: the parts of pyproject.toml that
name packages, the interpreter, and the checkout's place. A second start compares it and does nothing.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
if str(ROOT) not in sys.path:
    sys.path.append(str(ROOT))

from engine.app import system_libraries  # noqa: E402  (the line above makes the checkout importable)

STAMP_NAME = "lucarna-stamp.json"
#: Sections of pyproject.toml that change what gets installed; a new lint rule shall not reinstall anything.
_INSTALL_SECTIONS = (("build-system",), ("project",), ("tool", "hatch"))


class SetupError(Exception):
    """The checkout cannot be set up; the text says why and what to do."""


@dataclass(frozen=True, slots=True)
class Setup:
    """A ready environment: its interpreter and the folder of its console scripts."""

    python: Path
    scripts: Path

    def script(self, name: str) -> str:
        return str(self.scripts / (f"{name}.exe" if os.name == "nt" else name))


def say(text: str) -> None:
    print(f"lucarna setup: {text}", file=sys.stderr, flush=True)


# --- the stamp -----------------------------------------------------------------------------------------------------


def install_key(pyproject: bytes, python_version: str, root: Path) -> str:
    """Digest of everything that decides what the environment must hold.

    `root` is part of it because an editable install and the console scripts contain the checkout's path."""
    document = tomllib.loads(pyproject.decode("utf-8"))
    relevant: dict[str, Any] = {}
    for path in _INSTALL_SECTIONS:
        value: Any = document
        for name in path:
            value = value.get(name, {}) if isinstance(value, Mapping) else {}
        relevant[".".join(path)] = value
    text = json.dumps([relevant, python_version, str(root)], sort_keys=True)
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def read_stamp(path: Path) -> dict[str, Any]:
    """The stamp's content, or {} when there is none or it is damaged."""
    try:
        value = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return value if isinstance(value, dict) else {}


def write_stamp(path: Path, key: str, extras: Iterable[str]) -> None:
    temporary = path.with_suffix(".tmp")
    temporary.write_text(json.dumps({"key": key, "extras": sorted(set(extras))}) + "\n", encoding="utf-8")
    temporary.replace(path)


def is_current(stamp: Mapping[str, Any], key: str, extras: Iterable[str]) -> bool:
    """Whether an environment with this stamp serves: the same key, and at least these extras."""
    have = stamp.get("extras")
    return stamp.get("key") == key and isinstance(have, list) and set(extras) <= set(have)


# --- the environment -----------------------------------------------------------------------------------------------


def venv_python(venv: Path) -> Path:
    return venv / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def venv_version(venv: Path) -> str:
    """The full Python version that made `venv`, from its pyvenv.cfg; '' when unreadable. Starts no process."""
    try:
        lines = (venv / "pyvenv.cfg").read_text(encoding="utf-8").splitlines()
    except OSError:
        return ""
    values = {key.strip().lower(): value.strip() for key, _, value in (line.partition("=") for line in lines)}
    return values.get("version", values.get("version_info", ""))


def is_supported(version: str, minimum: tuple[int, int] = (3, 11)) -> bool:
    parts = version.split(".")
    return len(parts) >= 2 and parts[0].isdigit() and parts[1].isdigit() and (int(parts[0]), int(parts[1])) >= minimum


def ensure_environment(root: Path, extras: Sequence[str]) -> Setup:
    """Make `.venv` under `root` hold the project (editable) with `extras`. Does nothing when the stamp says so.

    Raises SetupError."""
    venv = root / ".venv"
    python = venv_python(venv)
    setup = Setup(python, python.parent)
    pyproject = (root / "pyproject.toml").read_bytes()
    stamp = read_stamp(venv / STAMP_NAME)
    usable = python.exists() and is_supported(venv_version(venv))
    if usable and is_current(stamp, install_key(pyproject, venv_version(venv), root), extras):
        return setup
    if not usable:
        _make_venv(venv)
    # whoever installed the tools once keeps them: run.py after test.py must not take turns with it
    wanted = sorted({*extras, *(e for e in stamp.get("extras", []) if isinstance(e, str))})
    _install(root, python, wanted)
    write_stamp(venv / STAMP_NAME, install_key(pyproject, venv_version(venv), root), wanted)
    return setup


def _make_venv(venv: Path) -> None:
    if importlib.util.find_spec("ensurepip") is None:
        package = f"python{sys.version_info.major}.{sys.version_info.minor}-venv"
        if not _apt_install([package]):
            raise SetupError(f"this Python has no venv/ensurepip; install it: sudo apt-get install {package}")
    say(f"making {venv}")
    # not EnvBuilder in this process: after an apt install the interpreter must look afresh
    command = [sys.executable, "-m", "venv", "--clear", str(venv)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SetupError(f"cannot make the virtual environment {venv}:\n{done.stdout}{done.stderr}".rstrip())


def _install(root: Path, python: Path, extras: Sequence[str]) -> None:
    target = f"{root}[{','.join(extras)}]" if extras else str(root)
    if subprocess.run([str(python), "-m", "pip", "--version"], capture_output=True, check=False).returncode:
        subprocess.run([str(python), "-m", "ensurepip", "--upgrade"], capture_output=True, check=False)
    say("installing the Python packages (once; a minute or two)")
    log = python.parent.parent / "lucarna-install.log"
    command = [str(python), "-m", "pip", "install", "--disable-pip-version-check", "--editable", target]
    with log.open("w", encoding="utf-8") as file:
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, encoding="utf-8", errors="replace"
        )
        assert process.stdout is not None
        for line in process.stdout:
            file.write(line)
            if line.startswith("Collecting "):
                say("  " + line.split(" (from ")[0].strip())
        code = process.wait()
    if code:
        tail = "\n".join(log.read_text(encoding="utf-8").splitlines()[-20:])
        raise SetupError(
            f"pip could not install the packages (whole log: {log}):\n{tail}\n"
            "Check the network connection and the free space, then start this command again."
        )


# --- the system ----------------------------------------------------------------------------------------------------


def ensure_system(*, tests: bool) -> list[system_libraries.Requirement]:
    """Install missing system libraries where we may (Debian, Ubuntu as root or with password-less sudo); elsewhere say
    what to install. Returns what is still missing: setting up goes on, `lucarna doctor` tells what then works."""
    lacking = system_libraries.missing(tests=tests)
    if lacking and system_libraries.distribution() == "debian":
        names = system_libraries.packages(lacking, "debian")
        say("installing system libraries: " + " ".join(names))
        _apt_install(names)
        lacking = system_libraries.missing(tests=tests)
    if lacking:
        say("missing from this system: " + ", ".join(f"{r.name} ({r.purpose})" for r in lacking))
        for line in system_libraries.install_hint(lacking).splitlines():
            say(f"  install with: {line}")
    return lacking


def has_display() -> bool:
    """Whether a window can open here."""
    return system_libraries.has_display()


def root_prefix() -> list[str] | None:
    """How to run a command as root without a question: [] as root, sudo's words, or None when we cannot."""
    if not hasattr(os, "geteuid"):
        return None
    if os.geteuid() == 0:
        return []
    if shutil.which("sudo") and not subprocess.run(["sudo", "-n", "true"], capture_output=True, check=False).returncode:
        return ["sudo", "-n", "env", "DEBIAN_FRONTEND=noninteractive"]
    return None


def _apt_install(names: Sequence[str]) -> bool:
    """`apt-get update`, then install `names`. False when that is not possible or failed (its words are shown)."""
    prefix = root_prefix()
    if prefix is None or not shutil.which("apt-get"):
        return False
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    for words in (["update", "-q"], ["install", "-q", "-y", "--no-install-recommends", *names]):
        done = subprocess.run(
            [*prefix, "apt-get", *words], env=environment, capture_output=True, text=True, check=False
        )
        # an update that fails (no network, a broken third-party list) need not stop the installation
        if done.returncode and words[0] == "install":
            say(f"apt-get {words[0]} failed:\n{(done.stdout + done.stderr).strip()}")
            return False
    return True


def prepare(*, extras: Sequence[str], tests: bool) -> Setup:
    """Everything a start needs; raises SetupError."""
    if sys.platform == "darwin":
        say("macOS stops at OpenGL 4.1, Lucarna needs 4.3: edit, render and play cannot run here; convert, inspect can")
    ensure_system(tests=tests)
    return ensure_environment(ROOT, extras)
