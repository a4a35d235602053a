"""Where things are: the product's own data (shaders, project template), the user's cache, the user's settings.

`data_root()` finds the data both in a checkout and in an installed wheel, where they lie in `lucarna_data/`.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path


def data_root() -> Path:
    """The folder that holds `shaders/` and `project_template/`."""
    checkout = Path(__file__).resolve().parents[2]
    installed = checkout / "lucarna_data"
    return installed if installed.is_dir() else checkout


def shaders_dir() -> Path:
    return data_root() / "shaders"


def template_dir() -> Path:
    return data_root() / "project_template"


def user_cache_dir() -> Path:
    """The per-user cache (LUCARNA_CACHE overrides): rebuildable at any time, safe to delete."""
    override = os.environ.get("LUCARNA_CACHE")
    if override:
        return Path(override)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", str(Path.home() / "AppData" / "Local")))
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME", str(Path.home() / ".cache")))
    return base / "lucarna"


def user_config_dir() -> Path:
    """The per-user settings: layouts, keymap (LUCARNA_CONFIG overrides). Never inside a project."""
    override = os.environ.get("LUCARNA_CONFIG")
    if override:
        return Path(override)
    if sys.platform == "win32":
        base = Path(os.environ.get("APPDATA", str(Path.home() / "AppData" / "Roaming")))
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Application Support"
    else:
        base = Path(os.environ.get("XDG_CONFIG_HOME", str(Path.home() / ".config")))
    return base / "lucarna"
