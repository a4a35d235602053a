from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.assets.texture import FORMATS
from engine.core.errors import DeviceError, UsageError
from engine.gpu import formats
from engine.gpu.types import TARGET_FORMATS, Bindings, SamplerDesc, TextureDesc

UNPACKED = [
    "r8",
    "rg8",
    "rgba8",
    "rgba8-srgb",
    "r16f",
    "rg16f",
    "rgba16f",
    "r32f",
    "rg32f",
    "rgba32f",
    "r32ui",
    "rg32ui",
    "d32f",
]
KINDS: list[dict[str, Any]] = [
    {"kind": "2d"}, {"kind": "2d-array", "layers": 3}, {"kind": "2d-array", "layers": 1}, {"kind": "cube", "layers": 6},
    {"kind": "cube", "layers": 12}, {"kind": "3d", "depth": 4},
]  # fmt: skip


def some_image(desc: TextureDesc, level: int, seed: int) -> np.ndarray:
    dtype, shape = formats.read_shape(desc, level)
    rng = np.random.default_rng(seed)
    if np.dtype(dtype).kind == "u":
        return rng.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)
    return rng.random(shape).astype(dtype)


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: f"{k['kind']}{k.get('layers', '')}")
@pytest.mark.parametrize("format", UNPACKED)
def test_every_image_comes_back_as_it_went(bench: Any, format: str, kind: dict[str, Any]) -> None:
    if format == "d32f" and kind["kind"] == "3d":
        with pytest.raises(UsageError, match="3d"):
            bench.texture(format, 8, 8, **kind)
        return
    texture = bench.texture(format, 8, 8, mips=3, **kind)
    count = [4, 2, 1] if kind["kind"] == "3d" else [texture.desc.layers] * 3
    images = {}
    for level in range(3):
        for layer in range(count[level]):
            images[level, layer] = some_image(texture.desc, level, 10 * level + layer)
            texture.write(images[level, layer], level=level, layer=layer)
    for (level, layer), image in images.items():
        got = texture.read(level=level, layer=layer)
        assert got.dtype == image.dtype
        np.testing.assert_array_equal(got, image)


def test_all_formats_are_covered() -> None:
    assert set(UNPACKED) | {"rg11b10f", "rgb10a2", "d32f-s8"} == {
        f for f in (*FORMATS, *TARGET_FORMATS) if f in formats.READ_AS and f not in formats.COMPRESSED
    }
    assert set(formats.BLOCKS) == set(FORMATS) | set(TARGET_FORMATS)


def test_packed_formats(bench: Any) -> None:
    texture = bench.texture("rgb10a2", 1, 1)
    texture.write(np.uint32([1023 | 512 << 10 | 0 << 20 | 3 << 30]))
    np.testing.assert_allclose(texture.read()[0, 0], [1.0, 512 / 1023, 0.0, 1.0], atol=1e-6)
    texture = bench.texture("rg11b10f", 1, 1)
    texture.write(np.uint32([0x3C0 | (0x400 << 11) | (0x1C0 << 22)]))  # 1.0, 2.0 (5-bit exponent 16), 0.5
    np.testing.assert_array_equal(texture.read()[0, 0], [1.0, 2.0, 0.5])


def test_odd_sizes_are_tightly_packed(bench: Any) -> None:
    texture = bench.texture("rg8", 5, 3, mips=2)
    image = np.arange(30, dtype=np.uint8).reshape(3, 5, 2)
    texture.write(image.tobytes())
    texture.write(memoryview(bytes([1, 2, 3, 4])), level=1)
    np.testing.assert_array_equal(texture.read(), image)
    np.testing.assert_array_equal(texture.read(level=1), [[[1, 2], [3, 4]]])


def test_srgb_decodes_when_sampled_and_stores_what_shaders_write(bench: Any) -> None:
    texture = bench.texture("rgba8-srgb", 1, 1)
    texture.write(bytes([188, 188, 188, 128]))
    bindings = Bindings(textures={0: (texture, bench.nearest())})
    fetch = "layout(binding = 0) uniform sampler2D t; void main() { color = texelFetch(t, ivec2(0), 0); }"
    linear = ((188 / 255 + 0.055) / 1.055) ** 2.4
    np.testing.assert_allclose(bench.shade(fetch, 1, 1, bindings=bindings)[0, 0], [linear] * 3 + [128 / 255], atol=1e-3)
    target = bench.texture("rgba8-srgb", 1, 1)
    assert bench.shade("void main() { color = vec4(0.5); }", into=target)[0, 0, 0] in (127, 128)


