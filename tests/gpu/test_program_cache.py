"""Compiled programs kept on the disk: taken back bit for bit, and made again where anything is not as it was."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.core.errors import DeviceError, ShaderError
from engine.gpu import open_device
from engine.gpu.program_cache import VARIABLE, Binary, ProgramCache, open_cache
from engine.gpu.types import (
    Bindings,
    ColorAttachment,
    ComputePipelineDesc,
    RenderPipelineDesc,
    ShaderSource,
    TextureDesc,
)

VERTEX = ShaderSource(
    "vertex", "void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.5, 1.0); }"
)
FRAGMENT = ShaderSource("fragment", "out vec4 c; void main() { c = vec4(fract(gl_FragCoord.xy * 0.23), 0.5, 1.0); }")
DESC = RenderPipelineDesc("cached", VERTEX, FRAGMENT, depth=None)
COMPUTE = ComputePipelineDesc(
    "cached compute",
    ShaderSource(
        "compute",
        "layout(local_size_x = 4) in; layout(std430, binding = 0) buffer Block { uint values[]; } block;\n"
        "void main() { block.values[gl_GlobalInvocationID.x] = gl_GlobalInvocationID.x * 3u + 1u; }",
    ),
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path))
    monkeypatch.delenv(VARIABLE, raising=False)
    return tmp_path / "programs"


def drawn() -> tuple[int, int, NDArray[np.uint8], bytes]:
    """(compiled, loaded, a picture, what a compute shader wrote) by a device of its own."""
    try:
        device = open_device("gl", debug=True)
    except DeviceError as error:
        pytest.skip(f"no OpenGL device: {error}")
    try:
        if device.programs.cache is None:  # type: ignore[attr-defined]  # the gl device's own
            pytest.skip("this driver gives no program binaries")
        target = device.texture(TextureDesc("rgba8", 16, 16))
        buffer = device.buffer(32)
        pipelines = [device.render_pipeline(DESC), device.compute_pipeline(COMPUTE)]
        assert pipelines[1].block_size("Block") >= 4
        with device.render_pass("p", [ColorAttachment(target, clear=(0, 0, 0, 0))]) as render:
            render.set_pipeline(pipelines[0])
            render.draw(3)
        with device.compute_pass("c") as compute:
            compute.set_pipeline(pipelines[1])
            compute.set_bindings(Bindings(storage={0: buffer}))
            compute.dispatch(2)
        picture, written = np.array(target.read()), buffer.read()
        counts = device.counters.programs_compiled, device.counters.programs_loaded
        device.end_frame()  # raises on API errors
        for thing in (target, buffer, *pipelines):
            thing.release()
        assert device.live_objects()["program"] == 0
        return *counts, picture, written
    finally:
        device.release()


@pytest.mark.gl
def test_the_second_start_compiles_nothing(folder: Path) -> None:
    compiled, loaded, picture, written = drawn()
    assert (compiled, loaded) == (2, 0)
    assert len(np.unique(picture)) > 8
    # a third file is that of the device's own start-up test of its depth
    assert len(list(folder.glob("*.bin"))) >= 3
    again = drawn()
    assert again[:2] == (0, 2)
    np.testing.assert_array_equal(again[2], picture)
    assert again[3] == written == np.arange(1, 25, 3, np.uint32).tobytes()


@pytest.mark.gl
@pytest.mark.parametrize("damage", ["cut", "flipped", "foreign format", "nonsense that is whole", "empty"])
def test_what_is_damaged_is_made_again(folder: Path, damage: str) -> None:
    first = drawn()
    for path in folder.glob("*.bin"):
        raw = path.read_bytes()
        magic, kind, length, digest = struct.unpack_from("<4sIQ32s", raw)
        if damage == "cut":
            raw = raw[:-7]
        elif damage == "flipped":
            raw = raw[:-1] + bytes([raw[-1] ^ 1])
        elif damage == "foreign format":
            raw = struct.pack("<4sIQ32s", magic, kind + 77, length, digest) + raw[48:]
        elif damage == "empty":
            raw = b""
        path.write_bytes(raw)
        if damage == "nonsense that is whole":  # the driver itself must refuse it
            cache = ProgramCache(("x",), folder=folder)
            cache.put(path.stem, Binary(kind, b"no program at all" * 9))
    again = drawn()
    assert again[:2] == (2, 0)
    np.testing.assert_array_equal(again[2], first[2])
    assert drawn()[:2] == (0, 2), "it was replaced"


@pytest.mark.gl
def test_off_leaves_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "off")
    device = open_device("gl")
    device.render_pipeline(DESC).release()
    device.release()
    assert not folder.exists()


@pytest.mark.gl
def test_a_mistake_is_told_alike_and_not_kept(folder: Path) -> None:
    device = open_device("gl")
    bad = RenderPipelineDesc("bad", VERTEX, ShaderSource("fragment", "void main() { nothing; }"))
    before = len(list(folder.glob("*.bin")))
    for _ in range(2):
        device.begin_pipeline(bad)
        with pytest.raises(ShaderError, match="nothing"):
            device.render_pipeline(bad)
    assert len(list(folder.glob("*.bin"))) == before
    assert device.begin_pipeline(DESC)
    device.begin_pipeline(bad)
    device.abandon_pipelines()
    assert device.live_objects()["program"] == 0
    device.release()


def test_another_driver_version_or_text_is_another_key(tmp_path: Path) -> None:
    stages = [("vertex", "a"), ("fragment", "b")]
    cache = ProgramCache(("Mesa", "llvmpipe", "22.3.6"), folder=tmp_path)
    assert cache.key(stages) == ProgramCache(("Mesa", "llvmpipe", "22.3.6"), folder=tmp_path).key(stages)
    others = [
        ProgramCache(("Mesa", "llvmpipe", "22.3.7"), folder=tmp_path).key(stages),
        cache.key([("vertex", "a"), ("fragment", "b ")]),
        cache.key([("vertex", "ab"), ("fragment", "")]),
        cache.key([("fragment", "b"), ("vertex", "a")]),
        cache.key([("vertex", "a")]),
    ]
    assert len({cache.key(stages), *others}) == 6


def test_the_least_recently_used_go_at_the_limit(tmp_path: Path) -> None:
    cache = ProgramCache(("x",), folder=tmp_path, limit=10_000)
    for i in range(9):
        cache.put(f"k{i}", Binary(1, bytes([i]) * 1000))
        os.utime(tmp_path / f"k{i}.bin", (1000 + i, 1000 + i))
    assert cache.get("k0") == Binary(1, bytes(1000))  # used just now
    cache.put("k9", Binary(1, b"9" * 1000))
    left = {path.stem for path in tmp_path.glob("*.bin")}
    assert {"k0", "k9"} <= left
    assert "k1" not in left
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) <= 7_500
    cache.put("huge", Binary(1, bytes(20_000)))
    assert cache.get("huge") is None


def test_a_folder_that_cannot_be_written_is_no_cache(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    cache = ProgramCache(("x",), folder=tmp_path / "file" / "programs")
    cache.put("k", Binary(1, b"data"))
    assert cache.get("k") is None
    cache.put("k", Binary(1, b"data"))


@pytest.mark.parametrize(("said", "limit"), [("", 256 << 20), ("64MB", 64_000_000), ("nonsense", 256 << 20)])
def test_the_environment_limits_it(said: str, limit: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path))
    monkeypatch.setenv(VARIABLE, said)
    cache = open_cache(("x",))
    assert cache is not None
    assert cache.limit == limit
    assert cache.folder == tmp_path / "programs"


def test_the_cache_command_counts_and_prunes_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from importers.cli.main import main

    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path))
    cache = ProgramCache(("x",))
    for i in range(3):
        cache.put(f"k{i}", Binary(1, bytes(1000)))
    assert main(["cache", "info"]) == 0
    assert "programs          3 entries" in capsys.readouterr().out
    assert main(["cache", "prune", "--max-size", "2500"]) == 0
    assert "1 entries" in capsys.readouterr().out
    assert len(list(tmp_path.glob("programs/*.bin"))) == 2
