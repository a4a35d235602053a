"""AnimationGraph: what a kind of character can do, resolved to numbers: motions, states, transitions, layers.

Made from an animation file (animation_file.py) or by hand; shared by all characters and never changed while they play.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from engine.animation.blend_space import BlendSpace
from engine.animation.events import Marker
from engine.animation.rig import Rig
from engine.animation.sampler import ClipSampler
from engine.core.errors import InputError

F8 = NDArray[np.float64]


@dataclass(slots=True)
class ClipUse:
    """A clip and its markers."""

    sampler: ClipSampler
    markers: list[Marker] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Motion:
    """One clip, or several in a blend space steered by the parameters `params` (numbers). Clips of one motion run in
    step by phase: each is at the same share of its own length."""

    clips: tuple[int, ...]
    space: BlendSpace | None = None
    params: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class State:
    name: str
    motion: Motion
    speed: float = 1.0
    mode: str = "loop"


@dataclass(frozen=True, slots=True)
class Condition:
    """`param` (number) `op` value: one of > >= < <= == !=."""

    param: int
    op: str
    value: float


@dataclass(frozen=True, slots=True)
class Transition:
    """From state `source` (-1: any other) to `target` when all conditions hold and the state has run to the phase
    `exit_phase`. `sync` starts the target at the phase of the source."""

    source: int
    target: int
    conditions: tuple[Condition, ...] = ()
    seconds: float = 0.2
    curve: str = "smooth"
    exit_phase: float | None = None
    sync: bool = False


@dataclass(frozen=True, slots=True)
class Param:
    """`kind`: float, bool, or trigger (true until a transition that asks for it is taken)."""

    name: str
    kind: Literal["float", "bool", "trigger"] = "float"
    default: float = 0.0


@dataclass(slots=True)
class LayerUse:
    """A motion laid over the states' pose. `weight` is the parameter that steers it (-1: `constant`)."""

    name: str
    motion: Motion
    mask: F8
    mode: Literal["override", "additive"] = "override"
    reference: F8 | None = None
    weight: int = -1
    constant: float = 1.0
    speed: float = 1.0
    play: str = "loop"


@dataclass(slots=True)
class AnimationGraph:
    rig: Rig
    clips: list[ClipUse]
    states: list[State]
    params: list[Param] = field(default_factory=list)
    transitions: list[Transition] = field(default_factory=list)
    layers: list[LayerUse] = field(default_factory=list)
    #: rig node whose way is given to the character, or -1
    root: int = -1
    start: int = 0
    name: str = ""

    def validate(self) -> None:
        """Raise InputError for a number that names nothing or a value out of range."""
        if not self.states or not 0 <= self.start < len(self.states):
            raise InputError("an animation needs a state to start in")
        for motion in [s.motion for s in self.states] + [layer.motion for layer in self.layers]:
            space = motion.space
            if not motion.clips or not all(0 <= c < len(self.clips) for c in motion.clips):
                raise InputError(f"a motion of the clips {motion.clips}, of {len(self.clips)}")
            if (space is None) != (len(motion.params) == 0) or (space is None and len(motion.clips) != 1):
                raise InputError("a motion of several clips needs a blend space, and that its parameters")
            if space is not None and (len(space.points), space.dimensions) != (len(motion.clips), len(motion.params)):
                raise InputError(
                    f"a blend space of {space.points.shape} for {len(motion.clips)} clips and "
                    f"{len(motion.params)} parameters"
                )
            if not all(0 <= p < len(self.params) for p in motion.params):
                raise InputError(f"a motion steered by the parameters {motion.params}, of {len(self.params)}")
        for t in self.transitions:
            if not (-1 <= t.source < len(self.states) and 0 <= t.target < len(self.states)):
                raise InputError(f"a transition from {t.source} to {t.target}, of {len(self.states)} states")
            if not 0.0 <= t.seconds < np.inf:
                raise InputError(f"a transition that takes {t.seconds} s")
            if not all(0 <= c.param < len(self.params) for c in t.conditions):
                raise InputError("a transition on a parameter that does not exist")
        for layer in self.layers:
            if layer.mask.shape != (len(self.rig),):
                raise InputError(f"layer {layer.name!r}: a mask {layer.mask.shape} for {len(self.rig)} nodes")
            if layer.mode == "additive" and layer.reference is None:
                raise InputError(f"layer {layer.name!r} is additive", hint="name the pose its clip starts from")

    @property
    def marker_names(self) -> list[str]:
        """The markers' names, clip after clip: what Fired.marker counts in."""
        return [marker.name for clip in self.clips for marker in clip.markers]


def single(sampler: ClipSampler, mode: str = "loop", speed: float = 1.0) -> AnimationGraph:
    """Just that clip."""
    return AnimationGraph(sampler.rig, [ClipUse(sampler)], [State(sampler.name, Motion((0,)), speed, mode)])
