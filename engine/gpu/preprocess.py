"""#include, defines and the line map: GLSL files -> one ShaderSource that remembers where every line came from.

A file is included once, as if it had an include guard; also where the first #include of it stands inside an #if.
"""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from engine.core.errors import Place, ShaderError, UsageError
from engine.gpu.types import ShaderSource

STAGES = ("vertex", "fragment", "compute", "geometry", "tess_control", "tess_evaluation")
MAX_BYTES = 4 << 20  # of one file: shaders are small, anything above is not a shader
MAX_NAMES = 2000  # of files that a wrong name is compared with
MAX_LINES = 200_000  # of the flattened text
MAX_INCLUDES = 2000  # that one text follows: conditional includes could multiply

_HEEDED = frozenset({"include", "version", "if", "ifdef", "ifndef", "endif"})
_DIRECTIVE = re.compile(r"\s*#\s*(\w+)")
_INCLUDE = re.compile(r'\s*#\s*include\s*"([^"]+)"\s*(//.*|/\*.*\*/\s*)?$')


class Texts(dict[Path, str]):
    """Contents by resolved path, see `flatten`, and what includes among them meant: the calls that share one see one
    state of the disk."""

    def __init__(self) -> None:
        super().__init__()
        self.found: dict[tuple[tuple[Path, ...], Path | None, str], tuple[Path, Path] | None] = {}
        self.resolved: dict[Path, Path] = {}


@dataclass(slots=True)
class _Flattening:
    """The text so far. `done`: files surely in it; `conditional`: files in it inside some #if, with a guard."""

    search: list[Path]
    roots: list[Path]
    text: list[str] = field(default_factory=list)
    lines: list[tuple[str, int]] = field(default_factory=list)
    stack: list[Path] = field(default_factory=list)
    done: set[Path] = field(default_factory=set)
    conditional: dict[Path, str] = field(default_factory=dict)
    texts: MutableMapping[Path, str] = field(default_factory=dict)
    includes: int = 0
    #: (search, including folder, what it says) -> the file and its resolved path; the same few are asked for often
    found: dict[tuple[tuple[Path, ...], Path | None, str], tuple[Path, Path] | None] = field(default_factory=dict)
    resolved: dict[Path, Path] = field(default_factory=dict)

    def resolve(self, path: Path) -> Path:
        key = self.resolved.get(path)
        if key is None:
            key = self.resolved[path] = path.resolve()
        return key

    def has(self, path: Path) -> bool:
        return path.is_file() or self.resolve(path) in self.texts

    def find(self, folder: Path | None, wanted: str) -> tuple[Path, Path] | None:
        """The file that `wanted` means, beside the including one or in `search`, and its resolved path."""
        asked = (tuple(self.search), folder, wanted)
        if asked not in self.found:
            bases = ([folder] if folder is not None else []) + self.search
            path = next((base / wanted for base in bases if self.has(base / wanted)), None)
            self.found[asked] = None if path is None else (path, self.resolve(path))
        return self.found[asked]

    def put_all(self, lines: Sequence[str], file: str, first: int) -> None:
        """Lines of a file, from number `first`."""
        self.text += lines
        self.lines += [(file, number) for number in range(first, first + len(lines))]
        if len(self.text) > MAX_LINES:
            raise ShaderError(f"more than {MAX_LINES} lines after #include", where=Place(file, first))

    def put(self, line: str, file: str, number: int) -> None:
        self.text.append(line)
        self.lines.append((file, number))
        if len(self.text) > MAX_LINES:
            raise ShaderError(f"more than {MAX_LINES} lines after #include", where=Place(file, number))


def flatten(
    path: Path, stage: str, *, search: Sequence[Path], prelude: str = "",
    defines: Mapping[str, str | int] | None = None, texts: MutableMapping[Path, str] | None = None,
) -> ShaderSource:  # fmt: skip
    """Read `path` and all it includes. Includes are looked for beside the including file, then in `search`, and must
    lie below one of those folders. `STAGE_<STAGE>` is defined to 1, then come `defines` by name, then
    `prelude`.

    `texts`: contents by resolved path. What is in it is not read from the disk; what is read is put into it. So several
    calls see the same contents, and an older state can be flattened again after the files have changed. With a `Texts`
    they also look for each file once.

    Raises ShaderError with file, line and column for a missing file (and what was meant), a cycle, a stray #version.
    """
    if stage not in STAGES:
        raise UsageError(f"unknown shader stage {stage!r}", hint=f"choose one of {', '.join(STAGES)}")
    state = _Flattening(list(search), [])
    if texts is not None:
        state.texts = texts
    if isinstance(texts, Texts):
        state.found, state.resolved = texts.found, texts.resolved
    state.roots += [state.resolve(folder) for folder in (*search, path.parent)]
    head = [f"#define STAGE_{stage.upper()} 1"]
    head += [f"#define {name} {value}" for name, value in sorted((defines or {}).items())]
    for number, line in enumerate(head, 1):
        state.put(line, "<defines>", number)
    if prelude:
        _add_text(state, prelude, "<prelude>", None, depth=0)
    if not state.has(path):
        raise ShaderError("there is no such shader file", where=path, hint=_did_you_mean(path.name, state.search))
    _add_file(state, path, depth=0)
    return ShaderSource(stage, "\n".join([*state.text, ""]), tuple(state.lines))


