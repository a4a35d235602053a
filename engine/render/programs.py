"""Programs: pipelines by what a batch or a pass needs; the generated blocks in front of every shader."""

from __future__ import annotations

from collections.abc import Mapping

from engine.core.errors import ShaderError
from engine.core.paths import shaders_dir
from engine.gpu.glsl_layout import BlockLayout
from engine.gpu.preprocess import flatten
from engine.gpu.types import BlendState, DepthState, Device, Pipeline, RasterState, RenderPipelineDesc
from engine.materials.library import EffectLibrary
from engine.render.draw_list import DrawState, arena_streams
from engine.render.facts import SceneFacts
from engine.render.light_rows import light_glsl
from engine.render.view_block import VIEW_LAYOUT
from engine.resources.arena import MeshArena

#: uniform and storage blocks that surface shaders see; the bindings are those of engine.render.frame
SCENE_PRELUDE = (
    VIEW_LAYOUT.block_glsl("ViewBlock", 0, "view")
    + "\nlayout(std430, binding = 0) readonly buffer TransformBlock { vec4 transforms[]; };"
    + "\nlayout(std430, binding = 1) readonly buffer ObjectBlock { uvec4 objects[]; };\n"
    + light_glsl(3)
    + "layout(std430, binding = 4) readonly buffer PaletteBlock { vec4 palette[]; };\n"
)
VIEW_PRELUDE = VIEW_LAYOUT.block_glsl("ViewBlock", 0, "view") + "\n"

PREMULTIPLIED = BlendState("one", "one_minus_src_alpha", "add", "one", "one_minus_src_alpha", "add")


class Programs:
    """Caches by key: one dict look-up a batch in the steady state. `errors`: what failed to compile, by variant."""

    def __init__(self, device: Device, effects: EffectLibrary) -> None:
        self._device = device
        self._effects = effects
        self._surface: dict[tuple[object, ...], Pipeline] = {}
        self._screen: dict[tuple[object, ...], Pipeline] = {}
        self.errors: dict[str, ShaderError] = {}

    def forget(self) -> None:
        """Ask the library again for every pipeline (after a hot reload)."""
        self._surface.clear()

    def surface(self, state: DrawState, arena: MeshArena, facts: SceneFacts, samples: int) -> Pipeline:
        key = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, state.blended,
            facts.environment, facts.suns, facts.local_lights, facts.debug_view, facts.force_all,
        )  # fmt: skip
        pipeline = self._surface.get(key)
        if pipeline is None:
            effect = self._effects.get(state.effect)
            streams = arena_streams(arena, effect, state.features)
            pipeline, error = self._effects.pipeline_or_magenta(
                self._device, effect, "forward", state.features, arena.attributes(streams),
                topology=state.topology, cull=state.cull, front_ccw=state.front_ccw,
                blend=PREMULTIPLIED if state.blended else None, depth_write=not state.blended,
                prelude=SCENE_PRELUDE,
                defines={"HAS_UV0": int("uv0" in streams), "BLENDED": int(state.blended), **facts.variant_defines()},
            )  # fmt: skip
            if error is not None:
                self.errors[f"{state.effect}: {', '.join(sorted(state.features))}"] = error
            self._surface[key] = pipeline
        return pipeline

    def screen(
        self, fragment: str, *, block: BlockLayout | None = None, block_name: str = "",
        defines: Mapping[str, int] | None = None, depth: DepthState | None = None, blend: BlendState | None = None,
    ) -> Pipeline:  # fmt: skip
        """The pipeline of a full-screen triangle with shaders/passes/<fragment>; `block` becomes a uniform block at
        binding 1, named as the instance `block_name`. Raises ShaderError."""
        key = (fragment, tuple(sorted((defines or {}).items())), depth, blend)
        pipeline = self._screen.get(key)
        if pipeline is None:
            prelude = VIEW_PRELUDE
            if block is not None:
                prelude += block.block_glsl(f"PassBlock_{block_name}", 1, block_name) + "\n"
            root = shaders_dir()
            vertex = flatten(root / "passes/fullscreen.vert", "vertex", search=[root], defines={})
            text = flatten(
                root / "passes" / fragment, "fragment", search=[root], prelude=prelude, defines=defines or {}
            )
            pipeline = self._device.render_pipeline(
                RenderPipelineDesc(fragment, vertex, text, (), "triangles", depth, (blend,), RasterState("none"))
            )
            self._screen[key] = pipeline
        return pipeline
