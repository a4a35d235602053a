"""The gather from the layers, which bounces and the light of the picture's own pixels share; and what it reads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from engine.framegraph.passes import PassContext
from engine.gpu.types import Buffer, Texture
from engine.render.frame import DEPTH_UNIT, INPUT_UNIT, PASS_BINDING, RenderFrame
from engine.render.gi.block import BLOCK, NAME
from engine.render.gi.choice import LEVELS, METHODS

#: of each layer: d32f; rg32ui normal, albedo; rg32ui albedo, roughness, emission
DEPTHS, SHAPES, LIGHTS = (tuple(f"layer{i}_{name}" for i in (0, 1)) for name in ("depth", "shape", "light"))
#: rg32f depths of both layers; rgba8 which way they face; rgba16f what each sends out: all in several sizes
NEAR_FAR, SIDES, SENT = "layer_depths", "layer_sides", ("layer0_sent", "layer1_sent")
#: texture units of shapes and lights in lib/deep_read.glsl
SHAPE_UNITS, LIGHT_UNITS = (17, 19), (18, 21)
#: places are read from a size whose texels are 2 to this times smaller than what lies between places
FINER = 1
#: and light from one so many times 2 larger than that
COARSER = 1
#: slices at least where bounces are gathered: all of one slice weighs more or less than the hemisphere, by the way it
#: lies, and what is too much in a bounce grows with each further one (a closed box of albedo 0.8: 12 % over its limit)
COARSE_DIRECTIONS = 2


def levels_of(width: int, height: int) -> int:
    """Sizes that there are of layers so wide and high."""
    return max(1, min(LEVELS, max(width, height).bit_length()))


def sent_inputs(ctx: PassContext, layers: int) -> dict[int, Any]:
    """By texture unit: what lib/gather_read.glsl reads."""
    frame: RenderFrame = ctx.frame
    names = dict(zip((INPUT_UNIT, 17, 18, 19), (NEAR_FAR, SIDES, *SENT[:layers]), strict=False))
    return {unit: (ctx.texture(name), frame.point_sampler) for unit, name in names.items()}


def sent_targets(ctx: PassContext, layers: int) -> dict[int, Texture]:
    """By image unit: the same, as radiosity.comp and radiosity_mips.comp write it."""
    return {i + 1: ctx.texture(name) for i, name in enumerate((NEAR_FAR, SIDES, *SENT[:layers]))}


def dispatch(
    ctx: PassContext, shader: str, defines: Mapping[str, int], inputs: Mapping[int, Any], images: Mapping[int, Any],
    block: Buffer, *, label: str = "",
) -> None:  # fmt: skip
    """Run a compute shader over the texels of the first of `images`: unit -> (texture, level, access)."""
    frame: RenderFrame = ctx.frame
    pipeline = frame.programs.compute(shader, block=BLOCK, block_name=NAME, defines=defines)
    texture, level, _ = next(iter(images.values()))
    width, height = max(1, texture.desc.width >> level), max(1, texture.desc.height >> level)
    with ctx.device.compute_pass(label or shader.removesuffix(".comp")) as compute_pass:
        compute_pass.set_pipeline(pipeline)
        compute_pass.set_bindings(frame.pass_bindings(inputs, {PASS_BINDING: block}, images))
        compute_pass.dispatch(-(-width // 8), -(-height // 8))


def shrink(ctx: PassContext, layers: int, block: Buffer) -> None:
    """Fill the smaller sizes of what is sent out from the first."""
    targets, inputs = sent_targets(ctx, layers), sent_inputs(ctx, layers)
    desc = targets[1].desc
    for level in range(1, levels_of(desc.width, desc.height)):
        images = {i: (texture, level, "write") for i, texture in targets.items()}
        dispatch(ctx, "radiosity_mips.comp", {"LAYERS": layers, "LEVEL": level}, inputs, images, block)


def gather(ctx: PassContext, out: Texture, block: Buffer, *, layer: int = 0, level: int = 0) -> None:
    """Light that arrives at the texels of a layer in one of its sizes, rgba16f: light over pi; part left to the sky."""
    frame: RenderFrame = ctx.frame
    quality, size = frame.facts.indirect, ctx.texture(NEAR_FAR).desc
    directions = max(quality.directions, COARSE_DIRECTIONS if level else 1)
    defines = {
        "METHOD": METHODS.index(quality.method), "DIRECTIONS": directions, "STEPS": quality.steps,
        "LAYERS": quality.layers, "LEVELS": levels_of(size.width, size.height), "FINER": FINER, "COARSER": COARSER,
        "UNSEEN": int(quality.unseen == "seen"), "OF_LAYER": layer, "OWN_LEVEL": level,
    }  # fmt: skip
    inputs = {**sent_inputs(ctx, quality.layers), DEPTH_UNIT: (ctx.texture(SHAPES[layer]), frame.point_sampler)}
    dispatch(ctx, "indirect.comp", defines, inputs, {1: (out, 0, "write")}, block)
