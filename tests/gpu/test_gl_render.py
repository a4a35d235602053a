from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.core.errors import DeviceError, UsageError
from engine.gpu.types import (
    Bindings,
    BlendState,
    ColorAttachment,
    DepthAttachment,
    DepthState,
    RasterState,
    VertexAttribute,
)

WHITE = "out vec4 color; void main() { color = vec4(1.0); }"
POSITION = VertexAttribute(0, "position", "f4x3")
SCREEN = "layout(location = 0) in vec3 position; void main() { gl_Position = vec4(position, 1.0); }"


def test_row_0_is_the_top_row(bench: Any) -> None:
    """Clip y = +1 lands in row 0, and gl_FragCoord.y counts down from it."""
    target = bench.texture("rgba32f", 2, 4)
    top_half = np.float32([[-1, 0, 0.5], [1, 0, 0.5], [-1, 1, 0.5], [1, 1, 0.5]])
    pipeline = bench.pipeline(
        SCREEN, "out vec4 color; void main() { color = vec4(gl_FragCoord.xy, 7.0, 1.0); }", topology="triangle_strip",
        attributes=(POSITION,),
    )  # fmt: skip
    vertices = bench.buffer(top_half)
    with bench.device.render_pass("top", [ColorAttachment(target, clear=(0, 0, 0, 0))]) as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_vertex_buffers({"position": vertices})
        encoder.draw(4)
    image = target.read()
    assert image[:, :, 2].tolist() == [[7, 7], [7, 7], [0, 0], [0, 0]]
    assert image[0, 1, :2].tolist() == [1.5, 0.5]
    assert image[1, 0, :2].tolist() == [0.5, 1.5]


def test_viewport_counts_from_the_top(bench: Any) -> None:
    target = bench.texture("r8", 4, 4)
    pipeline = bench.pipeline(
        "void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2 - 1, 0, 1); }", WHITE
    )
    with bench.device.render_pass("viewport", [ColorAttachment(target, clear=(0, 0, 0, 0))]) as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_viewport(1, 0, 2, 1)
        encoder.draw(3)
    assert target.read()[:, :, 0].tolist() == [[0, 255, 255, 0], [0] * 4, [0] * 4, [0] * 4]


def test_sampling_uv_origin_is_the_top_left(bench: Any) -> None:
    source = bench.texture("r8", 2, 2)
    source.write(bytes([10, 20, 30, 40]))
    text = "layout(binding = 0) uniform sampler2D t; void main() { color = texture(t, uv); }"
    seen = bench.shade(text, 2, 2, bindings=Bindings(textures={0: (source, bench.nearest())}))
    np.testing.assert_allclose(seen[:, :, 0] * 255, [[10, 20], [30, 40]], atol=1e-3)


@pytest.mark.parametrize(
    ("cull", "front_ccw", "seen"),
    [
        ("back", True, True),
        ("front", True, False),
        ("back", False, False),
        ("front", False, True),
        ("none", True, True),
    ],
)
def test_counter_clockwise_as_seen_is_the_front(bench: Any, cull: str, front_ccw: bool, seen: bool) -> None:
    """Left-bottom, right-bottom, top in clip space with y up is counter-clockwise."""
    target = bench.texture("rgba8", 4, 4)
    pipeline = bench.pipeline(
        SCREEN, "out vec4 color; void main() { color = vec4(gl_FrontFacing); }", attributes=(POSITION,),
        raster=RasterState(cull=cull, front_ccw=front_ccw),
    )  # fmt: skip
    vertices = bench.buffer(np.float32([[-3, -1, 0], [3, -1, 0], [0, 5, 0]]))
    with bench.device.render_pass("winding", [ColorAttachment(target, clear=(0.5, 0.5, 0.5, 0.5))]) as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_vertex_buffers({"position": vertices})
        encoder.draw(3)
    expected = (255 if front_ccw else 0) if seen else 128
    assert abs(int(target.read()[1, 1, 0]) - expected) <= 1


def test_depth_is_zero_to_one_and_reversed_z_separates_20000_m_from_20000_25(bench: Any) -> None:
    assert bench.device.caps.reversed_z
    color, depth = bench.texture("r8", 1, 1), bench.texture("d32f", 1, 1)
    vertex = """void main() {
        vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0;
        float distance = %s;
        gl_Position = vec4(corner * distance, 0.1, distance); }"""
    far = bench.pipeline(vertex % "20000.25", WHITE, depth=DepthState())
    near = bench.pipeline(vertex % "20000.0", "out vec4 color; void main() { color = vec4(0.5); }", depth=DepthState())
    for first, second in ((far, near), (near, far)):
        with bench.device.render_pass(
            "planes", [ColorAttachment(color, clear=(0, 0, 0, 0))], DepthAttachment(depth, clear=0.0)
        ) as encoder:
            for pipeline in (first, second):
                encoder.set_pipeline(pipeline)
                encoder.draw(3)
        assert abs(int(color.read()[0, 0, 0]) - 128) <= 1
        assert depth.read()[0, 0, 0] == pytest.approx(0.1 / 20000.0, rel=1e-5)


