"""Culling against brute force, and aliasing: two textures alive together never share. Random graphs."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from engine.framegraph import planning
from engine.framegraph.builder import Declaration, Resource
from engine.framegraph.planning import Lifetime
from engine.framegraph.resources import TextureSpec

SPEC = TextureSpec("rgba8")


@st.composite
def graphs(draw: st.DrawFn) -> list[Declaration]:
    """Valid declarations: each pass creates, reads and writes among what is there; some present or have effects."""
    declarations: list[Declaration] = []
    names: list[str] = []
    for index in range(draw(st.integers(1, 12))):
        d = Declaration(f"p{index}")
        if names:
            d.reads = draw(st.lists(st.sampled_from(names), unique=True, max_size=3))
            d.writes = draw(st.lists(st.sampled_from(names), unique=True, max_size=2))
        d.creates = [f"r{index}_{i}" for i in range(draw(st.integers(0, 2)))]
        d.writes = d.writes + d.creates
        names += d.creates
        d.side_effect = draw(st.booleans()) and draw(st.booleans())
        if names and draw(st.integers(0, 4)) == 0:
            d.presents = [draw(st.sampled_from(names))]
        declarations.append(d)
    for d in declarations:
        if names and draw(st.integers(0, 5)) == 0:
            d.histories = [draw(st.sampled_from(names))]
    return declarations


def resources(declarations: list[Declaration]) -> dict[str, Resource]:
    return {name: Resource(name, SPEC, creator=d.name) for d in declarations for name in d.creates}


def brute_force(declarations: list[Declaration]) -> set[int]:
    """Mark what is wanted until nothing changes, straight from the words of the rules."""
    wanted = {i for i, d in enumerate(declarations) if d.side_effect or d.presents}
    while True:
        grown = set(wanted)
        for i, d in enumerate(declarations):
            for j in range(len(declarations)):
                if j not in wanted:
                    continue
                other = declarations[j]
                for name in d.writes:
                    later = [k for k in range(i + 1, j) if name in declarations[k].writes]
                    if j > i and not later and name in (*other.reads, *other.writes):
                        grown.add(i)
                    last = not any(name in declarations[k].writes for k in range(i + 1, len(declarations)))
                    if last and name in (*other.histories, *other.presents):
                        grown.add(i)
        if grown == wanted:
            return wanted
        wanted = grown


@given(graphs())
@settings(max_examples=200, deadline=None)
def test_kept_is_what_brute_force_reaches(declarations: list[Declaration]) -> None:
    assert planning.check(declarations, resources(declarations), {}) == []
    kept = planning.reachable(
        planning.dependencies(declarations), planning.roots(declarations, resources(declarations))
    )
    assert kept == brute_force(declarations)


@given(graphs(), st.integers(1, 3))
@settings(max_examples=200, deadline=None)
def test_aliased_textures_are_never_alive_together(declarations: list[Declaration], kind_count: int) -> None:
    spans = planning.lifetimes(declarations)
    kinds = {name: index % kind_count for index, name in enumerate(spans)}
    slots = planning.alias(spans, kinds)
    assert slots.keys() == kinds.keys()
    owner: dict[tuple[int, int], str] = {}
    for name, slot in slots.items():
        assert all(kinds[other] == kinds[name] for other in slots if slots[other] == slot)
        for index in range(spans[name].first, spans[name].last + 1):
            assert owner.setdefault((slot, index), name) == name
    for kind in range(kind_count):
        mine = [spans[n] for n in kinds if kinds[n] == kind]
        most = max((sum(s.first <= i <= s.last for s in mine) for i in range(len(declarations))), default=0)
        assert len({slots[n] for n in kinds if kinds[n] == kind}) == most  # interval colouring is optimal


def test_a_texture_may_take_the_place_of_one_that_died_before() -> None:
    spans = {"a": Lifetime(0, 1), "b": Lifetime(1, 2), "c": Lifetime(2, 3)}
    assert planning.alias(spans, dict.fromkeys(spans, "rgba8")) == {"a": 0, "b": 1, "c": 0}
