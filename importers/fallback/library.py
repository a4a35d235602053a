"""Assimp's shared library: found on the system, its version and its memory layout checked before anything is read.

Looked for: the file that LUCARNA_ASSIMP names, then what the system's loader finds as `assimp`, then usual places.
"""

from __future__ import annotations

import base64
import ctypes as c
import ctypes.util
import functools
import json
import os
import struct
import sys
from pathlib import Path

from engine.core.errors import FormatError, UsageError
from importers.fallback import structs
from importers.fallback.file_access import FileIO

VARIABLE = "LUCARNA_ASSIMP"
_PLACES = {
    "linux": ("/usr/lib/*/libassimp.so*", "/usr/lib64/libassimp.so*", "/usr/local/lib/libassimp.so*"),
    "darwin": ("/opt/homebrew/lib/libassimp*.dylib", "/usr/local/lib/libassimp*.dylib"),
    "win32": ("C:/Program Files/Assimp/bin/*/assimp*.dll", "C:/Program Files/Assimp/bin/assimp*.dll"),
}
HINT = (
    "install Assimp 5.1 to 6.0 (Debian and Ubuntu: apt install libassimp5; macOS: brew install assimp; Windows: its "
    f"installer, or set {VARIABLE} to the library's file)"
)


@functools.cache
def find_library() -> str:
    """The library's file or its name for the loader; empty where there is none. Raises UsageError (a bad variable)."""
    given = os.environ.get(VARIABLE, "")
    if given:
        if not Path(given).is_file():
            raise UsageError(f"{VARIABLE} names no file: {given!r}", hint="set it to Assimp's shared library")
        return given
    for pattern in _PLACES.get(sys.platform, ()):
        root = Path(Path(pattern).anchor)
        found = sorted(p for p in root.glob(str(Path(pattern).relative_to(root))) if p.is_file())
        if found:
            return str(found[-1].resolve())
    return ctypes.util.find_library("assimp") or ""


def available() -> bool:
    """Whether there is a library to try."""
    return bool(find_library())


def open_library(name: str) -> tuple[c.CDLL, tuple[int, int]]:
    """The library and its (major, minor), with its functions declared. Raises FormatError, as a worker reports it,
    where it cannot be used: a version whose structures we do not know, or one that fails the self-test."""
    try:
        library = c.CDLL(name)
        library.aiImportFileExWithProperties.restype = c.POINTER(structs.Scene)
    except (OSError, AttributeError) as error:
        raise FormatError(f"Assimp's library cannot be loaded: {error}", hint=HINT) from error
    library.aiImportFileExWithProperties.argtypes = [c.c_char_p, c.c_uint, c.POINTER(FileIO), c.c_void_p]
    library.aiCreatePropertyStore.restype = c.c_void_p
    library.aiSetImportPropertyInteger.argtypes = [c.c_void_p, c.c_char_p, c.c_int]
    library.aiSetImportPropertyInteger.restype = None
    library.aiImportFileFromMemory.restype = c.POINTER(structs.Scene)
    library.aiImportFileFromMemory.argtypes = [c.c_char_p, c.c_uint, c.c_uint, c.c_char_p]
    library.aiGetErrorString.restype = c.c_char_p
    version = int(library.aiGetVersionMajor()), int(library.aiGetVersionMinor())
    known = structs.OLDEST <= version <= structs.NEWEST
    if not known:
        raise FormatError(f"Assimp {version[0]}.{version[1]} is none that is known here", hint=HINT)
    wrong = [t.__name__ for t, size in structs.SIZES.items() if c.sizeof(t) != size]
    if wrong:
        raise FormatError(f"Assimp's structures {', '.join(wrong)} have another layout on this machine", hint=HINT)
    _self_test(library, version)
    return library, version


def _self_test(library: c.CDLL, version: tuple[int, int]) -> None:
    """Read a triangle with a bone and two turns whose numbers we know. Raises FormatError where others come back."""
    data = _probe()
    scene = library.aiImportFileFromMemory(data, len(data), 0, b"gltf")
    try:
        if not scene:
            raise ValueError(str(library.aiGetErrorString(), "utf-8", "replace"))
        mesh = scene.contents.meshes[0].contents
        corner = (c.c_float * 9).from_address(mesh.positions)
        bone = mesh.bones[0].contents
        vertex, weight = struct.unpack("<If", c.string_at(bone.weights, 8))
        channel = scene.contents.animations[0].contents.channels[0].contents
        step = structs.quat_key_size(version)
        time, w, x, y, z = struct.unpack("<d4f", c.string_at(channel.rotations + step, 24))
        seen = (
            mesh.vertex_count, mesh.face_count, list(corner), bone.name.text(), bone.weight_count, vertex,
            round(weight, 6), round(bone.offset[3], 6), channel.name.text(), channel.rotation_count, w, x, y, z,
        )  # fmt: skip
        wanted = (3, 1, _CORNERS, "joint", 3, 0, 1.0, -2.0, "joint", 2, 0.0, 0.0, 1.0, 0.0)
        if seen != wanted or not time > 0.0:
            raise ValueError(f"read {seen}")
    except (ValueError, IndexError) as error:
        text = f"Assimp {version[0]}.{version[1]} lays its data out as no version known here ({error})"
        raise FormatError(text[:400], hint=HINT) from error


_CORNERS = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]


def _probe() -> bytes:
    """A glTF file: one skinned triangle, one joint bound at x = 2, turned by 180 degrees about y at 1 s."""
    inverse = [1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -2, 0, 0, 1]
    blocks = [
        struct.pack("<9f", *_CORNERS), bytes(12), struct.pack("<12f", *([1.0, 0, 0, 0] * 3)),
        struct.pack("<16f", *inverse), struct.pack("<2f", 0, 1), struct.pack("<8f", 0, 0, 0, 1, 0, 1, 0, 0),
        struct.pack("<3H", 0, 1, 2) + bytes(2),
    ]  # fmt: skip
    kinds = [("VEC3", 5126, 3), ("VEC4", 5121, 3), ("VEC4", 5126, 3), ("MAT4", 5126, 1), ("SCALAR", 5126, 2),
             ("VEC4", 5126, 2), ("SCALAR", 5123, 3)]  # fmt: skip
    views, offset = [], 0
    for block in blocks:
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": len(block)})
        offset += len(block)
    accessors: list[dict[str, object]] = [
        {"bufferView": i, "type": kind, "componentType": part, "count": count}
        for i, (kind, part, count) in enumerate(kinds)
    ]
    accessors[0] |= {"min": [0, 0, 0], "max": [1, 1, 0]}
    text = base64.b64encode(b"".join(blocks)).decode()
    attributes = {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0, 1]}],
            "nodes": [{"name": "mesh", "mesh": 0, "skin": 0}, {"name": "joint"}],
            "meshes": [{"primitives": [{"attributes": attributes, "indices": 6}]}],
            "skins": [{"joints": [1], "inverseBindMatrices": 3}],
            "animations": [
                {
                    "name": "turn",
                    "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}],
                    "samplers": [{"input": 4, "output": 5}],
                }
            ],
            "buffers": [{"byteLength": offset, "uri": "data:application/octet-stream;base64," + text}],
            "bufferViews": views,
            "accessors": accessors,
        }
    ).encode()
