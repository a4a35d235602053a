"""Builder: what a pass says about its resources. Mistakes are collected, so that all are reported at once."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from engine.framegraph.resources import TextureSpec
from engine.gpu.types import Texture


@dataclass(slots=True)
class Resource:
    """A named texture of the graph. `spec` for created ones, `imported` for those that come from outside."""

    name: str
    spec: TextureSpec | None
    imported: Texture | None = None
    creator: str = ""


@dataclass(slots=True)
class Declaration:
    """What one pass declared, by resource name. `writes` includes `creates`."""

    name: str
    creates: list[str] = field(default_factory=list)
    imports: list[str] = field(default_factory=list)
    reads: list[str] = field(default_factory=list)
    optional: list[str] = field(default_factory=list)  # optional reads which found nothing
    writes: list[str] = field(default_factory=list)
    histories: list[str] = field(default_factory=list)
    presents: list[str] = field(default_factory=list)
    keeps: list[str] = field(default_factory=list)
    side_effect: bool = False

    @property
    def used(self) -> frozenset[str]:
        return frozenset((*self.reads, *self.writes, *self.histories, *self.presents, *self.keeps, *self.imports))


class Builder:
    """Given to `Pass.declare`. Nothing here raises or touches the GPU.

    `facts` and `view_size` (pixels) are there to be looked at; whatever depends on them is part of the graph's key.
    """

    def __init__(
        self, name: str, resources: dict[str, Resource], errors: list[str], facts: Any, view_size: tuple[int, int]
    ) -> None:
        self.declaration = Declaration(name)
        self.facts = facts
        self.view_size = view_size
        self.resources = resources
        self._errors = errors

    def create(
        self, name: str, format: str, *, scale: float = 1.0, size: tuple[int, int] | None = None,
        kind: str = "2d", mips: int = 1, layers: int = 1, samples: int = 1,
    ) -> None:  # fmt: skip
        """A new transient texture, of `size` pixels or `scale` times the view (rounded up); `mips` 0 = full chain.

        Its content is undefined: this pass must write all of it or clear it.
        """
        spec = TextureSpec(format, scale, size, kind, mips, layers, samples)
        self._errors += [f"pass {self.declaration.name!r}: {name!r} {problem}" for problem in spec.problems()]
        if self._new(name, Resource(name, spec, creator=self.declaration.name)):
            _once(self.declaration.creates, name)
            _once(self.declaration.writes, name)

    def import_texture(self, name: str, texture: Texture) -> None:
        """Bring in a texture that lives outside the graph. Its readers and writers say so with read and write.

        A write to it is visible outside, so its writers stay. The compiled graph keeps the texture: give a new one with
        `CompiledGraph.bind`, or put its identity in the key.
        """
        if self._new(name, Resource(name, None, texture, self.declaration.name)):
            _once(self.declaration.imports, name)

    def read(self, name: str, *, optional: bool = False) -> bool:
        """Read the last version written before this pass. With `optional`, returns False when there is none."""
        if optional and name not in self.resources:
            _once(self.declaration.optional, name)
            return False
        _once(self.declaration.reads, name)
        return name in self.resources

    def write(self, name: str) -> None:
        """Write over the last version (which is kept where this pass does not write): makes a new version."""
        _once(self.declaration.writes, name)

    def history(self, name: str) -> None:
        """Read what `name` held at the end of the previous frame; it becomes a pair of textures that swap."""
        _once(self.declaration.histories, name)

    def present(self, name: str) -> None:
        """`name`, as it is at the end of the frame, is a result: what it depends on stays, it is not aliased."""
        _once(self.declaration.presents, name)

    def keep(self, name: str) -> None:
        """`name` may be looked at after the frame: it is not aliased. It makes no pass stay."""
        _once(self.declaration.keeps, name)

    def side_effect(self) -> None:
        """This pass does something outside of its textures: it stays."""
        self.declaration.side_effect = True

    def _new(self, name: str, resource: Resource) -> bool:
        other = self.resources.get(name)
        if other is not None:
            self._errors.append(
                f"pass {self.declaration.name!r}: creates {name!r}, but pass {other.creator!r} did already"
                " (write to it instead, or give it another name)"
            )
            return False
        self.resources[name] = resource
        return True


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`did you mean 'x'?`, or what there is."""
    known = sorted(known)
    near = difflib.get_close_matches(name, known, 1)
    return f"did you mean {near[0]!r}?" if near else f"there are: {', '.join(known) or 'none'}"


def _once(names: list[str], name: str) -> None:
    if name not in names:
        names.append(name)
