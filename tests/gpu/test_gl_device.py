from __future__ import annotations

import ctypes
import gc
import logging
import subprocess
import sys
import threading
from typing import Any

import glcontext
import numpy as np
import pytest

from engine.core.errors import DeviceError, ShaderError, UsageError
from engine.gpu import open_device
from engine.gpu.gl import context
from engine.gpu.gl import enums as e
from engine.gpu.gl.capabilities import SOFTWARE, reversed_z_works
from engine.gpu.gl.context import lacking
from engine.gpu.gl.device import GlDevice
from engine.gpu.gl.shader import version_prelude
from engine.gpu.gl.timestamps import Timestamps
from engine.gpu.types import (
    Bindings,
    ColorAttachment,
    Device,
    RenderPipelineDesc,
    SamplerDesc,
    ShaderSource,
    TextureDesc,
)

VERTEX = "void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2 - 1, 0, 1); }"
RED = "out vec4 color; void main() { color = vec4(1, 0, 0, 1); }"


def pipeline_desc(fragment: str = RED, **state: Any) -> RenderPipelineDesc:
    vertex = ShaderSource("vertex", VERTEX)
    return RenderPipelineDesc("t", vertex, ShaderSource("fragment", fragment), depth=None, **state)


def red_picture(device: Device) -> list[int]:
    """Draw red over a 2x2 texture on `device`; the top left pixel."""
    target = device.texture(TextureDesc("rgba8", 2, 2))
    pipeline = device.render_pipeline(pipeline_desc())
    with device.render_pass("red", [ColorAttachment(target, clear=(0, 0, 1, 1))]) as encoder:
        encoder.set_pipeline(pipeline)
        encoder.draw(3)
    pixel: list[int] = target.read()[0, 0].tolist()
    target.release()
    pipeline.release()
    return pixel


def test_caps(gl_device: Device) -> None:
    caps = gl_device.caps
    assert caps.backend == "gl"
    assert caps.compute
    assert caps.max_texture_size >= 4096
    assert caps.max_array_layers >= 256
    assert 4 <= caps.uniform_alignment <= 256
    assert caps.max_uniform_bytes >= 16384
    assert caps.timestamps is not caps.software


@pytest.mark.parametrize(
    ("name", "software"),
    [("llvmpipe (LLVM 15.0.6, 256 bits)", True), ("softpipe", True), ("SwiftShader Device (LLVM 10)", True),
     ("NVIDIA GeForce RTX 3060/PCIe/SSE2", False), ("AMD Radeon RX 6800 (radeonsi, navi21)", False)],
)  # fmt: skip
def test_software_is_known_by_name(name: str, software: bool) -> None:
    assert bool(SOFTWARE.search(name)) is software


def test_what_a_driver_lacks() -> None:
    needed = frozenset({"GL_ARB_direct_state_access", "GL_ARB_clip_control", "GL_ARB_get_texture_sub_image"})
    assert lacking((4, 5), frozenset()) == []
    assert lacking((4, 3), needed) == []
    assert lacking((4, 3), needed - {"GL_ARB_clip_control"}) == ["GL_ARB_clip_control"]
    assert lacking((4, 1), needed) == ["OpenGL 4.3"]


def test_version_prelude() -> None:
    assert version_prelude((4, 6), frozenset()).startswith("#version 450 core\n")
    text = version_prelude((4, 3), frozenset({"GL_ARB_shader_draw_parameters"}))
    assert text == "#version 430 core\n#extension GL_ARB_shader_draw_parameters : enable\n#line 1\n"


def test_unknown_backend() -> None:
    with pytest.raises(UsageError, match="'vulkan'"):
        open_device("vulkan")


def test_no_context_is_a_device_error_that_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(**options: Any) -> None:
        raise RuntimeError("cannot detect the display")

    monkeypatch.setattr(glcontext, "get_backend_by_name", lambda name: refuse)
    monkeypatch.setattr(glcontext, "default_backend", lambda: refuse)
    with pytest.raises(DeviceError, match=r"cannot detect the display.*install Mesa"):
        open_device("gl")