# known solid blocks, by the format definitions (Khronos Data Format Specification 1.3, chapters 18 to 20)
BC1_RED = bytes([0x00, 0xF8, 0x00, 0xF8, 0, 0, 0, 0])
BC3_RED_HALF = bytes([128, 128, 0, 0, 0, 0, 0, 0]) + BC1_RED
BC4_200 = bytes([200, 200, 0, 0, 0, 0, 0, 0])
BC5_200_50 = BC4_200 + bytes([50, 50, 0, 0, 0, 0, 0, 0])


def bc7_mode5(red: int, green: int, blue: int, alpha: int) -> bytes:
    """A solid block: mode 5 (bit 5 set), rotation 0, equal 7-bit endpoints, 8-bit alpha endpoints, all indices 0."""
    bits, at = 1 << 5, 8
    for value in (red >> 1, red >> 1, green >> 1, green >> 1, blue >> 1, blue >> 1):
        bits |= value << at
        at += 7
    bits |= alpha << at | alpha << at + 8
    return bits.to_bytes(16, "little")


def bc6h_mode11(half_bits: int) -> bytes:
    """A solid grey block: mode 11 (10-bit endpoints, one region)."""
    bits, at = 0b00011, 5
    for _ in range(6):
        bits |= half_bits << at
        at += 10
    return bits.to_bytes(16, "little")


@pytest.mark.parametrize(
    ("format", "block", "expected", "tolerance"),
    [
        ("bc1", BC1_RED, [1, 0, 0, 1], 0.005),
        ("bc1-srgb", BC1_RED, [1, 0, 0, 1], 0.005),
        ("bc3", BC3_RED_HALF, [1, 0, 0, 128 / 255], 0.005),
        ("bc3-srgb", BC3_RED_HALF, [1, 0, 0, 128 / 255], 0.005),
        ("bc4", BC4_200, [200 / 255, 0, 0, 1], 0.005),
        ("bc5", BC5_200_50, [200 / 255, 50 / 255, 0, 1], 0.005),
        ("bc7", bc7_mode5(255, 101, 0, 77), [1, 101 / 255, 0, 77 / 255], 0.005),
        ("bc7-srgb", bc7_mode5(189, 189, 189, 255), [((189 / 255 + 0.055) / 1.055) ** 2.4] * 3 + [1], 0.005),
        ("bc6h", bc6h_mode11(0x1EF), None, 0.0),
    ],
)
@pytest.mark.parametrize("kind", [{"kind": "2d"}, {"kind": "2d-array", "layers": 2}], ids=["2d", "array"])
def test_blocks_are_sampled(
    bench: Any, format: str, block: bytes, expected: list[float] | None, tolerance: float, kind: dict[str, Any]
) -> None:
    texture = bench.texture(format, 6, 4, mips=2, **kind)  # 6: blocks reach over the edge
    last = texture.desc.layers - 1
    texture.write(block * 2, layer=last)
    texture.write(block, level=1, layer=last)
    sampler = "sampler2DArray" if last else "sampler2D"
    at = "ivec3(ivec2({0}), 1)" if last else "ivec2({0})"
    text = f"""layout(binding = 0) uniform {sampler} t;
        void main() {{ color = gl_FragCoord.x < 6.0 ? texelFetch(t, {at.format("gl_FragCoord.xy")}, 0)
                                                    : texelFetch(t, {at.format("0")}, 1); }}"""
    seen = bench.shade(text, 7, 4, bindings=Bindings(textures={0: (texture, bench.nearest())}))
    if expected is None:  # unquantise(0x1EF) = ((0x1EF << 16) + 0x8000) >> 10, then * 31 >> 6 gives the half's bits
        half = np.uint16((((0x1EF << 16) + 0x8000) >> 10) * 31 >> 6).view(np.float16)
        expected = [float(half)] * 3 + [1.0]
    np.testing.assert_allclose(seen.reshape(-1, 4), np.tile(expected, (28, 1)), atol=tolerance)
    decoded = texture.read(layer=last)
    scale = 1.0 if decoded.dtype == np.float16 else 255.0
    if not format.endswith("-srgb"):  # those come as stored, not linearised
        channels = decoded.shape[-1]
        np.testing.assert_allclose(decoded[0, 0] / scale, expected[:channels], atol=max(tolerance, 1e-3))


