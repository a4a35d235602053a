"""Driver logs -> ShaderError: the forms in use, mapped back to the files, each with its source line and a caret.

Mesa          0:7(11): error: `x' undeclared          (Intel's and AMD's open drivers too; also `preprocessor error`)
NVIDIA        0(7) : error C1503: undefined variable "x"
AMD           ERROR: 0:7: error(#143) Undeclared identifier: x
Intel         ERROR: 0:7: 'x' : undeclared identifier            ERROR: 0:? : '' : syntax error: #line
ANGLE, Apple  ERROR: 0:7: 'x' : undeclared identifier            ERROR: 0:7: Use of undeclared identifier 'x'

Sums (`2 compilation errors. No code generated`, `compilation terminated`) and what is told twice are left out.
"""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass

from engine.core.errors import Place, ShaderError
from engine.gpu.types import ShaderSource

_FORMS = (
    re.compile(
        r"^\d+:(?P<line>\d+)\((?P<column>\d+)\)\s*:\s*(?:preprocessor\s+)?(?P<kind>error|warning)\s*:?\s*(?P<text>.*)$",
        re.I,
    ),
    re.compile(r"^\d+\((?P<line>\d+)\)\s*:\s*(?P<kind>(?:fatal )?error|warning)\s*(?P<text>.*)$", re.I),
    re.compile(
        r"^(?P<kind>ERROR|WARNING)\s*:\s*\d+:(?P<line>\d+|\?)\s*:\s*(?:(?:error|warning)\(#\d+\)\s*)?(?P<text>.*)$",
        re.I,
    ),
)
_QUOTED = re.compile(r"[\"'`]([A-Za-z_]\w*)[\"'`]")
_SUM = re.compile(r"compilation (?:errors?\b|terminated)", re.I)
_NAMED = re.compile(r"(?:identifier|function found)\s*:\s*([A-Za-z_]\w*)")
_UNKNOWN = re.compile(
    r"undeclared|undefined|not declared|cannot access field"
    r"|no (?:such |matching |overloaded )*(?:function|field|member)",
    re.I,
)
_NAME = re.compile(r"[A-Za-z_]\w{2,}")
SHOWN = 8  # errors after the first few follow from them


@dataclass(frozen=True, slots=True)
class LogEntry:
    """One message of a driver. `line` counts in the flattened text from 1; 0 = none given, likewise `column`."""

    kind: str
    line: int
    column: int
    text: str


def parse_log(log: str) -> list[LogEntry]:
    """All messages with a line number, in order; lines of no known form are left out."""
    entries = []
    for raw in log.replace("\0", "").splitlines():
        for form in _FORMS:
            match = form.match(raw.strip())
            if match:
                groups = match.groupdict()
                kind = "warning" if groups["kind"].lower() == "warning" else "error"
                line = int(groups["line"]) if groups["line"] != "?" else 0
                entry = LogEntry(kind, line, int(groups.get("column") or 0), groups["text"].strip())
                if entry not in entries and not _SUM.search(entry.text):
                    entries.append(entry)
                break
    return entries


def place_of(source: ShaderSource, line: int, column: int = 0) -> Place:
    """The file and line that flattened line `line` came from."""
    if 1 <= line <= len(source.lines):
        file, number = source.lines[line - 1]
        return Place(file, number, column)
    return Place(f"<{source.stage}>", line, column)


def compile_error(source: ShaderSource, log: str, label: str = "") -> ShaderError:
    """The error to raise when `source` did not compile and the driver said `log`."""
    errors = [entry for entry in parse_log(log) if entry.kind == "error"]
    of = f" of {label!r}" if label else ""
    if not errors:
        where = place_of(source, 1) if source.lines else None
        said = log.replace("\0", "").strip() or "the driver said nothing"
        return ShaderError(f"the {source.stage} stage{of} does not compile: {said}", where=where)
    text_lines = source.text.splitlines()
    parts: list[str] = []
    first = Place()
    for index, entry in enumerate(errors[:SHOWN]):
        code = text_lines[entry.line - 1] if 1 <= entry.line <= len(text_lines) else ""
        column = _column(code, entry)
        place = place_of(source, entry.line, column)
        if index == 0:
            first = place
            parts.append(f"{entry.text} [{source.stage} stage{of}]{_excerpt(code, column)}")
        else:
            parts.append(f"{place}: {entry.text}{_excerpt(code, column)}")
    if len(errors) > SHOWN:
        parts.append(f"and {len(errors) - SHOWN} more")
    return ShaderError("\n".join(parts), where=first, hint=_did_you_mean(source.text, errors[0].text))


def _did_you_mean(text: str, message: str) -> str:
    """For a message about a name that is not known: the nearest that is."""
    if not _UNKNOWN.search(message):
        return ""
    known = set(_NAME.findall(text))
    for name in _names(message):
        uses = len(re.findall(rf"\b{re.escape(name)}\b", text))
        near = [n for n in difflib.get_close_matches(name, sorted(known - {name}), 3, 0.75) if text.count(n) > uses]
        if near:
            return f"did you mean {near[0]!r}?"
    return ""


def link_error(label: str, sources: tuple[ShaderSource, ...], log: str) -> ShaderError:
    """The error to raise when stages that compiled do not link; drivers name no line then."""
    said = log.replace("\0", "").strip() or "the driver said nothing"
    files = {source.stage: source.lines[-1][0] for source in sources if source.lines}
    named = [stage for stage in files if f"{stage} shader" in said]
    where: Place | str = Place(files[named[0]], 1) if len(named) == 1 else " + ".join(files.values())
    return ShaderError(f"{label!r} does not link: {said}", where=where or None)


def _column(code: str, entry: LogEntry) -> int:
    """Where in `code` the message points: at the quoted name that stands in the line, else at the driver's column, else
    0 (NVIDIA, AMD and Intel give none). Mesa counts columns after it has shrunk each run of blanks to one."""
    told = 0
    if entry.column:
        starts = [m.start() for m in re.finditer(r"\s+|\S", code)]
        told = starts[entry.column - 1] + 1 if entry.column <= len(starts) else 0
    for name in _names(entry.text):
        columns = [m.start() + 1 for m in re.finditer(rf"\b{re.escape(name)}\b", code)]
        if columns:
            return min(columns, key=lambda column: abs(column - told))
    return told


def _names(message: str) -> list[str]:
    """The names that a message is about."""
    return [*_QUOTED.findall(message), *_NAMED.findall(message)]


def _excerpt(code: str, column: int) -> str:
    if not code.strip():
        return ""
    shown = code.rstrip().replace("\t", " ")
    caret = f"\n    {' ' * (column - 1)}^" if column else ""
    return f"\n    {shown}{caret}"
