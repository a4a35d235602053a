"""The one tree of errors. Every message says what was given, what was expected, where, and what to do.

LucarnaError                 exit 3, the base: could not run
├── UsageError               exit 2, wrong words on the command line
├── InputError               exit 1, a file or value from outside is wrong; it names the file and the place in it
│   ├── FormatError          a source or engine file breaks its format
│   └── ShaderError          GLSL or an effect file does not compile
├── OutputError              exit 3, something could not be written
└── DeviceError              exit 3, no usable graphics device

Programmer mistakes are asserts, never one of these.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

#: characters of a place and of a message that are shown: both may hold names from a file
_LONGEST, _LARGEST = 300, 2000


@dataclass(frozen=True, slots=True)
class Place:
    """Where something is: a file, and in it a line and column (1-based) or an object path like `meshes[3].indices`."""

    file: str = ""
    line: int = 0
    column: int = 0
    path: str = ""

    def __str__(self) -> str:
        text = self.file
        if self.line:
            text += f":{self.line}"
            if self.column:
                text += f":{self.column}"
        if self.path:
            # names come from files, and may be of any length
            path = self.path if len(self.path) <= _LONGEST else f"{self.path[:_LONGEST]}…"
            text = f"{text}: {path}" if text else path
        return text


class LucarnaError(Exception):
    """Base of all expected failures. `hint` says what to do next."""

    exit_code = 3

    def __init__(self, message: str, *, where: Place | str | Path | None = None, hint: str = "") -> None:
        if len(message) > _LARGEST:
            message = f"{message[: _LARGEST // 2]} … {message[-_LARGEST // 2 :]}"
        super().__init__(message)
        self.message = message
        self.where = where if isinstance(where, Place) else Place(str(where)) if where is not None else Place()
        self.hint = hint

    def __str__(self) -> str:
        place = str(self.where)
        text = f"{place}: {self.message}" if place else self.message
        return f"{text} ({self.hint})" if self.hint else text


class UsageError(LucarnaError):
    """The command line, a call or an option is wrong."""

    exit_code = 2


class InputError(LucarnaError):
    """A file or value that came from outside is wrong."""

    exit_code = 1


class FormatError(InputError):
    """A file breaks the rules of its format."""


class ShaderError(InputError):
    """A shader or an effect does not compile."""


class OutputError(LucarnaError):
    """A result could not be written; whatever was there before is untouched."""


class DeviceError(LucarnaError):
    """There is no usable graphics device, or it failed."""
