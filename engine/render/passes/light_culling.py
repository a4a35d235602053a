"""Light lists of tiles: which local lights can reach what each tile shows, in ascending order.

    depth ─► tile_bounds ─► (light_view ─► light_bins) ─► light_tiles, counts ─► light_tiles, lists
                                                                 └─► headers (LIGHT_TILES) ◄─┘
Stages and their buffers: engine/render/light_lists.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Bindings, Buffer, Texture
from engine.render.facts import SceneFacts
from engine.render.frame import (
    DEPTH_UNIT,
    LIGHT_BOUNDS_BINDING,
    LIGHT_LIST_BINDING,
    LIGHT_TILES_UNIT,
    PASS_BINDING,
    VIEW_BINDING,
    RenderFrame,
)
from engine.render.light_lists import LightLists
from engine.render.lighting import TESTS, Lighting

#: rg32ui array, a texel per tile: first entry in the light list, count; a layer per list
LIGHT_TILES = "light_tiles"

BLOCK = layout(
    [
        Field("words", "uint"),  # of a mask with a bit per light
        Field("bin_columns", "uint"),
        Field("blended", "uint"),  # 1: lists for what is blended are wanted
        Field("parts", "uint"),  # words of a bin's second mask, with a bit per word of the first
    ],
    rule="std140",
)
SEEN = GROUPS = 0  # one of them at a time
TILES, VIEW_MASK, BIN_MASK, BIN_DEPTH, BIN_PARTS, COUNTERS = 1, 2, 3, 4, 6, 7


@dataclass(frozen=True, slots=True)
class ListJob:
    """The lists of one view: `row`, of VIEW_LAYOUT, is what `view` holds; `depth` with so many `samples`; `tiles`: the
    headers are written there; `blended`: lists for what is blended are wanted, too."""

    lists: LightLists
    lighting: Lighting
    view: Buffer
    row: NDArray[np.void]
    depth: Texture
    samples: int
    tiles: Texture
    blended: bool

    def bindings(self, frame: RenderFrame, block: Buffer) -> Bindings:
        lists = self.lists
        return Bindings(
            uniforms={VIEW_BINDING: self.view, PASS_BINDING: block},
            storage={
                GROUPS: lists.groups, TILES: lists.tiles, VIEW_MASK: lists.view_mask, BIN_MASK: lists.bin_mask,
                BIN_DEPTH: lists.bin_depth, BIN_PARTS: lists.bin_parts,
                LIGHT_LIST_BINDING: lists.list, LIGHT_BOUNDS_BINDING: lists.bounds, COUNTERS: lists.counters,
            },
            textures={DEPTH_UNIT: (self.depth, frame.point_sampler)},
            images={0: (self.tiles, 0, "read_write")},
        )  # fmt: skip

    def tell_room(self) -> None:
        """The list is another: its room is in the view block, which shaders test headers against."""
        self.row["tiles"][1] = self.lists.capacity
        self.view.write(self.row.tobytes())


def make_lists(ctx: PassContext, name: str, job: ListJob) -> None:
    """Which lights reach each tile of a view. `name`: of its pass block."""
    frame: RenderFrame = ctx.frame
    lists, lighting = job.lists, job.lighting
    row = np.zeros((), BLOCK.dtype)
    row["words"], row["parts"] = lists.words, lists.parts
    row["bin_columns"], row["blended"] = lists.bins[0], job.blended
    block = frame.pass_block(name, row)
    bins_x, bins_y = lists.bins
    lists.begin()
    word_groups = -(-lists.words // 64)
    layers = lighting.lists if lighting.clustered else 1 + job.blended
    tile_defines = {
        "TEST": TESTS.index(lighting.test), "DEPTH_BINS": int(lighting.depth == "bins"),
        "CLUSTERS": int(lighting.clustered), "LOOP_STEPS": lighting.steps,
    }  # fmt: skip
    #: shader, defines, groups
    stages: tuple[tuple[str, dict[str, int], tuple[int, int, int]], ...] = (
        ("tile_bounds.comp", {"SAMPLES": job.samples, "DEPTH_BINS": int(lighting.depth == "bins")},
         (bins_x, bins_y, 1)),
        ("light_view.comp", {}, (word_groups, 1, 1)),
        ("light_bins.comp", {}, (word_groups, bins_x, bins_y)),
        ("light_tiles.comp", {"WRITES": 0, **tile_defines}, (bins_x, bins_y, layers)),
        ("light_tiles.comp", {"WRITES": 1, **tile_defines}, (bins_x, bins_y, layers)),
    )  # fmt: skip
    with ctx.device.compute_pass(name) as compute_pass:
        compute_pass.set_bindings(job.bindings(frame, block))
        for shader, defines, groups in stages:
            if defines.get("WRITES") and lists.unsure and lists.counted():
                job.tell_room()
                compute_pass.set_bindings(job.bindings(frame, block))
            pipeline = frame.programs.compute(shader, block=BLOCK, block_name="culling", defines=defines)
            compute_pass.set_pipeline(pipeline)
            compute_pass.dispatch(*groups)


class LightCullingPass(Pass):
    """Its headers reach the whole picture: where a list begins depends on all tiles before it."""

    name: ClassVar[str] = "light_culling"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        if not facts.local_lights:
            return "no local lights"
        if facts.lighting.path == "deferred" and not (facts.transparent or facts.debug_view == "light_tiles"):
            return "light volumes need no lists, and nothing is blended"
        return True

    def declare(self, b: Builder) -> None:
        b.read("depth")
        lighting = b.facts.lighting
        width, height = b.view_size
        size = (-(-width // lighting.tile), -(-height // lighting.tile))
        b.create(LIGHT_TILES, "rg32ui", size=size, kind="2d-array", layers=lighting.lists)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        make_lists(
            ctx, self.name, ListJob(
                frame.light_lists, frame.facts.lighting, frame.view_buffer, frame.shadow_rows, ctx.texture("depth"),
                frame.facts.samples, ctx.texture(LIGHT_TILES), frame.facts.transparent or frame.facts.force_all,
            ),
        )  # fmt: skip
        if frame.view.settings.light_stats:
            self._count_needed(ctx)

    def _count_needed(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        lists = frame.light_lists
        seen = frame.device.buffer(lists.list.size, label="entries seen")
        bindings = Bindings(
            uniforms={VIEW_BINDING: frame.view_buffer},
            storage={
                SEEN: seen, LIGHT_LIST_BINDING: lists.list, LIGHT_BOUNDS_BINDING: lists.bounds,
                COUNTERS: lists.counters,
            },
            textures={
                DEPTH_UNIT: (ctx.texture("depth"), frame.point_sampler),
                LIGHT_TILES_UNIT: (ctx.texture(LIGHT_TILES), frame.point_sampler),
            },
        )  # fmt: skip
        with ctx.device.compute_pass("light_needed") as compute_pass:
            compute_pass.set_pipeline(
                frame.programs.compute("light_needed.comp", defines={"SAMPLES": frame.facts.samples})
            )
            compute_pass.set_bindings(bindings)
            compute_pass.dispatch(-(-ctx.size[0] // 8), -(-ctx.size[1] // 8))
        seen.release()


def light_list_inputs(ctx: PassContext) -> dict[int, Any]:
    """The headers for shaders that read light lists, by texture unit."""
    frame: RenderFrame = ctx.frame
    return {LIGHT_TILES_UNIT: (ctx.texture(LIGHT_TILES), frame.point_sampler)} if ctx.has(LIGHT_TILES) else {}