@pytest.mark.parametrize(
    ("compare", "passes"),
    [("never", ""), ("less", "l"), ("equal", "e"), ("lequal", "le"), ("greater", "g"), ("notequal", "lg"),
     ("gequal", "ge"), ("always", "leg")],
)  # fmt: skip
def test_depth_compare(bench: Any, compare: str, passes: str) -> None:
    color, depth = bench.texture("r8", 1, 1), bench.texture("d32f", 1, 1)
    for name, z in (("l", 0.25), ("e", 0.5), ("g", 0.75)):
        pipeline = bench.pipeline(
            f"void main() {{ gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2 - 1, {z}, 1); }}",
            WHITE,
            depth=DepthState(compare=compare),
        )
        bench.draw(pipeline, [color], depth, clear=(0, 0, 0, 0), depth_clear=0.5)
        assert bool(color.read()[0, 0, 0]) == (name in passes)
        assert depth.read()[0, 0, 0] == (z if name in passes else 0.5)


def test_depth_without_test_still_writes_and_read_only_never(bench: Any) -> None:
    color, depth = bench.texture("r8", 1, 1), bench.texture("d32f", 1, 1)
    vertex = "void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2 - 1, 0.25, 1); }"
    bench.draw(bench.pipeline(vertex, WHITE, depth=DepthState(test=False)), [color], depth, depth_clear=1.0)
    assert depth.read()[0, 0, 0] == 0.25
    depth.write(np.float32([0.1]))
    with bench.device.render_pass(
        "read only", [ColorAttachment(color)], DepthAttachment(depth, read_only=True)
    ) as encoder:
        encoder.set_pipeline(bench.pipeline(vertex, WHITE, depth=DepthState()))
        encoder.set_bindings(Bindings(textures={0: (depth, bench.nearest())}))  # may be sampled at the same time
        encoder.draw(3)
    assert depth.read()[0, 0, 0] == np.float32(0.1)


def test_depth_only_pass_layers_and_bias(bench: Any) -> None:
    shadow = bench.texture("d32f", 2, 2, kind="2d-array", layers=3)
    vertex = "void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2 - 1, 0.5, 1); }"
    for layer, bias in ((0, 0.0), (2, -(2.0**20))):
        with bench.device.render_pass("shadow", [], DepthAttachment(shadow, clear=0.0, layer=layer)) as encoder:
            encoder.set_pipeline(bench.pipeline(vertex, None, depth=DepthState(bias=bias)))
            encoder.draw(3)
    assert shadow.read(layer=0)[0, 0, 0] == 0.5
    assert shadow.read(layer=2)[0, 0, 0] < 0.5


def test_layered_pass_picks_layers_by_gl_layer(bench: Any) -> None:
    if "GL_ARB_shader_viewport_layer_array" not in bench.device.caps.extensions:
        pytest.skip("gl_Layer is not writable in vertex shaders here")
    target = bench.texture("r8", 2, 2, kind="2d-array", layers=3)
    vertex = """void main() { gl_Layer = gl_InstanceID;
        gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2 - 1, 0, 1); }"""
    fragment = "out vec4 color; void main() { color = vec4((gl_Layer + 1) * 50 / 255.0); }"
    with bench.device.render_pass("layers", [ColorAttachment(target, layer=-1, clear=(0, 0, 0, 0))]) as encoder:
        encoder.set_pipeline(bench.pipeline(vertex, fragment))
        encoder.draw(3, 2)
    assert [int(target.read(layer=i)[0, 0, 0]) for i in range(3)] == [50, 100, 0]


