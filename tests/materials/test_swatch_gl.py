"""The generated GLSL on a real compiler: MaterialParams and numpy agree on every field, layers and uv are right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.assets.material import MaterialAsset, TextureRef
from engine.core.errors import ShaderError
from engine.core.paths import shaders_dir
from engine.gpu.types import Bindings, ColorAttachment, Device, SamplerDesc, TextureDesc, VertexAttribute
from engine.materials.library import EffectLibrary
from engine.materials.table import MaterialTable, resolve_features

DATA = Path(__file__).parent / "data"
ATTRIBUTES = (VertexAttribute(0, "position", "f4x3"), VertexAttribute(3, "uv0", "f4x2"))
MESH = ("position", "normal", "uv0", "uv1")

#: one triangle over the whole target; uv (0.25, 0.25) everywhere
POSITIONS = np.array([[-1, -1, 0.5], [3, -1, 0.5], [-1, 3, 0.5]], np.float32)
UVS = np.full((3, 2), 0.25, np.float32)

#: texels of the two layers, [layer, row, column]
TEXELS = np.zeros((2, 2, 2, 4), np.float32)
TEXELS[1] = [[[0.5, 0.25, 0.125, 1], [1, 2, 3, 1]], [[4, 5, 6, 1], [7, 8, 9, 1]]]


def draw(device: Device, material: MaterialAsset) -> NDArray[np.float32]:
    """The colour that `material` (in row 1, reading layer 1) gives."""
    effects = EffectLibrary([DATA, shaders_dir()])
    effect = effects.get("swatch")
    table = MaterialTable(effect)
    table.add(MaterialAsset("other", params={"gain": 0.0}), {})
    table.add(material, {"base_map": 1})
    features = resolve_features(effect, material, MESH)
    pipeline = effects.pipeline(device, effect, "forward", features, ATTRIBUTES, cull="none", depth_compare="always")
    array = device.texture(TextureDesc("rgba32f", 2, 2, "2d-array", layers=2))
    for layer in range(2):
        array.write(TEXELS[layer], layer=layer)
    sampler = device.sampler(SamplerDesc(min_filter="nearest", mag_filter="nearest"))
    target = device.texture(TextureDesc("rgba32f", 4, 4))
    positions, uvs = device.buffer(POSITIONS), device.buffer(UVS)
    rows = device.buffer(table.rows.tobytes())
    with device.render_pass("swatch", [ColorAttachment(target, clear=(0.0, 0.0, 0.0, 0.0))]) as render_pass:
        render_pass.set_pipeline(pipeline)
        render_pass.set_vertex_buffers({"position": positions, "uv0": uvs})
        render_pass.set_bindings(Bindings(storage={2: rows}, textures={0: (array, sampler), 1: (array, sampler)}))
        render_pass.draw(3)
    color: NDArray[np.float32] = target.read()[1, 2].astype(np.float32)
    for item in (array, target, positions, uvs, rows):
        item.release()
    effects.release()
    return color


@pytest.mark.gl
def test_every_field_arrives(gl_device: Device) -> None:
    material = MaterialAsset("m", params={"gain": 2.0, "tint": [0.5, 0.25, 1.0], "flip": True, "shift": [3.0, 7.0]})
    np.testing.assert_array_equal(draw(gl_device, material), [2.0, 0.5, 1.0, 7.0])


@pytest.mark.gl
def test_the_layer_and_the_enum(gl_device: Device) -> None:
    base = {"base_map": TextureRef("a")}
    multiplied = MaterialAsset("m", params={"tint": [2.0, 2.0, 2.0]}, textures=base)
    np.testing.assert_array_equal(draw(gl_device, multiplied), [1.0, 0.5, 0.25, 0.0])
    added = MaterialAsset("m", params={"tint": [2.0, 2.0, 2.0], "mode": "add"}, textures=base)
    np.testing.assert_array_equal(draw(gl_device, added), [2.5, 2.25, 2.125, 0.0])


@pytest.mark.gl
def test_uv_transform_picks_the_texel(gl_device: Device) -> None:
    moved = MaterialAsset("m", textures={"base_map": TextureRef("a", offset=(0.5, 0.0))})
    np.testing.assert_array_equal(draw(gl_device, moved), [1.0, 2.0, 3.0, 0.0])
    scaled = MaterialAsset("m", textures={"base_map": TextureRef("a", scale=(1.0, 3.0))})
    np.testing.assert_array_equal(draw(gl_device, scaled), [4.0, 5.0, 6.0, 0.0])


@pytest.mark.gl
def test_the_second_uv_set(gl_device: Device) -> None:
    # the test shader gives uv0 + 10 as uv1: repeated, that is the same texel; scaled by 0.05 it is not
    second = TextureRef("a", uv_set=1, scale=(0.05, 0.075))
    np.testing.assert_array_equal(
        draw(gl_device, MaterialAsset("m", textures={"base_map": second})), [7.0, 8.0, 9.0, 0.0]
    )


@pytest.mark.gl
def test_an_error_names_file_and_line_and_magenta_compiles(gl_device: Device, tmp_path: Path) -> None:
    for name in ("swatch.effect.toml", "swatch.vert", "swatch.frag"):
        text = (DATA / "effects" / name).read_text(encoding="utf-8")
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / "effects").mkdir(exist_ok=True)
        (tmp_path / "effects" / name).write_text(text.replace("m.gain", "m.gian"), encoding="utf-8")
    effects = EffectLibrary([tmp_path, DATA, shaders_dir()])
    with pytest.raises(ShaderError, match=r"swatch\.frag:14:"):
        effects.pipeline(gl_device, "swatch", "forward", frozenset(), ATTRIBUTES)
    pipeline, error = effects.pipeline_or_magenta(gl_device, "swatch", "forward", frozenset(), ATTRIBUTES)
    assert error is not None
    assert pipeline is not None
    effects.release()
