"""What this machine has and lacks: interpreter, packages, system libraries, display, graphics device, caches.

    examine() -> Report(checks, gl) -> to_text() | to_json(); exit code 0, or 3 without a graphics device

Each check stands alone: one that fails never hides the others.
"""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine import __version__
from engine.app import system_libraries
from engine.core.errors import LucarnaError
from engine.core.paths import data_root, shaders_dir, template_dir, user_cache_dir, user_config_dir

if TYPE_CHECKING:
    from engine.gpu.types import Caps, Device

OK, WARN, FAIL = "ok", "warn", "fail"
_MARKS = {OK: "ok  ", WARN: "warn", FAIL: "FAIL"}


@dataclass(frozen=True, slots=True)
class Check:
    """One thing looked at: `status` ok | warn | fail, what was found, and what to do when it is not ok."""

    name: str
    status: str
    found: str
    hint: str = ""


@dataclass(slots=True)
class Report:
    """All checks, and the device's description when there is one."""

    checks: list[Check] = field(default_factory=list)
    gl: dict[str, Any] | None = None

    @property
    def exit_code(self) -> int:
        """3 when nothing can be rendered here, else 0."""
        return 0 if self.gl is not None else 3

    def to_json(self) -> dict[str, Any]:
        return {
            "lucarna": __version__,
            "ok": all(check.status != FAIL for check in self.checks),
            "device": self.gl,
            "checks": [{"name": c.name, "status": c.status, "found": c.found, "hint": c.hint} for c in self.checks],
        }

    def to_text(self) -> str:
        width = max((len(check.name) for check in self.checks), default=0)
        lines = []
        for check in self.checks:
            first, *rest = check.found.splitlines() or [""]
            lines.append(f"{_MARKS[check.status]}  {check.name:<{width}}  {first}")
            lines += [" " * (width + 8) + line for line in rest]
            lines += [" " * (width + 8) + f"-> {line}" for line in check.hint.splitlines()]
        return "\n".join(lines)


def open_default_device() -> Device:
    """A device for asking; the caller releases it."""
    from engine.gpu import open_device

    return open_device()


def examine(open_device: Callable[[], Device] = open_default_device) -> Report:
    """Look at everything. Never raises for what it finds."""
    report = Report()
    report.checks += [_version_check(), _python_check(), *_package_checks(), _system_check(), _display_check()]
    device_checks, report.gl = _device_checks(open_device)
    report.checks += [*device_checks, _data_check(), _folder_check("cache", user_cache_dir(), "LUCARNA_CACHE")]
    report.checks.append(_folder_check("settings", user_config_dir(), "LUCARNA_CONFIG"))
    return report


def _version_check() -> Check:
    return Check("lucarna", OK, f"{__version__}, {platform.system()} {platform.release()} {platform.machine()}")


def _python_check() -> Check:
    return Check("python", OK, f"{platform.python_version()} at {sys.executable}")


def _requirements() -> list[str]:
    """Lucarna's own dependency list, without the optional ones; [] when it is not installed as a package."""
    try:
        lines = importlib.metadata.requires("lucarna") or []
    except importlib.metadata.PackageNotFoundError:
        return []
    return [line for line in lines if "extra ==" not in line]


