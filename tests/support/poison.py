"""Plants one bad texel in a pass's input, within a running frame, and collects what that pass and the frame make of it.

The frame runs as always; just before the pass in question the texel is written over. So each pass is tried by itself,
on inputs that the passes before it really made.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.app.runtime import Runtime
from engine.framegraph.compiled import CompiledGraph
from engine.gpu.types import (
    ColorAttachment,
    DepthAttachment,
    DepthState,
    Device,
    RasterState,
    RenderPipelineDesc,
    ShaderSource,
    Texture,
)
from engine.render.view import View

#: what may end up in a texture: by name, for test ids
VALUES = {
    "nan": float("nan"), "inf": float("inf"), "minus_inf": float("-inf"), "zero": 0.0, "minus_one": -1.0,
    "half_max": 65504.0, "huge": 1e38, "denormal": 1e-40,
}  # fmt: skip

_VERTEX = "void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0, 0.0, 1.0); }"


@dataclass(slots=True)
class Shot:
    """Of one frame: `outputs` of the pass right after it ran, by name; `color` u1[h,w,4] and `hdr` f4[h,w,4] at the
    end. What is multisampled cannot be read and is not in `outputs`."""

    graph: CompiledGraph
    outputs: dict[str, NDArray[Any]] = field(default_factory=dict)
    color: NDArray[Any] = field(default_factory=lambda: np.zeros(0))
    hdr: NDArray[Any] = field(default_factory=lambda: np.zeros(0))


def inputs_of(graph: CompiledGraph, name: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """(what the pass reads, what it only draws over)."""
    declaration = next(d for d in graph.plan.declarations if d.name == name)
    read = (*declaration.reads, *declaration.histories)
    over = [w for w in declaration.writes if w not in declaration.creates and w not in read]
    return tuple(read), tuple(over)


def shoot(runtime: Runtime, view: View, name: str, plant: tuple[str, int, int, float] | None = None) -> Shot:
    """Render a frame; `plant` = (input, x, y, value) goes in before pass `name`."""
    renderer = runtime.renderer
    timed = renderer._on_pass
    undo: list[tuple[Texture, NDArray[Any]]] = []
    taken: dict[str, NDArray[Any]] = {}

    @contextlib.contextmanager
    def on_pass(running: str) -> Iterator[None]:
        graph = _running_graph(runtime)
        if running == name and plant is not None:
            texture = graph.texture(plant[0])
            if texture.desc.samples == 1:
                undo.append((texture, texture.read().copy()))
            put(runtime.device, texture, *plant[1:])
        with timed(running):
            yield
        if running == name:
            for written in next(d for d in graph.plan.declarations if d.name == name).writes:
                texture = graph.texture(written)
                if texture.desc.samples == 1:
                    taken[written] = texture.read()

    renderer._on_pass = on_pass  # type: ignore[method-assign]  # put back below
    try:
        frame = runtime.render(view, hdr=True)
    finally:
        del renderer._on_pass
    assert frame.hdr is not None
    shot = Shot(frame.graph, taken, frame.color.read(), frame.hdr.read())
    for texture, texels in undo:  # some maps are kept from frame to frame
        texture.write(np.ascontiguousarray(texels))
    return shot


def _running_graph(runtime: Runtime) -> CompiledGraph:
    """The graph in use: the cache's newest."""
    return next(reversed(runtime.renderer.graph._cache.values()))


def put(device: Device, texture: Texture, x: int, y: int, value: float) -> None:
    """Write `value` to all channels (and samples) of one texel."""
    desc = texture.desc
    if desc.samples > 1:
        _draw_texel(device, texture, x, y, value)
        return
    texels = texture.read().copy()
    with np.errstate(over="ignore", invalid="ignore"):
        if texels.dtype.kind == "f":
            # a denormal of the format's own; 1e38 becomes infinite in half floats, as a store may make it
            texels[y, x] = np.finfo(texels.dtype).smallest_subnormal if value == VALUES["denormal"] else value
        else:
            texels[y, x] = np.iinfo(texels.dtype).max if value > 0.5 or value != value else 0
    texture.write(np.ascontiguousarray(texels))


def _draw_texel(device: Device, texture: Texture, x: int, y: int, value: float) -> None:
    bits = int(np.float32(value).view(np.uint32))
    depth = texture.desc.format == "d32f"
    here = f"if (ivec2(gl_FragCoord.xy) != ivec2({x}, {y})) discard; float v = uintBitsToFloat({bits}u);"
    body = "gl_FragDepth = v;" if depth else "o_color = vec4(v);"
    fragment = f"layout(location = 0) out vec4 o_color;\nvoid main() {{ {here} {body} }}"
    pipeline = device.render_pipeline(
        RenderPipelineDesc(
            "plant", ShaderSource("vertex", _VERTEX), ShaderSource("fragment", fragment), (), "triangles",
            DepthState(True, True, "always") if depth else None, () if depth else (None,), RasterState("none"),
        )
    )  # fmt: skip
    colors = [] if depth else [ColorAttachment(texture)]
    with device.render_pass("plant", colors, DepthAttachment(texture) if depth else None) as encoder:
        encoder.set_pipeline(pipeline)
        encoder.draw(3)
    pipeline.release()


def outside(shape: tuple[int, ...], x: int, y: int, reach: int) -> NDArray[np.bool_]:
    """bool[h,w]: the pixels further than `reach` from (x, y) in x or y."""
    rows, columns = np.indices(shape[:2])
    return np.asarray((np.abs(rows - y) > reach) | (np.abs(columns - x) > reach))


def bits(image: NDArray[Any]) -> NDArray[np.unsignedinteger[Any]]:
    """The raw bits of an image, so that equal means equal also for -0 and not-a-number."""
    return np.ascontiguousarray(image).view(f"u{image.dtype.itemsize}")
