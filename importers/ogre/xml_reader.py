"""XML of Ogre's converter, read as a stream: one call for each element, checked attributes, lines in the errors.

Expat underneath. Entities of a file's own are refused, elements may not nest deeper than 64.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import FormatError, Place

MAX_DEPTH = 64
Attributes = Mapping[str, str]


class XmlReader:
    """Calls `starts[name](attributes)` and `ends[name]()` for elements that are listed there."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.starts: dict[str, Callable[[Attributes], None]] = {}
        self.ends: dict[str, Callable[[], None]] = {}
        self._depth = 0
        self._parser = expat.ParserCreate()
        self._parser.buffer_text = True
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.EntityDeclHandler = self._entity

    def parse(self, data: bytes) -> None:
        """Read all of `data`. Raises FormatError with line and column."""
        try:
            self._parser.Parse(data, True)
        except expat.ExpatError as error:
            reason = expat.ErrorString(error.code) or "broken"
            raise FormatError(
                f"not valid XML: {reason}", where=Place(self.file, error.lineno, error.offset + 1),
                hint="the file is cut or damaged",
            ) from error  # fmt: skip
        except (LookupError, ValueError) as error:  # an encoding that expat or Python does not know
            raise FormatError(f"not valid XML: {error}", where=Place(self.file, 1)) from error

    def error(self, message: str, hint: str = "export the file again") -> FormatError:
        where = Place(self.file, self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1)
        return FormatError(message, where=where, hint=hint)

    def text(self, attributes: Attributes, name: str) -> str:
        if name not in attributes:
            raise self.error(f"the attribute {name!r} is missing")
        return attributes[name]

    def number(self, attributes: Attributes, name: str, default: float | None = None) -> float:
        """A finite number; `default` where the attribute is not there."""
        if default is not None and name not in attributes:
            return default
        text = self.text(attributes, name)
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.error(f"{name}={text[:40]!r} is no number")
        return value

    def whole(self, attributes: Attributes, name: str, default: int | None = None) -> int:
        """A number from 0 to 2^32 - 1."""
        if default is not None and name not in attributes:
            return default
        text = self.text(attributes, name)
        try:
            value = int(text)
        except ValueError:
            value = -1
        if not 0 <= value <= 0xFFFFFFFF:
            raise self.error(f"{name}={text[:40]!r} is no number from 0 to 4294967295")
        return value

    def vector(self, attributes: Attributes) -> tuple[float, float, float]:
        return self.number(attributes, "x"), self.number(attributes, "y"), self.number(attributes, "z")

    def _start(self, name: str, attributes: Attributes) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self.error(f"elements nest more than {MAX_DEPTH} deep")
        handler = self.starts.get(name)
        if handler is not None:
            try:
                handler(attributes)
            except KeyError as error:
                raise self.error(f"<{name}> lacks the attribute {error.args[0]!r}") from None

    def _end(self, name: str) -> None:
        self._depth -= 1
        handler = self.ends.get(name)
        if handler is not None:
            handler()

    def _entity(self, *_: object) -> None:
        raise self.error("the file declares entities of its own", "remove its DOCTYPE")


def floats_of(words: list[str], width: int) -> NDArray[np.float32]:
    """f4[n,width] of numbers as text; what is no number becomes NaN (old exporters write -1.#IND)."""
    try:
        values = np.array(list(map(float, words)), np.float64)
    except ValueError:
        values = np.array([_number(word) for word in words], np.float64)
    with np.errstate(over="ignore"):
        return values.astype(np.float32).reshape(-1, width)


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return math.nan
