"""`.ies` files: how bright a luminaire is in each direction (type C photometry).

ANSI/IESNA LM-63-2002, "Standard File Format for the Electronic Transfer of Photometric Data", and its forms of 1986,
1991 and 1995: labels, a TILT line, then numbers that flow freely over lines.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import FormatError, InputError, Place
from engine.core.findings import Findings

F8 = NDArray[np.float64]

MAX_BYTES, MAX_ANGLES = 8 << 20, 4096
VERSIONS = {"IESNA91": "1991", "IESNA:LM-63-1995": "1995", "IESNA:LM-63-2002": "2002", "IES:LM-63-2019": "2019"}
_TYPES = {1: "C", 2: "B", 3: "A"}
_HINT = "ask the maker of the luminaire for a file of type C photometry"


@dataclass(frozen=True, slots=True)
class PhotometricProfile:
    """`candela` f8[h,v] at `horizontal` f8[h] and `vertical` f8[v] (degrees), all factors of the file applied.

    Vertical 0 is straight down, horizontal 0 along the luminaire's length; `horizontal` is as in the file: one angle
    (the same all around), to 90 or 180 (mirrored), 90 to 270 (mirrored), or all around. `lumens`: what the lamps are
    said to give together, 0 where the file is absolute. `labels`: KEY -> text.
    """

    vertical: F8
    horizontal: F8
    candela: F8
    version: str = "1986"
    lumens: float = 0.0
    watts: float = 0.0
    labels: dict[str, str] = field(default_factory=dict)

    @property
    def peak(self) -> float:
        """Candela where it is brightest."""
        return float(self.candela.max(initial=0.0))

    def at(self, horizontal: ArrayLike, vertical: ArrayLike) -> F8:
        """Return candela [...] at angles in degrees, linear between those of the file; 0 outside its vertical ones."""
        h, v = np.broadcast_arrays(np.asarray(horizontal, np.float64), np.asarray(vertical, np.float64))
        folded = _fold(h, self.horizontal)
        low, high, share = _between(self.horizontal, folded)
        below, above, part = _between(self.vertical, v)
        c = self.candela
        one = c[low, below] * (1.0 - part) + c[low, above] * part
        two = c[high, below] * (1.0 - part) + c[high, above] * part
        inside = (v >= self.vertical[0] - 1e-9) & (v <= self.vertical[-1] + 1e-9)
        return np.where(inside, one * (1.0 - share) + two * share, 0.0)

    def relative(self, width: int, height: int) -> NDArray[np.float32]:
        """Return f4[height,width] over the peak: columns 0 to 360 degrees around, rows 0 to 180 from straight down,
        both ends on texels."""
        around, down = np.meshgrid(np.linspace(0.0, 360.0, width), np.linspace(0.0, 180.0, height))
        return (self.at(around, down) / max(self.peak, 1e-300)).astype(np.float32)

    def flux(self) -> float:
        """Return the lumens that leave it: candela over the sphere, a degree at a time."""
        around, down = np.meshgrid(np.arange(0.5, 360.0), np.arange(0.25, 180.0, 0.5))
        solid = np.radians(1.0) * np.radians(0.5) * np.sin(np.radians(down))
        return float((self.at(around, down) * solid).sum())


def read_ies(path: Path, findings: Findings | None = None) -> PhotometricProfile:
    """Read a file. Raises InputError when it cannot be read, FormatError with the line where something is wrong."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise FormatError(f"is {path.stat().st_size} bytes; an IES file may have {MAX_BYTES}", where=path)
        text = path.read_bytes().decode("latin-1")
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", where=path) from error
    return parse_ies(text, str(path), findings)


def parse_ies(text: str, file: str = "", findings: Findings | None = None) -> PhotometricProfile:
    """The same from text; `file` names it in messages."""
    notes = findings if findings is not None else Findings(file)
    lines = text.splitlines()
    first = lines[0].strip().upper() if lines else ""
    version = VERSIONS.get(first, "1986")
    if first.startswith("IES") and first not in VERSIONS:
        notes.warn("ies.version", f"unknown version {first!r}, read as that of 2002", "line 1")
        version = "2002"
    tilt = next((i for i, line in enumerate(lines) if re.match(r"\s*TILT\s*=", line, re.I)), None)
    if tilt is None:
        raise FormatError("has no TILT= line", where=Place(file), hint="is it an IES (LM-63) file?")
    numbers = _Numbers(lines, tilt + 1, file)
    kind = lines[tilt].split("=", 1)[1].strip().upper()
    if kind == "INCLUDE":
        numbers.take("lamp geometry", 1)
        pairs = numbers.count("tilt angles")
        numbers.take("tilt angles and factors", 2 * pairs)
        notes.warn("ies.tilt", "the factors for a tilted lamp are not used", f"line {tilt + 1}")
    elif kind != "NONE":
        notes.warn("ies.tilt", f"the tilt file {kind!r} is not used", f"line {tilt + 1}")
    lamps, lumens, multiplier = numbers.take("number of lamps, lumens, multiplier", 3)
    v_count, h_count = numbers.count("vertical angles"), numbers.count("horizontal angles")
    photometry = int(numbers.take("photometric type", 1)[0])
    if photometry != 1:
        name = _TYPES.get(photometry, str(photometry))
        raise FormatError(f"is type {name} photometry, expected type C", where=numbers.place(), hint=_HINT)
    numbers.take("units and size of the opening", 4)
    ballast, _, watts = numbers.take("ballast factor, future use, watts", 3)
    vertical = numbers.angles("vertical angles", v_count, 180.0)
    if v_count < 2:
        raise FormatError("has one vertical angle: no shape", where=numbers.place(), hint=_HINT)
    horizontal = numbers.angles("horizontal angles", h_count, 360.0)
    _check_symmetry(horizontal, numbers.place())
    factor = multiplier * ballast
    candela = numbers.take("candela values", v_count * h_count).reshape(h_count, v_count) * factor
    if not np.isfinite(candela).all() or (candela < 0.0).any():
        raise FormatError("has a candela value below 0 or beyond counting", where=numbers.place())
    if not candela.any():
        raise FormatError("is dark: all candela values are 0", where=numbers.place())
    if numbers.left():
        notes.warn(
            "ies.rest", f"{numbers.left()} numbers follow the last candela value", str(numbers.place().line or "")
        )
    total = 0.0 if lumens < 0.0 else max(lamps, 1.0) * lumens
    return PhotometricProfile(vertical, horizontal, candela, version, total, watts, _labels(lines[:tilt]))


