"""Leaving passes out and sharing textures changes no result: random graphs whose textures hold what made them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.framegraph.builder import Builder
from engine.framegraph.graph import FrameGraph
from engine.framegraph.passes import Pass, PassContext
from engine.gpu import open_device
from engine.gpu.types import ColorAttachment, Device


@dataclass
class Recipe:
    """What a made-up pass declares."""

    name: str
    creates: list[str]
    reads: list[str]
    writes: list[str]
    presents: list[str]
    size: int


class Cook(Pass):
    """Writes into `content` (by the texture's identity) what it was made from."""

    name = "cook"

    def __init__(self, recipe: Recipe, content: dict[int, str]) -> None:
        self.recipe, self.content = recipe, content
        super().__init__()

    def declare(self, b: Builder) -> None:
        for name in self.recipe.creates:
            b.create(name, "r8", size=(self.recipe.size, 1))
        for name in self.recipe.reads:
            b.read(name)
        for name in self.recipe.writes:
            b.write(name)
        for name in self.recipe.presents:
            b.present(name)

    def execute(self, ctx: PassContext) -> None:
        inputs = [self.content[id(ctx.texture(n))] for n in self.recipe.reads + self.recipe.writes]
        made = f"{self.recipe.name}({' '.join(inputs)})"
        for name in self.recipe.creates + self.recipe.writes:
            self.content[id(ctx.texture(name))] = f"{name}={made}" if len(made) < 200 else f"{name}#{hash(made)}"


@st.composite
def recipes(draw: st.DrawFn) -> list[Recipe]:
    result: list[Recipe] = []
    names: list[str] = []
    for index in range(draw(st.integers(1, 10))):
        some = st.lists(st.sampled_from(names), unique=True, max_size=3) if names else st.just([])
        reads = draw(some)
        writes = [name for name in draw(some) if name not in reads][:1]
        creates = [f"r{index}{i}" for i in range(draw(st.integers(0, 2)))]
        names += creates
        presents = [draw(st.sampled_from(names))] if names and draw(st.integers(0, 3)) == 0 else []
        result.append(Recipe(f"p{index}", creates, reads, writes, presents, draw(st.integers(1, 2))))
    return result


def results(device: Device, made: list[Recipe], force_all: bool) -> dict[str, str]:
    content: dict[int, str] = {}
    passes = []
    for recipe in made:
        item = type(recipe.name, (Cook,), {"name": recipe.name})(recipe, content)
        passes.append(item)
    graph = FrameGraph(passes)
    compiled = graph.compile(device, None, (4, 4), force_all=force_all)
    assert len(compiled.passes) + len(compiled.left_out) == len(passes)
    for _ in range(2):  # the second frame finds the leftovers of the first
        compiled.execute()
    shown = {n: content[id(compiled.texture(n))] for recipe in made for n in recipe.presents}
    graph.release()
    return shown


@given(recipes())
@settings(max_examples=150, deadline=None)
def test_pruned_equals_force_all(made: list[Recipe]) -> None:
    device = open_device("null")
    assert results(device, made, False) == results(device, made, True)


@pytest.mark.gl
def test_a_graph_on_a_real_device(gl_device: Device) -> None:
    class Fill(Pass):
        name = "fill"

        def declare(self, b: Builder) -> None:
            b.create("a", "rgba16f")

        def execute(self, ctx: PassContext) -> None:
            with ctx.device.render_pass("fill", [ColorAttachment(ctx.texture("a"), clear=(0.5, 2.0, 0.0, 1.0))]):
                pass

    class Copy(Pass):
        name = "copy"

        def declare(self, b: Builder) -> None:
            b.read("a")
            b.create("b", "rgba16f")
            b.present("b")

        def execute(self, ctx: PassContext) -> None:
            ctx.device.copy_texture(ctx.texture("a"), ctx.texture("b"), 1)

    graph = FrameGraph([Fill(), Copy()])
    compiled = graph.compile(gl_device, None, (3, 2))
    compiled.execute()
    np.testing.assert_array_equal(compiled.texture("b").read()[1, 2], [0.5, 2.0, 0.0, 1.0])
    graph.release()
