"""Textures behind compiled graphs: sharing, freeing, histories and their reset."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from engine.framegraph.builder import Builder
from engine.framegraph.graph import FrameGraph
from engine.framegraph.passes import Pass, PassContext
from engine.gpu import open_device
from engine.gpu.types import Device, Texture

SIZE = (16, 8)


@pytest.fixture
def device() -> Iterator[Device]:
    device = open_device("null")
    yield device
    device.release()


class Draw(Pass):
    name = "draw"

    def declare(self, b: Builder) -> None:
        b.create("a", "rgba16f")
        b.create("taa", "rgba16f")

    def execute(self, ctx: PassContext) -> None: ...


class Blur(Pass):
    name = "blur"

    def declare(self, b: Builder) -> None:
        b.read("a")
        b.create("b", "rgba16f")

    def execute(self, ctx: PassContext) -> None: ...


class Resolve(Pass):
    name = "resolve"

    def __init__(self) -> None:
        super().__init__()
        self.seen: list[tuple[Texture, Texture, bool]] = []

    def declare(self, b: Builder) -> None:
        b.read("b")
        b.write("taa")
        b.history("taa")
        b.create("c", "rgba16f")
        b.present("c")

    def execute(self, ctx: PassContext) -> None:
        self.seen.append((ctx.texture("taa"), ctx.history("taa"), ctx.history_reset("taa")))


def textures(device: Device) -> Any:
    return {k: v for k, v in device.live_objects().items() if "texture" in k}


def test_history_swaps_and_says_when_it_is_new(device: Device) -> None:
    resolve = Resolve()
    graph = FrameGraph([Draw(), Blur(), resolve])
    for _ in range(3):
        graph.compile(device, None, SIZE).execute()
    (now0, before0, reset0), (now1, before1, reset1), (now2, before2, reset2) = resolve.seen
    assert (reset0, reset1, reset2) == (True, False, False)
    assert now0 is not before0
    assert before1 is now0
    assert now1 is before0
    assert now2 is now0
    assert before2 is now1


def test_history_survives_a_recompile_but_not_a_resize_or_gap(device: Device) -> None:
    resolve = Resolve()
    graph = FrameGraph([Draw(), Blur(), resolve])
    graph.compile(device, "day", SIZE).execute()
    graph.compile(device, "night", SIZE).execute()
    assert resolve.seen[1][2] is False
    assert resolve.seen[1][1] is resolve.seen[0][0]
    graph.compile(device, "night", (8, 8)).execute()
    assert resolve.seen[2][2] is True
    graph.reset_history(device)
    graph.compile(device, "night", (8, 8)).execute()
    assert resolve.seen[3][2] is True


def test_history_is_reset_after_frames_without_it(device: Device) -> None:
    class MaybeResolve(Resolve):
        def declare(self, b: Builder) -> None:
            if b.facts:
                super().declare(b)
            else:
                b.create("c", "rgba16f")
                b.present("c")

    resolve = MaybeResolve()
    graph = FrameGraph([Draw(), Blur(), resolve])
    resolve_execute = Resolve.execute
    MaybeResolve.execute = lambda self, ctx: resolve_execute(self, ctx) if ctx.has("taa") else None  # type: ignore[method-assign]  # a test double
    for facts in (True, True, False, True):
        graph.compile(device, facts, SIZE).execute()
    assert [reset for _, _, reset in resolve.seen] == [True, False, True]


def test_views_have_their_own_results_and_share_transients(device: Device) -> None:
    graph = FrameGraph([Draw(), Blur(), Resolve()])
    left = graph.compile(device, None, SIZE, key="left")
    right = graph.compile(device, None, SIZE, key="right")
    left.execute()
    right.execute()
    assert left.texture("c") is not right.texture("c")
    assert left.texture("a") is right.texture("a")
    assert left.texture("taa") is not right.texture("taa")


def test_transient_bytes(device: Device) -> None:
    compiled = FrameGraph([Draw(), Blur(), Resolve()]).compile(device, None, SIZE)
    assert compiled.unaliased_bytes == 2 * 16 * 8 * 8  # a and b; c is presented, taa a history
    assert compiled.transient_bytes == compiled.unaliased_bytes


def test_executing_again_makes_nothing(device: Device) -> None:
    graph = FrameGraph([Draw(), Blur(), Resolve()])
    graph.compile(device, None, SIZE).execute()
    before = textures(device)
    for _ in range(5):
        graph.compile(device, None, SIZE).execute()
    assert textures(device) == before


def test_old_sizes_are_freed_and_an_evicted_graph_can_come_back(device: Device) -> None:
    graph = FrameGraph([Draw(), Blur(), Resolve()], capacity=2)
    first = graph.compile(device, None, SIZE)
    first.execute()
    for width in range(20, 60):
        graph.compile(device, None, (width, 8)).execute()
    assert len(graph.pool(device)) <= 2 * 9
    assert first.texture("a").desc.width == 16
    first.execute()
    assert first.texture("c").desc.width == 16


def test_release_frees_everything(device: Device) -> None:
    before = textures(device)
    graph = FrameGraph([Draw(), Blur(), Resolve()])
    graph.compile(device, None, SIZE).execute()
    assert textures(device) != before
    graph.release()
    assert textures(device) == before
