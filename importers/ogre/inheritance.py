"""Objects of scripts as they are meant: with what they inherit, and their variables filled in.

A child object without a name stands for the parent's child of its kind and number; a named one for the parent's of
that name, or for a new one. Its properties come after the parent's: the last one counts.

Source: Ogre manual, scripts (inheritance, overriding, variables).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from importers.ogre.script import Node, Property, Script

#: objects and properties that one material may come to, all its parents included
MAX_PARTS = 50_000
_MAX_CHAIN = 64
_MAX_TEXT = 4096


class Library:
    """The objects of several scripts by kind and name; of equal names the first script's counts."""

    def __init__(self, scripts: Iterable[Script]) -> None:
        self._objects: dict[tuple[str, str], list[Node]] = {}
        self._variables: dict[str, Mapping[str, str]] = {}
        self.scripts = list(scripts)
        for script in self.scripts:
            self._variables[script.file] = script.variables
            for node in script.objects:
                self._objects.setdefault((node.kind, node.name), []).append(node)

    def names(self, kind: str) -> list[str]:
        """The names of all objects of a kind that are not abstract."""
        return [name for (k, name), nodes in self._objects.items() if k == kind and not nodes[0].abstract]

    def find(self, kind: str, name: str) -> list[Node]:
        """All objects of that kind and name, as written."""
        return self._objects.get((kind, name), [])

    def resolve(self, node: Node, problems: list[str]) -> Node:
        """A copy of `node` with its parents merged in and variables replaced. What fails is told in `problems`."""
        self._left = MAX_PARTS
        merged = self._merged(node, problems, ())
        if self._left < 0:
            problems.append(f"comes to more than {MAX_PARTS:,} parts with what it inherits; cut")
        scope = dict(self._variables.get(node.file, {}))
        return _filled(merged, scope, problems)

    def _merged(self, node: Node, problems: list[str], chain: tuple[str, ...]) -> Node:
        result = replace(node, properties=[], children=[], variables={})
        if len(chain) >= _MAX_CHAIN:
            problems.append(f"the parents of {chain[0]!r} go on for more than {_MAX_CHAIN} steps")
            return result
        for base in node.bases:
            self._left -= 1
            if self._left < 0:
                break
            if base in chain or base == node.name:
                problems.append(f"{node.name!r} inherits from itself by way of {base!r}")
                continue
            found = self.find(node.kind, base)
            if not found:
                problems.append(f"the parent {base!r} is in no script")
                continue
            self._overlay(result, self._merged(found[0], problems, (*chain, node.name)))
        own = replace(node, children=[])
        for child in node.children:
            if self._left < 0:
                break
            own.children.append(self._merged(child, problems, (*chain, node.name)) if child.bases else child)
        self._overlay(result, own)
        return result

    def _overlay(self, below: Node, above: Node) -> None:
        """Put `above` over `below`, which is changed; `above` is not."""
        self._left -= len(above.properties) + 1
        if self._left < 0:
            return
        below.properties.extend(above.properties)
        below.variables |= above.variables
        places: dict[str, int] = {}
        existing = {kind: below.of(kind) for kind in {child.kind for child in above.children}}
        for child in above.children:
            place = places.get(child.kind, 0)
            places[child.kind] = place + 1
            target = _counterpart(existing[child.kind], child, place)
            if target is None:
                target = replace(child, properties=[], children=[], variables={})
                below.children.append(target)
            self._overlay(target, child)


def _counterpart(candidates: list[Node], child: Node, place: int) -> Node | None:
    if child.kind.endswith("_ref"):
        return None
    if child.name:
        named = next((c for c in candidates if c.name == child.name), None)
        if named is not None or not child.name.isdigit():
            return named
        place = int(child.name[:6])
    return candidates[place] if place < len(candidates) else None


def _filled(node: Node, scope: Mapping[str, str], problems: list[str]) -> Node:
    """A copy with `$name` replaced everywhere; inner scopes win."""
    scope = {**scope, **node.variables}

    def value(text: str) -> str:
        for _ in range(8):
            if not text.startswith("$"):
                break
            if text not in scope:
                problems.append(f"the variable {text} is not set")
                return ""
            text = scope[text][:_MAX_TEXT]
        return text

    properties = [
        Property(p.name, tuple(word for v in p.values for word in (value(v).split() if v[:1] == "$" else [v])), p.line)
        for p in node.properties
    ]
    return replace(
        node, properties=properties, children=[_filled(child, scope, problems) for child in node.children],
        variables=dict(scope),
    )  # fmt: skip
