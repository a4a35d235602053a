"""The bytes of an Ogre binary file: every read is checked against what is left; either endianness.

A file is a header (u16 0x1000, the version as a line of text) and chunks: u16 id, u32 length with these six bytes.
Which children a chunk has is told by their ids, not by its length: older serialisers wrote lengths without them.
"""

from __future__ import annotations

import math
import struct
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import FormatError, Place

HEADER_ID = 0x1000
CHUNK_HEAD = 6
MAX_NAME = 4096


class Chunks:
    """A cursor over `data`. `order` is '<' or '>'. Every method raises FormatError where the file ends too early."""

    def __init__(self, data: bytes, file: str) -> None:
        self.data = data
        self.file = file
        self.position = 0
        self.order: Literal["<", ">"] = "<"
        self.chunk_start = 0
        self.chunk_length = 0

    def error(self, message: str, hint: str = "export the file again", at: int | None = None) -> FormatError:
        """A FormatError that names the byte where things went wrong."""
        offset = self.position if at is None else at
        return FormatError(message, where=Place(self.file, path=f"byte {offset:,}"), hint=hint)

    @property
    def left(self) -> int:
        return len(self.data) - self.position

    def header(self, what: str) -> str:
        """Read the header and set the byte order; returns the version without its brackets."""
        if self.left < 2:
            raise self.error(f"the file has {self.left} bytes: no {what}")
        first = self.data[:2]
        if first == b"\x10\x00":
            self.order = ">"
        elif first != b"\x00\x10":
            raise self.error(f"the file does not begin as {what} does", "is the extension right?")
        self.position = 2
        end = self.data.find(b"\n", 2, 2 + 64)
        if end < 0:
            raise self.error(f"the version line of {what} does not end", "the file is cut or damaged")
        line = self.data[2:end].decode("ascii", "replace").strip()
        self.position = end + 1
        return line.strip("[]")

    def take(self, count: int, what: str) -> bytes:
        if count > self.left:
            raise self.error(f"{what} wants {count:,} bytes, {self.left:,} are left", "the file is cut or damaged")
        start = self.position
        self.position += count
        return self.data[start : self.position]

    def u16(self, what: str) -> int:
        return int(struct.unpack(f"{self.order}H", self.take(2, what))[0])

    def u32(self, what: str) -> int:
        return int(struct.unpack(f"{self.order}I", self.take(4, what))[0])

    def flag(self, what: str) -> bool:
        return self.take(1, what) != b"\0"

    def floats(self, count: int, what: str) -> tuple[float, ...]:
        """`count` finite numbers."""
        start = self.position
        values: tuple[float, ...] = struct.unpack(f"{self.order}{count}f", self.take(4 * count, what))
        if not all(map(math.isfinite, values)):
            raise self.error(f"{what} is no finite number", at=start)
        return values

    def text(self, what: str) -> str:
        """A name up to the end of its line, UTF-8 or else Latin-1."""
        end = self.data.find(b"\n", self.position, self.position + MAX_NAME)
        if end < 0:
            raise self.error(f"{what} has no end", "the file is cut or damaged")
        raw = self.data[self.position : end].rstrip(b"\r")
        self.position = end + 1
        try:
            return raw.decode("utf-8")
        except UnicodeDecodeError:
            return raw.decode("latin-1")

    def array(self, dtype: str, count: int, what: str) -> NDArray[Any]:
        """`count` values of `dtype` (without byte order), a copy in native order."""
        kind = np.dtype(dtype).newbyteorder(self.order)
        raw = self.take(count * kind.itemsize, what)
        return np.frombuffer(raw, kind).astype(kind.newbyteorder("="))

    # --- chunks ---

    def next_id(self) -> int:
        """The id of the chunk that begins here, or -1 at the end (fewer than six bytes are no chunk)."""
        if self.left < CHUNK_HEAD:
            return -1
        return int(struct.unpack_from(f"{self.order}H", self.data, self.position)[0])

    def enter(self, what: str) -> int:
        """Read a chunk's head; returns its id. `chunk_start` and `chunk_length` are then its own."""
        self.chunk_start = self.position
        head = self.take(CHUNK_HEAD, what)
        number, length = struct.unpack(f"{self.order}HI", head)
        if length < CHUNK_HEAD:
            raise self.error(f"{what} 0x{number:04X} has a length of {length}", at=self.chunk_start)
        self.chunk_length = length
        return int(number)

    def expect(self, number: int, what: str) -> None:
        found = self.next_id()
        if found != number:
            given = "the end of the file" if found < 0 else f"chunk 0x{found:04X}"
            raise self.error(f"expected {what}, found {given}")
        self.enter(what)

    def skip(self, what: str) -> None:
        """Go past the chunk that begins here, by its length."""
        self.enter(what)
        end = self.chunk_start + self.chunk_length
        if end > len(self.data):
            raise self.error(
                f"{what} ends at byte {end:,}, beyond the file's {len(self.data):,}", "the file is cut or damaged",
                self.chunk_start,
            )  # fmt: skip
        self.position = end

    def records(self, number: int, body: list[Any], what: str) -> NDArray[Any]:
        """A run of equal chunks `number` with the fixed `body` (a structured dtype), as one array of records."""
        kind = np.dtype([("id", "u2"), ("length", "u4"), *body]).newbyteorder(self.order)
        most = self.left // kind.itemsize
        found = np.frombuffer(self.data, kind, most, self.position)
        wrong = (found["id"] != number) | (found["length"] != kind.itemsize)
        count = int(np.argmax(wrong)) if wrong.any() else most
        if count == 0:
            raise self.error(f"{what} is not of {kind.itemsize} bytes")
        self.position += count * kind.itemsize
        return found[:count].astype(kind.newbyteorder("="))
