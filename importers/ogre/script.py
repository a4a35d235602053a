"""Ogre's script language: text -> objects with properties, children, parents and variables.

    abstract material Base { set $tex a.png  technique { pass { texture_unit { texture $tex } } } }
    material Shown : Base  { set $tex b.png }

A statement ends with its line or a brace; words before a `{` (which may stand on the next line) head an object.
Mistakes never stop the reading: they are noted, and what is sound around them is kept.

Source: Ogre manual, scripts (syntax, inheritance, variables, imports).
"""

from __future__ import annotations

import functools
import re
from dataclasses import dataclass, field

MAX_DEPTH = 32
_TOKEN = re.compile(
    r'(?P<comment>//[^\n]*|/\*.*?(?:\*/|\Z))|(?P<quoted>"[^"\n]*")|(?P<brace>[{}])|(?P<line>\n)|(?P<word>[^\s{}"]+|")',
    re.DOTALL,
)


@dataclass(frozen=True, slots=True)
class Property:
    name: str
    values: tuple[str, ...]
    line: int


@dataclass(slots=True)
class Node:
    """`kind name values : bases { properties children }`. `file` and `line` say where it begins."""

    kind: str
    name: str = ""
    values: tuple[str, ...] = ()
    bases: tuple[str, ...] = ()
    abstract: bool = False
    file: str = ""
    line: int = 0
    properties: list[Property] = field(default_factory=list)
    children: list[Node] = field(default_factory=list)
    variables: dict[str, str] = field(default_factory=dict)

    def of(self, kind: str) -> list[Node]:
        """The children of a kind."""
        return [child for child in self.children if child.kind == kind]

    def get(self, *names: str) -> Property | None:
        """The last property of one of these names: in scripts the last one counts."""
        return next((p for p in reversed(self.properties) if p.name in names), None)


@dataclass(slots=True)
class Script:
    """`problems`: (line, what). `imports`: files that it imports from."""

    file: str
    objects: list[Node] = field(default_factory=list)
    variables: dict[str, str] = field(default_factory=dict)
    imports: list[str] = field(default_factory=list)
    problems: list[tuple[int, str]] = field(default_factory=list)


@functools.lru_cache(maxsize=64)
def parse_script(text: str, file: str) -> Script:
    """Parse the text of a script. The result is shared: do not change it."""
    return _Parser(file).parse(text)


class _Parser:
    def __init__(self, file: str) -> None:
        self._script = Script(file)
        self._stack: list[Node] = []
        self._too_deep = 0
        self._words: list[tuple[str, bool]] = []
        self._line = 1
        self._words_line = 1

    def parse(self, text: str) -> Script:
        pending = False  # words whose line has ended: an object's head if a brace follows
        for match in _TOKEN.finditer(text):
            kind, token = match.lastgroup, match.group()
            if kind == "comment":
                self._line += token.count("\n")
            elif kind == "line":
                self._line += 1
                pending = bool(self._words)
            elif token == "{" and kind == "brace":
                self._open()
                pending = False
            else:
                if pending or kind == "brace":
                    self._statement()
                    pending = False
                if kind == "brace":
                    self._close()
                    continue
                if not self._words:
                    self._words_line = self._line
                quoted = kind == "quoted"
                self._words.append((token[1:-1] if quoted else token, quoted))
        self._statement()
        if self._stack:
            top = self._stack[0]
            self._note(top.line, f"{top.kind} {top.name!r} is not closed")
            self._script.objects.append(top)
        return self._script

    def _note(self, line: int, what: str) -> None:
        if len(self._script.problems) < 20:
            self._script.problems.append((line, what))

    def _open(self) -> None:
        words, self._words = self._words, []
        if self._too_deep or len(self._stack) >= MAX_DEPTH:
            self._too_deep += 1
            if self._too_deep == 1:
                self._note(self._line, f"more than {MAX_DEPTH} levels of braces; the innermost are left out")
            return
        node = _head(words)
        node.file, node.line = self._script.file, self._words_line if words else self._line
        if not words:
            self._note(self._line, "a brace without a name before it")
        if self._stack:
            self._stack[-1].children.append(node)
        self._stack.append(node)

    def _close(self) -> None:
        if self._too_deep:
            self._too_deep -= 1
        elif not self._stack:
            self._note(self._line, "a closing brace too many")
        else:
            node = self._stack.pop()
            if not self._stack:
                self._script.objects.append(node)

    def _statement(self) -> None:
        words, self._words = [word for word, _ in self._words], []
        if not words or self._too_deep:
            return
        name, values = words[0], tuple(words[1:])
        owner = self._stack[-1] if self._stack else None
        if name == "set" and values and values[0].startswith("$"):
            scope = self._script.variables if owner is None else owner.variables
            scope[values[0]] = " ".join(values[1:])
        elif owner is not None:
            owner.properties.append(Property(name, values, self._words_line))
        elif name == "import" and len(values) >= 2:
            self._script.imports.append(values[-1])
        else:
            self._note(self._words_line, f"{name!r} stands outside of any object")


def _head(words: list[tuple[str, bool]]) -> Node:
    """The words before a brace. `:` may touch its neighbours; a material's name may hold spaces."""
    parts: list[str] = []
    for word, quoted in words:
        if quoted or ":" not in word or word == ":":
            parts.append("\0" if word == ":" and not quoted else word)
        elif word.endswith(":"):
            parts += [word[:-1], "\0"]
        elif word.startswith(":"):
            parts += ["\0", word[1:]]
        else:
            parts.append(word)
    abstract = parts[:1] == ["abstract"]
    parts = parts[abstract:]
    own, bases = parts, []
    if "\0" in parts:
        split = parts.index("\0")
        own, bases = parts[:split], [base.strip(",") for base in parts[split + 1 :] if base not in ("\0", ",")]
    kind = own[0] if own else ""
    if kind == "material":
        return Node(kind, " ".join(own[1:]), (), tuple(bases), abstract)
    return Node(kind, own[1] if len(own) > 1 else "", tuple(own[2:]), tuple(bases), abstract)
