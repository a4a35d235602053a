"""The system's font with Chinese, Japanese and Korean glyphs; they are too many to ship. No imgui.

LUCARNA_FONT names a file of one's own. Windows and macOS bring one; on Linux it is a package such as fonts-noto-cjk or
fonts-wqy-microhei. Without one the interface stays English, and the log says so.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path

VARIABLE = "LUCARNA_FONT"
HINT = "install a font with Chinese glyphs (on Debian: fonts-noto-cjk), or name one in LUCARNA_FONT"

#: small files first: a font is read as a whole when the window opens. (name, index of the simplified Chinese face)
KNOWN: dict[str, tuple[tuple[str, int], ...]] = {
    "win32": (("Deng.ttf", 0), ("simhei.ttf", 0), ("msyh.ttc", 0), ("simsun.ttc", 0)),
    "darwin": (("STHeiti Light.ttc", 1), ("Hiragino Sans GB.ttc", 0), ("PingFang.ttc", 2), ("Arial Unicode.ttf", 0)),
    "linux": (
        ("wqy-microhei.ttc", 0), ("DroidSansFallbackFull.ttf", 0), ("DroidSansFallback.ttf", 0),
        ("NotoSansSC-Regular.otf", 0), ("NotoSansCJKsc-Regular.otf", 0), ("SourceHanSansSC-Regular.otf", 0),
        ("NotoSansCJK-Regular.ttc", 2), ("wqy-zenhei.ttc", 0),
    ),
}  # fmt: skip
FOLDERS: dict[str, tuple[str, ...]] = {
    "win32": (r"%WINDIR%\Fonts", r"%LOCALAPPDATA%\Microsoft\Windows\Fonts"),
    "darwin": ("/System/Library/Fonts", "/System/Library/Fonts/Supplemental", "/Library/Fonts", "~/Library/Fonts"),
    "linux": ("/usr/share/fonts", "/usr/local/share/fonts", "~/.local/share/fonts", "~/.fonts"),
}


@dataclass(frozen=True, slots=True)
class FontFile:
    """`index`: the face in a collection."""

    path: Path
    index: int = 0


@cache
def cjk_font() -> FontFile | None:
    """The font to take those glyphs from, or None where the system has none that is known."""
    own = os.environ.get(VARIABLE)
    if own:
        return FontFile(Path(own)) if Path(own).is_file() else None
    platform = "linux" if sys.platform.startswith("linux") else sys.platform
    folders = [Path(os.path.expandvars(f)).expanduser() for f in FOLDERS.get(platform, ())]
    return find_font(folders, KNOWN.get(platform, ())) or (_by_fontconfig() if platform == "linux" else None)


def find_font(folders: list[Path], known: tuple[tuple[str, int], ...]) -> FontFile | None:
    """The first of `known` that lies in one of the folders or below."""
    there = {path.name: path for folder in reversed(folders) if folder.is_dir() for path in folder.rglob("*.[to]t[cf]")}
    return next((FontFile(there[name], index) for name, index in known if name in there), None)


def _by_fontconfig() -> FontFile | None:
    """What the desktop would show Chinese with."""
    if shutil.which("fc-match") is None:
        return None
    try:
        asked = subprocess.run(
            ["fc-match", "--format=%{file}\t%{index}\t%{lang}", "sans-serif:lang=zh-cn"],
            capture_output=True, text=True, check=True, timeout=5,
        )  # fmt: skip
        file, index, languages = asked.stdout.split("\t")
    except (OSError, subprocess.SubprocessError, ValueError):
        return None
    if "zh-cn" not in languages.lower().split("|") or not Path(file).is_file():
        return None
    return FontFile(Path(file), int(index) & 0xFFFF)
