"""Small glTF files made by tests: arrays in, a JSON tree and its binary out."""

from __future__ import annotations

import base64
import json
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

_COMPONENT = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
_TYPE = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class GltfBuilder:
    """Collects accessors in one buffer; `root` is the JSON tree, free to be bent by a test."""

    def __init__(self) -> None:
        self.root: dict[str, Any] = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [], "accessors": [], "bufferViews": [], "buffers": [],
        }  # fmt: skip
        self.binary = bytearray()

    def view(self, data: bytes, **extra: Any) -> int:
        """Append bytes as a buffer view, 4-byte aligned."""
        self.binary += bytes(-len(self.binary) % 4)
        self.root["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)} | extra
        )  # fmt: skip
        self.binary += data
        return len(self.root["bufferViews"]) - 1

    def accessor(self, values: ArrayLike, dtype: str = "f4", **extra: Any) -> int:
        """Append an array [n] or [n, c] as an accessor with its own view."""
        array: NDArray[Any] = np.asarray(values, f"<{dtype}")
        array = array.reshape(len(array), -1)
        self.root["accessors"].append(
            {
                "bufferView": self.view(array.tobytes()), "componentType": _COMPONENT[dtype], "count": len(array),
                "type": _TYPE[array.shape[1]],
            }
            | extra
        )  # fmt: skip
        return len(self.root["accessors"]) - 1

    def mesh(self, *primitives: dict[str, Any], **extra: Any) -> int:
        self.root["meshes"].append({"primitives": list(primitives)} | extra)
        return len(self.root["meshes"]) - 1

    def material(self, **fields: Any) -> int:
        self.root.setdefault("materials", []).append(fields)
        return len(self.root["materials"]) - 1

    def texture(self, image: dict[str, Any] | bytes) -> int:
        """A texture of an image object, or of PNG bytes put into the buffer."""
        if isinstance(image, bytes):
            image = {"bufferView": self.view(image), "mimeType": "image/png"}
        self.root.setdefault("images", []).append(image)
        self.root.setdefault("textures", []).append({"source": len(self.root["images"]) - 1})
        return len(self.root["textures"]) - 1

    def glb(self) -> bytes:
        self.root["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.root).encode()
        text += b" " * (-len(text) % 4)
        binary = bytes(self.binary) + bytes(-len(self.binary) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def write_glb(self, path: Path) -> Path:
        path.write_bytes(self.glb())
        return path

    def write_gltf(self, path: Path, uri: str | None = None) -> Path:
        """A .gltf with its buffer inside, or in the file `uri` beside it."""
        body = bytes(self.binary)
        embedded = "data:application/octet-stream;base64," + base64.b64encode(body).decode()
        self.root["buffers"] = [{"byteLength": len(body), "uri": uri or embedded}]
        if uri is not None:
            (path.parent / uri).write_bytes(body)
        path.write_text(json.dumps(self.root), encoding="utf-8")
        return path


def triangle(positions: Sequence[Sequence[float]] = ((0, 0, 0), (1, 0, 0), (0, 1, 0))) -> GltfBuilder:
    """One triangle with normals and uv, one node, one scene."""
    b = GltfBuilder()
    attributes = {
        "POSITION": b.accessor(positions),
        "NORMAL": b.accessor([[0, 0, 1]] * len(positions)),
        "TEXCOORD_0": b.accessor([[p[0], 1 - p[1]] for p in positions]),
    }
    b.mesh({"attributes": attributes, "indices": b.accessor(range(len(positions)), "u2")})
    return b


def textured_triangle(png_bytes: bytes | None = None) -> GltfBuilder:
    """The triangle with a base colour and a normal map, so that tangents are made."""
    b = triangle()
    color = b.texture(png_bytes or png(4, 4))
    normal = b.texture(png(4, 4, (128, 128, 255)))
    b.material(
        name="paint", pbrMetallicRoughness={"baseColorTexture": {"index": color}}, normalTexture={"index": normal}
    )
    b.root["meshes"][0]["primitives"][0]["material"] = 0
    return b


def png(width: int, height: int, color: tuple[int, int, int] = (200, 100, 50)) -> bytes:
    """A plain RGB PNG of one colour."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    row = b"\0" + bytes(color) * width
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = zlib.compress(row * height)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", body) + chunk(b"IEND", b"")
