"""`.lmesh` and `.lanim`: round trip, same bytes, mapped arrays, and nothing but our errors on damaged files."""

from __future__ import annotations

import json
import random
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load_file

from engine.animation.sample import ClipPlayer
from engine.assets.clip import Channel, ClipAsset, CodedChannel
from engine.assets.container import write_container
from engine.assets.key_codes import candidates
from engine.assets.lanim import OLD_SCHEMA, clip_arrays, read_lanim, write_lanim
from engine.assets.lmesh import read_lmesh, read_provenance, write_lmesh
from engine.assets.mesh import MeshAsset, MorphTarget, Skeleton, Submesh
from engine.core.errors import FormatError, InputError, LucarnaError
from engine.scene.nodes import NodeTable


def make_mesh(n: int = 5, name: str = "mesh") -> MeshAsset:
    rng = np.random.default_rng(n)
    streams: dict[str, Any] = {
        "position": rng.standard_normal((n, 3)).astype("<f4"),
        "normal": rng.integers(-32767, 32767, (n, 4)).astype("<i2"),
        "uv0": rng.random((n, 2)).astype("<f4"),
        "joints": rng.integers(0, 2, (n, 4)).astype("<u2"),
        "weights": np.full((n, 4), 16383, "<u2"),
    }
    indices = rng.integers(0, n, 9).astype("<u4")
    parts = [
        Submesh(0, 6, 1, "triangles", (-3.0, -3.0, -3.0), (3.0, 3.0, 3.0)),
        Submesh(6, 2, 0, "lines"),
        Submesh(8, 1, 2, "points"),
    ]
    skeleton = Skeleton(["hüfte", "knie"], np.array([-1, 0], "<i4"), np.tile(np.eye(4, dtype="<f4"), (2, 1, 1)))
    morphs = [MorphTarget("smile", {"position": rng.random((n, 3)).astype("<f4")})]
    return MeshAsset(name, streams, indices, parts, skeleton, morphs, {"source": {"a": [1, 2.5]}})


def same(a: MeshAsset, b: MeshAsset) -> None:
    assert (a.name, a.submeshes, a.extras, a.layout) == (b.name, b.submeshes, b.extras, b.layout)
    for name in a.layout:
        np.testing.assert_array_equal(a.streams[name], b.streams[name])
    np.testing.assert_array_equal(a.indices, b.indices)
    assert a.skeleton is not None
    assert b.skeleton is not None
    assert a.skeleton.names == b.skeleton.names
    np.testing.assert_array_equal(a.skeleton.inverse_bind, b.skeleton.inverse_bind)
    assert [m.name for m in a.morphs] == [m.name for m in b.morphs]
    np.testing.assert_array_equal(a.morphs[0].streams["position"], b.morphs[0].streams["position"])


def test_round_trip_is_mapped_aligned_and_repeatable(tmp_path: Path) -> None:
    meshes = [make_mesh(5, "a"), make_mesh(7, "a")]
    write_lmesh(tmp_path / "x.lmesh", meshes, {"source": "x.glb"})
    read = read_lmesh(tmp_path / "x.lmesh")
    for before, after in zip(meshes, read, strict=True):
        same(before, after)
        for array in (*after.streams.values(), after.indices):
            assert not array.flags.writeable
            assert not array.flags.owndata
            assert array.__array_interface__["data"][0] % 64 == 0
    assert read_provenance(tmp_path / "x.lmesh") == {"source": "x.glb"}
    write_lmesh(tmp_path / "y.lmesh", read, {"source": "x.glb"})
    assert (tmp_path / "x.lmesh").read_bytes() == (tmp_path / "y.lmesh").read_bytes()


def test_other_readers_open_it(tmp_path: Path) -> None:
    mesh = make_mesh()
    write_lmesh(tmp_path / "x.lmesh", [mesh])
    np.testing.assert_array_equal(load_file(tmp_path / "x.lmesh")["m0.position"], mesh.streams["position"])