def test_block_cube(bench: Any) -> None:
    cube = bench.texture("bc1", 4, 4, kind="cube", layers=6)
    for face in range(6):
        cube.write(BC1_RED if face == 3 else bytes([0x1F, 0, 0x1F, 0, 0, 0, 0, 0]), layer=face)
    text = "layout(binding = 0) uniform samplerCube t; void main() { color = texture(t, vec3(0.1, %s1.0, 0.1)); }"
    bindings = Bindings(textures={0: (cube, bench.nearest())})
    np.testing.assert_allclose(bench.shade(text % "-", bindings=bindings)[0, 0], [1, 0, 0, 1], atol=0.01)
    np.testing.assert_allclose(bench.shade(text % "+", bindings=bindings)[0, 0], [0, 0, 1, 1], atol=0.01)


def test_generate_mips(bench: Any) -> None:
    texture = bench.texture("rgba32f", 4, 4, mips=3, kind="2d-array", layers=2)
    for layer in range(2):
        texture.write(np.arange(64, dtype=np.float32) + 100 * layer, layer=layer)
    bench.device.generate_mips(texture)
    image = np.arange(64, dtype=np.float32).reshape(4, 4, 4)
    np.testing.assert_allclose(texture.read(level=1), image.reshape(2, 2, 2, 2, 4).mean((1, 3)), rtol=1e-6)
    np.testing.assert_allclose(texture.read(level=2, layer=1)[0, 0], image.mean((0, 1)) + 100, rtol=1e-6)
    with pytest.raises(UsageError, match="cannot be generated"):
        bench.device.generate_mips(bench.texture("bc7", 4, 4, mips=2))


@pytest.mark.parametrize("format", ["rgba16f", "d32f"])
def test_copy_texture(bench: Any, format: str) -> None:
    source = bench.texture(format, 4, 4, mips=3, kind="2d-array", layers=2)
    target = bench.texture(format, 4, 4, mips=3, kind="2d-array", layers=3)
    for layer in range(2):
        for level in range(3):
            source.write(some_image(source.desc, level, layer), level=level, layer=layer)
            target.write(np.zeros_like(some_image(source.desc, level, 0)), level=level, layer=layer)
    bench.device.copy_texture(source, target, 2)
    for layer in range(2):
        for level in range(3):
            np.testing.assert_array_equal(target.read(level=level, layer=layer), some_image(source.desc, level, layer))
    with pytest.raises(UsageError, match="3 layers of 2"):
        bench.device.copy_texture(source, target, 3)
    with pytest.raises(UsageError, match="equal format"):
        bench.device.copy_texture(source, bench.texture("r8", 4, 4, mips=3, kind="2d-array", layers=2), 1)


def test_copy_of_blocks_and_cubes(bench: Any) -> None:
    source = bench.texture("bc1", 4, 4, mips=3, kind="cube", layers=6)
    target = bench.texture("bc1", 4, 4, mips=3, kind="cube", layers=6)
    for level in range(3):
        for face in range(6):
            source.write(BC1_RED, level=level, layer=face)
    bench.device.copy_texture(source, target, 6)
    text = "layout(binding = 0) uniform samplerCube t; void main() { color = textureLod(t, vec3(0, 0, -1), 2.0); }"
    seen = bench.shade(text, bindings=Bindings(textures={0: (target, bench.device.sampler(SamplerDesc()))}))
    np.testing.assert_allclose(seen[0, 0], [1, 0, 0, 1], atol=0.01)


