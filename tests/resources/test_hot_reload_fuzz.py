"""500 random edits of effects, shaders and materials: nothing crashes, nothing leaks, the last good version stays."""

from __future__ import annotations

import gc
import os
import random
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from engine.gpu.types import Device
from tests.resources.test_hot_reload import EFFECT, FRAG, INCLUDE, MATERIAL, TONE, Project

FILES = (FRAG, FRAG, EFFECT, EFFECT, EFFECT, INCLUDE, MATERIAL, TONE, "shaders/effects/surface.vert")
EDITS = 500
TOKENS = (
    b"{", b"}", b"(", b";", b"[", b"]", b'"', b"=", b"#", b"\x00", b"\xff", b"\xed\xa0\x80", b"\r", b"//", b"/*",
    b"#if ", b"#endif\n", b'#include "lib/lights.glsl"\n', b'extends = "surface"\n', b"[params.x]\n", b"nan", b"1e999",
    b"vec3", b"float", b"discard;", b"\n" * 50, "ä漢".encode(), b"-1", b"99999999999999999999", b"true", b"''", b"\\",
    b"#define color\n", b"#version 450\n", b"#line 9\n", b"const ",
)  # fmt: skip


def bytes_flipped(data: bytes, rng: random.Random) -> bytes:
    made = bytearray(data)
    for _ in range(rng.randint(1, 6)):
        made[rng.randrange(len(made))] = rng.randrange(256)
    return bytes(made)


def token_inserted(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data))
    return data[:at] + rng.choice(TOKENS) + data[at:]


def span_removed(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data))
    return data[:at] + data[at + rng.randint(1, 60) :]


def truncated(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data))]


def lines_shuffled(data: bytes, rng: random.Random) -> bytes:
    lines = data.split(b"\n")
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(3)
    if kind == 0:
        lines[a], lines[b] = lines[b], lines[a]
    elif kind == 1:
        lines.insert(a, lines[b])
    else:
        del lines[min(a, b) : max(a, b) + 1]
    return b"\n".join(lines)


def word_replaced(data: bytes, rng: random.Random) -> bytes:
    """A word of the file in the place of another: structure that is nearly right."""
    words = list(re.finditer(rb"[A-Za-z_][A-Za-z0-9_.]*|\d+(?:\.\d+)?", data))
    a, b = rng.choice(words), rng.choice(words)
    return data[: a.start()] + b.group() + data[a.end() :]


def number_changed(data: bytes, rng: random.Random) -> bytes:
    numbers = list(re.finditer(rb"\d+(?:\.\d+)?", data))
    a = rng.choice(numbers)
    return data[: a.start()] + rng.choice((b"0", b"-1.0", b"1e30", b"inf", b"7", b'"7"', b"[]")) + data[a.end() :]


CHANGES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    bytes_flipped, token_inserted, span_removed, truncated, lines_shuffled, word_replaced, word_replaced,
    number_changed,
)  # fmt: skip


def write(path: Path, data: bytes, step: float) -> None:
    """With a time of its own: edits come faster here than some clocks tick."""
    path.write_bytes(data)
    os.utime(path, ns=(0, int((1000 + step) * 1e9)))


def _settled(device: Device) -> dict[str, int]:
    gc.collect()
    device.end_frame()
    return dict(device.live_objects())


def test_random_edits(gl_device: Device, tmp_path: Path) -> None:
    rng = random.Random(20)
    project = Project(gl_device, tmp_path)
    try:
        good = project.picture()
        for file in FILES:
            project.write(file, (tmp_path / file).read_text(encoding="utf-8"))
        project.poll()
        project.picture()
        before = _settled(gl_device)
        refused = taken = 0
        for step in range(EDITS):
            file = rng.choice(FILES)
            path = tmp_path / file
            sound = path.read_bytes()
            fuzzed = rng.choice(CHANGES)(sound, rng)
            write(path, fuzzed, step)
            result = project.poll()
            assert result is not None
            broken = bool(result.problems) and not result.names
            refused, taken = refused + broken, taken + (not broken)
            if broken and step % 8 == 0:  # a fuzzed shader that compiles may never end: only what must be good is drawn
                np.testing.assert_array_equal(project.picture(), good, err_msg=f"edit {step} of {file}")
            write(path, sound, step + 0.5)
            project.poll()
            assert project.problems == (), f"edit {step} of {file}"
        assert refused > EDITS // 4, "too few of the edits were mistakes"
        assert taken > EDITS // 20, "too few of the edits were good"
        np.testing.assert_array_equal(project.picture(), good)
        after = _settled(gl_device)
        assert {kind: after[kind] - before[kind] for kind in after if after[kind] > before[kind]} == {}
    finally:
        project.runtime.close()