def test_file_without_meshes_and_empty_mesh(tmp_path: Path) -> None:
    write_lmesh(tmp_path / "none.lmesh", [])
    assert read_lmesh(tmp_path / "none.lmesh") == []
    empty = MeshAsset(
        "e", {"position": np.zeros((0, 3), "<f4"), "normal": np.zeros((0, 4), "<i2")}, np.zeros(0, "<u4"), []
    )
    write_lmesh(tmp_path / "e.lmesh", [empty])
    assert read_lmesh(tmp_path / "e.lmesh")[0].vertex_count == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda m: m.indices.__setitem__(3, 5), "outside the 5 vertices"),
        (lambda m: setattr(m.submeshes[0], "index_count", 99), "outside the 9 indices"),
        (lambda m: setattr(m.submeshes[0], "index_count", 5), "whole number of triangles"),
        (lambda m: setattr(m.submeshes[0], "first_index", -3), "outside the 9 indices"),
        (lambda m: setattr(m.submeshes[0], "material_slot", -1), "material slot"),
        (lambda m: setattr(m.submeshes[0], "topology", "quads"), "topology"),
        (lambda m: setattr(m.submeshes[0], "bounds_max", (np.nan, 0.0, 0.0)), "bounds"),
        (lambda m: setattr(m.submeshes[0], "bounds_max", (-9.0, 0.0, 0.0)), "bounds"),
        (lambda m: m.streams["joints"].__setitem__((2, 1), 2), "joint outside"),
        (lambda m: m.streams.pop("normal"), "no normal"),
        (lambda m: m.streams.__setitem__("uv0", np.zeros((4, 2), "<f4")), "expected <f4[5, 2]"),
        (lambda m: m.streams.__setitem__("colour", np.zeros((5, 4), "<u2")), "unknown stream"),
        (lambda m: m.skeleton.parents.__setitem__(1, 1), "before its joint"),
        (lambda m: m.morphs[0].streams.__setitem__("position", np.zeros((5, 2), "<f4")), "expected <f4[5, 3]"),
    ],
)
def test_broken_meshes_are_not_written(tmp_path: Path, change: Any, message: str) -> None:
    mesh = make_mesh()
    change(mesh)
    with pytest.raises(FormatError) as info:
        write_lmesh(tmp_path / "x.lmesh", [mesh])
    assert message in str(info.value)
    assert "meshes[0]" in str(info.value)
    assert not list(tmp_path.iterdir())


def test_range_errors_are_found_on_reading(tmp_path: Path) -> None:
    path = tmp_path / "x.lmesh"
    mesh = make_mesh()
    write_lmesh(path, [mesh])
    raw = path.read_bytes()
    at = raw.index(mesh.indices.tobytes())
    path.write_bytes(raw[:at] + b"\xff\xff\xff\x7f" + raw[at + 4 :])
    with pytest.raises(FormatError, match="outside the 5 vertices"):
        read_lmesh(path)


def test_wrong_schema_and_absent_file(tmp_path: Path) -> None:
    write_lanim(tmp_path / "x.lanim", make_clip())
    with pytest.raises(FormatError, match="schema"):
        read_lmesh(tmp_path / "x.lanim")
    with pytest.raises(InputError):
        read_lmesh(tmp_path / "absent.lmesh")
    with pytest.raises(InputError):
        read_lmesh(tmp_path)
    (tmp_path / "empty.lmesh").touch()
    with pytest.raises(FormatError):
        read_lmesh(tmp_path / "empty.lmesh")


def make_clip() -> ClipAsset:
    times = np.array([0.0, 0.5, 2.0], "<f4")
    return ClipAsset(
        "walk",
        [
            Channel(0, "translation", "linear", times, np.arange(9, dtype="<f4").reshape(3, 3), "hip"),
            Channel(1, "rotation", "cubic", times, np.ones((3, 3, 4), "<f4")),
            Channel(2, "weights", "step", times[:1], np.ones((1, 7), "<f4")),
        ],
    )


def test_clip_round_trip(tmp_path: Path) -> None:
    clip = make_clip()
    write_lanim(tmp_path / "x.lanim", clip)
    read = read_lanim(tmp_path / "x.lanim")
    assert (read.name, read.duration) == ("walk", 2.0)
    for a, b in zip(clip.channels, read.channels, strict=True):
        assert (a.node, a.path, a.interpolation, a.target) == (b.node, b.path, b.interpolation, b.target)
        np.testing.assert_array_equal(a.times, b.times)
        np.testing.assert_array_equal(a.values, b.values)
    write_lanim(tmp_path / "y.lanim", read)
    assert (tmp_path / "x.lanim").read_bytes() == (tmp_path / "y.lanim").read_bytes()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: setattr(c, "path", "visibility"), "path"),
        (lambda c: setattr(c, "interpolation", "cubic"), "expected <f4"),
        (lambda c: setattr(c, "node", -1), "node"),
        (lambda c: c.times.__setitem__(1, 0.0), "strictly rising"),
        (lambda c: c.values.__setitem__((1, 1), np.inf), "not finite"),
    ],
)
def test_broken_channels_are_not_written(tmp_path: Path, change: Any, message: str) -> None:
    clip = make_clip()
    change(clip.channels[0])
    with pytest.raises(FormatError, match=message):
        write_lanim(tmp_path / "x.lanim", clip)


