"""What could be meant at the cursor of a shader, effect or material file, with a word about each.

GLSL: files to include, parameters and textures of the scene's effects, features, functions of what is included, names
of this file, GLSL itself. TOML: the keys of the table at the cursor, and the values that one may have.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from editor.code.glsl_words import DIRECTIVES, WORDS
from editor.code.toml_words import toml_words
from engine.materials.effect import Effect

_INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]*)$')
_DIRECTIVE = re.compile(r"^\s*#\s*([a-z]*)$")
_WORD = re.compile(r"[A-Za-z_]\w*$")
_MEMBER = re.compile(r"\bm\.(\w*)$")
_INCLUDED = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
_FUNCTION = re.compile(r"^(?:\w+\s+)?(\w+)\s+(\w+)\s*\(([^;{)]*)\)\s*\n?\{", re.MULTILINE)
_COMMENT_BEFORE = re.compile(r"//\s*(.*)\n$")
#: files that includes are followed through
MOST_FILES = 64


@dataclass(frozen=True, slots=True)
class Candidate:
    """`about` stands beside the name, `doc` is its tooltip."""

    name: str
    about: str = ""
    doc: str = ""


def candidates(
    before: str, text: str, line: int, language: str, includes: Sequence[str], effects: Sequence[Effect],
    search: Sequence[Path] = (),
) -> tuple[str, list[Candidate]]:  # fmt: skip
    """(what is typed of it, what could be meant, the likeliest first) for the cursor after `before` in line `line`
    (from 1) of the file `text`."""
    if language == "toml":
        typed, known = toml_words(before, text, line, effects)
        return typed, _ranked(typed, (Candidate(name, about) for name, about in known))
    include = _INCLUDE.match(before)
    if include:
        return include[1], _ranked(include[1], (Candidate(name) for name in includes))
    directive = _DIRECTIVE.match(before)
    if directive:
        return directive[1], _ranked(directive[1], (Candidate(name, "directive") for name in DIRECTIVES))
    member = _MEMBER.search(before)
    if member:
        return member[1], _ranked(member[1], (_of_param(p) for effect in effects for p in effect.params))
    word = _WORD.search(before)
    typed = word[0] if word else ""
    known_names: list[Candidate] = []
    for effect in effects:
        known_names += [Candidate(name.upper(), "feature", feature.doc) for name, feature in effect.features.items()]
        known_names += [Candidate(f"sample_{slot.name}", "(m, uv0, uv1) → vec4", slot.doc) for slot in effect.textures]
        known_names += [_of_param(p) for p in effect.params]
    own = set(re.findall(r"[A-Za-z_]\w{2,}", text)) - {typed}
    functions = included_functions(text, search)
    return typed, _ranked(
        typed,
        [
            *known_names,
            *functions.values(),
            *(Candidate(name, "in this file") for name in sorted(own) if name not in WORDS),
            *(Candidate(name, about) for name, about in WORDS.items()),
        ],
    )


def completions(
    before: str, text: str, includes: Sequence[str], effects: Iterable[Effect], search: Sequence[Path] = ()
) -> tuple[str, list[str]]:
    """As `candidates` for a shader, the names alone."""
    typed, found = candidates(before, text, 0, "glsl", includes, list(effects), search)
    return typed, [candidate.name for candidate in found]


def include_names(search: Sequence[Path]) -> list[str]:
    """All files that can be included, as they are written in an #include."""
    found: dict[str, None] = {}
    for folder in search:
        for file in sorted(folder.glob("*/*.glsl")):
            found.setdefault(file.relative_to(folder).as_posix())
    return list(found)


def included_functions(text: str, search: Sequence[Path]) -> Mapping[str, Candidate]:
    """name -> the functions of `text` and of all that it includes, with the comment above each."""
    found: dict[str, Candidate] = {}
    seen: set[str] = set()
    queue = [("", text)]
    while queue and len(seen) < MOST_FILES:
        origin, source = queue.pop(0)
        for match in _FUNCTION.finditer(source):
            result, name, arguments = match.groups()
            above = _COMMENT_BEFORE.search(source[: match.start()])
            call = f"({' '.join(arguments.split())}) → {result}"
            where = f"{origin}\n" if origin else ""
            found.setdefault(name, Candidate(name, call, f"{where}{above[1] if above else ''}"))
        for name in _INCLUDED.findall(source):
            file = next((folder / name for folder in search if (folder / name).is_file()), None)
            if name not in seen and file is not None:
                seen.add(name)
                try:
                    queue.append((name, file.read_text(encoding="utf-8-sig")))
                except (OSError, UnicodeDecodeError):
                    continue  # the compiler says what is wrong with it
    return found


def _of_param(param: object) -> Candidate:
    unit = f" {getattr(param, 'unit', '')}".rstrip()
    return Candidate(getattr(param, "name", ""), f"{getattr(param, 'type', '')}{unit}", getattr(param, "doc", ""))


def _ranked(typed: str, found: Iterable[Candidate]) -> list[Candidate]:
    """Those that begin with what is typed, then those that hold it; each name once."""
    lowered = typed.lower()
    unique: dict[str, Candidate] = {}
    for candidate in found:
        if candidate.name != typed:
            unique.setdefault(candidate.name, candidate)
    starts = [c for name, c in unique.items() if name.lower().startswith(lowered)]
    holds = [c for name, c in unique.items() if lowered and lowered in name.lower()[1:] and c not in starts]
    return starts + holds
