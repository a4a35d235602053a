"""Every state word reaches the pixels: stencil, scissor, constant blend, masks, samplers; and all shader stages."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.gpu.types import (
    Bindings,
    BlendState,
    ColorAttachment,
    DepthAttachment,
    Device,
    RasterState,
    RenderPipelineDesc,
    SamplerDesc,
    ShaderSource,
    StencilFace,
    StencilState,
)

WHITE = "layout(location = 0) out vec4 color; void main() { color = vec4(1.0); }"
ALL = "void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0, 0.5, 1.0); }"
#: covers the left half
LEFT = "void main() { gl_Position = vec4((gl_VertexID & 1) - 1, gl_VertexID < 2 ? -1 : 1, 0.5, 1.0); }"
PASS = StencilFace("equal")
MARK = StencilFace("always", passed="replace")


def test_stencil_marks_and_masks(bench: Any) -> None:
    """The left half is marked with 3 and no colour; then only what is marked is drawn, and what is not."""
    target, depth = bench.texture("r8", 4, 2), bench.texture("d32f-s8", 4, 2)
    none = (BlendState(write_mask=""),)
    mark = bench.pipeline(
        LEFT, WHITE, topology="triangle_strip", blend=none, stencil=StencilState(MARK, MARK, reference=3)
    )
    inside = bench.pipeline(ALL, WHITE, stencil=StencilState(PASS, PASS, reference=3))
    outside = bench.pipeline(
        ALL, WHITE.replace("1.0)", "0.5)"), stencil=StencilState(StencilFace("notequal"), StencilFace("notequal"), 3)
    )
    black = ColorAttachment(target, clear=(0, 0, 0, 0))
    for pipelines, expected in (([mark], [0] * 4), ([mark, inside], [255, 255, 0, 0])):
        with bench.device.render_pass("stencil", [black], DepthAttachment(depth, clear=0.0)) as encoder:
            for pipeline in pipelines:
                encoder.set_pipeline(pipeline)
                encoder.draw(4 if pipeline is mark else 3)
        assert target.read()[0, :, 0].tolist() == expected
    with bench.device.render_pass("kept", [black], DepthAttachment(depth)) as encoder:
        encoder.set_pipeline(outside)
        encoder.draw(3)
    assert target.read()[1, :, 0].tolist() == [0, 0, 128, 128]  # the marks outlive the pass; a clear takes them away
    with bench.device.render_pass("cleared", [black], DepthAttachment(depth, clear=0.25)) as encoder:
        encoder.set_pipeline(inside)
        encoder.draw(3)
    assert not target.read().any()
    assert (depth.read() == 0.25).all()


def test_stencil_masks_operations_and_faces(bench: Any) -> None:
    """Front faces count up, back faces down; the write mask keeps bits, the read mask looks at some."""
    target, depth = bench.texture("r8", 1, 1), bench.texture("d32f-s8", 1, 1)
    up, down = StencilFace(passed="increment_wrap"), StencilFace(passed="decrement_wrap")
    flipped = ALL.replace("gl_VertexID << 1", "(2 - gl_VertexID) << 1").replace("gl_VertexID & 2", "(2-gl_VertexID)&2")
    none = (BlendState(write_mask=""),)
    front = bench.pipeline(flipped, WHITE, blend=none, stencil=StencilState(up, down))
    back = bench.pipeline(ALL, WHITE, blend=none, stencil=StencilState(up, down))
    for order, expected in (
        ([front, front, front, back], 2), ([back], 255), ([front, back], 0), ([back, back, front], 255),
    ):  # fmt: skip
        with bench.device.render_pass("count", [ColorAttachment(target)], DepthAttachment(depth, clear=0.0)) as encoder:
            for pipeline in order:
                encoder.set_pipeline(pipeline)
                encoder.draw(3)
        assert _stored(bench, depth, 255) in (expected, (256 - expected) % 256)
    some = bench.pipeline(ALL, WHITE, blend=none, stencil=StencilState(MARK, MARK, 0xFF, 0xFF, write_mask=0x0F))
    with bench.device.render_pass("mask", [ColorAttachment(target)], DepthAttachment(depth, clear=0.0)) as encoder:
        encoder.set_pipeline(some)
        encoder.draw(3)
    assert _stored(bench, depth, 255) == 0x0F
    assert _stored(bench, depth, 0xF0) == 0


def _stored(bench: Any, depth: Any, mask: int) -> int:
    """The stencil value under `mask`, found by trying all."""
    target = bench.texture("r8", 1, 1)
    for value in range(256):
        test = bench.device.render_pipeline(
            RenderPipelineDesc(
                "look", ShaderSource("vertex", ALL), ShaderSource("fragment", WHITE), depth=None,
                raster=RasterState(cull="none"), stencil=StencilState(PASS, PASS, value, mask, 0),
            )
        )  # fmt: skip
        clear = ColorAttachment(target, clear=(0, 0, 0, 0))
        with bench.device.render_pass("look", [clear], DepthAttachment(depth)) as encoder:
            encoder.set_pipeline(test)
            encoder.draw(3)
        seen = target.read()[0, 0, 0]
        test.release()
        if seen:
            return value
    return -1


def test_scissor_is_a_part_of_the_target_and_clears_ignore_it(bench: Any) -> None:
    target = bench.texture("r8", 4, 4)
    cut = bench.pipeline(ALL, WHITE, raster=RasterState("none", scissor=(0.25, 0.0, 0.5, 0.25)))
    for _ in range(2):  # the second clear comes while the scissor of the first pass is set
        bench.draw(cut, [target], None, clear=(0.5, 0, 0, 0))
        assert target.read()[:, :, 0].tolist() == [[128, 255, 255, 128], *[[128] * 4] * 3]


def test_blend_with_a_constant(bench: Any) -> None:
    target = bench.texture("rgba32f", 1, 1)
    blend = BlendState("constant", "one_minus_constant", "add", "constant_alpha", "zero")
    pipeline = bench.pipeline(ALL, WHITE, blend=(blend,), blend_constant=(0.25, 0.5, 1.0, 0.75))
    bench.draw(pipeline, [target], None, clear=(2.0, 2.0, 2.0, 2.0))
    np.testing.assert_allclose(target.read()[0, 0], [0.25 + 1.5, 0.5 + 1.0, 1.0, 0.75], atol=1e-6)


def test_each_target_has_its_own_blend_and_mask(bench: Any) -> None:
    first, second = bench.texture("rgba32f", 1, 1), bench.texture("rgba32f", 1, 1)
    two = "layout(location = 0) out vec4 a; layout(location = 1) out vec4 b; void main() { a = vec4(1); b = vec4(2); }"
    add = BlendState("one", "one", "add", "one", "one", "add")
    pipeline = bench.pipeline(ALL, two, blend=(add, BlendState(write_mask="gb")))
    bench.draw(pipeline, [first, second], None, clear=(0.5, 0.5, 0.5, 0.5))
    assert first.read()[0, 0].tolist() == [1.5] * 4
    assert second.read()[0, 0].tolist() == [0.5, 2.0, 2.0, 0.5]


def test_sample_mask_and_alpha_to_coverage(bench: Any) -> None:
    samples = bench.texture("rgba32f", 1, 1, samples=4)
    count = """layout(binding = 0) uniform sampler2DMS t; void main() { color = vec4(0);
        for (int i = 0; i < 4; ++i) color += texelFetch(t, ivec2(0), i); }"""
    half = WHITE.replace("vec4(1.0)", "vec4(vec3(1.0), 0.5)")
    for fragment, raster, expected in (
        (WHITE, RasterState("none", sample_mask=0b0101), 2.0),
        (half, RasterState("none", alpha_to_coverage=True), 2.0),
        (half, RasterState("none"), 4.0),
    ):
        bench.draw(bench.pipeline(ALL, fragment, raster=raster), [samples], None, clear=(0, 0, 0, 0))
        seen = bench.shade(count, 1, 1, bindings=Bindings(textures={0: (samples, bench.nearest())}))
        assert seen[0, 0, 0] == expected


def test_border_and_levels_of_detail(bench: Any) -> None:
    source = bench.texture("rgba32f", 2, 2, mips=2)
    source.write(np.full((2, 2, 4), 0.25, np.float32))
    source.write(np.full((1, 1, 4), 0.5, np.float32), level=1)
    look = "layout(binding = 0) uniform sampler2D t; void main() { color = textureLod(t, vec2(%s), %s); }"

    def seen(where: str, level: float, **sampler: Any) -> list[float]:
        made = bench.device.sampler(
            SamplerDesc(**{"wrap_u": "border", "wrap_v": "border", "min_filter": "nearest_mip_nearest",
                           "mag_filter": "nearest", **sampler})
        )  # fmt: skip
        bindings = Bindings(textures={0: (source, made)})
        return list(map(float, bench.shade(look % (where, level), 1, 1, bindings=bindings)[0, 0]))

    assert seen("-0.5", 0.0, border=(0.1, 0.2, 0.3, 1.0)) == pytest.approx([0.1, 0.2, 0.3, 1.0])
    assert seen("0.5", 0.0)[0] == 0.25
    assert seen("0.5", 0.0, lod_min=1.0)[0] == 0.5
    assert seen("0.5", 1.0, lod_max=0.0)[0] == 0.25
    assert seen("-0.25", 0.0, wrap_u="mirror_once", wrap_v="mirror_once")[0] == 0.25


CONTROL = """layout(vertices = 3) out; void main() {
    gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;
    gl_TessLevelInner[0] = 4.0; gl_TessLevelOuter[0] = gl_TessLevelOuter[1] = gl_TessLevelOuter[2] = 4.0; }"""
EVALUATION = """layout(triangles, equal_spacing, ccw) in; void main() {
    gl_Position = gl_TessCoord.x * gl_in[0].gl_Position + gl_TessCoord.y * gl_in[1].gl_Position
        + gl_TessCoord.z * gl_in[2].gl_Position; }"""
GEOMETRY = """layout(triangles) in; layout(triangle_strip, max_vertices = 3) out; flat out int which; void main() {
    for (int i = 0; i < 3; ++i) { gl_Position = gl_in[i].gl_Position; which = gl_PrimitiveIDIn; EmitVertex(); } }"""


def test_all_stages_of_a_pipeline(bench: Any) -> None:
    """A patch of three vertices becomes sixteen triangles, told apart by the geometry stage; faces keep their side."""
    target = bench.texture("r32ui", 16, 16)
    fragment = "flat in int which; layout(location = 0) out uint color; void main() { color = 1u + uint(which); }"
    flipped = ALL.replace("gl_VertexID << 1", "(2 - gl_VertexID) << 1").replace("gl_VertexID & 2", "(2-gl_VertexID)&2")
    seen = {}
    for vertex in (ALL, flipped):
        for cull in ("none", "back"):
            pipeline = bench.pipeline(
                vertex, fragment, topology="patches", tess_control=ShaderSource("tess_control", CONTROL),
                tess_evaluation=ShaderSource("tess_evaluation", EVALUATION),
                geometry=ShaderSource("geometry", GEOMETRY), raster=RasterState(cull=cull),
            )  # fmt: skip
            bench.draw(pipeline, [target], None, clear=(0, 0, 0, 0))
            seen[vertex is ALL, cull] = len(np.unique(target.read()))
    plain = bench.pipeline(ALL, "layout(location = 0) out uint color; void main() { color = 9u; }",
                           raster=RasterState(cull="back"))  # fmt: skip
    bench.draw(plain, [target], None, clear=(0, 0, 0, 0))
    drawn = bool(target.read().any())
    assert seen[True, "none"] == seen[False, "none"] > 4
    assert (seen[True, "back"] > 1) == drawn
    assert (seen[False, "back"] > 1) != drawn


@pytest.mark.parametrize(
    ("state", "says"),
    [
        ({"topology": "patches"}, "without a tess_evaluation"),
        ({"tess_evaluation": ShaderSource("tess_evaluation", "")}, "with a tess_evaluation"),
        ({"tess_control": ShaderSource("tess_control", "")}, "needs a tess_evaluation"),
        ({"geometry": ShaderSource("fragment", "")}, "given for geometry is one of stage fragment"),
        ({"stencil": StencilState(StencilFace(passed="add"))}, "'add' is not one of keep"),
        ({"stencil": StencilState(reference=256)}, "0 to 255, got 256"),
        ({"raster": RasterState(scissor=(0.5, 0.0, 0.6, 1.0))}, "leaves the attachment"),
    ],
)
def test_mistakes_are_found_without_a_gpu(null_device: Device, state: dict[str, Any], says: str) -> None:
    desc = RenderPipelineDesc("x", ShaderSource("vertex", ALL), ShaderSource("fragment", WHITE), **state)
    with pytest.raises(UsageError, match=says):
        null_device.render_pipeline(desc)