def coded_clip() -> ClipAsset:
    """Every coding, float ones between them."""
    rng = np.random.default_rng(1)
    clip = make_clip()
    times = np.linspace(0.0, 2.0, 9).astype("<f4")
    turned = rng.normal(size=(9, 4)) * 0.2 + np.array([0.0, 0.0, 1.0, 0.0])
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    for i, codes in enumerate([*candidates(turned), *candidates(rng.normal(size=(9, 3)))]):
        kind = "scale" if i == 3 else "rotation"
        clip.channels.insert(i, CodedChannel(i + 3, kind, "step" if i == 1 else "linear", times, codes, f"n{i}"))
    return clip


def test_coded_keys_round_trip_and_are_decoded_when_asked_for(tmp_path: Path) -> None:
    clip = coded_clip()
    write_lanim(tmp_path / "x.lanim", clip)
    read = read_lanim(tmp_path / "x.lanim")
    kinds = {c.codes.coding for c in read.channels if c.codes is not None}
    assert len(kinds) == 3
    for a, b in zip(clip.channels, read.channels, strict=True):
        assert (a.node, a.path, a.interpolation, a.target) == (b.node, b.path, b.interpolation, b.target)
        assert (a.codes is None) == (b.codes is None)
        if b.codes is not None:
            assert isinstance(b, CodedChannel)
            assert b._decoded is None
            assert not b.codes.codes.flags.owndata  # mapped
        np.testing.assert_array_equal(a.times, b.times)
        np.testing.assert_array_equal(a.values, b.values)
        assert b.values.dtype == np.float32
        assert not b.values.flags.writeable
    write_lanim(tmp_path / "y.lanim", read)
    assert (tmp_path / "x.lanim").read_bytes() == (tmp_path / "y.lanim").read_bytes()
    nodes = NodeTable()
    rows = nodes.add_many([""] * 7)
    fresh = read_lanim(tmp_path / "x.lanim")
    player = ClipPlayer(fresh, rows)
    assert player.node_rows.tolist() == ClipPlayer(clip, rows).node_rows.tolist()
    assert player.duration == 2.0
    assert all(c._decoded is None for c in fresh.channels if isinstance(c, CodedChannel))
    player.apply(nodes, 0.5)
    assert all(c._decoded is not None for c in fresh.channels if isinstance(c, CodedChannel))
    other = read.channels[0].of_node(99)
    assert (other.node, other.codes) == (99, read.channels[0].codes)


def test_the_bytes_are_the_same_everywhere() -> None:
    """Codes are made of sums, products, quotients and roots alone: known bytes, from keys that need no library."""
    steps = np.arange(40) / 64.0
    q = np.stack([steps, -0.5 * steps, 0.25 * steps, 2.0 - steps], axis=1)
    q /= np.sqrt(q[:, 0] * q[:, 0] + q[:, 1] * q[:, 1] + q[:, 2] * q[:, 2] + q[:, 3] * q[:, 3])[:, None]
    coded = (*candidates(q), *candidates(q[:, :3]))
    found = [zlib.crc32(c.codes.tobytes() + c.low.tobytes() + c.step.tobytes()) for c in coded]
    assert found == [182851837, 1716120967, 2200369539, 182851837]


def test_files_of_the_first_schema_are_read(tmp_path: Path) -> None:
    clip = make_clip()
    metadata = {
        "schema": OLD_SCHEMA, "name": "walk", "provenance": {}, "start": 0.25, "frame_rate": 30.0,
        "channels": [[c.node, c.path, c.interpolation, c.target] for c in clip.channels],
    }  # fmt: skip
    arrays = {f"c{i}.{n}": getattr(c, n) for i, c in enumerate(clip.channels) for n in ("times", "values")}
    write_container(tmp_path / "old.lanim", metadata, arrays)
    read = read_lanim(tmp_path / "old.lanim")
    assert (read.start, read.frame_rate, len(read.channels)) == (0.25, 30.0, 3)
    for a, b in zip(clip.channels, read.channels, strict=True):
        np.testing.assert_array_equal(a.values, b.values)


