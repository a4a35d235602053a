"""Compressed glTF: meshopt streams (vectors made by the reference encoder), Draco, KTX2 images; whole and damaged."""

from __future__ import annotations

import base64
import hashlib
import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.core.errors import FormatError
from importers.gltf import draco
from importers.gltf.meshopt import decode
from importers.gltf.meshopt_attributes import Damaged
from importers.gltf.reader import load
from importers.settings import ImportSettings
from importers.textures import ktx2
from importers.textures.image import decode as decode_image
from tests.support.gltf_builder import GltfBuilder, textured_triangle, triangle

SETTINGS = ImportSettings()
VECTORS: list[dict[str, Any]] = json.loads((Path(__file__).parent / "data" / "meshopt_vectors.json").read_text())
#: 8x4 texels: left half (200, 60, 30), right half (40, 160, 220)
ETC1S = base64.b64decode(
    "q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAABAAAAAAAAAAAAAAAAQAAAAEAAAABAAAAaAAAACwAAACUAAAAJAAAALgAAAAAAAAAhQAAAAAAAAA9AQAAAAAAAAEA"
    "AAAAAAAAAAAAAAAAAAAsAAAAAAAAAAIAKACjAQIAAwMAAAgAAAAAAAAAAAA/AAAAAAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIu"
    "NTAAAAIAAQAtAAAABQAAACsAAAAAAAAAAAAAAAAAAAABAAAAAAAAAAAAAAAVwEQAAAAAAAAyoQKYAQAAAAAAgmCbWwBmAAAAAAAAkIcATAEQAAAAACBZ0AFU"
    "VVVVBQDBRAAAAAAAAPJfTQCYABAAAAAAQBQAJgAEAAAAABADgAkAAAAAAAAEEAAA"
)
UASTC = base64.b64decode(
    "q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAABAAAAAAAAAAAAAAAAQAAAAEAAAACAAAAaAAAACwAAACUAAAAJAAAAAAAAAAAAAAAAAAAAAAAAAC4AAAAAAAAACkA"
    "AAAAAAAAIAAAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AAAAAAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIu"
    "NTAAACi1L/0gIAEBABeZx+N/yogAAAAAAAAAAAAXBZT7fyRTAwAAAAAAAAAA"
)


