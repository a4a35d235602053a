"""How much of its surroundings each pixel sees: found from depth, filtered, and given to environment light.

    depth ─► (_depths.comp) ─► ambient_occlusion.comp ─► (_temporal.comp) ─► _filter.comp ─► ambient_visibility
             ao_mips           ambient_visibility_raw    ao_temporal: ambient_mean, ambient_state

Frames are mixed before the filter, as it evens out what they leave: after it their mean had twice the error (0.0031 for
0.0011 of one slice after 16 frames at rest, 0.0068 for 0.0054 in motion).
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Bindings, Buffer
from engine.render.facts import SceneFacts
from engine.render.frame import AMBIENT_UNIT, DEPTH_UNIT, INPUT_UNIT, PASS_BINDING, VIEW_BINDING, RenderFrame
from engine.render.occlusion import METHODS, MOVING, RESTING, turns_of
from engine.render.passes.motion import MOTION

#: r16f: 1 open, 0 closed; rgba16f with bent normals: from the normal to the mean open direction (world), then the same
VISIBILITY, FILTERED = "ambient_visibility_raw", "ambient_visibility"
#: the same, of this frame and those before; and rg32f: depth, how many frames are in it
MEAN, STATE = "ambient_mean", "ambient_state"
#: r32f: depth at half the size and less; of four texels one stands for all (McGuire, Mara, Luebke 2012, sect. 2.2)
DEPTHS = "ambient_depths"

FORMATS = {False: "r16f", True: "rgba16f"}
#: means of many frames in half floats stop short of their limit
MEAN_FORMATS = {False: "r32f", True: "rgba32f"}
DEPTHS_UNIT, BEFORE_UNIT, STATE_UNIT, MOTION_UNIT = 17, 28, 29, 30
#: sizes of depth besides its own, at most
LEVELS = 5

BLOCK = layout(
    [
        Field("before_from_now", "mat4"),  # clip space to clip space, without jitter
        Field("now_from_before", "mat4"),
        Field("jitter", "vec2"),  # pixels
        Field("radius", "float"),  # metres
        Field("per_radius_squared", "float"),  # 1 / radius^2
        Field("strength", "float"),  # 0 none to 1 all
        Field("thickness", "float"),  # metres
        Field("bias", "float"),  # sine above the tangent plane that does not hide anything yet
        Field("turn", "float"),  # of the way from one slice to the next, and from one place to the next
        Field("shift", "float"),
        Field("known", "float"),  # 1: there is a mean of frames before
        Field("frozen", "float"),  # 1: nothing changed since
        Field("most", "float"),  # frames that a mean is of
        Field("floor_height", "float"),  # over the origin, metres
    ],
    rule="std140",
)
#: half floats of the filtered visibility, and facets between pixels, are no flatter than this
BIAS = 0.02


class AmbientOcclusionPass(Pass):
    """Before surfaces are shaded, and only for light from the environment: lamps have shadows of their own."""

    name: ClassVar[str] = "ambient_occlusion"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.ambient_occlusion.wanted else facts.ambient_occlusion.why_not

    def declare(self, b: Builder) -> None:
        quality = b.facts.ambient_occlusion
        b.read("depth")
        scale, form = 1.0 / quality.stride, FORMATS[quality.bent]
        b.create(VISIBILITY, form, scale=scale)
        b.create(FILTERED, form)
        if quality.temporal:
            b.read(MOTION)
            b.create(MEAN, MEAN_FORMATS[quality.bent], scale=scale)
            b.create(STATE, "rg32f", scale=scale)
            b.history(MEAN)
            b.history(STATE)
        levels = levels_of(*b.view_size)
        if quality.mips and levels:
            size = (b.view_size[0] // 2, b.view_size[1] // 2)
            b.create(DEPTHS, "r32f", size=size, mips=levels)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        quality, point = frame.facts.ambient_occlusion, frame.point_sampler
        block = frame.pass_block(self.name, _row(ctx))
        levels = levels_of(*ctx.size) if ctx.has(DEPTHS) else 0
        defines = {"STRIDE": quality.stride, "SAMPLES": frame.facts.samples, "BENT": int(quality.bent)}
        defines["FLOOR"] = int(_has_floor(frame))
        depth: dict[int, Any] = {DEPTH_UNIT: (ctx.texture("depth"), point)}
        inputs = depth
        if levels:
            depths = ctx.texture(DEPTHS)
            inputs = {**depth, DEPTHS_UNIT: (depths, point)}
            for level in range(levels):
                own = {"LEVEL": level, "SAMPLES": frame.facts.samples}
                _dispatch(ctx, "ambient_occlusion_depths.comp", own, inputs, {1: (depths, level, "write")}, block)
        looks = {
            "METHOD": METHODS.index(quality.method), "DIRECTIONS": quality.directions, "STEPS": quality.steps,
            "LEVELS": levels, "FORMAT": FORMATS[quality.bent],
        }  # fmt: skip
        found = ctx.texture(VISIBILITY)
        _dispatch(ctx, "ambient_occlusion.comp", {**defines, **looks}, inputs, {1: (found, 0, "write")}, block)
        if quality.temporal:
            textures = {
                INPUT_UNIT: found, MOTION_UNIT: ctx.texture(MOTION), BEFORE_UNIT: ctx.history(MEAN),
                STATE_UNIT: ctx.history(STATE),
            }  # fmt: skip
            inputs = {**depth, **{unit: (texture, point) for unit, texture in textures.items()}}
            found = ctx.texture(MEAN)
            out = {1: (found, 0, "write"), 2: (ctx.texture(STATE), 0, "write")}
            form = {"FORMAT": MEAN_FORMATS[quality.bent]}
            _dispatch(ctx, "ambient_occlusion_temporal.comp", {**defines, **form}, inputs, out, block)
        inputs, form = {**depth, INPUT_UNIT: (found, point)}, {"FORMAT": FORMATS[quality.bent]}
        out = {1: (ctx.texture(FILTERED), 0, "write")}
        _dispatch(ctx, "ambient_occlusion_filter.comp", {**defines, **form}, inputs, out, block)


def _has_floor(frame: RenderFrame) -> bool:
    return frame.facts.shadow_floor and frame.shadows.floor is not None


def levels_of(width: int, height: int) -> int:
    """Smaller copies of a depth of that size; all their texels stand for a pixel of it."""
    return min(LEVELS, min(width, height).bit_length() - 1)


def _row(ctx: PassContext) -> np.ndarray[Any, Any]:
    frame: RenderFrame = ctx.frame
    quality, motion, row = frame.facts.ambient_occlusion, frame.motion, np.zeros((), BLOCK.dtype)
    row["radius"] = frame.look["ambient_radius"]
    row["per_radius_squared"] = 1.0 / float(row["radius"]) ** 2
    row["strength"] = frame.look["ambient_strength"] if quality.wanted else 0.0
    row["thickness"] = frame.look["ambient_thickness"]
    row["bias"] = BIAS
    if _has_floor(frame):
        row["floor_height"] = frame.shadows.floor - frame.origin[1]
    if quality.temporal:
        known = motion.known and not ctx.history_reset(MEAN)
        row["before_from_now"] = motion.before_from_now.T
        row["now_from_before"] = np.linalg.inv(motion.before_from_now).T
        row["jitter"] = motion.jitter
        row["turn"], row["shift"] = turns_of(motion.frames if known else 0)
        row["known"], row["frozen"] = known, known and motion.frozen > 0
        # what was gathered while things moved was held to that time's noise: it counts as one frame
        row["most"] = min(motion.frozen + 1, RESTING) if motion.frozen > 0 else MOVING
    return row


def _dispatch(
    ctx: PassContext, shader: str, defines: dict[str, Any], inputs: dict[int, Any], images: dict[int, Any],
    block: Buffer,
) -> None:  # fmt: skip
    """Run a compute shader over the texels of image 1: (texture, level, access)."""
    frame: RenderFrame = ctx.frame
    pipeline = frame.programs.compute(shader, block=BLOCK, block_name="ao", defines=defines)
    texture, level, _ = images[1]
    width, height = max(1, texture.desc.width >> level), max(1, texture.desc.height >> level)
    with ctx.device.compute_pass(shader.removesuffix(".comp")) as compute_pass:
        compute_pass.set_pipeline(pipeline)
        uniforms = {VIEW_BINDING: frame.view_buffer, PASS_BINDING: block}
        compute_pass.set_bindings(Bindings(uniforms, {}, inputs, images))
        compute_pass.dispatch(-(-width // 8), -(-height // 8))


def ambient_inputs(ctx: PassContext) -> dict[int, Any]:
    """The visibility for surface shaders, by texture unit; nothing where the frame has none."""
    if not ctx.has(FILTERED):
        return {}
    frame: RenderFrame = ctx.frame
    return {AMBIENT_UNIT: (ctx.texture(FILTERED), frame.point_sampler)}
