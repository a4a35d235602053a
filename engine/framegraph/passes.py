"""Pass: one class in one file, with its parameters, whether the scene needs it, its resources and its work."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from engine.core.param import ParamBlock
from engine.gpu.types import Device, Texture

if TYPE_CHECKING:
    from engine.framegraph.builder import Builder
    from engine.framegraph.compiled import CompiledGraph


#: the reach of a pass whose every output pixel depends on all of its input
WHOLE_PICTURE = 1 << 30


class Pass(ABC):
    """A node of the frame graph.

        class Ssao(Pass):
            name = "ssao"

            class Params(ParamBlock):
                radius: float = param(0.5, min=0.01, max=5.0, unit="m")

    `declare` may not touch the GPU; it runs only when the graph is compiled.
    """

    name: ClassVar[str] = ""
    Params: ClassVar[type[ParamBlock]] = ParamBlock
    #: So many pixels from its own place one texel of an input may show in an output; WHOLE_PICTURE: anywhere. Every
    #: pass says it: the stability tests plant bad texels and hold it to that. None: not said.
    reach: ClassVar[int | None] = None

    def __init__(self, params: ParamBlock | None = None) -> None:
        assert self.name, f"{type(self).__name__} has no name"
        self.params: Any = self.Params() if params is None else params

    def needs(self, facts: Any) -> bool | str:
        """Whether a scene with these facts needs this pass; a str is the reason why it does not."""
        return True

    def structure_key(self) -> Hashable:
        """Whatever of the parameters changes what `declare` says; part of the key of the compiled graph."""
        return None

    @abstractmethod
    def declare(self, b: Builder) -> None:
        """Say what is created, read and written. Called with the same facts always gives the same declarations."""

    @abstractmethod
    def execute(self, ctx: PassContext) -> None:
        """Do the work. Only declared resources may be used."""


@dataclass(slots=True)
class PassContext:
    """What a pass sees while it executes. `frame` is opaque here; engine.render fills it."""

    device: Device
    graph: CompiledGraph
    pass_name: str
    facts: Any = None
    frame: Any = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the view in pixels."""
        return self.graph.size

    def texture(self, name: str) -> Texture:
        """The texture of a resource that this pass declared."""
        self._check(name)
        return self.graph.texture(name)

    def has(self, name: str) -> bool:
        """Whether this pass has that resource: False for an optional read of what is left out."""
        return name in self.graph.accesses[self.pass_name]

    def history(self, name: str) -> Texture:
        """What the resource held at the end of the previous frame; undefined while `history_reset`."""
        self._check(name)
        return self.graph.history(name)

    def history_reset(self, name: str) -> bool:
        """True when the previous frame's content is not there: first frame, after a resize, after a gap."""
        self._check(name)
        return self.graph.history_reset(name)

    def _check(self, name: str) -> None:
        assert name in self.graph.accesses[self.pass_name], f"pass {self.pass_name!r} uses {name!r} undeclared"
