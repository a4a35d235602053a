from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.gpu.null.device import NullDevice
from engine.gpu.types import (
    Bindings,
    ColorAttachment,
    ComputePipelineDesc,
    DepthAttachment,
    Pipeline,
    RenderPipelineDesc,
    SamplerDesc,
    ShaderSource,
    TextureDesc,
    VertexAttribute,
)

ATTRIBUTES = (VertexAttribute(0, "position", "f4x3"), VertexAttribute(1, "object", "u4x1", per_instance=True))


def pipeline(device: NullDevice, label: str = "forward") -> Pipeline:
    return device.render_pipeline(
        RenderPipelineDesc(label, ShaderSource("vertex", "v"), ShaderSource("fragment", "f"), ATTRIBUTES)
    )


def test_records_what_was_asked_in_order(null_device: NullDevice) -> None:
    device = null_device
    color, depth = device.texture(TextureDesc("rgba16f", 8, 4, label="hdr")), device.texture(TextureDesc("d32f", 8, 4))
    positions, objects = device.buffer(48), device.buffer(np.arange(8, dtype=np.uint32))
    index, block = device.buffer(np.zeros(12, np.uint32)), device.buffer(256)
    commands = device.buffer(np.uint32([[6, 2, 0, 0, 0], [6, 1, 6, 0, 7]]))
    clear = ColorAttachment(color, clear=(0, 0, 0, 1))
    with device.render_pass("main", [clear], DepthAttachment(depth, 0.0)) as encoder:
        encoder.set_pipeline(pipeline(device))
        encoder.set_bindings(Bindings(uniforms={0: block}))
        encoder.set_vertex_buffers({"position": positions, "object": objects}, index)
        encoder.multi_draw_indexed_indirect(commands, 0, 2)
        encoder.draw_indexed(3, 2, first_index=6, base_instance=1)
        encoder.draw(3)
    with device.compute_pass("cull") as compute:
        compute.set_pipeline(device.compute_pipeline(ComputePipelineDesc("cull", ShaderSource("compute", "c"))))
        compute.dispatch(4, 2)
    assert device.calls.names() == [
        "render_pass", "set_pipeline", "set_bindings", "set_vertex_buffers", "multi_draw_indexed_indirect",
        "draw_indexed", "draw", "end_pass", "compute_pass", "set_pipeline", "dispatch", "end_pass",
    ]  # fmt: skip
    indirect, plain = device.calls.named("multi_draw_indexed_indirect", "draw_indexed")
    assert indirect.inside == "main"
    assert indirect.commands.tolist() == [[6, 2, 0, 0, 0], [6, 1, 6, 0, 7]]
    assert (plain.first_index, plain.base_instance) == (6, 1)
    with pytest.raises(AttributeError, match="has no 'vertex_count'"):
        _ = plain.vertex_count
    counters = device.counters
    assert (counters.draws, counters.indirect_commands, counters.dispatches, counters.passes) == (3, 2, 1, 2)
    device.calls.clear()
    assert len(device.calls) == 0


def test_keeps_bytes(null_device: NullDevice) -> None:
    source = np.arange(4, dtype=np.uint32)
    buffer = null_device.buffer(source)
    source[:] = 0  # a device copies
    buffer.write(np.uint32([9]), 8)
    assert np.frombuffer(buffer.read(), np.uint32).tolist() == [0, 1, 9, 3]
    assert buffer.read(4, 4) == b"\1\0\0\0"
    assert null_device.counters.bytes_uploaded == 20
    with pytest.raises(UsageError, match="outside its 16 bytes"):
        buffer.write(bytes(4), 13)


def test_textures_read_as_zeros_and_know_what_was_written(null_device: NullDevice) -> None:
    texture = null_device.texture(TextureDesc("rgba16f", 4, 2, mips=2))
    texture.write(np.ones((2, 4, 4), np.float16))
    assert texture.written == {(0, 0)}
    image = texture.read(level=1)
    assert (image.dtype, image.shape, image.any()) == (np.float16, (1, 2, 4), np.False_)
    with pytest.raises(UsageError, match="= 64 bytes, got 8"):
        texture.write(bytes(8))
    assert null_device.texture(TextureDesc("bc7", 4, 4)).read().shape == (4, 4, 4)  # decoded


def test_checks_like_the_real_device(null_device: NullDevice) -> None:
    device = null_device
    color = device.texture(TextureDesc("rgba8", 4, 4))
    with device.render_pass("p", [ColorAttachment(color)]) as encoder:
        with pytest.raises(UsageError, match="set_pipeline comes before"):
            encoder.draw(3)
        encoder.set_pipeline(pipeline(device))
        encoder.set_vertex_buffers({"position": device.buffer(36)}, device.buffer(12))
        with pytest.raises(UsageError, match=r"needs vertex stream\(s\) object, given: position"):
            encoder.draw_indexed(3)
        encoder.set_vertex_buffers({"position": device.buffer(36), "object": device.buffer(8)}, device.buffer(12))
        with pytest.raises(UsageError, match="lie outside the index buffer of 3"):
            encoder.draw_indexed(4)
        with pytest.raises(UsageError, match="stream 'object' holds 2"):
            encoder.draw_indexed(3, 2, base_instance=1)
        with pytest.raises(UsageError, match="lie outside the index buffer"):
            encoder.multi_draw_indexed_indirect(device.buffer(np.uint32([[3, 1, 1, 0, 0]])), 0, 1)
        with pytest.raises(UsageError, match="holds 2"):
            encoder.multi_draw_indexed_indirect(device.buffer(np.uint32([[3, 1, 0, 0, 2]])), 0, 1)
        with pytest.raises(UsageError, match="outside"):
            encoder.multi_draw_indexed_indirect(device.buffer(20), 1, 1)
        with pytest.raises(UsageError, match="while it is drawn into"):
            encoder.set_bindings(Bindings(textures={0: (color, device.sampler(SamplerDesc()))}))
        with pytest.raises(UsageError, match="not a multiple of 256"):
            encoder.set_bindings(Bindings(uniforms={0: (device.buffer(512), 16, 16)}))
        with pytest.raises(UsageError, match="begins before"):
            device.render_pass("q", [ColorAttachment(color)])
        with pytest.raises(UsageError, match="end_frame before"):
            device.end_frame()
    with pytest.raises(UsageError, match="has ended"):
        encoder.draw(3)
    with pytest.raises(UsageError, match="no attachment"):
        device.render_pass("p", [])


def test_counts_live_objects_and_shares_pipelines(null_device: NullDevice) -> None:
    buffer, texture = null_device.buffer(4), null_device.texture(TextureDesc("r8", 1, 1))
    assert null_device.live_objects() == {"buffer": 1, "texture": 1}
    buffer.release()
    buffer.release()
    del texture
    assert null_device.live_objects() == {"buffer": 0, "texture": 0}
    assert pipeline(null_device) is pipeline(null_device)
    assert null_device.counters.programs_compiled == 1
    assert null_device.sampler(SamplerDesc()) is null_device.sampler(SamplerDesc())


def test_without_recording_only_counts() -> None:
    device = NullDevice(record=False)
    color = device.texture(TextureDesc("r8", 1, 1))
    with device.render_pass("p", [ColorAttachment(color)]) as encoder:
        encoder.set_pipeline(pipeline(device))
        encoder.set_vertex_buffers({"position": device.buffer(36), "object": device.buffer(4)})
        encoder.draw(3)
    assert len(device.calls) == 0
    assert device.counters.draws == 1


def test_the_null_device_loads_no_graphics_library() -> None:
    code = "import sys; from engine.gpu import open_device; open_device('null'); print('moderngl' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
