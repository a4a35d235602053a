from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.gpu.gl.pipeline import writes_memory
from engine.gpu.types import Bindings, ColorAttachment


def test_dispatches_see_what_the_last_one_wrote(bench: Any) -> None:
    pipeline = bench.compute("""
        layout(local_size_x = 8) in;
        layout(std430, binding = 0) buffer Data { uint data[]; };
        void main() { uint i = gl_GlobalInvocationID.x; data[i] = data[i] * 2u + 1u; }""")
    data = bench.buffer(np.arange(64, dtype=np.uint32))
    with bench.device.compute_pass("double") as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_bindings(Bindings(storage={0: data}))
        encoder.dispatch(8)
        encoder.dispatch(4)
    got = np.frombuffer(data.read(), np.uint32)
    once = np.arange(64) * 2 + 1
    np.testing.assert_array_equal(got[:32], once[:32] * 2 + 1)
    np.testing.assert_array_equal(got[32:], once[32:])


def test_ranges_of_uniform_and_storage_buffers(bench: Any) -> None:
    caps = bench.device.caps
    pipeline = bench.compute("""
        layout(local_size_x = 1) in;
        layout(std140, binding = 2) uniform Scale { float scale; };
        layout(std430, binding = 0) readonly buffer In { float given[]; };
        layout(std430, binding = 1) writeonly buffer Out { float made[]; };
        void main() { made[0] = given[0] * scale + float(given.length()); }""")
    uniforms = np.zeros(2 * caps.uniform_alignment // 4, np.float32)
    uniforms[caps.uniform_alignment // 4] = 10.0
    given = np.zeros(2 * caps.storage_alignment // 4, np.float32)
    given[caps.storage_alignment // 4] = 3.0
    uniform, source, made = bench.buffer(uniforms), bench.buffer(given), bench.buffer(4)
    bindings = Bindings(
        uniforms={2: (uniform, caps.uniform_alignment, 16)}, storage={0: (source, caps.storage_alignment, 4), 1: made}
    )
    with bench.device.compute_pass("ranges") as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_bindings(bindings)
        encoder.dispatch(1)
        if caps.uniform_alignment > 4:
            with pytest.raises(UsageError, match="not a multiple of"):
                encoder.set_bindings(Bindings(uniforms={2: (uniform, 4, 16)}))
        with pytest.raises(UsageError, match="outside"):
            encoder.set_bindings(Bindings(storage={0: (source, 0, source.size + 4)}))
    assert np.frombuffer(made.read(), np.float32)[0] == 31.0


@pytest.mark.parametrize("kind", ["2d", "2d-array", "cube", "3d"])
def test_image_store_to_levels_and_layers(bench: Any, kind: str) -> None:
    shape = {"2d": {}, "2d-array": {"layers": 2}, "cube": {"layers": 6}, "3d": {"depth": 4}}[kind]
    texture = bench.texture("rgba16f", 8, 8, mips=2, kind=kind, **shape)
    count = {"2d": 1, "2d-array": 2, "cube": 6, "3d": 2}[kind]
    name = {"2d": "image2D", "2d-array": "image2DArray", "cube": "imageCube", "3d": "image3D"}[kind]
    at = "ivec2(p.xy)" if kind == "2d" else "p"
    pipeline = bench.compute(f"""
        layout(local_size_x = 4, local_size_y = 4) in;
        layout(rgba16f, binding = 1) writeonly uniform {name} target;
        void main() {{ ivec3 p = ivec3(gl_GlobalInvocationID); imageStore(target, {at}, vec4(p, 1.0)); }}""")
    with bench.device.compute_pass("store") as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_bindings(Bindings(images={1: (texture, 1, "write")}))
        encoder.dispatch(1, 1, count)
    for layer in range(count):
        image = texture.read(level=1, layer=layer)
        assert image[3, 2].tolist() == [2, 3, layer, 1]


def test_image_then_sampled_in_a_render_pass(bench: Any) -> None:
    texture = bench.texture("r32ui", 4, 4)
    pipeline = bench.compute("""
        layout(local_size_x = 4, local_size_y = 4) in;
        layout(r32ui, binding = 0) uniform uimage2D target;
        void main() { imageAtomicAdd(target, ivec2(0), 1u); }""")
    texture.write(np.zeros((4, 4), np.uint32))
    with bench.device.compute_pass("count") as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_bindings(Bindings(images={0: (texture, 0, "read_write")}))
        encoder.dispatch(2)
    text = "layout(binding = 0) uniform usampler2D t; void main() { color = vec4(texelFetch(t, ivec2(0), 0).x); }"
    assert bench.shade(text, 1, 1, bindings=Bindings(textures={0: (texture, bench.nearest())}))[0, 0, 0] == 32


def test_shared_memory_and_barrier(bench: Any) -> None:
    pipeline = bench.compute("""
        layout(local_size_x = 64) in;
        layout(std430, binding = 0) readonly buffer In { uint given[]; };
        layout(std430, binding = 1) writeonly buffer Out { uint sums[]; };
        shared uint partial[64];
        void main() {
            uint i = gl_LocalInvocationIndex;
            partial[i] = given[gl_GlobalInvocationID.x];
            barrier();
            for (uint step = 32u; step > 0u; step >>= 1u) { if (i < step) partial[i] += partial[i + step]; barrier(); }
            if (i == 0u) sums[gl_WorkGroupID.x] = partial[0];
        }""")
    given, sums = bench.buffer(np.arange(256, dtype=np.uint32)), bench.buffer(16)
    with bench.device.compute_pass("sum") as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_bindings(Bindings(storage={0: given, 1: sums}))
        encoder.dispatch(4)
    np.testing.assert_array_equal(np.frombuffer(sums.read(), np.uint32), np.arange(256).reshape(4, 64).sum(1))


def test_storage_written_by_a_draw_is_there_after_the_pass(bench: Any) -> None:
    counted = bench.buffer(np.zeros(1, np.uint32))
    text = """layout(std430, binding = 0) buffer Count { uint fragments; };
        void main() { atomicAdd(fragments, 1u); color = vec4(0.0); }"""
    bench.shade(text, 4, 4, bindings=Bindings(storage={0: counted}))
    assert np.frombuffer(counted.read(), np.uint32)[0] == 16


def test_images_that_cannot_be(bench: Any) -> None:
    texture = bench.texture("rgba8-srgb", 4, 4)
    with bench.device.compute_pass("p") as encoder:
        with pytest.raises(UsageError, match="cannot be an image"):
            encoder.set_bindings(Bindings(images={0: (texture, 0, "write")}))
        with pytest.raises(UsageError, match="access"):
            encoder.set_bindings(Bindings(images={0: (texture, 0, "rw")}))
        with pytest.raises(UsageError, match="set_pipeline comes before"):
            encoder.dispatch(1)


@pytest.mark.parametrize(
    ("text", "writes"),
    [
        ("layout(std430, binding = 2) readonly buffer Materials { float m[]; };", False),
        ("layout(std430, binding = 2) buffer Counts { uint n[]; };", True),
        ("layout(std430, binding = 2) coherent writeonly buffer Counts { uint n[]; };", True),
        ("layout(std140, binding = 2) uniform Frame { float buffers; };", False),
        ("layout(r32f, binding = 0) readonly uniform image2D i; void main() { imageLoad(i, ivec2(0)); }", False),
        ("void main() { imageStore (i, ivec2(0), vec4(0)); }", True),
        ("void main() { imageAtomicMax(i, ivec2(0), 1u); }", True),
    ],
)
def test_writers_are_found_in_the_text(text: str, writes: bool) -> None:
    assert writes_memory(text) is writes


def test_a_pass_that_only_reads_needs_no_barrier(bench: Any) -> None:
    target = bench.texture("r8", 1, 1)
    counters = bench.device.counters
    bench.shade("void main() { color = vec4(0.0); }", into=target)
    pipeline = bench.made[-1]
    before = counters.api_calls
    with bench.device.render_pass("again", [ColorAttachment(target)]) as encoder:
        encoder.set_pipeline(pipeline)
        encoder.draw(3)
    assert counters.api_calls - before == 1  # everything else is bound already