@pytest.mark.parametrize("layers", [6, 12])
def test_render_to_cube_faces_and_levels(bench: Any, layers: int) -> None:
    cube = bench.texture("rgba16f", 4, 4, kind="cube", layers=layers, mips=2)
    for layer in range(layers):
        for level in range(2):
            text = f"void main() {{ color = vec4({layer}.0, {level}.0, uv); }}"
            bench.shade(text, into=cube, level=level, layer=layer)
    for layer in range(layers):
        for level in range(2):
            image = cube.read(level=level, layer=layer)
            assert image.shape == ((4, 4, 4), (2, 2, 4))[level]
            np.testing.assert_array_equal(
                image[..., :2], np.broadcast_to(np.float16([layer, level]), image[..., :2].shape)
            )
            assert image[0, -1, 2] > image[0, 0, 2]
            assert image[-1, 0, 3] > image[0, 0, 3]


def test_render_to_3d_slices(bench: Any) -> None:
    volume = bench.texture("r8", 2, 2, kind="3d", depth=3)
    bench.shade("void main() { color = vec4(1.0); }", into=volume, layer=2)
    assert volume.read(layer=2).min() == 255


def test_several_targets_and_integer_clear(bench: Any) -> None:
    ids, colors = bench.texture("r32ui", 2, 1), bench.texture("rg11b10f", 2, 1)
    fragment = """layout(location = 0) out uint id; layout(location = 1) out vec4 color;
        void main() { if (gl_FragCoord.x < 1.0) discard; id = 4000000000u; color = vec4(3.0, 0.25, 7.0, 1.0); }"""
    vertex = "void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2 - 1, 0, 1); }"
    with bench.device.render_pass(
        "targets", [ColorAttachment(ids, clear=(7, 0, 0, 0)), ColorAttachment(colors, clear=(0.5, 0, 0, 0))]
    ) as encoder:
        encoder.set_pipeline(bench.pipeline(vertex, fragment, blend=(None, None)))
        encoder.draw(3)
    assert ids.read()[0, :, 0].tolist() == [7, 4000000000]
    assert colors.read()[0].tolist() == [[0.5, 0, 0], [3, 0.25, 7]]


@pytest.mark.parametrize(
    ("blend", "expected"),
    [
        (None, [0.5, 0.25, 1.0, 0.5]),
        (
            BlendState("src_alpha", "one_minus_src_alpha", src_alpha="one", dst_alpha="one_minus_src_alpha"),
            [0.375, 0.25, 0.5, 0.75],
        ),
        (BlendState("one", "one", src_alpha="one", dst_alpha="one"), [0.75, 0.5, 1.0, 1.0]),
        (BlendState("dst_color", "zero"), [0.125, 0.0625, 0.0, 0.5]),
        (BlendState("one", "one", "max"), [0.5, 0.25, 1.0, 0.5]),
        (BlendState("one", "one", "reverse_subtract"), [-0.25, 0.0, -1.0, 0.5]),
        (BlendState(write_mask="rb"), [0.5, 0.25, 1.0, 0.5]),
    ],
)  # fmt: skip
def test_blend(bench: Any, blend: BlendState | None, expected: list[float]) -> None:
    target = bench.texture("rgba32f", 1, 1)
    vertex = "void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2 - 1, 0, 1); }"
    fragment = "out vec4 color; void main() { color = vec4(0.5, 0.25, 1.0, 0.5); }"
    bench.draw(bench.pipeline(vertex, fragment, blend=(blend,)), [target], None, clear=(0.25, 0.25, 0.0, 0.5))
    np.testing.assert_allclose(target.read()[0, 0], expected, atol=1e-6)


def test_write_mask_and_the_clear_after_it(bench: Any) -> None:
    target = bench.texture("rgba8", 1, 1)
    vertex = "void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2 - 1, 0, 1); }"
    masked = bench.pipeline(vertex, WHITE, blend=(BlendState(write_mask="g"),))
    bench.draw(masked, [target], None, clear=(0, 0, 0, 0))
    assert target.read()[0, 0].tolist() == [0, 255, 0, 0]
    bench.draw(masked, [target], None, clear=(1, 0, 1, 1))  # the mask of the last draw must not hold the clear back
    assert target.read()[0, 0].tolist() == [255, 255, 255, 255]


INSTANCED = """
layout(location = 0) in vec3 position; layout(location = 1) in uint row;
flat out uint picked;
void main() { picked = row; gl_Position = vec4(position.xy + vec2(0.5 * float(gl_InstanceID), 0.0), position.z, 1.0); }
"""
PICKED = "flat in uint picked; layout(location = 0) out uint id; void main() { id = picked; }"
INSTANCE_ATTRIBUTES = (POSITION, VertexAttribute(1, "row", "u4x1", per_instance=True))


