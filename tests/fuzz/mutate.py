"""One sound file + a random generator -> a damaged one, and what was done to it."""

from __future__ import annotations

import json
import os
import random
import re
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.fuzz.seeds import Seed, is_json

NUMBERS = ("-1", "0", "4294967295", "2147483648", "1e400", "-1e38", "nan", "inf", "99999999999999999999", "0.5", "1e9")
WORDS = ("../../../secret.png", "/etc/passwd", "..\\..\\..\\secret.png", "file:///etc/passwd", "\\\\host\\share\\x", "",
         "\0", "a" * 5000, "%2e%2e%2f%2e%2e%2f%2e%2e%2fsecret.png", "CON", "C:\\secret.png", "./../.././../secret.png",
         "\u202e", "*", "~/.ssh/id")  # fmt: skip
EXTREMES = (
    b"\xff" * 4,
    b"\0" * 4,
    b"\xff\xff\xff\x7f",
    b"\0\0\0\x80",
    b"\0\0\xc0\x7f",
    b"\0\0\x80\x7f",
    b"\x7f\xff\xff\xff",
)
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?")
_QUOTED = re.compile(rb'"[^"\n]{1,200}"')
_FILE = re.compile(rb"[\w ./\\-]+\.(?:png|jpg|mtl|bin|skeleton|toml|lmesh|lanim|dds)")
#: where an image file keeps its width and height, or what stands for them: (offset, struct)
_SIZES = {
    "png": (16, ">II"), "tga": (12, "<HH"), "bmp": (18, "<ii"), "dds": (12, "<II"), "psd": (14, ">II"),
    "ktx2": (20, "<II"),
}  # fmt: skip
DISK = ("empty", "directory", "link to nowhere", "link to itself", "pipe", "unreadable", "vanishing", "wrong extension")


def mutant(seed: Seed, dice: random.Random, folder: Path) -> tuple[str, str]:
    """Write the damaged files into `folder`; returns what was done and the name to read."""
    for name, data in seed.files.items():
        (folder / name).write_bytes(data)
    data = seed.files[seed.target]
    path = folder / seed.target
    if dice.random() < 0.08:
        return _on_disk(seed, dice, folder)
    choices: list[tuple[str, Callable[[bytes, random.Random], bytes]]] = [("cut", _cut), ("bytes", _bytes)]
    if seed.is_text:
        choices += [("numbers", _numbers), ("words", _words), ("lines", _lines), ("depth", _depth)]
    if is_json(data):
        choices += [("values", _json), ("values", _json), ("cycle", _cycle)]
    elif seed.kind in ("glb", "lmesh", "lanim"):
        choices += [("values", _json_inside)] * 2
    if seed.work == "image":
        choices += [("size", lambda d, r: _size(seed.kind, d, r)), ("bomb", lambda d, r: _bomb(seed.kind, d, r))]
    what, change = dice.choice(choices)
    path.write_bytes(change(data, dice))
    return what, seed.entry


def _on_disk(seed: Seed, dice: random.Random, folder: Path) -> tuple[str, str]:
    path = folder / seed.target
    what = dice.choice(DISK)
    if what == "wrong extension":
        other = dice.choice((".glb", ".gltf", ".fbx", ".mesh", ".mesh.xml", ".obj", ".dae", ".ply", ".stl", ".png",
                             ".scene.json", ".lmesh", ".material.toml", ".xyz", ""))  # fmt: skip
        path.rename(folder / f"wrong{other}")
        return what, f"wrong{other}"
    if what == "unreadable":
        path.chmod(0)
    elif what == "vanishing":
        pass  # the child takes it away meanwhile
    else:
        path.unlink()
        if what == "empty":
            path.write_bytes(b"")
        elif what == "directory":
            path.mkdir()
        elif what == "link to nowhere":
            path.symlink_to("nowhere")
        elif what == "link to itself":
            path.symlink_to(path.name)
        else:
            os.mkfifo(path)
    return what, seed.entry


def _cut(data: bytes, dice: random.Random) -> bytes:
    return data[: dice.randrange(max(len(data), 1))]


def _bytes(data: bytes, dice: random.Random) -> bytes:
    """One to four of: flipped bits, random bytes, extremes of four bytes, deleted, doubled and filled runs."""
    out = bytearray(data)
    for _ in range(dice.randint(1, 4)):
        if len(out) < 8:
            break
        at, run = dice.randrange(len(out)), dice.choice((1, 2, 4, 16, 200))
        what = dice.randrange(6)
        if what == 0:
            out[at] ^= 1 << dice.randrange(8)
        elif what == 1:
            out[at : at + run] = dice.randbytes(len(out[at : at + run]))
        elif what == 2:
            out[at : at + 4] = dice.choice(EXTREMES)
        elif what == 3:
            del out[at : at + run]
        elif what == 4:
            out[at:at] = out[at : at + run]
        else:
            out[at : at + run] = bytes([dice.randrange(256)]) * len(out[at : at + run])
    return bytes(out)


def _swap(
    data: bytes, pattern: re.Pattern[bytes], dice: random.Random, new: Callable[[], bytes], most: int = 2
) -> bytes:
    spots = [match.span() for match in pattern.finditer(data)]
    for first, last in sorted(dice.sample(spots, min(len(spots), dice.randint(1, most))), reverse=True):
        data = data[:first] + new() + data[last:]
    return data


def _numbers(data: bytes, dice: random.Random) -> bytes:
    return _swap(data, _NUMBER, dice, lambda: dice.choice(NUMBERS).encode())


