"""The GPU layer: descriptors in, images out. Owns every object of the graphics API; only this package talks to it.

    ShaderSource <- preprocess.flatten(file)          TextureDesc, BufferData
         |                                                  |
         v                                                  v
    Device.render_pipeline(desc)                     Device.texture() / buffer() / sampler()
    Device.compute_pipeline(desc)                           |
         |                                                  |
         +------------------> RenderPass / ComputePass <----+
                               set_pipeline, set_bindings, set_vertex_buffers, draw*, dispatch
                                     |
                                     v
                              Texture.read() / Texture.native / Device.present()

    types         the contract: descriptors and protocols        formats     what one texel or vertex is made of
    validate      wrong calls, the same words in every backend   glsl_layout std140/std430 <-> numpy
    preprocess    #include, defines, line map                    compile_log driver logs -> ShaderError
    program_cache linked programs kept on the disk
    gl/           OpenGL 4.5 (4.3 + DSA + clip control)          null/       records the call stream, no GPU

May import engine.core and engine.assets (formats). No graphics library is imported before open_device.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from engine.core.errors import UsageError

if TYPE_CHECKING:
    from engine.gpu.types import Device

BACKENDS = ("gl", "null")


def open_device(backend: str = "gl", *, attach: bool = False, debug: bool = False) -> Device:
    """Open a device. `attach`: use the OpenGL context that is current (a window's), not an own one without window.

    `debug`: check for API errors after each pass and name objects for frame debuggers. Raises DeviceError where the
    machine has no usable device, UsageError for an unknown backend."""
    if backend == "gl":
        from engine.gpu.gl.device import GlDevice

        return GlDevice(attach=attach, debug=debug)
    if backend == "null":
        from engine.gpu.null.device import NullDevice

        return NullDevice()
    raise UsageError(f"unknown graphics backend {backend!r}", hint=f"choose one of {', '.join(BACKENDS)}")
