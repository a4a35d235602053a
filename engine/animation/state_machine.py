"""StateMachine: which state each character is in, what it is fading from, and how far."""

from __future__ import annotations

import operator
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation.blend import fade
from engine.animation.graph import AnimationGraph, Transition
from engine.animation.playhead import Playheads, Step, Who, chosen, mode_number
from engine.assets.records import did_you_mean
from engine.core.errors import InputError

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]

OPERATORS: dict[str, Callable[[F8, float], NDArray[np.bool_]]] = {
    ">": operator.gt, ">=": operator.ge, "<": operator.lt, "<=": operator.le, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip

#: `source` of a fade whose own fade was cut short: the pose at that moment, held
FROZEN = -2
NO_FADE = -1


class StateMachine:
    """m characters in the states of `graph`. `values` f8[p,m]: their parameters.

    `state` i8[m]; `source` i8[m]: the state faded from, FROZEN, or NO_FADE; `heads` and `source_heads`: where they are
    in them. Transitions are tried in their order; the first whose conditions hold is taken, also in mid-fade.
    """

    def __init__(self, graph: AnimationGraph, characters: int) -> None:
        graph.validate()
        self.graph = graph
        self.values: F8 = np.repeat(np.array([[p.default] for p in graph.params]).reshape(-1, 1), characters, axis=1)
        self.state: I8 = np.full(characters, graph.start, np.int64)
        self.source: I8 = np.full(characters, NO_FADE, np.int64)
        self.transition: I8 = np.full(characters, -1, np.int64)
        self.elapsed: F8 = np.zeros(characters)
        self.heads = Playheads(characters, graph.states[graph.start].mode)
        self.source_heads = Playheads(characters)
        self._modes = np.array([mode_number(s.mode) for s in graph.states])
        self._seconds = np.array([t.seconds for t in graph.transitions] or [0.0])

    def param(self, name: str) -> int:
        """The parameter's number. Raises InputError with what was perhaps meant."""
        names = [p.name for p in self.graph.params]
        if name not in names:
            raise InputError(f"there is no parameter {name!r}", hint=did_you_mean(name, names))
        return names.index(name)

    def set(self, name: str, value: ArrayLike, who: Who = slice(None)) -> None:
        """Set a parameter (a trigger: 1) of the characters `who`; what is not finite becomes 0."""
        self.values[self.param(name), chosen(who, len(self.state))] = np.nan_to_num(
            np.asarray(value, np.float64), posinf=0.0, neginf=0.0
        )

    def state_names(self) -> list[str]:
        """The name of each character's state."""
        return [self.graph.states[s].name for s in self.state]

    def decide(self) -> NDArray[np.bool_]:
        """Take the transitions that are due; bool[m]: who cut a fade short, and needs its pose of now held."""
        free = np.ones(len(self.state), np.bool_)
        frozen = np.zeros(len(self.state), np.bool_)
        for number, transition in enumerate(self.graph.transitions):
            due = free & self._due(transition)
            if not due.any():
                continue
            who = np.flatnonzero(due)
            free[who] = False
            for condition in transition.conditions:
                if self.graph.params[condition.param].kind == "trigger":
                    self.values[condition.param, who] = 0.0
            frozen[who] |= self.source[who] != NO_FADE
            self._start(number, transition, who)
        self.source[frozen & (self.source != NO_FADE)] = FROZEN
        cut: NDArray[np.bool_] = frozen & (self.source == FROZEN)
        return cut

    def _due(self, transition: Transition) -> NDArray[np.bool_]:
        due: NDArray[np.bool_] = np.ones(len(self.state), np.bool_)
        due &= self.state == transition.source if transition.source >= 0 else self.state != transition.target
        for condition in transition.conditions:
            due &= OPERATORS[condition.op](self.values[condition.param], condition.value)
        if transition.exit_phase is not None:
            due &= (self.heads.turn > 0) | (self.heads.phase >= transition.exit_phase)
        return due

    def _start(self, number: int, transition: Transition, who: I8) -> None:
        phase = self.heads.fraction[who]
        self.source[who] = self.state[who] if transition.seconds > 0.0 else NO_FADE
        self.source_heads.copy_from(self.heads, who)
        self.state[who] = transition.target
        self.transition[who], self.elapsed[who] = number, 0.0
        self.heads.mode[who] = self._modes[transition.target]
        self.heads.seek(phase if transition.sync else 0.0, who)

    def advance(self, dt: F8, rates: F8, source_rates: F8 | None) -> tuple[Step, Step]:
        """Go on by `dt` f8[m] seconds at `rates` f8[m] (phases a second); the steps of the states and the sources.
        Without `source_rates` nobody fades, and the second step says nothing."""
        step = self.heads.advance(dt * rates)
        if source_rates is None:
            return step, step
        source_step = self.source_heads.advance(dt * source_rates)
        # a fade runs forward, also where the clip runs back
        self.elapsed += np.abs(dt)
        done = (self.source != NO_FADE) & (self.elapsed >= self._seconds[self.transition])
        self.source[done] = NO_FADE
        return step, source_step

    def weight(self) -> F8:
        """f8[m]: how much of each pose is the current state's; the rest is the source's."""
        result = np.ones(len(self.state))
        fades = self.source != NO_FADE
        for number in np.unique(self.transition[fades]) if fades.any() else ():
            who = (self.transition == number) & (self.source != NO_FADE)
            transition = self.graph.transitions[number]
            result[who] = fade(self.elapsed[who] / transition.seconds, transition.curve)
        return result