def _column_quads() -> tuple[np.ndarray, np.ndarray]:
    """A quad over the first of four columns, after four unused vertices; its indices, after three unused ones."""
    positions = np.float32([[9, 9, 9]] * 4 + [[-1, -1, 0], [-0.5, -1, 0], [-0.5, 1, 0], [-1, 1, 0]])
    return positions, np.uint32([77, 77, 77, 0, 1, 2, 0, 2, 3])


def test_draw_indexed_with_offsets_and_base_instance(bench: Any) -> None:
    target = bench.texture("r32ui", 4, 1)
    positions, indices = _column_quads()
    pipeline = bench.pipeline(INSTANCED, PICKED, attributes=INSTANCE_ATTRIBUTES, raster=RasterState())
    streams = {"position": bench.buffer(positions), "row": bench.buffer(np.arange(100, 120, dtype=np.uint32))}
    index = bench.buffer(indices)
    with bench.device.render_pass("instances", [ColorAttachment(target, clear=(0, 0, 0, 0))]) as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_vertex_buffers(streams, index)
        encoder.draw_indexed(6, 3, first_index=3, base_vertex=4, base_instance=10)
    assert target.read()[0, :, 0].tolist() == [110, 111, 112, 0]


def test_multi_draw_indexed_indirect(bench: Any) -> None:
    target = bench.texture("r32ui", 4, 1)
    positions, indices = _column_quads()
    pipeline = bench.pipeline(INSTANCED, PICKED, attributes=INSTANCE_ATTRIBUTES)
    streams = {"position": bench.buffer(positions), "row": bench.buffer(np.arange(100, 120, dtype=np.uint32))}
    index = bench.buffer(indices)
    commands = bench.buffer(np.uint32([[6, 4, 3, 4, 0], [6, 2, 3, 4, 10], [6, 1, 3, 4, 15]]), "commands")
    counters = bench.device.counters
    before = counters.snapshot()
    with bench.device.render_pass("indirect", [ColorAttachment(target, clear=(0, 0, 0, 0))]) as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_vertex_buffers(streams, index)
        encoder.multi_draw_indexed_indirect(commands, 1, 2)
        with pytest.raises(UsageError, match=r"'commands'.*outside"):
            encoder.multi_draw_indexed_indirect(commands, 2, 2)
    assert target.read()[0, :, 0].tolist() == [115, 111, 0, 0]
    after = counters.snapshot()
    assert (after["draws"] - before["draws"], after["indirect_commands"] - before["indirect_commands"]) == (1, 2)


def test_vertex_formats_reach_the_shader(bench: Any) -> None:
    target = bench.texture("rgba32f", 1, 1)
    vertex = """layout(location = 0) in vec4 s; layout(location = 1) in vec4 u; layout(location = 2) in uvec4 j;
        layout(location = 3) in vec2 h; layout(location = 4) in vec2 pair; layout(location = 5) in float single;
        flat out vec4 seen;
        void main() { seen = vec4(s.x + s.y, u.z, float(j.w) + h.y, pair.y * single);
            gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2 - 1, 0, 1); }"""
    attributes = (
        VertexAttribute(0, "s", "snorm16x4"), VertexAttribute(1, "u", "unorm16x4"), VertexAttribute(2, "j", "u2x4"),
        VertexAttribute(3, "h", "f2x2"), VertexAttribute(4, "mixed", "f4x2"), VertexAttribute(5, "mixed", "f4x1"),
    )  # fmt: skip
    streams = {
        "s": bench.buffer(np.int16([[32767, -32767, 0, 0]] * 3)),
        "u": bench.buffer(np.uint16([[0, 0, 65535, 0]] * 3)),
        "j": bench.buffer(np.uint16([[0, 0, 0, 40000]] * 3)),
        "h": bench.buffer(np.float16([[0, 0.5]] * 3)),
        "mixed": bench.buffer(np.float32([[1, 2, 3]] * 3)),
    }
    pipeline = bench.pipeline(
        vertex, "flat in vec4 seen; out vec4 color; void main() { color = seen; }", attributes=attributes
    )
    with bench.device.render_pass("formats", [ColorAttachment(target)]) as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_vertex_buffers(streams)
        encoder.draw(3)
    np.testing.assert_allclose(target.read()[0, 0], [0, 1, 40000.5, 6], atol=1e-6)


def test_wireframe_lines_and_points(bench: Any) -> None:
    target = bench.texture("r8", 64, 64)
    vertex = """void main() { gl_PointSize = 1.0;
        gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 0.8 - 0.8, 0, 1); }"""
    lit = {}
    for name, state in {
        "solid": {},
        "wireframe": {"raster": RasterState("none", fill="wireframe")},
        "lines": {"topology": "lines"},
        "points": {"topology": "points"},
    }.items():
        bench.draw(bench.pipeline(vertex, WHITE, **state), [target], None, clear=(0, 0, 0, 0))
        lit[name] = int((target.read() > 0).sum())
    assert lit["solid"] > lit["wireframe"] > lit["lines"] > lit["points"] == 3