def test_attaching_to_nothing_is_a_device_error() -> None:
    code = "from engine.gpu import open_device; open_device('gl', attach=True)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "DeviceError: no OpenGL context is current on this thread (open the window first" in done.stderr


def test_a_driver_that_is_too_old_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(context, "lacking", lambda version, extensions: ["OpenGL 4.3", "GL_ARB_clip_control"])
    with pytest.raises(DeviceError, match=r"OpenGL 4\.\d by .* lacks OpenGL 4\.3, GL_ARB_clip_control; OpenGL 4\.5"):
        open_device("gl")


def test_pipelines_are_shared_and_counted(gl_device: Device) -> None:
    programs = gl_device.live_objects()["program"]
    compiled = gl_device.counters.programs_compiled
    first = gl_device.render_pipeline(pipeline_desc("out vec4 color; void main() { color = vec4(0.123); }"))
    again = gl_device.render_pipeline(pipeline_desc("out vec4 color; void main() { color = vec4(0.123); }"))
    strip = gl_device.render_pipeline(
        pipeline_desc("out vec4 color; void main() { color = vec4(0.123); }", topology="triangle_strip")
    )
    assert first is again
    assert strip is not first
    assert gl_device.counters.programs_compiled == compiled + 1  # other state, same program
    for pipeline in (first, strip):
        pipeline.release()
    assert gl_device.live_objects()["program"] == programs + 1
    again.release()
    assert gl_device.live_objects()["program"] == programs


def test_a_failed_compile_leaves_nothing(gl_device: Device) -> None:
    before = gl_device.live_objects()
    for _ in range(2):
        with pytest.raises(ShaderError):
            gl_device.render_pipeline(pipeline_desc("broken"))
    assert gl_device.live_objects() == before
    assert red_picture(gl_device) == [255, 0, 0, 255]


def test_buffers(gl_device: Device) -> None:
    buffer = gl_device.buffer(np.arange(4, dtype=np.uint32), label="numbers")
    buffer.write(np.uint32([9]), 4)
    buffer.write(b"", 16)
    assert np.frombuffer(buffer.read(), np.uint32).tolist() == [0, 9, 2, 3]
    assert np.frombuffer(buffer.read(8, 4), np.uint32).tolist() == [2]
    assert buffer.read(16) == b""
    empty, small, zeros = gl_device.buffer(b""), gl_device.buffer(b"abc"), gl_device.buffer(64)
    assert (empty.size, empty.read()) == (0, b"")
    assert small.read() == b"abc"
    assert zeros.read() == bytes(64)
    with pytest.raises(UsageError, match=r"'numbers': bytes \[12, 20\) lie outside its 16 bytes"):
        buffer.write(bytes(8), 12)
    with pytest.raises(UsageError, match="outside"):
        buffer.read(-4, 4)
    with pytest.raises(UsageError, match="outside"):
        gl_device.buffer(-1)
    with pytest.raises(UsageError, match="C-contiguous"):
        buffer.write(np.zeros((2, 2), np.uint32).T[::-1])
    for made in (buffer, empty, small, zeros):
        made.release()
        made.release()  # twice does no harm


def test_an_allocation_that_fails_is_a_device_error(gl_device: Device) -> None:
    before = gl_device.live_objects()
    with pytest.raises(DeviceError, match=r"allocating \d+ MiB for buffer 'huge': OUT_OF_MEMORY.*smaller"):
        gl_device.buffer(1 << 46, label="huge")
    gc.collect()
    gl_device.end_frame()
    assert gl_device.live_objects() == before


def test_errors_of_the_windows_toolkit_are_not_ours(gl_device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    size = 1 << 24
    gl_device.gl.Enable(0xFFFF)  # type: ignore[attr-defined]  # the real backend's functions
    with pytest.raises(DeviceError, match="INVALID_ENUM"):
        gl_device.buffer(size, label="own")
    monkeypatch.setattr(gl_device, "attached", True)
    gl_device.gl.Enable(0xFFFF)  # type: ignore[attr-defined]  # as above
    gl_device.buffer(size, label="in a window").release()
    gl_device.gl.Enable(0xFFFF)  # type: ignore[attr-defined]  # as above
    gl_device.texture(TextureDesc("d32f", 2048, 2048)).release()
    gc.collect()


def test_release_forgets_framebuffers_and_vertex_arrays(gl_device: Device) -> None:
    before = gl_device.live_objects()
    red_picture(gl_device)
    assert gl_device.live_objects()["framebuffer"] == before["framebuffer"]
    assert gl_device.live_objects()["texture"] == before["texture"]


def test_forgotten_and_foreign_threads_objects_are_freed_by_end_frame(gl_device: Device) -> None:
    before = gl_device.live_objects()
    gl_device.texture(TextureDesc("r8", 4, 4))  # no one holds it
    texture = gl_device.texture(TextureDesc("r8", 4, 4))
    thread = threading.Thread(target=texture.release)
    thread.start()
    thread.join()
    gc.collect()
    assert gl_device.live_objects()["texture"] == before["texture"] + 2
    gl_device.end_frame()
    assert gl_device.live_objects() == before


def test_a_reused_name_is_bound_again(gl_device: Device) -> None:
    """Drivers give a deleted object's name to the next one: the cache must not take it for the old one."""
    target = gl_device.texture(TextureDesc("r8", 1, 1))
    fetch = "layout(binding = 0) uniform sampler2D t; out vec4 c; void main() { c = texelFetch(t, ivec2(0), 0); }"
    sampler = gl_device.sampler(SamplerDesc())
    pipeline = gl_device.render_pipeline(pipeline_desc(fetch))
    for value in (10, 20, 30):
        source = gl_device.texture(TextureDesc("r8", 1, 1))
        source.write(bytes([value]))
        with gl_device.render_pass("again", [ColorAttachment(target)]) as encoder:
            encoder.set_pipeline(pipeline)
            encoder.set_bindings(Bindings(textures={0: (source, sampler)}))
            encoder.draw(3)
        assert target.read()[0, 0, 0] == value
        source.release()
    target.release()
    pipeline.release()


def test_bindings_are_diffed(gl_device: Device) -> None:
    target = gl_device.texture(TextureDesc("r8", 1, 1))
    block = gl_device.buffer(64)
    pipeline = gl_device.render_pipeline(pipeline_desc())
    counters = gl_device.counters
    with gl_device.render_pass("diff", [ColorAttachment(target)]) as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_bindings(Bindings(uniforms={0: block}))
        before = counters.api_calls
        encoder.set_bindings(Bindings(uniforms={0: block}))
        assert counters.api_calls == before
        encoder.set_bindings(Bindings(uniforms={1: block}))
        assert counters.api_calls == before + 1
    for made in (target, block, pipeline):
        made.release()


def test_driver_errors_are_raised_in_debug(gl_device: GlDevice) -> None:
    gl_device.gl.Enable(0xDEAD)
    with pytest.raises(DeviceError, match=r"OpenGL error in here: INVALID_ENUM"):
        gl_device.check_errors("here")
    target = gl_device.texture(TextureDesc("r8", 1, 1))
    with pytest.raises(DeviceError, match="pass 'bad'"), gl_device.render_pass("bad", [ColorAttachment(target)]):
        gl_device.gl.Enable(0xDEAD)
    target.release()


def test_end_frame_inside_a_pass_is_refused_and_recovers(gl_device: Device) -> None:
    target = gl_device.texture(TextureDesc("r8", 1, 1))
    gl_device.render_pass("left open", [ColorAttachment(target)])
    with pytest.raises(UsageError, match="'left open'"):
        gl_device.end_frame()
    target.release()
    assert red_picture(gl_device) == [255, 0, 0, 255]


def test_self_test_of_reversed_depth(gl_device: GlDevice, caplog: pytest.LogCaptureFixture) -> None:
    before = gl_device.live_objects()
    assert reversed_z_works(gl_device)
    try:
        gl_device.state.take_over()
        take_over = gl_device.state.take_over
        gl_device.gl.ClipControl(e.UPPER_LEFT, e.NEGATIVE_ONE_TO_ONE)  # what a driver without clip control would do
        with caplog.at_level(logging.WARNING):
            assert not reversed_z_works(gl_device)
        assert "does not keep its precision" in caplog.text
    finally:
        take_over()
    assert gl_device.live_objects() == before


def test_timestamps(gl_device: GlDevice) -> None:
    if not gl_device.caps.timestamps:
        assert gl_device.timestamp() == 0
        assert gl_device.resolve_timestamps([0, 0]) == [0, 0]
    timestamps = Timestamps(gl_device)  # the queries work anywhere; what software says they cost is not to be trusted
    ids = [timestamps.queue() for _ in range(2)]
    first, second = timestamps.resolve(ids)
    assert 0 < first <= second
    assert timestamps.queue() in ids  # reused
    with pytest.raises(UsageError, match="never queued"):
        timestamps.resolve([12345])
    timestamps.clear()


def test_two_devices_in_one_process(gl_device: Device) -> None:
    other = open_device("gl", debug=True)
    try:
        mine, theirs = (d.buffer(np.uint32([n])) for n, d in ((1, gl_device), (2, other)))
        assert red_picture(gl_device) == red_picture(other) == [255, 0, 0, 255]
        mine.write(np.uint32([11]))
        assert np.frombuffer(theirs.read(), np.uint32)[0] == 2
        assert np.frombuffer(mine.read(), np.uint32)[0] == 11
        gl_device.end_frame()
        other.end_frame()
        mine.release()
        theirs.release()
        assert sum(other.live_objects().values()) - other.live_objects()["vertex_array"] == 0
    finally:
        other.release()
        other.release()
    assert red_picture(gl_device) == [255, 0, 0, 255]


def test_release_frees_everything_and_late_collection_is_harmless(gl_device: Device) -> None:
    other = open_device("gl")
    buffer, texture = other.buffer(16), other.texture(TextureDesc("r8", 1, 1))
    red_picture(other)
    other.release()
    buffer.release()
    del texture
    gc.collect()
    gl_device.begin_frame()


@pytest.fixture
def window() -> Any:
    """A context that somebody else made and made current, as a window does."""
    handle = glcontext.get_backend_by_name("egl")(mode="standalone", glversion=450)
    yield handle
    handle.release()
    GlDevice._current = None


def _integer(device: GlDevice, what: int) -> int:
    value = ctypes.c_int()
    device.gl.GetIntegerv(what, ctypes.byref(value))
    return value.value


def test_attached_device_hands_the_context_back(gl_device: Device, window: Any) -> None:
    device = open_device("gl", attach=True, debug=True)
    assert isinstance(device, GlDevice)
    source = device.texture(TextureDesc("rgba8", 4, 4))
    try:
        for _ in range(2):
            device.begin_frame()
            pipeline = device.render_pipeline(pipeline_desc())
            with device.render_pass("red", [ColorAttachment(source, clear=(0, 0, 0, 0))]) as encoder:
                encoder.set_pipeline(pipeline)
                encoder.draw(3)
            pipeline.release()
            device.end_frame()
            assert source.read()[3, 3].tolist() == [255, 0, 0, 255]
            assert _integer(device, 0x935C) == e.LOWER_LEFT  # GL_CLIP_ORIGIN
            assert _integer(device, 0x935D) == e.NEGATIVE_ONE_TO_ONE  # GL_CLIP_DEPTH_MODE
            assert _integer(device, 0x8B8D) == 0  # GL_CURRENT_PROGRAM
            assert _integer(device, 0x85B5) == 0  # GL_VERTEX_ARRAY_BINDING
            assert _integer(device, 0x8CA6) == 0  # GL_DRAW_FRAMEBUFFER_BINDING
            assert _integer(device, e.UNPACK_ALIGNMENT) == 4
            assert not any(device.gl.IsEnabled(what) for what in (e.BLEND, e.CULL_FACE, e.DEPTH_TEST, e.SCISSOR_TEST))
            # the toolkit leaves its own state behind
            device.gl.Enable(e.SCISSOR_TEST)
            device.gl.Enable(e.BLEND)
            device.gl.ColorMask(0, 0, 0, 0)
            device.gl.PixelStorei(e.UNPACK_ROW_LENGTH, 64)
            device.gl.Viewport(0, 0, 1, 1)
        source.write(np.full((4, 4, 4), 7, np.uint8))
        assert source.read().min() == 7
    finally:
        source.release()
        device.release()


def test_upload_between_frames_does_not_trust_the_toolkit(gl_device: Device, window: Any) -> None:
    device = open_device("gl", attach=True)
    assert isinstance(device, GlDevice)
    texture = device.texture(TextureDesc("r8", 3, 3))
    texture.write(bytes(range(9)))
    device.begin_frame()
    device.end_frame()
    device.gl.PixelStorei(e.UNPACK_ROW_LENGTH, 64)  # after end_frame the context is the toolkit's
    device.begin_frame()
    texture.write(bytes(range(9)))
    assert texture.read().ravel().tolist() == list(range(9))
    texture.release()
    device.release()


def test_present_puts_row_0_at_the_top_of_the_window(gl_device: GlDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    """A window's framebuffer has its row 0 at the bottom: the copy must be upside down in memory."""
    source, window = (gl_device.texture(TextureDesc("r8", 1, 2)) for _ in range(2))
    source.write(bytes([10, 20]))
    framebuffer = gl_device.framebuffers.get("window", [ColorAttachment(window)], None)
    blit = gl_device.gl.BlitNamedFramebuffer
    gl_device.present(source, 1, 2)  # not attached: nothing happens
    monkeypatch.setattr(gl_device, "attached", True)
    monkeypatch.setattr(gl_device.gl, "BlitNamedFramebuffer", lambda read, draw, *rest: blit(read, framebuffer, *rest))
    gl_device.present(source, 1, 2)
    monkeypatch.undo()
    assert window.read().ravel().tolist() == [20, 10]
    source.release()
    window.release()
