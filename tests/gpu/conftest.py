"""What the tests of the OpenGL backend share: a scope that releases, and one full-screen draw in a line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest
from numpy.typing import NDArray

from engine.gpu.types import (
    Bindings,
    ColorAttachment,
    ComputePipelineDesc,
    DepthAttachment,
    Device,
    Pipeline,
    RasterState,
    RenderPipelineDesc,
    SamplerDesc,
    ShaderSource,
    Texture,
    TextureDesc,
)

#: covers the target with one triangle; `uv` is (0,0) at the top left pixel's outer corner
FULL_SCREEN = """
out vec2 uv;
void main() {
    uv = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, 0.5, 1.0);
}
"""


@dataclass
class Bench:
    """Makes things on the device and releases them all when the test ends."""

    device: Device
    made: list[Any] = field(default_factory=list)

    def keep(self, resource: Any) -> Any:
        self.made.append(resource)
        return resource

    def buffer(self, data: Any, label: str = "") -> Any:
        return self.keep(self.device.buffer(data, label=label))

    def texture(self, format: str, width: int, height: int, **rest: Any) -> Any:
        return self.keep(self.device.texture(TextureDesc(format, width, height, **rest)))

    def pipeline(self, vertex: str, fragment: str | None, **state: Any) -> Pipeline:
        state.setdefault("depth", None)
        state.setdefault("raster", RasterState(cull="none"))
        desc = RenderPipelineDesc(
            "test", ShaderSource("vertex", vertex), ShaderSource("fragment", fragment) if fragment else None, **state
        )
        return self.keep(self.device.render_pipeline(desc))

    def compute(self, text: str) -> Pipeline:
        return self.keep(self.device.compute_pipeline(ComputePipelineDesc("test", ShaderSource("compute", text))))

    def nearest(self, **rest: Any) -> Any:
        return self.device.sampler(SamplerDesc("clamp", "clamp", "clamp", "nearest", "nearest", **rest))

    def shade(
        self, fragment: str, width: int = 4, height: int = 4, format: str = "rgba32f", into: Texture | None = None,
        bindings: Bindings | None = None, **attachment: Any,
    ) -> NDArray[Any]:  # fmt: skip
        """Draw `fragment` (it sees `in vec2 uv`, writes `out vec4 color`) over a target; what is in it then."""
        target = into or self.texture(format, width, height)
        pipeline = self.pipeline(FULL_SCREEN, "in vec2 uv; layout(location = 0) out vec4 color;\n" + fragment)
        with self.device.render_pass("shade", [ColorAttachment(target, **attachment)]) as encoder:
            encoder.set_pipeline(pipeline)
            encoder.set_bindings(bindings or Bindings())
            encoder.draw(3)
        return target.read(level=attachment.get("level", 0), layer=max(0, attachment.get("layer", 0)))

    def draw(self, pipeline: Pipeline, colors: list[Any], depth: Texture | None, count: int = 3, **clear: Any) -> None:
        attachment = DepthAttachment(depth, clear=clear.get("depth_clear")) if depth else None
        with self.device.render_pass(
            "draw", [ColorAttachment(c, clear=clear.get("clear")) for c in colors], attachment
        ) as e:
            e.set_pipeline(pipeline)
            e.draw(count)


@pytest.fixture
def bench(gl_device: Device) -> Iterator[Bench]:
    bench = Bench(gl_device)
    yield bench
    for resource in reversed(bench.made):
        resource.release()
