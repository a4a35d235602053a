"""TOML with places: a parsed file that can still say on which line and column each key and value stands.

    load_toml(path) -> TomlSource
        .data                    plain dicts, lists and values (tomllib)
        .place(("a", "b", 0))    -> Place(file, line, column, "a.b[0]")
        .caret(place)            -> the source line with a ^ under the column
        .error(keypath, message) -> FormatError with place, line and caret, ready to raise

The text is parsed by tomllib; the positions come from a second, lenient walk over text that is known to be valid.
"""

from __future__ import annotations

import re
import stat
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from engine.core.errors import FormatError, InputError, Place

KeyPath = tuple[str | int, ...]

#: a hand-written file; anything larger is not one
MAX_BYTES = 4 << 20

_TOML_PLACE = re.compile(r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)$")
_BARE = re.compile(r"[^\s=.\[\]{},#\"']+")
_SKIP = re.compile(r"(?:[ \t\r\n]+|#[^\n]*)*")
_SCALAR = re.compile(r"[^,\]}#\n]*")
_SPACE = re.compile(r"[ \t]*")
_ESCAPED = re.compile(r"\\(u[0-9A-Fa-f]{4}|U[0-9A-Fa-f]{8}|.)", re.DOTALL)


def dotted(keypath: Sequence[str | int]) -> str:
    """`("a", "b c", 0)` -> `a."b c"[0]`."""
    text = ""
    for part in keypath:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            name = part if re.fullmatch(r"[A-Za-z0-9_-]+", part) else f'"{part}"'
            text += f".{name}" if text else name
    return text


@dataclass(slots=True)
class TomlSource:
    """A parsed TOML file: `data`, and where its keys stand. `file` is how messages name it."""

    file: str
    text: str
    data: dict[str, Any]
    _keys: dict[KeyPath, int] = field(default_factory=dict)
    _values: dict[KeyPath, int] = field(default_factory=dict)

    def place(self, keypath: Sequence[str | int] | str, *, value: bool = False) -> Place:
        """The place of the key (of its value with `value`); of the nearest ancestor where it is not in the file.

        `keypath`: keys and array indices, or one string with dots between plain keys. Never raises.
        """
        path: KeyPath = tuple(keypath.split(".")) if isinstance(keypath, str) else tuple(keypath)
        if not self._keys and self.data:
            _Walk(self.text, self._keys, self._values).document()
        name = dotted(path)
        known = path
        while known:
            table = self._values if value and known == path else self._keys
            at = table.get(known, self._keys.get(known, -1))
            if at >= 0:
                line, column = _line_column(self.text, at)
                return Place(self.file, line, column, name)
            known = known[:-1]
        return Place(self.file, 1 if path else 0, 1 if path else 0, name)

    def caret(self, place: Place) -> str:
        """The line of `place` and below it a caret under its column; empty when the place has no line."""
        return caret(self.text, place.line, place.column)

    def error(
        self, keypath: Sequence[str | int] | str, message: str, *, hint: str = "", value: bool = False
    ) -> FormatError:
        """A FormatError at that key whose message ends with the source line and the caret."""
        place = self.place(keypath, value=value)
        return FormatError(with_caret(message, self.text, place), where=place, hint=hint)


def load_toml(path: Path) -> TomlSource:
    """Read and parse a TOML file.

    Raises InputError when it cannot be read, FormatError with line, column and caret when it is not TOML.
    """
    path = Path(path)
    try:
        info = path.stat()
        if not stat.S_ISREG(info.st_mode):
            raise InputError("is not a regular file", where=path, hint="give the path of a TOML file")
        if info.st_size > MAX_BYTES:
            raise FormatError(f"is {info.st_size} bytes; a TOML file may have {MAX_BYTES}", where=path)
        raw = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror or error}", where=path, hint="check the path") from error
    return parse_toml(raw, str(path))