def _package_checks() -> list[Check]:
    wanted = _requirements()
    if not wanted:
        return [Check("packages", WARN, "Lucarna itself is not installed here", "python3 packaging/run.py sets it up")]
    found, absent = [], []
    for line in wanted:
        match = re.match(r"[A-Za-z0-9._-]+", line)
        assert match is not None, line
        try:
            found.append(f"{match[0]} {importlib.metadata.version(match[0])}")
        except importlib.metadata.PackageNotFoundError:
            absent.append(line)
    if absent:
        quoted = " ".join(f'"{line}"' for line in absent)
        return [Check("packages", FAIL, f"missing: {', '.join(absent)}", f"{sys.executable} -m pip install {quoted}")]
    half = -(-len(found) // 2)
    return [Check("packages", OK, ", ".join(found[:half]) + "\n" + ", ".join(found[half:]))]


def _system_check() -> Check:
    lacking = system_libraries.missing()
    if not lacking:
        return Check("libraries", OK, "all there" if sys.platform.startswith("linux") else "part of the system")
    found = "missing: " + ", ".join(f"{r.name} ({r.purpose})" for r in lacking)
    return Check("libraries", WARN, found, system_libraries.install_hint(lacking))


def _display_check() -> Check:
    if not system_libraries.has_display():
        return Check(
            "display",
            WARN,
            "none (neither DISPLAY nor WAYLAND_DISPLAY is set)",
            "convert, render and inspect work without one; for edit and play log in at a desktop, or use\n"
            "xvfb-run -a lucarna edit … --screenshot out.png",
        )
    names = [f"{n}={os.environ[n]}" for n in ("DISPLAY", "WAYLAND_DISPLAY") if os.environ.get(n)]
    return Check("display", OK, ", ".join(names) or "the desktop's")


def _device_checks(open_device: Callable[[], Device]) -> tuple[list[Check], dict[str, Any] | None]:
    hint = "install or update the graphics driver; it must offer OpenGL 4.5 (4.3 with its extensions)"
    if sys.platform == "darwin":
        hint = "macOS stops at OpenGL 4.1, Lucarna needs 4.3: render elsewhere; convert and inspect work here"
    elif sys.platform.startswith("linux"):
        hint += "; without a GPU, Mesa's software driver serves (libgl1-mesa-dri, libegl1)"
    try:
        device = open_device()
    except LucarnaError as error:
        return [Check("device", FAIL, error.message, error.hint or hint)], None
    except (ImportError, OSError) as error:  # a package or a library that the backend needs is broken
        return [Check("device", FAIL, f"the graphics layer does not load: {error}", hint)], None
    caps = device.caps
    device.release()
    checks = [Check("device", OK, f"{caps.device}\n{caps.backend}, {caps.version}\n{_limits(caps)}")]
    if caps.software:
        checks.append(
            Check("speed", WARN, "software rendering: right pictures, slowly", "a GPU driver makes the editor smooth")
        )
    if not caps.reversed_z:
        checks.append(Check("depth", WARN, "no reversed-z depth: far surfaces may flicker", "update the driver"))
    if not caps.bc:
        checks.append(Check("textures", WARN, "no BCn textures: more memory is used", "update the driver"))
    return checks, caps_to_json(caps)


def _limits(caps: Caps) -> str:
    return (
        f"textures up to {caps.max_texture_size} px, {caps.max_array_layers} layers, "
        f"anisotropy {caps.max_anisotropy:g}; storage {caps.max_ssbo_bytes / 2**20:.0f} MiB; "
        f"workgroups of {caps.max_workgroup_invocations}"
    )


def caps_to_json(caps: Caps) -> dict[str, Any]:
    """Every field of `caps` as JSON values; extensions sorted."""
    values = {name: getattr(caps, name) for name in caps.__slots__}
    values["extensions"] = sorted(values["extensions"])
    return values


def _data_check() -> Check:
    absent = [path.name for path in (shaders_dir(), template_dir()) if not path.is_dir()]
    if absent:
        return Check("data", FAIL, f"{data_root()} lacks {', '.join(absent)}", "install Lucarna again")
    return Check("data", OK, str(data_root()))


def _folder_check(name: str, folder: Path, variable: str) -> Check:
    """Whether `folder` can be written, and how much it holds. Makes nothing that was not there."""
    hint = f"set {variable} to a folder that you may write to"
    existing = folder
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if existing != folder:
        writable = existing.is_dir() and os.access(existing, os.W_OK)
        found = f"{folder} (not made yet)"
        return Check(name, OK, found) if writable else Check(name, FAIL, f"{folder} cannot be made", hint)
    if not folder.is_dir():
        return Check(name, FAIL, f"{folder} is not a folder", hint)
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        return Check(name, FAIL, f"{folder}: {error.strerror or error}", hint)
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    return Check(name, OK, f"{folder} ({size / 2**20:.1f} MiB; safe to delete)" if name == "cache" else str(folder))