def test_passes_in_wrong_use(bench: Any) -> None:
    device = bench.device
    color, small, depth = bench.texture("r8", 4, 4), bench.texture("r8", 2, 2), bench.texture("d32f", 4, 4)
    with pytest.raises(UsageError, match="no attachment"):
        device.render_pass("p", [])
    with pytest.raises(UsageError, match="differ in size"):
        device.render_pass("p", [ColorAttachment(color), ColorAttachment(small)])
    with pytest.raises(UsageError, match="cannot be a colour"):
        device.render_pass("p", [ColorAttachment(depth)])
    with pytest.raises(UsageError, match="cannot be a depth"):
        device.render_pass("p", [], DepthAttachment(color))
    pipeline = bench.pipeline(SCREEN, WHITE, attributes=(POSITION,))
    with device.render_pass("outer", [ColorAttachment(color)]) as encoder:
        with pytest.raises(UsageError, match="'inner' begins before pass 'outer'"):
            device.compute_pass("inner")
        with pytest.raises(UsageError, match="set_pipeline comes before"):
            encoder.draw(3)
        encoder.set_pipeline(pipeline)
        with pytest.raises(UsageError, match=r"stream.*position"):
            encoder.draw(3)
        encoder.set_vertex_buffers({"position": bench.buffer(36)})
        with pytest.raises(UsageError, match="index buffer"):
            encoder.draw_indexed(3)
        with pytest.raises(UsageError, match="while it is drawn into"):
            encoder.set_bindings(Bindings(textures={0: (color, bench.nearest())}))
    with pytest.raises(UsageError, match="has ended"):
        encoder.draw(3)
    with pytest.raises(UsageError, match="location is used twice"):
        bench.pipeline(SCREEN, WHITE, attributes=(POSITION, POSITION))
    with pytest.raises(UsageError, match="unknown vertex format"):
        bench.pipeline(SCREEN, WHITE, attributes=(VertexAttribute(0, "position", "f3x3"),))


def test_index_range_is_checked(bench: Any) -> None:
    color = bench.texture("r8", 4, 4)
    pipeline = bench.pipeline(SCREEN, WHITE, attributes=(POSITION,))
    with bench.device.render_pass("p", [ColorAttachment(color)]) as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_vertex_buffers({"position": bench.buffer(36)}, bench.buffer(np.uint32([0, 1, 2])))
        with pytest.raises(UsageError, match=r"indices \[1, 4\) lie outside the index buffer of 3"):
            encoder.draw_indexed(3, first_index=1)


def test_attachments_that_do_not_go_together(bench: Any) -> None:
    array = bench.texture("r8", 4, 4, kind="2d-array", layers=2)
    flat = bench.texture("r8", 4, 4)
    with pytest.raises(DeviceError, match="cannot draw into these attachments together"):
        bench.device.render_pass("p", [ColorAttachment(array, layer=-1), ColorAttachment(flat)])


def test_multisampled_targets_are_resolved_by_a_shader(bench: Any) -> None:
    many = bench.texture("rgba8", 8, 8, samples=4)
    depth = bench.texture("d32f", 8, 8, samples=4)
    slanted = "void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 0.9 - 1.0, 0.5, 1); }"
    pipeline = bench.pipeline(slanted, WHITE, depth=DepthState())
    bench.draw(pipeline, [many], depth, clear=(0, 0, 0, 0), depth_clear=0.0)
    mean = """layout(binding = 0) uniform sampler2DMS t;
        void main() { ivec2 p = ivec2(gl_FragCoord.xy);
            color = texelFetch(t, p, 0) + texelFetch(t, p, 1) + texelFetch(t, p, 2) + texelFetch(t, p, 3); }"""
    seen = bench.shade(mean, 8, 8, bindings=Bindings(textures={0: (many, bench.nearest())}))
    values = set(seen[..., 0].ravel().tolist())
    assert {0.0, 4.0} < values  # and something between, on the edge
    with pytest.raises(DeviceError, match="at most"):
        bench.texture("rgba8", 8, 8, samples=1024)
    with pytest.raises(UsageError, match="cannot be read back"):
        many.read()
    with pytest.raises(UsageError, match="only be drawn into"):
        many.write(bytes(256))
