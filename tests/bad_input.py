"""Bad input as a table: each case makes a broken source, converts it by the CLI, and says what came of it.

`python -m tests.bad_input` prints the table as markdown; tests/importers/test_bad_input.py asserts every row.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import struct
import sys
import tempfile
import urllib.parse
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from importers.cli.main import main
from tests.support.gltf_builder import GltfBuilder, png, textured_triangle, triangle


@dataclass(frozen=True)
class Case:
    """`make` writes the source into a folder and returns it. The run must end with `code`, print `message` and
    `place` in one of its lines, and leave a scene behind or nothing at all."""

    name: str
    make: Callable[[Path], Path]
    code: int
    message: str
    place: str
    writes: bool = True
    options: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """What the CLI did: the exit code, all it printed, the line that `message` is in, and the files left."""

    code: int
    text: str
    line: str
    files: tuple[str, ...]


def run(case: Case, folder: Path) -> Outcome:
    """Convert the case's source into folder/out."""
    (folder / "source").mkdir()
    source = case.make(folder / "source")
    out = folder / "out"
    if case.name.startswith("output:"):
        out.write_text("a file in the way")
    printed, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors):
        code = main(["convert", str(source), "--out", str(out), *case.options])
    text = printed.getvalue() + errors.getvalue()
    lines = [line.strip() for line in text.splitlines() if case.message in line]
    files = tuple(sorted(p.name for p in folder.iterdir() if p.name not in ("source", "out")))
    if out.is_dir():
        files += tuple(sorted(str(p.relative_to(folder)) for p in out.rglob("*")))
    return Outcome(code, text, lines[0] if lines else "", files)


def _bent(change: Callable[[GltfBuilder], Any], start: Callable[[], GltfBuilder] = triangle) -> Callable[[Path], Path]:
    """A source whose builder was changed before it was written."""

    def make(folder: Path) -> Path:
        builder = start()
        change(builder)
        return builder.write_gltf(folder / "bad.gltf")

    return make


def _nodes(nodes: list[dict[str, Any]], roots: list[int]) -> Callable[[Path], Path]:
    def change(b: GltfBuilder) -> None:
        b.root["nodes"] = nodes
        b.root["scenes"] = [{"nodes": roots}]

    return _bent(change)


def _set(path: str, value: Any) -> Callable[[Path], Path]:
    """The triangle with `root[path] = value`; `path` like accessors.0.count."""

    def change(b: GltfBuilder) -> None:
        *way, last = [int(k) if k.isdigit() else k for k in path.split(".")]
        owner: Any = b.root
        for key in way:
            owner = owner[key]
        owner[last] = value

    return _bent(change)


def _cut(share: float) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        data = textured_triangle().glb()
        (folder / "bad.glb").write_bytes(data[: int(len(data) * share)])
        return folder / "bad.glb"

    return make


def _positions(values: list[list[float]]) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        return triangle(values).write_gltf(folder / "bad.gltf")

    return make


def _uri(uri: str) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        (folder.parent / "secret.bin").write_bytes(bytes(200))
        b = triangle()
        path = b.write_gltf(folder / "bad.gltf")
        b.root["buffers"][0]["uri"] = uri.replace("{secret}", str(folder.parent / "secret.bin"))
        path.write_text(json.dumps(b.root))
        return path

    return make


def _missing_bin(folder: Path) -> Path:
    path = triangle().write_gltf(folder / "bad.gltf", "bad.bin")
    (folder / "bad.bin").unlink()
    return path


def _pipe(folder: Path) -> Path:
    path = triangle().write_gltf(folder / "bad.gltf", "bad.bin")
    (folder / "bad.bin").unlink()
    os.mkfifo(folder / "bad.bin")
    return path


def _link(folder: Path) -> Path:
    (folder / "bad.glb").symlink_to("/dev/zero")
    return folder / "bad.glb"