def _add_file(state: _Flattening, path: Path, depth: int) -> None:
    """Append a file unless it is there already."""
    key = state.resolve(path)
    if key in state.done:
        return
    guard = state.conditional.get(key, "")
    if depth > 0 and not guard:
        guard = state.conditional[key] = f"INCLUDED_{len(state.conditional)}"
    if depth == 0:
        state.done.add(key)
    if guard:
        for line in (f"#ifndef {guard}", f"#define {guard} 1"):
            state.put(line, str(path), 1)
    state.stack.append(key)
    _add_text(state, _read(state, path), str(path), path.parent, depth + bool(guard))
    state.stack.pop()
    if guard:
        state.put("#endif", str(path), 1)


def _add_text(state: _Flattening, text: str, file: str, folder: Path | None, depth: int) -> None:
    lines, directives = _scan(text)
    at = 0
    for index, name in directives:
        line, number = lines[index], index + 1
        if name == "include":
            state.put_all(lines[at:index], file, at + 1)
            at = index + 1
            _include(state, line, Place(file, number, line.index("#") + 1), folder, depth)
        elif name == "version":
            raise ShaderError(
                "#version does not belong in a shader file: the graphics backend writes it",
                where=Place(file, number, line.index("#") + 1), hint="remove the line",
            )  # fmt: skip
        else:
            depth += 1 if name != "endif" else -1
    state.put_all(lines[at:], file, at + 1)


@lru_cache(maxsize=512)  # variants are made from the same few files again and again
def _scan(text: str) -> tuple[tuple[str, ...], tuple[tuple[int, str], ...]]:
    """The lines, and which of them (from 0) are directives that matter here, outside of comments."""
    lines = tuple(text.splitlines()) or ("",)
    found = []
    in_comment = False
    for index, line in enumerate(lines):
        directive = None if in_comment or "#" not in line else _DIRECTIVE.match(line)
        if in_comment or "/*" in line:
            in_comment = _comment_goes_on(line, in_comment)
        if directive and directive[1] in _HEEDED:
            found.append((index, directive[1]))
    return lines, tuple(found)


def _include(state: _Flattening, line: str, place: Place, folder: Path | None, depth: int) -> None:
    match = _INCLUDE.match(line)
    if not match:
        raise ShaderError('#include needs a file in double quotes: #include "lib/x.glsl"', where=place)
    wanted = match[1]
    place = Place(place.file, place.line, line.index('"') + 1)
    known = state.find(folder, wanted)
    if known is None:
        raise ShaderError(
            f"#include {wanted!r} is neither beside this file nor in {', '.join(map(str, state.search))}",
            where=place, hint=_did_you_mean(wanted, state.search + ([folder] if folder else [])),
        )  # fmt: skip
    found, key = known
    if not any(key.is_relative_to(root) for root in state.roots):
        raise ShaderError(
            f"#include {wanted!r} lies outside the shader folders", where=place, hint="copy the file into one of them"
        )
    if key in state.stack:
        chain = " -> ".join(p.name for p in [*state.stack[state.stack.index(key) :], key])
        raise ShaderError(f"#include {wanted!r} closes a cycle: {chain}", where=place)
    state.includes += 1
    if state.includes > MAX_INCLUDES:
        raise ShaderError(
            f"more than {MAX_INCLUDES} files through #include", where=place,
            hint="#include each file once, outside of any #if",
        )  # fmt: skip
    _add_file(state, found, depth)


def _read(state: _Flattening, path: Path) -> str:
    key = state.resolve(path)
    if key in state.texts:
        return state.texts[key]
    try:
        if path.stat().st_size > MAX_BYTES:
            raise ShaderError(f"a shader file has at most {MAX_BYTES >> 20} MiB", where=path)
        text = state.texts[key] = path.read_text(encoding="utf-8-sig")
        return text
    except UnicodeDecodeError as error:
        place = Place(str(path), error.object.count(b"\n", 0, error.start) + 1)
        raise ShaderError(f"not UTF-8 text: {error.reason} at byte {error.start}", where=place) from error
    except OSError as error:
        raise ShaderError(f"cannot be read: {error.strerror}", where=path) from error


def _comment_goes_on(line: str, inside: bool) -> bool:
    """Whether a /* comment */ is still open at the end of `line`."""
    at = 0
    while True:
        if inside:
            at = line.find("*/", at)
            if at < 0:
                return True
            inside, at = False, at + 2
        else:
            block, rest = line.find("/*", at), line.find("//", at)
            if block < 0 or 0 <= rest < block:
                return False
            inside, at = True, block + 2


def _files_below(folder: Path) -> list[str]:
    """Files by their path from `folder`; not all of a folder with very many, and none in hidden ones."""
    found: list[str] = []
    for base, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        found += [(Path(base) / name).relative_to(folder).as_posix() for name in sorted(files)]
        if len(found) > MAX_NAMES:
            break
    return found[:MAX_NAMES]


def _did_you_mean(wanted: str, folders: Sequence[Path]) -> str:
    known: list[str] = []
    for folder in folders:
        known += _files_below(folder)
    near = difflib.get_close_matches(wanted, known, 1) or [k for k in known if Path(k).name == Path(wanted).name][:1]
    return f"did you mean {near[0]!r}?" if near else ""
