"""Importing this leaves with a clear message, or goes on in a newer Python, when the running one is too old.

It must itself run on old interpreters, so it uses nothing newer than Python 3.7.
"""

from __future__ import annotations

import os
import shutil
import sys

MINIMUM = (3, 11)
#: interpreters to look for, best first; newer ones than these may lack ready-made packages
CANDIDATES = ("python3.13", "python3.12", "python3.11", "python3.14")


def message(version: tuple[int, ...]) -> str:
    needed = ".".join(map(str, MINIMUM))
    found = ".".join(map(str, version[:2]))
    return (
        f"Lucarna needs Python {needed} or newer, this is {found}.\n"
        "  Debian, Ubuntu: sudo apt-get install python3.12 python3.12-venv   (or python3.11)\n"
        "  Fedora: sudo dnf install python3.12     Windows: winget install Python.Python.3.12\n"
        "Then: python3.12 packaging/run.py"
    )


def require() -> None:
    """Return on a new enough Python; else start this script again in one from PATH, or exit with what to do."""
    if tuple(sys.version_info[:2]) >= MINIMUM:
        return
    for name in CANDIDATES:
        path = shutil.which(name)
        if path and os.name == "posix":
            os.execv(path, [path, *sys.argv])
    sys.exit(message(tuple(sys.version_info[:2])))


require()
