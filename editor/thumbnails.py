"""Thumbnails of resident textures: each layer drawn once into a small picture that the window can show."""

from __future__ import annotations

from typing import Any

from engine.core.errors import LucarnaError
from engine.core.paths import shaders_dir
from engine.gpu.types import Bindings, ColorAttachment, RasterState, RenderPipelineDesc, SamplerDesc, TextureDesc

SIZE = 96
#: the least recently made go when there are more
LIMIT = 256
_UNIT = 10


def kind_of(format: str) -> int:
    """How the shader shows a format: 1 encoded colour, 2 a normal's two components, 3 one channel, 0 as it is."""
    if format.endswith("-srgb"):
        return 1
    if format in {"bc5", "rg8", "rg16f"}:
        return 2
    return 3 if format in {"bc4", "r8", "r16f", "r32f"} else 0


class Thumbnails:
    """Made on demand, inside a device frame. `forget` when the textures go."""

    def __init__(self) -> None:
        self._made: dict[tuple[int, int], Any] = {}

    def get(self, device: Any, texture: Any, layer: int) -> int:
        """The native id of a SIZE x SIZE picture of `layer` of a 2D array; 0 where there can be none."""
        key = (int(texture.native), layer)
        if key[0] == 0 or texture.desc.kind != "2d-array":
            return 0
        if key not in self._made:
            try:
                self._made[key] = self._draw(device, texture, layer)
            except LucarnaError:
                self._made[key] = None  # a picture less; the texture itself was reported when it was loaded
            while len(self._made) > LIMIT:
                _release(self._made.pop(next(iter(self._made))))
        made = self._made[key]
        return 0 if made is None else int(made.native)

    def forget(self) -> None:
        for made in self._made.values():
            _release(made)
        self._made.clear()

    def _draw(self, device: Any, texture: Any, layer: int) -> Any:
        from engine.gpu.preprocess import flatten

        root = shaders_dir()
        defines = {"THUMBNAIL_SIZE": SIZE, "LAYER": layer, "KIND": kind_of(texture.desc.format)}
        pipeline = device.render_pipeline(
            RenderPipelineDesc(
                "thumbnail",
                flatten(root / "passes/fullscreen.vert", "vertex", search=[root]),
                flatten(root / "editor/thumbnail.frag", "fragment", search=[root], defines=defines),
                depth=None,
                raster=RasterState("none"),
            )
        )
        target = device.texture(TextureDesc("rgba8", SIZE, SIZE, label="thumbnail"))
        sampler = device.sampler(SamplerDesc("clamp", "clamp"))
        with device.render_pass("thumbnail", [ColorAttachment(target, clear=(0.0, 0.0, 0.0, 1.0))]) as render_pass:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bindings(Bindings(textures={_UNIT: (texture, sampler)}))
            render_pass.draw(3)
        return target


def _release(made: Any) -> None:
    if made is not None:
        made.release()