@pytest.mark.parametrize(
    ("array", "at", "value", "message"),
    [
        ("channels", (0, 0), -1, "not a count"),
        ("channels", (0, 1), 4, "a channel"),
        ("channels", (0, 2), 9, "a channel"),
        ("channels", (0, 2), 2, "cubic rotation as"),
        ("channels", (0, 3), 7, "a channel"),
        ("channels", (0, 4), 3, "rotation of 3 components"),
        ("channels", (3, 3), 2, "scale of 3 components as largest"),
        ("channels", (0, 5), 0, "a channel"),
        ("channels", (0, 5), 2**31 - 1, "a channel"),
        ("channels", (0, 6), -3, "a channel"),
        ("channels", (0, 6), 1, "rising|numbers"),
        ("keys", 0, 60000, "times"),
        ("keys", 1, 0, "strictly rising"),
        ("times", 1, np.nan, "strictly rising"),
        ("ranges", 0, np.inf, "range of the keys"),
        ("ranges", 1, 3e4, "range of the keys"),
        ("ranges", None, 0, "too few"),
        ("codes", None, 0, "too few"),
        ("floats", None, 0, "too few"),
        ("floats", "more", 0, "the channels have"),
        ("floats", 3, np.nan, "values are not finite"),
        ("times", "f8", 0, "expected <f4"),
    ],
)
def test_lies_in_the_arrays_are_found(tmp_path: Path, array: str, at: Any, value: float, message: str) -> None:
    arrays = {name: values.copy() for name, values in clip_arrays(coded_clip()).items()}
    if at is None:
        arrays[array] = arrays[array][:-1]
    elif at == "more":
        arrays[array] = np.append(arrays[array], arrays[array][:1])
    elif at == "f8":
        arrays[array] = arrays[array].astype("<f8")
    else:
        arrays[array][at] = value
    targets = [c.target for c in coded_clip().channels]
    write_container(tmp_path / "x.lanim", {"schema": "lucarna.anim/2", "name": "x", "targets": targets}, arrays)
    with pytest.raises(FormatError, match=message):
        read_lanim(tmp_path / "x.lanim")


def test_damaged_files_raise_only_our_errors(tmp_path: Path) -> None:
    write_lmesh(tmp_path / "x.lmesh", [make_mesh()])
    write_lanim(tmp_path / "x.lanim", coded_clip())
    rng = random.Random(7)
    for kind, reader in (("lmesh", read_lmesh), ("lanim", read_lanim)):
        good = (tmp_path / f"x.{kind}").read_bytes()
        header = int.from_bytes(good[:8], "little") + 8
        for trial in range(250):
            bad = bytearray(good)
            for _ in range(rng.randint(1, 4)):
                bad[rng.randrange(header if trial % 3 else len(bad))] = rng.choice(b'0129-.,:"[]{}eaxN\x00\xff')
            if trial % 5 == 0:
                del bad[rng.randrange(len(bad)) :]
            path = tmp_path / f"bad{trial}.{kind}"
            path.write_bytes(bad)
            try:
                found = reader(path)
            except LucarnaError:
                continue
            if isinstance(found, ClipAsset):
                assert all(np.isfinite(c.values).all() for c in found.channels)


def test_hostile_headers(tmp_path: Path) -> None:
    def write(header: Any, body: bytes = b"") -> Path:
        text = json.dumps(header).encode() if not isinstance(header, bytes) else header
        path = tmp_path / "h.lmesh"
        path.write_bytes(len(text).to_bytes(8, "little") + text + body)
        return path

    meta = {"lucarna": json.dumps({"schema": "lucarna.mesh/1", "meshes": [], "provenance": {}})}
    for array in (
        {"dtype": "F32", "shape": [2**62, 2**62], "data_offsets": [0, 0]},
        {"dtype": "F32", "shape": [1], "data_offsets": [0, 4]},
        {"dtype": "F32", "shape": [-1], "data_offsets": [4, 0]},
        {"dtype": "F32", "shape": [True], "data_offsets": [0, 4]},
        {"dtype": "C64", "shape": [1], "data_offsets": [0, 8]},
        {"dtype": "F32", "shape": 3, "data_offsets": [0]},
        [],
        None,
    ):
        with pytest.raises(FormatError):
            read_lmesh(write({"__metadata__": meta, "a": array}))
    for header in (b"[" * 100_000, b"{}", b"[]", b"nul", {"__metadata__": {"lucarna": 3}}, {"__metadata__": []}):
        with pytest.raises(FormatError):
            read_lmesh(write(header))
    (tmp_path / "h.lmesh").write_bytes(b"\xff" * 16)
    with pytest.raises(FormatError):
        read_lmesh(tmp_path / "h.lmesh")
