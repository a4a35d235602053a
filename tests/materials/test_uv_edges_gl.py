"""Along the edges of triangles, a uv that depends on the material still chooses the right mip.

Pixels there share their 2x2 quad with helper invocations, which need not see the material's row.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.assets.material import MaterialAsset, TextureRef
from engine.core.paths import shaders_dir
from engine.gpu.types import Bindings, ColorAttachment, Device, SamplerDesc, TextureDesc, VertexAttribute
from engine.materials.library import EffectLibrary
from engine.materials.table import MaterialTable, resolve_features

DATA = Path(__file__).parent / "data"
ATTRIBUTES = (VertexAttribute(0, "position", "f4x3"), VertexAttribute(3, "uv0", "f4x2"))
SIZE, BLADES = 64, 48


def fan() -> tuple[np.ndarray, np.ndarray]:
    """Narrow triangles around the middle of the target, and their uv: half a texture over the whole target."""
    angle = np.linspace(0, 2 * np.pi, BLADES + 1)
    rim = np.stack([2 * np.cos(angle), 2 * np.sin(angle), np.full_like(angle, 0.5)], 1)
    middle = np.broadcast_to([0.0, 0.0, 0.5], (BLADES, 3))
    positions = np.stack([middle, rim[:-1], rim[1:]], 1).reshape(-1, 3).astype(np.float32)
    return positions, (positions[:, :2] * 0.25 + 0.5).astype(np.float32)


@pytest.mark.gl
@pytest.mark.parametrize(
    "reference",
    [TextureRef("a", uv_set=1), TextureRef("a", offset=(5.0, 3.0)), TextureRef("a", uv_set=1, rotation=1.0)],
    ids=["second set", "moved", "second set, turned"],
)
def test_every_pixel_has_the_finest_mip(gl_device: Device, reference: TextureRef) -> None:
    effects = EffectLibrary([DATA, shaders_dir()])
    effect = effects.get("swatch")
    table = MaterialTable(effect)
    table.add(MaterialAsset("other"), {})
    material = MaterialAsset("m", textures={"base_map": reference})
    table.add(material, {"base_map": 0})
    features = resolve_features(effect, material, ("position", "uv0", "uv1"))
    pipeline = effects.pipeline(gl_device, effect, "forward", features, ATTRIBUTES, cull="none", depth_compare="always")
    texture = gl_device.texture(TextureDesc("rgba32f", SIZE, SIZE, "2d-array", mips=7))
    for level in range(7):
        extent = SIZE >> level
        texture.write(np.full((extent, extent, 4), 1.0 if level == 0 else 0.0, np.float32), level=level)
    sampler = gl_device.sampler(SamplerDesc())
    target = gl_device.texture(TextureDesc("rgba32f", SIZE, SIZE))
    positions, uvs = (gl_device.buffer(values) for values in fan())
    rows = gl_device.buffer(table.rows.tobytes())
    with gl_device.render_pass("fan", [ColorAttachment(target, clear=(0.0, 0.0, 0.0, 0.0))]) as render_pass:
        render_pass.set_pipeline(pipeline)
        render_pass.set_vertex_buffers({"position": positions, "uv0": uvs})
        render_pass.set_bindings(Bindings(storage={2: rows}, textures={0: (texture, sampler), 1: (texture, sampler)}))
        render_pass.draw(3 * BLADES)
    red = target.read()[:, :, 0]
    for item in (texture, target, positions, uvs, rows):
        item.release()
    effects.release()
    assert np.count_nonzero(red < 0.999) == 0