def _words(data: bytes, dice: random.Random) -> bytes:
    """Names replaced: paths that lead out, absurd ones, or those of something else in the file."""
    files = dice.random() < 0.6 and _FILE.search(data)
    pattern = _FILE if files else _QUOTED
    names = [match.group() for match in pattern.finditer(data)]

    def new() -> bytes:
        if names and dice.random() < 0.4:
            return dice.choice(names)
        word = dice.choice(WORDS).encode("utf-8", "replace")
        return word if files else b'"' + word + b'"'

    return _swap(data, pattern, dice, new)


def _lines(data: bytes, dice: random.Random) -> bytes:
    lines = data.split(b"\n")
    one, other = dice.randrange(len(lines)), dice.randrange(len(lines))
    what = dice.randrange(3)
    if what == 0:
        del lines[one]
    elif what == 1:
        lines.insert(one, lines[other])
    else:
        lines[one], lines[other] = lines[other], lines[one]
    return b"\n".join(lines)


def _depth(data: bytes, dice: random.Random) -> bytes:
    """Brackets, braces or elements, thousands deep, at some place."""
    many = dice.choice((200, 3000, 100_000))
    at = dice.choice([match.start() for match in re.finditer(rb"[\[{<(=:]|\n", data)] or [0]) + 1
    opening = (
        dice.choice((b"[", b"{", b"<node>", b"<node name='a'>", b"a {\n", b"(", b'{"a":', b"[[", b"a = [", b"(("))
        * many
    )
    return data[:at] + opening + data[at:]


def _json(data: bytes, dice: random.Random) -> bytes:
    root = json.loads(data)
    for _ in range(dice.randint(1, 3)):
        owner, key = _somewhere(root, dice)
        if owner is not None:
            owner[key] = _value(owner[key], dice)
    text = json.dumps(root)
    return text.replace('"@huge"', "1e999").replace('"@nan"', "NaN").encode()


def _cycle(data: bytes, dice: random.Random) -> bytes:
    """Children that hold their parents, parents that come after their children."""
    root = json.loads(data)
    nodes = root.get("nodes") if isinstance(root, dict) else None
    if not isinstance(nodes, list) or not nodes or not all(isinstance(node, dict) for node in nodes):
        return _json(data, dice)
    for node in dice.sample(nodes, min(len(nodes), 2)):
        target = dice.randrange(len(nodes))
        if "asset" in root:
            node["children"] = [*node.get("children", []), target]
        else:
            node["parent"] = target
    return json.dumps(root).encode()


def _json_inside(data: bytes, dice: random.Random) -> bytes:
    """The JSON header of a GLB, or of a container of ours, with its length put right (mostly)."""
    at, layout = (12, "<I") if data[:4] == b"glTF" else (0, "<Q")
    (length,) = struct.unpack_from(layout, data, at)
    start = at + 8
    text = data[start : start + length]
    try:
        new = _json(text, dice)
    except ValueError:
        return _bytes(data, dice)
    new += b" " * (-len(new) % 8)
    size = len(new) if dice.random() < 0.9 else dice.randrange(1 << 31)
    result = bytearray(data[:start] + new + data[start + length :])
    struct.pack_into(layout, result, at, size)
    if data[:4] == b"glTF":
        struct.pack_into("<I", result, 8, len(result))
    return bytes(result)


def _somewhere(root: Any, dice: random.Random) -> tuple[Any, Any]:
    """A random place in a tree: (owner, key)."""
    owner, key = None, None
    here = root
    for _ in range(dice.randint(1, 8)):
        if isinstance(here, dict) and here:
            owner, key = here, dice.choice(list(here))
        elif isinstance(here, list) and here:
            owner, key = here, dice.randrange(len(here))
        else:
            break
        here = owner[key]
    return owner, key


def _value(old: Any, dice: random.Random) -> Any:
    if isinstance(old, int | float) and dice.random() < 0.6:
        return dice.choice((-1, 0, 1, 2, 2**31, 2**32, 10**30, -0.5, 1e38, "@huge", "@nan", old + 1, old * 1000))
    if isinstance(old, str) and dice.random() < 0.6:
        return dice.choice(WORDS)
    deep: Any = 1
    for _ in range(dice.choice((1, 150, 900))):
        deep = [deep]
    return dice.choice((None, True, [], {}, "", "x", -1, [old] * 3, {"a": old}, deep, [1, "a", None], [0.0] * 17))


def _size(kind: str, data: bytes, dice: random.Random) -> bytes:
    """Width and height that the pixels do not have."""
    place = _SIZES.get(kind)
    if place is None or len(data) < place[0] + struct.calcsize(place[1]):
        wanted = b"-Y %d +X %d" % (dice.choice((10**9, 0, 65536)), dice.choice((10**9, 1, 65536)))
        return re.sub(rb"-Y \d+ \+X \d+", wanted, data) if kind == "hdr" else _bytes(data, dice)
    most = 65535 if "H" in place[1] else 2**31 - 1
    sizes = [dice.choice((0, 1, 5, 30_000, 65_535, most)) for _ in range(2)]
    out = bytearray(data)
    struct.pack_into(place[1], out, place[0], *sizes)
    if kind == "png":
        out[29:33] = struct.pack(">I", zlib.crc32(bytes(out[12:29])))
    return bytes(out)


def _bomb(kind: str, data: bytes, dice: random.Random) -> bytes:
    """A small file that unpacks to very much."""
    if kind != "png":
        return data + bytes(dice.choice((1, 1000, 1_000_000)))
    side = dice.choice((20_000, 60_000, 100_000))
    head = struct.pack(">IIBBBBB", side, side, 8, 6, 0, 0, 0)
    body = zlib.compress(bytes(4_000_000), 9) * dice.choice((1, 20))

    def chunk(name: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    return data[:8] + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")