class _Numbers:
    """The numbers after the TILT line, with the lines they stand in."""

    def __init__(self, lines: list[str], start: int, file: str) -> None:
        self._file = file
        self._words: list[tuple[str, int]] = [
            (word, number + 1)
            for number in range(start, len(lines))
            for word in lines[number].replace(",", " ").split()
        ]
        self._next = 0

    def place(self) -> Place:
        line = self._words[min(self._next, len(self._words)) - 1][1] if self._words else 0
        return Place(self._file, line) if line else Place(self._file)

    def left(self) -> int:
        return len(self._words) - self._next

    def take(self, what: str, count: int) -> F8:
        if self.left() < count:
            self._next = len(self._words)
            raise FormatError(
                f"ends within the {what}: {count} numbers expected", where=self.place(), hint="the file is cut off"
            )
        out = np.zeros(count)
        for i in range(count):
            word, line = self._words[self._next]
            self._next += 1
            try:
                out[i] = float(word)
            except ValueError:
                raise FormatError(f"{word!r} is no number, in the {what}", where=Place(self._file, line)) from None
        return out

    def count(self, what: str) -> int:
        value = float(self.take(f"number of {what}", 1)[0])
        if not (value == int(value) if np.isfinite(value) else False) or not 1 <= value <= MAX_ANGLES:
            raise FormatError(f"the number of {what} is {value:g}", where=self.place(), hint=f"1 to {MAX_ANGLES}")
        return int(value)

    def angles(self, what: str, count: int, most: float) -> F8:
        out = self.take(what, count)
        if not np.isfinite(out).all() or (np.diff(out) <= 0.0).any():
            raise FormatError(f"the {what} do not rise", where=self.place())
        if out[0] < -1e-6 or out[-1] > most + 1e-6:
            raise FormatError(f"the {what} leave 0 to {most:g} degrees", where=self.place(), hint=_HINT)
        return out


def _check_symmetry(angles: F8, place: Place) -> None:
    whole = np.isclose(angles[-1], (90.0, 180.0, 360.0)).any() and np.isclose(angles[0], 0.0)
    across = np.isclose(angles[0], 90.0) and np.isclose(angles[-1], 270.0)
    near = np.isclose(angles[0], 0.0) and angles[-1] > 180.0  # all around without repeating the first at 360
    if len(angles) > 1 and not (whole or across or near):
        raise FormatError(
            f"horizontal angles from {angles[0]:g} to {angles[-1]:g} have no known symmetry", where=place,
            hint="0 to 90, 0 to 180, 0 to 360 or 90 to 270",
        )  # fmt: skip


def _fold(h: F8, angles: F8) -> F8:
    """Return where in the file's angles the direction `h` (degrees) is found, by its symmetry."""
    h = np.mod(h, 360.0)
    if len(angles) == 1:
        return np.full_like(h, angles[0])
    if np.isclose(angles[0], 90.0):
        return np.where(h < 90.0, 180.0 - h, np.where(h > 270.0, 540.0 - h, h))
    if angles[-1] <= 180.0 + 1e-6:
        h = np.where(h > 180.0, 360.0 - h, h)
    if angles[-1] <= 90.0 + 1e-6:
        h = np.where(h > 90.0, 180.0 - h, h)
    return h


def _between(angles: F8, at: F8) -> tuple[NDArray[np.int64], NDArray[np.int64], F8]:
    """Return the indices of the angles below and above, and how far between; past the last: back to the first."""
    if len(angles) == 1:
        zero = np.zeros(at.shape, np.int64)
        return zero, zero, np.zeros(at.shape)
    low = np.clip(np.searchsorted(angles, at, side="right") - 1, 0, len(angles) - 1)
    last = low == len(angles) - 1
    open_end = 180.0 < angles[-1] < 360.0 - 1e-6 and angles[0] < 1e-6  # horizontal, all around without 360
    high = np.where(last, 0 if open_end else low, low + 1)
    span = np.where(
        last, 360.0 - angles[-1] if open_end else 1.0, angles[np.minimum(low + 1, len(angles) - 1)] - angles[low]
    )
    share = np.where(last & (not open_end), 0.0, np.clip((at - angles[low]) / np.where(span > 0, span, 1.0), 0.0, 1.0))
    return low, high, share


def _labels(lines: list[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    key = ""
    for line in lines:
        match = re.match(r"\s*\[(\w+)\]\s*(.*)", line)
        if match:
            name, text = match[1].upper(), match[2].strip()
            if name == "MORE" and key:
                found[key] = f"{found[key]}\n{text}"
            else:
                key = name
                found[key] = text
    return found
