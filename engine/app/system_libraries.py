"""Which shared libraries and tools of the operating system Lucarna needs, and what they are called where.

Standard library only: `packaging/` reads it before any package is installed, `lucarna doctor` afterwards.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

#: Where Mesa's drivers lie; loading one to find out would start LLVM.
_DRIVERS = ("dri/*_dri.so", "libgallium*.so", "libgallium*.so.*", "gbm/dri_gbm.so")
_LIBRARY_FOLDERS = ("usr/lib/*-linux-*", "usr/lib64", "usr/lib", "usr/local/lib", "run/opengl-driver/lib")


@dataclass(frozen=True, slots=True)
class Requirement:
    """One library (`kind` "library": a soname to load), driver set ("driver") or program ("program": a name on PATH).

    `debian`, `fedora`, `arch`: the package that brings it. `purpose`: what does not work without it.
    `test_only`: only the project's own tests want it.
    """

    name: str
    kind: str
    debian: str
    fedora: str
    arch: str
    purpose: str
    test_only: bool = False


REQUIREMENTS = (
    Requirement("libEGL.so.1", "library", "libegl1", "libglvnd-egl", "libglvnd", "rendering without a window"),
    Requirement("libGL.so.1", "library", "libgl1", "libglvnd-glx", "libglvnd", "OpenGL"),
    Requirement(
        "Mesa drivers", "driver", "libgl1-mesa-dri", "mesa-dri-drivers", "mesa", "OpenGL without a vendor driver"
    ),
    Requirement("libX11.so.6", "library", "libx11-6", "libX11", "libx11", "windows"),
    Requirement("libXext.so.6", "library", "libxext6", "libXext", "libxext", "windows"),
    Requirement("libXcursor.so.1", "library", "libxcursor1", "libXcursor", "libxcursor", "windows"),
    Requirement("libXi.so.6", "library", "libxi6", "libXi", "libxi", "windows"),
    Requirement("libXrandr.so.2", "library", "libxrandr2", "libXrandr", "libxrandr", "windows"),
    Requirement("libXinerama.so.1", "library", "libxinerama1", "libXinerama", "libxinerama", "windows"),
    Requirement("Xvfb", "program", "xvfb", "xorg-x11-server-Xvfb", "xorg-server-xvfb", "window tests", test_only=True),
    Requirement("xauth", "program", "xauth", "xorg-x11-xauth", "xorg-xauth", "window tests", test_only=True),
)


def has_library(soname: str) -> bool:
    """Whether the dynamic loader finds `soname`."""
    try:
        ctypes.CDLL(soname)
    except OSError:
        return False
    return True


def has_driver(root: Path = Path("/")) -> bool:
    """Whether there is an OpenGL driver: Mesa's files, or NVIDIA's EGL library."""
    for folder in _LIBRARY_FOLDERS:
        for pattern in _DRIVERS:
            if next(root.glob(f"{folder}/{pattern}"), None):
                return True
    return has_library("libEGL_nvidia.so.0")


def is_present(requirement: Requirement) -> bool:
    if requirement.kind == "library":
        return has_library(requirement.name)
    if requirement.kind == "driver":
        return has_driver()
    return shutil.which(requirement.name) is not None


def missing(
    *, tests: bool = False, platform: str = sys.platform, present: Callable[[Requirement], bool] = is_present
) -> list[Requirement]:
    """What this machine lacks, in the table's order. Empty on Windows and macOS, whose systems bring what they have."""
    if not platform.startswith("linux"):
        return []
    return [r for r in REQUIREMENTS if (tests or not r.test_only) and not present(r)]


def distribution(os_release: Path = Path("/etc/os-release")) -> str:
    """The family of this Linux: debian | fedora | arch | '' (unknown)."""
    try:
        text = os_release.read_text(encoding="utf-8")
    except OSError:
        return ""
    values = dict(line.partition("=")[::2] for line in text.splitlines() if "=" in line)
    words = f"{values.get('ID', '')} {values.get('ID_LIKE', '')}".replace('"', "").replace("'", "").split()
    for word in words:
        family = {"ubuntu": "debian", "rhel": "fedora", "centos": "fedora"}.get(word, word)
        if family in {"debian", "fedora", "arch"}:
            return family
    return ""


def packages(requirements: Iterable[Requirement], family: str) -> list[str]:
    """The distribution's package names, without repeats, in order."""
    return list(dict.fromkeys(str(getattr(r, family)) for r in requirements))


def install_hint(requirements: Iterable[Requirement], family: str | None = None) -> str:
    """The exact command that installs `requirements`; for an unknown distribution, one line per known family."""
    wanted = list(requirements)
    family = distribution() if family is None else family
    commands = {
        "debian": "sudo apt-get install " + " ".join(packages(wanted, "debian")),
        "fedora": "sudo dnf install " + " ".join(packages(wanted, "fedora")),
        "arch": "sudo pacman -S --needed " + " ".join(packages(wanted, "arch")),
    }
    if family in commands:
        return commands[family]
    labels = {"debian": "Debian, Ubuntu", "fedora": "Fedora, RHEL", "arch": "Arch"}
    return "\n".join(f"{labels[name]}: {command}" for name, command in commands.items())


def has_display(environment: dict[str, str] | None = None, platform: str = sys.platform) -> bool:
    """Whether a window can open: always on Windows and macOS, elsewhere with an X or Wayland display."""
    if not platform.startswith("linux"):
        return True
    variables = dict(os.environ) if environment is None else environment
    return bool(variables.get("DISPLAY") or variables.get("WAYLAND_DISPLAY"))
