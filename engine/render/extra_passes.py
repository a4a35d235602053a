"""Passes that come from outside (plug-ins): they run last, on the finished picture. One that fails is taken out.

EXTRA.add(MyPass)          ─► lens_passes() of every path ─► the next frame's graph has it
EXTRA.remove(MyPass.name)  ─► the next frame's graph has not
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from engine.core.errors import LucarnaError
from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext


class GuardedPass(Pass):
    """`inner`, whose failure is told to the registry instead of ending the frame."""

    name = "extra"
    reach = WHOLE_PICTURE

    def __init__(self, inner: Pass, registry: ExtraPasses) -> None:
        super().__init__(inner.params)
        self.inner, self.registry = inner, registry
        self.name = inner.name  # type: ignore[misc]  # each wraps another, so the name is the instance's

    def needs(self, facts: Any) -> bool | str:
        try:
            return self.inner.needs(facts)
        except Exception as error:  # a plug-in raises what it likes: it is switched off, the frame goes on
            self.registry.fail(self.name, error)
            return f"it failed: {error}"

    def declare(self, b: Builder) -> None:
        try:
            self.inner.declare(b)
        except Exception as error:  # a plug-in raises what it likes: it is switched off, the frame goes on
            self.registry.fail(self.name, error)
            raise LucarnaError(f"pass {self.name}: {error}", hint="it was switched off") from error

    def execute(self, ctx: PassContext) -> None:
        try:
            self.inner.execute(ctx)
        except Exception as error:  # a plug-in raises what it likes: it is switched off, the frame goes on
            self.registry.fail(self.name, error)


class ExtraPasses:
    """`revision` grows with every change, so that renderers make their graphs anew. `failed` is told of a pass that
    raised; it is out by then."""

    def __init__(self) -> None:
        self._kinds: dict[str, type[Pass]] = {}
        #: the parameters of each, shared by the graphs of all paths
        self.params: dict[str, Any] = {}
        self.revision = 0
        self.failed: Callable[[str, Exception], None] = lambda name, error: None

    def add(self, kind: type[Pass]) -> None:
        """Raises LucarnaError for a name that is taken or none."""
        if not kind.name or kind.name in self._kinds:
            raise LucarnaError(f"there is a pass {kind.name!r} already" if kind.name else "a pass needs a name")
        self._kinds[kind.name] = kind
        self.params[kind.name] = kind.Params()
        self.revision += 1

    def remove(self, name: str) -> None:
        if self._kinds.pop(name, None) is not None:
            del self.params[name]
            self.revision += 1

    def make(self) -> list[Pass]:
        return [GuardedPass(kind(self.params[name]), self) for name, kind in self._kinds.items()]

    def fail(self, name: str, error: Exception) -> None:
        if name in self._kinds:
            self.remove(name)
            self.failed(name, error)


EXTRA = ExtraPasses()