@pytest.mark.parametrize(
    ("desc", "says"),
    [
        (TextureDesc("rgba9", 4, 4), "'rgba9' is not one of"),
        (TextureDesc("rgba8", 4, 4, kind="4d"), "'4d' is not one of"),
        (TextureDesc("rgba8", 0, 4), "at least 1"),
        (TextureDesc("rgba8", 4, 4, mips=4), "at most 3"),
        (TextureDesc("rgba8", 4, 4, layers=2), "2d-array"),
        (TextureDesc("rgba8", 4, 8, kind="cube", layers=6), "square"),
        (TextureDesc("rgba8", 4, 4, kind="cube", layers=5), "6 layers"),
        (TextureDesc("rgba8", 4, 4, depth=2), "only 3d"),
        (TextureDesc("rgba8", 4, 4, kind="2d-array", layers=2, samples=4), "multisampled"),
    ],
)
def test_wrong_descriptors(bench: Any, desc: TextureDesc, says: str) -> None:
    with pytest.raises(UsageError, match=says):
        bench.device.texture(desc)


def test_too_large_for_the_device(bench: Any) -> None:
    with pytest.raises(DeviceError, match="more than this device"):
        bench.device.texture(TextureDesc("r8", 1 << 20, 4))


def test_wrong_images(bench: Any) -> None:
    texture = bench.texture("rgba8", 4, 4, mips=2, label="albedo")
    with pytest.raises(UsageError, match="'albedo': level 1 is 2x2 rgba8 = 16 bytes, got 64"):
        texture.write(bytes(64), level=1)
    with pytest.raises(UsageError, match="level 2, layer 0 does not exist"):
        texture.write(bytes(4), level=2)
    with pytest.raises(UsageError, match="does not exist"):
        texture.read(layer=1)
    with pytest.raises(UsageError, match="not C-contiguous"):
        texture.write(np.zeros((4, 4, 4), np.uint8).transpose(1, 0, 2)[::-1])


@pytest.mark.parametrize(("wrap", "at", "expected"), [("repeat", 1.25, 0), ("mirror", 1.25, 1), ("clamp", -3.0, 0)])
def test_wraps(bench: Any, wrap: str, at: float, expected: int) -> None:
    texture = bench.texture("r8", 2, 1)
    texture.write(bytes([0, 255]))
    sampler = bench.device.sampler(SamplerDesc(wrap, wrap, wrap, "nearest", "nearest"))
    text = f"layout(binding = 0) uniform sampler2D t; void main() {{ color = textureLod(t, vec2({at}, 0.5), 0.0); }}"
    assert bench.shade(text, 1, 1, bindings=Bindings(textures={0: (texture, sampler)}))[0, 0, 0] == expected


def test_samplers_are_shared_filter_and_compare(bench: Any) -> None:
    device = bench.device
    desc = SamplerDesc("clamp", "clamp", min_filter="linear", anisotropy=4.0)
    assert device.sampler(desc) is device.sampler(SamplerDesc("clamp", "clamp", min_filter="linear", anisotropy=4.0))
    texture = bench.texture("r32f", 2, 1)
    texture.write(np.float32([0, 1]))
    text = "layout(binding = 3) uniform sampler2D t; void main() { color = textureLod(t, vec2(0.5), 0.0); }"
    seen = bench.shade(text, 1, 1, bindings=Bindings(textures={3: (texture, device.sampler(desc))}))
    assert seen[0, 0, 0] == pytest.approx(0.5)
    shadow = bench.texture("d32f", 1, 1, kind="2d-array", layers=2)
    shadow.write(np.float32([0.5]), layer=1)
    compare = device.sampler(SamplerDesc("clamp", "clamp", "clamp", "nearest", "nearest", compare="lequal"))
    text = """layout(binding = 0) uniform sampler2DArrayShadow t;
        void main() { color = vec4(texture(t, vec4(0.5, 0.5, 1, 0.4)), texture(t, vec4(0.5, 0.5, 1, 0.6)), 0, 1); }"""
    seen = bench.shade(text, 1, 1, bindings=Bindings(textures={0: (shadow, compare)}))
    assert seen[0, 0, :2].tolist() == [1.0, 0.0]
    with pytest.raises(UsageError, match="sampler wrap"):
        device.sampler(SamplerDesc("wrap"))