@pytest.mark.parametrize("vector", VECTORS, ids=lambda v: f"{v['name']} {v['filter']}")
def test_meshopt_vectors(vector: dict[str, Any]) -> None:
    data = base64.b64decode(vector["data"])
    words = vector["count"], vector["stride"], vector["mode"], vector["filter"]
    assert hashlib.sha256(decode(data, *words).tobytes()).hexdigest()[:16] == vector["sha256"]
    rng = np.random.default_rng(len(data))
    for cut in rng.integers(0, len(data), 8):
        with pytest.raises((Damaged, IndexError)):
            decode(data[:cut], *words)
    for _ in range(20):  # whatever comes out, nothing but our errors goes up
        bent = bytearray(data)
        bent[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
        try:
            assert len(decode(bytes(bent), *words)) == vector["count"] * vector["stride"]
        except (Damaged, IndexError):
            continue


@pytest.mark.parametrize(
    "words", [(4, 5, "ATTRIBUTES"), (3, 4, "OTHER"), (4, 4, "TRIANGLES"), (3, 8, "INDICES"), (3, 4, "ATTRIBUTES", "X")]
)
def test_meshopt_refusals(words: tuple[Any, ...]) -> None:
    with pytest.raises(Damaged):
        decode(b"\xa0" + bytes(64), *words)


def packed_triangle(vector_name: str, name: str = "EXT_meshopt_compression") -> GltfBuilder:
    """A strip of triangles whose indices are one of the vectors; its vertices are plain."""
    vector = next(v for v in VECTORS if v["name"] == vector_name)
    b = GltfBuilder()
    count = vector["count"]
    stream = b.view(base64.b64decode(vector["data"]))
    source = b.root["bufferViews"][stream]
    packed = {k: source[k] for k in ("buffer", "byteOffset", "byteLength")}
    packed |= {"byteStride": vector["stride"], "count": count, "mode": vector["mode"]}
    b.root["bufferViews"].append(
        {"buffer": 1, "byteLength": count * vector["stride"], "extensions": {name: packed}}
    )  # fmt: skip
    b.root["accessors"].append(
        {"bufferView": len(b.root["bufferViews"]) - 1, "componentType": 5123, "count": count, "type": "SCALAR"}
    )
    indices = len(b.root["accessors"]) - 1
    rng = np.random.default_rng(1)
    b.mesh({"attributes": {"POSITION": b.accessor(rng.random((36, 3)))}, "indices": indices})
    b.root["extensionsRequired"] = b.root["extensionsUsed"] = [name]
    return b


def test_meshopt_in_a_file(tmp_path: Path) -> None:
    b = packed_triangle("tri 2")
    model = load(b.write_glb(tmp_path / "t.glb"), SETTINGS)
    assert not model.findings.has_errors
    vector = next(v for v in VECTORS if v["name"] == "tri 2")
    wanted = decode(base64.b64decode(vector["data"]), vector["count"], 2, "TRIANGLES").view("<u2").reshape(-1, 3)
    a, c, d = wanted.T
    assert len(model.meshes[0].indices) == 3 * int(((a != c) & (c != d) & (d != a)).sum())
    b.root["bufferViews"][1]["extensions"]["EXT_meshopt_compression"]["byteLength"] -= 20
    broken = load(b.write_glb(tmp_path / "b.glb"), SETTINGS)
    assert any(f.code == "gltf.meshopt" and "damaged" in f.message for f in broken.findings)


def test_meshopt_counts_are_limited(tmp_path: Path) -> None:
    b = packed_triangle("tri 2")
    b.root["bufferViews"][1]["extensions"]["EXT_meshopt_compression"]["count"] = 1 << 30
    model = load(b.write_glb(tmp_path / "t.glb"), SETTINGS)
    assert any(f.code == "gltf.too-large" for f in model.findings)


def test_draco(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    DracoPy = pytest.importorskip("DracoPy")
    rng = np.random.default_rng(2)
    points, faces = rng.random((8, 3)).astype("f4"), np.array([[0, 1, 2], [3, 4, 5], [5, 6, 7]], np.uint32)
    uv = rng.random((8, 2))
    stream = DracoPy.encode(points, faces, quantization_bits=20, tex_coord=uv, preserve_order=True)
    b = GltfBuilder()
    decoded = DracoPy.decode(stream)
    ids = {a["attribute_type"]: a["unique_id"] for a in decoded.attributes}
    view = b.view(stream)
    kinds = (("VEC3", 5126), ("VEC2", 5126), ("SCALAR", 5125))
    b.root["accessors"] = [{"componentType": c, "count": 9 if t == "SCALAR" else 8, "type": t} for t, c in kinds]
    b.mesh({
        "attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2,
        "extensions": {draco.NAME: {"bufferView": view, "attributes": {"POSITION": ids[0], "TEXCOORD_0": ids[3]}}},
    })  # fmt: skip
    b.root["extensionsRequired"] = [draco.NAME]
    model = load(b.write_glb(tmp_path / "d.glb"), SETTINGS)
    assert not model.findings.has_errors
    got = model.meshes[0].streams["position"][model.meshes[0].indices]
    np.testing.assert_allclose(got, points[faces.reshape(-1)], atol=2e-6)
    np.testing.assert_allclose(
        model.meshes[0].streams["uv0"][model.meshes[0].indices], uv[faces.reshape(-1)], atol=1e-6
    )

    b.binary[5] ^= 255
    broken = load(b.write_glb(tmp_path / "e.glb"), SETTINGS)
    assert any(f.code == "gltf.draco" and "damaged" in f.message for f in broken.findings)
    monkeypatch.setattr(draco, "decoder", lambda: None)
    absent = load(b.write_glb(tmp_path / "f.glb"), SETTINGS)
    assert any("decoder is missing" in f.message and "lucarna[gltf]" in f.hint for f in absent.findings)


@pytest.mark.parametrize("data", [ETC1S, UASTC], ids=["etc1s", "uastc"])
def test_basis_images(data: bytes, tmp_path: Path) -> None:
    pytest.importorskip("opengl_basisu")
    pixels = decode_image(data, "k", SETTINGS)
    assert pixels.shape == (4, 8, 4)
    assert np.abs(pixels[:, :4].astype(int) - [200, 60, 30, 255]).max() <= 6
    assert np.abs(pixels[:, 4:].astype(int) - [40, 160, 220, 255]).max() <= 6
    for broken in (data[:90], data[:-30], data[:20] + b"\xff\xff\xff\xff" + data[24:]):
        with pytest.raises(FormatError):
            decode_image(broken, "k", SETTINGS)


def test_basis_in_a_file_and_without_the_transcoder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    b = textured_triangle()
    b.root["images"].append({"bufferView": b.view(UASTC), "mimeType": "image/ktx2"})
    b.root["textures"][0]["extensions"] = {"KHR_texture_basisu": {"source": 2}}
    path = b.write_glb(tmp_path / "t.glb")
    monkeypatch.setattr(ktx2, "can_transcode", lambda: True)
    assert load(path, SETTINGS).materials[0].images["base_color_map"].image == 2
    monkeypatch.setattr(ktx2, "can_transcode", lambda: False)
    fallen = load(path, SETTINGS)
    assert fallen.materials[0].images["base_color_map"].image == 0
    assert any("lucarna[gltf]" in f.hint for f in fallen.findings)


def ktx2_file(vk: int, width: int, height: int, images: list[bytes], scheme: int = 0, faces: int = 1) -> bytes:
    """A KTX2 file of one mip an image; scheme 3 packs it by zlib."""
    head = ktx2.MAGIC + struct.pack("<9I", vk, 1, width, height, 0, 0, faces, len(images), scheme) + bytes(32)
    at, index, body = 80 + 24 * len(images), b"", b""
    for image in images:
        stored = zlib.compress(image) if scheme == 3 else image
        index += struct.pack("<3Q", at + len(body), len(stored), len(image))
        body += stored
    return head + index + body


def test_plain_ktx2() -> None:
    rng = np.random.default_rng(0)
    rgba = rng.integers(0, 256, (6, 4, 4, 4), np.uint8)
    cube = ktx2.read_ktx2(ktx2_file(43, 4, 4, [rgba.tobytes()], faces=6), "c")
    assert (cube.format, cube.cube, cube.layers) == ("rgba8-srgb", True, 6)
    assert bytes(cube.levels[5][0]) == rgba[5].tobytes()
    packed = ktx2.read_ktx2(ktx2_file(145, 8, 8, [bytes(range(64)), bytes(16)], 3), "z")
    assert (packed.format, packed.mip_count, bytes(packed.levels[0][0])) == ("bc7", 2, bytes(range(64)))
    rgb = ktx2.read_ktx2(ktx2_file(23, 2, 1, [bytes([1, 2, 3, 4, 5, 6])]), "r")
    assert bytes(rgb.levels[0][0]) == bytes([1, 2, 3, 255, 4, 5, 6, 255])
    # 1.0, 0.5, 0.25 as three 9-bit mantissas under one exponent (16: mantissa / 256)
    shared = 256 | 128 << 9 | 64 << 18 | 16 << 27
    floats = ktx2.read_ktx2(ktx2_file(123, 1, 1, [struct.pack("<I", shared)]), "e")
    assert np.frombuffer(floats.levels[0][0], "<f2").tolist() == [1.0, 0.5, 0.25, 1.0]
    small = 15 << 6 | (14 << 6) << 11 | (13 << 5) << 22
    floats = ktx2.read_ktx2(ktx2_file(122, 1, 1, [struct.pack("<I", small)]), "b")
    assert np.frombuffer(floats.levels[0][0], "<f2").tolist() == [1.0, 0.5, 0.25, 1.0]


def test_zstd_ktx2() -> None:
    zstandard = pytest.importorskip("zstandard")
    data = bytearray(ktx2_file(37, 2, 2, [bytes(range(16))]))
    packed = zstandard.ZstdCompressor().compress(bytes(range(16)))
    data[44:48] = struct.pack("<I", 2)
    data[80:104] = struct.pack("<3Q", 104, len(packed), 16)
    assert bytes(ktx2.read_ktx2(bytes(data[:104]) + packed, "z").levels[0][0]) == bytes(range(16))
    with pytest.raises(FormatError):
        ktx2.read_ktx2(bytes(data[:104]) + packed[:-3], "z")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (ktx2.MAGIC + bytes(20), "cut off"),
        (ktx2_file(37, 0, 4, [b""]), "not possible"),
        (ktx2_file(37, 4, 4, [bytes(63)]), "bytes"),
        (ktx2_file(37, 60000, 60000, [bytes(16)]), "limit"),
        (ktx2_file(9999, 4, 4, [bytes(64)]), "VkFormat 9999"),
        (ktx2_file(37, 2, 2, [bytes(16)])[:-4], "beyond"),
        (ktx2_file(37, 2, 2, [bytes(99)], 3), "asks for"),
    ],
)
def test_damaged_ktx2(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        ktx2.read_ktx2(data, "k")


def test_unused_extension_changes_nothing(tmp_path: Path) -> None:
    b = triangle()
    b.root["extensionsRequired"] = ["KHR_meshopt_compression", "KHR_texture_basisu", draco.NAME]
    assert not load(b.write_glb(tmp_path / "t.glb"), SETTINGS).findings.has_errors
