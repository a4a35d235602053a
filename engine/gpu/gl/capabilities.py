"""What the device can do, asked once; and the test that reversed depth keeps its precision."""

from __future__ import annotations

import ctypes
import logging
import re
from typing import TYPE_CHECKING

from engine.core.errors import LucarnaError
from engine.gpu.gl import enums as e
from engine.gpu.gl.texel_formats import internal_format
from engine.gpu.types import (
    Caps,
    ColorAttachment,
    DepthAttachment,
    RasterState,
    RenderPipelineDesc,
    ShaderSource,
    TextureDesc,
)

if TYPE_CHECKING:
    from engine.gpu.gl.context import Context
    from engine.gpu.gl.device import GlDevice
    from engine.gpu.gl.functions import Functions

log = logging.getLogger(__name__)

SOFTWARE = re.compile(r"llvmpipe|softpipe|swiftshader|software rasterizer|swrast", re.I)


def probe(context: Context) -> Caps:
    """All but `reversed_z`, which needs a working device."""
    gl, extensions = context.gl, context.extensions
    renderer = gl.text(e.RENDERER)
    software = bool(SOFTWARE.search(renderer))
    anisotropic = context.version >= (4, 6) or bool(
        extensions & {"GL_ARB_texture_filter_anisotropic", "GL_EXT_texture_filter_anisotropic"}
    )
    most_samples = max(1, min(gl.integer(e.MAX_COLOR_TEXTURE_SAMPLES), gl.integer(e.MAX_DEPTH_TEXTURE_SAMPLES)))
    return Caps(
        backend="gl",
        device=renderer,
        version=gl.text(e.VERSION),
        software=software,
        reversed_z=True,
        compute=True,
        bc="GL_EXT_texture_compression_s3tc" in extensions,  # BC4 to BC7 are core, BC1 to BC3 are not
        max_texture_size=gl.integer(e.MAX_TEXTURE_SIZE),
        max_array_layers=gl.integer(e.MAX_ARRAY_TEXTURE_LAYERS),
        max_anisotropy=gl.number(e.MAX_TEXTURE_MAX_ANISOTROPY) if anisotropic else 1.0,
        max_ssbo_bytes=gl.integer(e.MAX_SHADER_STORAGE_BLOCK_SIZE),
        max_workgroup_invocations=gl.integer(e.MAX_COMPUTE_WORK_GROUP_INVOCATIONS),
        timestamps=not software,  # software rasterisers run behind: their timer queries measure nothing
        extensions=extensions,
        uniform_alignment=gl.integer(e.UNIFORM_BUFFER_OFFSET_ALIGNMENT),
        storage_alignment=gl.integer(e.SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT),
        max_uniform_bytes=gl.integer(e.MAX_UNIFORM_BLOCK_SIZE),
        max_samples=most_samples,
        sample_counts=_sample_counts(gl),
        max_patch_vertices=gl.integer(e.MAX_PATCH_VERTICES),
    )


def _sample_counts(gl: Functions) -> tuple[int, ...]:
    """Of colour and of depth alike. A texture of two samples may come with four, two of which nobody would read."""
    common: set[int] | None = None
    for format in ("rgba16f", "d32f"):
        count = ctypes.c_int()
        where = (e.TEXTURE_2D_MULTISAMPLE, internal_format(format))
        gl.GetInternalformativ(*where, e.NUM_SAMPLE_COUNTS, 1, ctypes.byref(count))
        counts = (ctypes.c_int * max(1, count.value))()
        gl.GetInternalformativ(*where, e.SAMPLES, len(counts), ctypes.byref(counts))
        common = set(counts) if common is None else common & set(counts)
    return tuple(sorted((common or set()) - {0, 1}))


_VERTEX = """
void main() {
    // two full-screen triangles at z = near / distance with near = 0.01: 20000.25 m, then 20000 m, which is nearer
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    float distance = gl_InstanceID == 0 ? 20000.25 : 20000.0;
    gl_Position = vec4(corner * 2.0 - 1.0, 0.01, distance);
    gl_Position.xy *= distance;
    shade = float(gl_InstanceID);
}
"""


def reversed_z_works(device: GlDevice) -> bool:
    """Draw two planes 25 cm apart, 20 km away, the far one first, and look whether the near one wins; then the same in
    the other order, where the far one must lose."""
    color = depth = pipeline = None
    try:
        color = device.texture(TextureDesc("rgba8", 4, 4, label="depth self-test"))
        depth = device.texture(TextureDesc("d32f", 4, 4, label="depth self-test"))
        results = []
        for flip in ("", "1 - "):
            vertex = "out float shade;\n" + _VERTEX.replace("gl_InstanceID", f"({flip}gl_InstanceID)")
            pipeline = device.render_pipeline(
                RenderPipelineDesc(
                    "depth self-test",
                    ShaderSource("vertex", vertex),
                    ShaderSource("fragment", "in float shade; out vec4 color; void main() { color = vec4(shade); }"),
                    raster=RasterState(cull="none"),
                )
            )
            with device.render_pass(
                "depth self-test",
                [ColorAttachment(color, clear=(0.5, 0.5, 0.5, 0.5))],
                DepthAttachment(depth, clear=0.0),
            ) as encoder:
                encoder.set_pipeline(pipeline)
                encoder.draw(3, 2)
            results.append(bool((color.read() == 255).all()))
            pipeline.release()
            pipeline = None
        works = all(results)
    except LucarnaError as error:
        log.warning("the depth self-test could not run: %s", error)
        works = False
    finally:
        for resource in (color, depth, pipeline):
            if resource is not None:
                resource.release()
    if not works:
        log.warning("%s: reversed depth does not keep its precision; far surfaces may flicker", device.caps.device)
    return works
