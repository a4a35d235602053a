"""Where numbers come from: device, driver, library versions, processor."""

from __future__ import annotations

import importlib.metadata
import os
import platform
from pathlib import Path

import engine
from engine.gpu.types import Device

PACKAGES = ("numpy", "moderngl-window", "flip-evaluator", "scikit-image", "embreex")


def versions() -> dict[str, str]:
    """Ours, the interpreter's, and those of the packages that make numbers."""
    found = {"lucarna": engine.__version__, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def device_name(device: Device | None) -> str:
    return device.caps.device if device is not None else "none"


def driver_name(device: Device | None) -> str:
    return device.caps.version if device is not None else "none"


def machine_name() -> str:
    """Processor, cores and system."""
    return f"{_processor()}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}"


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text("utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass  # not Linux: platform knows a name
    return platform.processor() or "unknown processor"