def parse_toml(raw: bytes | str, file: str) -> TomlSource:
    """Parse TOML text; `file` names it in messages. Raises FormatError as `load_toml`."""
    text = raw if isinstance(raw, str) else ""
    if isinstance(raw, bytes):
        try:
            text = raw.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = raw.count(b"\n", 0, error.start) + 1
            column = error.start - raw.rfind(b"\n", 0, error.start)
            raise FormatError("is not UTF-8 text", where=Place(file, line, column), hint="save it as UTF-8") from error
    text = text.replace("\r\n", "\n")
    try:
        return TomlSource(file, text, tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        message = str(error)
        found = _TOML_PLACE.search(message)
        if found and found.group(1):
            line, column = int(found.group(1)), int(found.group(2))
        else:
            line, column = _line_column(text, len(text.rstrip()))
        message = _TOML_PLACE.sub("", message)
        place = Place(file, line, column)
        raise FormatError(with_caret(f"not valid TOML: {message}", text, place), where=place) from error
    except RecursionError as error:
        raise FormatError("arrays or tables are nested too deeply", where=file) from error
    except ValueError as error:
        # tomllib lets int() and datetime() errors through, without a place
        raise FormatError(f"not valid TOML: {error}", where=file) from error


#: characters of a source line that a message shows
_WIDEST = 200


def caret(text: str, line: int, column: int) -> str:
    """Line `line` of `text` and a caret under `column` (both 1-based); empty when there is no such line. Of a long line
    only what is around the column."""
    lines = text.split("\n")
    if not 1 <= line <= len(lines):
        return ""
    source = lines[line - 1].rstrip("\r")
    if len(source) > _WIDEST:
        start = min(max(column - _WIDEST // 2, 0), len(source) - _WIDEST)
        source = source[start : start + _WIDEST]
        column -= start
    before = "".join("\t" if c == "\t" else " " for c in source[: max(0, column - 1)])
    return f"    {source}\n    {before}^"


def with_caret(message: str, text: str, place: Place) -> str:
    """`message` followed by the source line of `place` and the caret, where it has a line."""
    snippet = caret(text, place.line, place.column)
    return f"{message}\n{snippet}" if snippet else message


def _line_column(text: str, at: int) -> tuple[int, int]:
    return text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at)


class _Walk:
    """Notes the offset of every key and value of a valid TOML text."""

    def __init__(self, text: str, keys: dict[KeyPath, int], values: dict[KeyPath, int]) -> None:
        self.text, self.keys, self.values, self.at = text, keys, values, 0
        self.counts: dict[KeyPath, int] = {}

    def document(self) -> None:
        table: KeyPath = ()
        self._skip()
        while self.at < len(self.text):
            if self.text[self.at] == "[":
                table = self._header()
            else:
                self._pair(table)
            self._skip()

    def _skip(self) -> None:
        found = _SKIP.match(self.text, self.at)
        assert found is not None
        self.at = found.end()

    def _peek(self) -> str:
        return self.text[self.at : self.at + 1]

    def _header(self) -> KeyPath:
        array = self.text.startswith("[[", self.at)
        start = self.at
        self.at += 2 if array else 1
        names = [name for name, _ in self._key()]
        self.at += 2 if array else 1
        path: KeyPath = ()
        for position, name in enumerate(names):
            path = (*path, name)
            self.keys.setdefault(path, start)
            last = position == len(names) - 1
            if array and last:
                self.counts[path] = self.counts.get(path, 0) + 1
            if path in self.counts:
                path = (*path, self.counts[path] - 1)
                self.keys.setdefault(path, start)
        return path

    def _key(self) -> list[tuple[str, int]]:
        parts = []
        while True:
            self._blank()
            start = self.at
            if self._peek() in {'"', "'"}:
                parts.append((self._string(), start))
            else:
                found = _BARE.match(self.text, self.at)
                assert found is not None
                self.at = found.end()
                parts.append((found.group(), start))
            self._blank()
            if self._peek() != ".":
                return parts
            self.at += 1

    def _blank(self) -> None:
        found = _SPACE.match(self.text, self.at)
        assert found is not None
        self.at = found.end()

    def _pair(self, table: KeyPath) -> None:
        path = table
        for name, start in self._key():
            path = (*path, name)
            self.keys.setdefault(path, start)
        self.at += 1  # the =
        self._blank()
        self._value(path)

    def _value(self, path: KeyPath) -> None:
        self.values.setdefault(path, self.at)
        first = self._peek()
        if first in {'"', "'"}:
            self._string()
        elif first == "[":
            self.at += 1
            index = 0
            self._skip()
            while self._peek() != "]":
                self.keys.setdefault((*path, index), self.at)
                self._value((*path, index))
                index += 1
                self._comma()
            self.at += 1
        elif first == "{":
            self.at += 1
            self._skip()
            while self._peek() != "}":
                self._pair(path)
                self._comma()
            self.at += 1
        else:
            found = _SCALAR.match(self.text, self.at)
            assert found is not None
            self.at = found.end()

    def _comma(self) -> None:
        self._skip()
        if self._peek() == ",":
            self.at += 1
        self._skip()

    def _string(self) -> str:
        quote = self._peek()
        if self.text.startswith(quote * 3, self.at):
            end = self.at + 3
            while not self.text.startswith(quote * 3, end):
                end += 2 if quote == '"' and self.text[end] == "\\" else 1
            while self.text.startswith(quote, end + 3):  # up to two quotes may stand before the closing three
                end += 1
            body, self.at = self.text[self.at + 3 : end], end + 3
        else:
            end = self.at + 1
            while self.text[end] != quote:
                end += 2 if quote == '"' and self.text[end] == "\\" else 1
            body, self.at = self.text[self.at + 1 : end], end + 1
        return _ESCAPED.sub(_unescape, body) if quote == '"' else body


def _unescape(found: re.Match[str]) -> str:
    code = found.group(1)
    if code[0] in "uU":
        return chr(int(code[1:], 16))
    return {"n": "\n", "t": "\t", "r": "\r", "b": "\b", "f": "\f"}.get(code, code)