def _folder(folder: Path) -> Path:
    (folder / "bad.glb").mkdir()
    return folder / "bad.glb"


def _missing_texture(b: GltfBuilder) -> None:
    b.root["images"][0] = {"uri": "skin.png"}


def _broken_texture(b: GltfBuilder) -> None:
    b.root["images"][0] = {"bufferView": b.view(png(4, 4)[:40]), "mimeType": "image/png"}


def _bomb_texture(b: GltfBuilder) -> None:
    header = struct.pack(">IIBBBBB", 100_000, 100_000, 8, 2, 0, 0, 0)
    data = bytearray(png(1, 1))
    data[16:33] = header + struct.pack(">I", zlib.crc32(b"IHDR" + header))
    b.root["images"][0] = {"bufferView": b.view(bytes(data)), "mimeType": "image/png"}


def _textured(width: int, height: int) -> Callable[[Path], Path]:
    return _bent(lambda b: None, lambda: textured_triangle(png(width, height)))


def _index_beyond(b: GltfBuilder) -> None:
    b.root["meshes"][0]["primitives"][0]["indices"] = b.accessor([0, 1, 60000], "u2")


def _no_meshes(b: GltfBuilder) -> None:
    b.root["nodes"], b.root["meshes"] = [{}], []


def _strip_attributes(b: GltfBuilder) -> None:
    attributes = b.root["meshes"][0]["primitives"][0]["attributes"]
    del attributes["NORMAL"], attributes["TEXCOORD_0"]


def _text(name: str, text: str | bytes) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        data = text.encode() if isinstance(text, str) else text
        (folder / name).write_bytes(data)
        return folder / name

    return make


def _chain(count: int) -> Callable[[Path], Path]:
    nodes: list[dict[str, Any]] = [{"children": [i + 1]} for i in range(count - 1)]
    return _nodes([*nodes, {"mesh": 0}], [0])


