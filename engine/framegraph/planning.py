"""The pure part of compiling: checks, reverse reachability, lifetimes, aliasing. Names and indices only, no textures.

Culling as in the frame graph of Frostbite (O'Donnell 2017): walk back from what is wanted, drop what was not met.
Aliasing is first-fit over intervals sorted by their start, which needs the least textures per description (interval
graph colouring, Gavril 1972).
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

from engine.framegraph.builder import Declaration, Resource, did_you_mean


@dataclass(frozen=True, slots=True)
class Lifetime:
    """First and last kept pass (index, inclusive) that uses a resource."""

    first: int
    last: int


def check(
    declarations: Sequence[Declaration], resources: Mapping[str, Resource], absent: Mapping[str, tuple[str, str]]
) -> list[str]:
    """All mistakes in what the passes declared, in words.

    `absent`: resources that only passes without need would create -> (pass, reason).
    """
    errors = []
    creators = {name: index for index, d in enumerate(declarations) for name in (*d.creates, *d.imports)}
    for index, declaration in enumerate(declarations):
        for verb, names in (("reads", declaration.reads), ("writes", declaration.writes)):
            for name in names:
                if creators.get(name, index + 1) > index:
                    errors.append(_missing(declarations, index, verb, name, resources, creators, absent))
        named = [("reads the history of", n) for n in declaration.histories]
        named += [("presents", n) for n in declaration.presents] + [("keeps", n) for n in declaration.keeps]
        for verb, name in named:
            if name not in resources:
                errors.append(_missing(declarations, index, verb, name, resources, creators, absent))
            elif resources[name].imported is not None and verb.endswith("of"):
                errors.append(f"pass {declaration.name!r}: {verb} {name!r}, which is imported (its owner keeps it)")
    return errors


def _missing(
    declarations: Sequence[Declaration], index: int, verb: str, name: str, resources: Mapping[str, Resource],
    creators: Mapping[str, int], absent: Mapping[str, tuple[str, str]],
) -> str:  # fmt: skip
    start = f"pass {declarations[index].name!r}: {verb} {name!r}"
    if name in creators:
        later = creators[name]
        cycle = _path(declarations, creators, later, index)
        if cycle:
            names = " -> ".join(declarations[i].name for i in (index, *cycle))
            return f"{start}, which makes a cycle: {names} (break it, or read the history of {name!r})"
        return (
            f"{start} before pass {declarations[later].name!r} creates it"
            f" (put {declarations[later].name!r} first, or read the history of {name!r})"
        )
    if name in absent:
        owner, reason = absent[name]
        return f"{start}, but pass {owner!r} is left out: {reason} (declare it with read(..., optional=True))"
    return f"{start}, which no pass writes ({did_you_mean(name, resources)})"


def _path(
    declarations: Sequence[Declaration], creators: Mapping[str, int], start: int, goal: int
) -> tuple[int, ...] | None:
    """The passes from `start` to `goal` along what each needs, both included; None when there is no way."""
    stack: list[tuple[int, ...]] = [(start,)]
    seen = {start}
    while stack:
        path = stack.pop()
        if path[-1] == goal:
            return path
        for name in (*declarations[path[-1]].reads, *declarations[path[-1]].writes):
            other = creators.get(name, path[-1])
            if other not in seen:
                seen.add(other)
                stack.append((*path, other))
    return None


def dependencies(declarations: Sequence[Declaration]) -> list[set[int]]:
    """For each pass the passes that made the versions it needs. Histories need the last writer of the frame."""
    writers: dict[str, int] = {}
    needs: list[set[int]] = []
    for index, declaration in enumerate(declarations):
        names = {*declaration.reads, *declaration.writes}
        needs.append({writers[name] for name in names if name in writers})
        writers.update(dict.fromkeys(declaration.writes, index))
    for index, declaration in enumerate(declarations):
        needs[index] |= {writers[name] for name in declaration.histories if name in writers}
        needs[index].discard(index)
    return needs


def roots(declarations: Sequence[Declaration], resources: Mapping[str, Resource]) -> set[int]:
    """Passes wanted for themselves: they present, have a side effect, or write what was imported."""
    found = set()
    last_writer = {name: index for index, d in enumerate(declarations) for name in d.writes}
    for index, declaration in enumerate(declarations):
        if declaration.side_effect or declaration.presents:
            found.add(index)
        found |= {last_writer[name] for name in declaration.presents if name in last_writer}
        if any(resources[name].imported is not None for name in declaration.writes):
            found.add(index)
    return found


def reachable(needs: Sequence[set[int]], start: set[int]) -> set[int]:
    """Everything that `start` depends on, and `start`."""
    found, stack = set(start), list(start)
    while stack:
        for other in needs[stack.pop()] - found:
            found.add(other)
            stack.append(other)
    return found


def lifetimes(declarations: Sequence[Declaration]) -> dict[str, Lifetime]:
    """Of each resource, in order of first use, the span of passes that read or write it."""
    spans: dict[str, Lifetime] = {}
    for index, declaration in enumerate(declarations):
        for name in (*declaration.imports, *declaration.reads, *declaration.writes, *declaration.presents):
            spans[name] = Lifetime(spans[name].first if name in spans else index, index)
    return spans


def alias(spans: Mapping[str, Lifetime], kinds: Mapping[str, Hashable]) -> dict[str, int]:
    """Give each resource of `kinds` a slot; resources share one only if of equal kind and never alive together."""
    slots: dict[str, int] = {}
    busy_until: list[int] = []
    slot_kind: list[Hashable] = []
    for name in sorted(kinds, key=lambda n: (spans[n].first, n)):
        for slot, end in enumerate(busy_until):
            if slot_kind[slot] == kinds[name] and end < spans[name].first:
                break
        else:
            slot = len(busy_until)
            busy_until.append(-1)
            slot_kind.append(kinds[name])
        busy_until[slot] = spans[name].last
        slots[name] = slot
    return slots