_FLAT = [1.0, 0, 0, 0, 2.0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
_DEEP = '{"asset":{"version":"2.0"},"extras":' + "[" * 100_000 + "]" * 100_000 + "}"

CASES = (
    Case("GLB cut in its header", _cut(0.01), 1, "within its header", "bad.glb", False),
    Case("GLB cut in its JSON", _cut(0.3), 1, "JSON chunk should have", "GLB chunk 0", False),
    Case("GLB cut in its binary", _cut(0.9), 1, "it is cut off", "GLB header"),
    Case("empty file", _text("bad.glb", b""), 1, "it is empty", "bad.glb", False),
    Case("not glTF", _text("bad.glb", b"\x89PNG not at all"), 1, "is no glTF: it starts with", "bad.glb", False),
    Case(
        "broken JSON",
        _text("bad.gltf", '{"asset": {"version": "2.0",}}'),
        1,
        "the JSON is broken",
        "bad.gltf:1:",
        False,
    ),
    Case("JSON 100,000 deep", _text("bad.gltf", _DEEP), 1, "levels deep", "bad.gltf", False),
    Case("glTF 1.0", _set("asset", {"version": "1.0"}), 1, "only 2.0 is known", "asset.version", False),
    Case(
        "unknown required extension",
        _set("extensionsRequired", ["EXT_magic"]),
        1,
        "requires EXT_magic",
        "extensionsRequired",
        False,
    ),
    Case(
        "unknown extension required",
        _set("extensionsRequired", ["ACME_magic"]),
        1,
        "requires ACME_magic",
        "extensionsRequired",
        False,
    ),
    Case("missing .bin", _missing_bin, 1, "No such file", "buffers[0].uri"),
    Case("missing texture", _bent(_missing_texture, textured_triangle), 1, "No such file", "images[0].uri"),
    Case("undecodable texture", _bent(_broken_texture, textured_triangle), 1, "cannot be used", "images[0]"),
    Case(
        "texture of 10 gigapixels in 70 bytes",
        _bent(_bomb_texture, textured_triangle),
        1,
        "pixels are decoded",
        "images[0]",
    ),
    Case("accessor beyond its view", _set("accessors.0.count", 400), 1, "elements need bytes", "accessors[0]"),
    Case(
        "view beyond its buffer",
        _set("bufferViews.0.byteLength", 10**6),
        1,
        "lie outside the 102 of buffers[0]",
        "bufferViews[0]",
    ),
    Case("negative count", _set("accessors.0.count", -3), 1, "the count is -3", "accessors[0]"),
    Case("negative offset", _set("accessors.0.byteOffset", -8), 1, "elements need bytes -8", "accessors[0]"),
    Case("huge count", _set("accessors.0.count", 2**31 - 1), 1, "bytes decoded", "accessors[0]"),
    Case("count beyond 64 bits", _set("accessors.0.count", 10**30), 1, "the count is 1000", "accessors[0]"),
    Case("index out of range", _bent(_index_beyond), 1, "beyond the 3 vertices", "meshes[0].primitives[0].indices"),
    Case(
        "NaN positions",
        _positions([[0, 0, 0], [1, 0, 0], [0, float("nan"), 0]]),
        1,
        "no usable numbers",
        "attributes.POSITION",
    ),
    Case(
        "infinite positions",
        _positions([[0, 0, 0], [1, 0, 0], [0, 3e38, 0]]),
        1,
        "no usable numbers",
        "attributes.POSITION",
    ),
    Case(
        "zero-area triangle",
        _positions([[0, 0, 0], [1, 0, 0], [2, 0, 0]]),
        0,
        "have no area; kept",
        "meshes[0].primitives[0]",
    ),
    Case(
        "no normals, tangents, uv",
        _bent(_strip_attributes, textured_triangle),
        0,
        "which the mesh lacks",
        "meshes[0].primitives[0]",
    ),
    Case("zero node scale", _set("nodes.0.scale", [1, 0, 1]), 1, "flattens", "nodes[0].scale"),
    Case("singular matrix", _set("nodes.0.matrix", _FLAT), 1, "is singular:", "nodes[0].matrix"),
    Case("zero quaternion", _set("nodes.0.rotation", [0, 0, 0, 0]), 1, "no rotation", "nodes[0].rotation"),
    Case(
        "NaN in a matrix", _set("nodes.0.matrix", [float("nan")] * 16), 1, "not a finite number", "nodes[0].matrix[0]"
    ),
    Case(
        "cyclic nodes",
        _nodes([{"mesh": 0, "children": [1]}, {"children": [0]}], [0]),
        1,
        "a ring of 2 nodes",
        "nodes[1].children",
    ),
    Case(
        "node that is its own child",
        _nodes([{"mesh": 0, "children": [0]}], [0]),
        1,
        "its own child",
        "nodes[0].children",
    ),
    Case(
        "node with two parents",
        _nodes([{"children": [2]}, {"children": [2]}, {"mesh": 0}], [0, 1]),
        1,
        "already a child",
        "nodes[1].children",
    ),
    Case("nodes 1,000 deep", _chain(1000), 0, "no findings", "bad.gltf"),
    Case("node of no number", _set("nodes.0.mesh", "zero"), 1, "expected a whole number", "nodes[0].mesh"),
    Case("0 meshes", _bent(_no_meshes), 1, "no mesh that can be drawn", "bad.gltf"),
    Case(
        "no scene, no nodes", _text("bad.gltf", '{"asset": {"version": "2.0"}}'), 1, "no scene and no nodes", "bad.gltf"
    ),
    Case("1x1 texture", _textured(1, 1), 0, "no findings", "bad.gltf"),
    Case("8191x3 texture", _textured(8191, 3), 0, "no findings", "bad.gltf"),
    Case("URI climbs out", _uri("../secret.bin"), 1, "leads out of the asset's folder", "buffers[0].uri"),
    Case(
        "URI climbs out, encoded", _uri("%2e%2e%2Fsecret.bin"), 1, "leads out of the asset's folder", "buffers[0].uri"
    ),
    Case("absolute URI", _uri("{secret}"), 1, "leads out of the asset's folder", "buffers[0].uri"),
    Case("file: URI", _uri("file://{secret}"), 1, "refused", "buffers[0].uri"),
    Case("http: URI", _uri("https://example.com/a.bin"), 1, "refused", "buffers[0].uri"),
    Case("buffer is a pipe", _pipe, 1, "not a regular file", "buffers[0].uri"),
    Case("source is missing", lambda folder: folder / "none.glb", 1, "no such file", "none.glb", False),
    Case("source is a device", _link, 1, "not a regular file", "bad.glb", False),
    Case("a folder named .glb", _folder, 1, "holds no file that can be imported", "bad.glb", False),
    Case("FBX named .glb", _text("bad.glb", b"Kaydara FBX Binary  \0\x1a\0"), 1, "is no glTF", "bad.glb", False),
    Case(
        "FBX with an open text",
        _text("bad.fbx", '; FBX 7.4.0\nObjects: {\n\tModel: 1, "a\n}\n'),
        1,
        "line 3: a text",
        "bad.fbx",
        False,
    ),
    Case(
        "FBX that nests 5,000 deep",
        _text("bad.fbx", "; FBX 7.4.0\nA: " + "{ \n" * 5000),
        1,
        "nested deeper",
        "bad.fbx",
        False,
    ),
    Case("OBJ without anything", _text("bad.obj", ""), 1, "cannot read", "bad.obj", False),
    Case("no Blender file", _text("bad.blend", "hello"), 1, "Assimp", "bad.blend", False),
    Case("unknown format", _text("bad.xyz", "hello"), 1, "no importer reads .xyz", "bad.xyz", False),
    Case(
        "output: a file is in the way",
        lambda f: triangle().write_gltf(f / "bad.gltf"),
        3,
        "must be a folder",
        "out",
        False,
    ),
)


def mutants(count: int, seed: int = 7) -> list[bytes]:
    """`count` damaged copies of a small GLB: bits flipped, bytes set, runs cut, doubled or filled. Fixed by `seed`."""
    rng = np.random.default_rng(seed)
    original = textured_triangle().glb()
    made = []
    for _ in range(count):
        data = bytearray(original)
        for _ in range(int(rng.integers(1, 6))):
            at = int(rng.integers(len(data)))
            run = int(rng.integers(1, 40))
            kind = int(rng.integers(6))
            if kind == 0:
                data[at] ^= 1 << int(rng.integers(8))
            elif kind == 1:
                data[at] = int(rng.integers(256))
            elif kind == 2:
                del data[at : at + run]
            elif kind == 3:
                data[at:at] = data[at : at + run]
            elif kind == 4:
                data[at : at + 4] = struct.pack("<I", (0, 2**32 - 1, 2**31, 2**31 - 1)[int(rng.integers(4))])
            else:
                digits = [i for i, c in enumerate(data) if 48 <= c <= 57]
                data[digits[int(rng.integers(len(digits)))]] = 48 + int(rng.integers(10))
            if len(data) < 8:
                break
        made.append(bytes(data))
    return made


def table(folder: Path) -> str:
    """All cases as a markdown table."""
    rows = ["| case | exit | message |", "|---|---|---|"]
    for number, case in enumerate(CASES):
        place = folder / str(number)
        place.mkdir()
        outcome = run(case, place)
        line = urllib.parse.unquote(outcome.line).replace(str(place / "source") + "/", "").replace(str(place) + "/", "")
        rows.append(f"| {case.name} | {outcome.code} | {line[:240].replace('|', '/')} |")
    return "\n".join(rows)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        os.environ["LUCARNA_CACHE"] = str(Path(temporary) / "cache")
        sys.stdout.write(table(Path(temporary)) + "\n")
