"""Ogre skeletons: bones, bind pose, skins, clips, linked skeletons, and both forms against each other."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from engine.assets.clip import ClipAsset
from engine.core.errors import FormatError
from engine.core.findings import Findings, Severity
from engine.math.transform import compose
from importers.model import ImportedModel
from importers.ogre.data import OgreMesh, OgreSkeleton
from importers.ogre.reader import dependencies, load
from importers.ogre.skeleton_binary import read_skeleton
from importers.ogre.sources import read_source
from importers.settings import ImportSettings
from tests.support.ogre_builder import SQUARE_INDICES, OgreBytes

SETTINGS = ImportSettings()
B = OgreBytes()
QUARTER = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))  # 90 degrees about z

BONES = [
    B.bone("tip", 7, (0, 1, 0)),
    B.bone("root", 3, (1, 0, 0), QUARTER, (2, 2, 2)),
    B.bone("other", 5, (0, 0, 1)),
    B.parent(7, 3), B.parent(5, 3),
]  # fmt: skip


def write(folder: Path, skeleton: bytes, assignments: list[tuple[int, int, float]]) -> Path:
    (folder / "t.skeleton").write_bytes(skeleton)
    link = B.chunk(0x6000, B.text("t.skeleton"))
    path = folder / "t.mesh"
    path.write_bytes(B.mesh(B.submesh("m", SQUARE_INDICES, B.square_geometry(), assignments=assignments), link))
    return path


def codes(model: ImportedModel) -> set[str]:
    return {f.code for f in model.findings if f.severity is not Severity.INFO}


def values(clip: ClipAsset, target: str, path: str) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    (channel,) = [c for c in clip.channels if c.target == target and c.path == path]
    return channel.values


@pytest.mark.parametrize("order", ["<", ">"])
def test_bones_with_and_without_scale(order: str) -> None:
    b = OgreBytes(order)
    data = b.skeleton(b.bone("a", 0, (1, 2, 3), QUARTER, (2, 3, 4)), b.bone("b", 9, (4, 5, 6)), b.parent(9, 0))
    found = read_skeleton(data, "t", Findings())
    a, c = found.bones
    assert (a.name, a.handle, a.position, a.scale, a.parent) == ("a", 0, (1, 2, 3), (2, 3, 4), -1)
    assert a.rotation == pytest.approx(QUARTER)
    assert (c.name, c.handle, c.position, c.scale, c.parent) == ("b", 9, (4, 5, 6), (1, 1, 1), 0)


def test_joints_are_depth_first_and_the_bind_pose_leaves_the_mesh_alone(tmp_path: Path) -> None:
    path = write(tmp_path, B.skeleton(*BONES), [(0, 7, 1), (1, 3, 0.5), (1, 5, 0.5), (2, 5, 1), (3, 3, 1)])
    model = load(path, SETTINGS)
    mesh = model.meshes[0]
    assert mesh.skeleton is not None
    assert mesh.skeleton.names == ["root", "tip", "other"]
    assert mesh.skeleton.parents.tolist() == [-1, 0, 0]
    assert [(n.name, n.parent) for n in model.nodes] == [("t", -1), ("root", 0), ("tip", 1), ("other", 1)]
    assert model.nodes[0].joints == [1, 2, 3]
    assert np.asarray(mesh.streams["joints"])[:, 0].tolist() == [1, 0, 2, 0]
    assert np.asarray(mesh.streams["weights"])[1].tolist() == [32768, 32767, 0, 0]
    world: list[np.ndarray[tuple[int, ...], np.dtype[np.float64]]] = []
    for node in model.nodes:
        local = compose(node.translation, node.rotation, node.scale)
        world.append(local if node.parent < 0 else world[node.parent] @ local)
    for row, joint in enumerate(model.nodes[0].joints):
        np.testing.assert_allclose(world[joint] @ mesh.skeleton.inverse_bind[row], np.eye(4), atol=1e-6)
    # (0, 1, 0) doubled and turned a quarter about z, then moved by (1, 0, 0)
    np.testing.assert_allclose(world[2][:3, 3], (-1, 0, 0), atol=1e-6)
    assert [name for name, _ in dependencies(path, SETTINGS)] == ["t.skeleton"]


def test_keys_are_relative_to_the_bind_pose(tmp_path: Path) -> None:
    keys = [B.key(0), B.key(0.5, QUARTER, (1, 2, 3), (1, 2, 1)), B.key(1.0)]
    path = write(tmp_path, B.skeleton(*BONES, B.animation("walk", 1.0, [(3, keys), (7, [B.key(0)])])), [(0, 3, 1)])
    (clip,) = load(path, SETTINGS).clips
    assert (clip.name, clip.duration) == ("walk", 1.0)
    np.testing.assert_allclose(values(clip, "root", "translation"), [[1, 0, 0], [2, 2, 3], [1, 0, 0]])
    np.testing.assert_allclose(values(clip, "root", "rotation")[1], (0, 0, 1, 0), atol=1e-6)
    np.testing.assert_allclose(values(clip, "root", "scale"), [[2, 2, 2], [2, 4, 2], [2, 2, 2]])
    # one key only: the pose is held to the end
    np.testing.assert_allclose(values(clip, "tip", "translation"), [[0, 1, 0]] * 2)
    assert {c.node for c in clip.channels} == {1, 2}


def test_keys_out_of_order_and_at_one_time_keep_the_jump(tmp_path: Path) -> None:
    def at(time: float, x: float) -> bytes:
        return B.key(time, translation=(x, 0, 0))

    keys = [at(0.5, 10), at(0, 0), at(0.5, 20), at(0.5, 30), at(1, 0)]
    path = write(tmp_path, B.skeleton(*BONES, B.animation("jump", 2.0, [(5, keys)])), [(0, 3, 1)])
    model = load(path, SETTINGS)
    channel = next(c for c in model.clips[0].channels if c.path == "translation")
    assert (np.diff(channel.times) > 0).all()
    assert channel.values[:, 0].tolist() == [0, 10, 30, 0, 0]
    assert channel.times[1] == np.nextafter(np.float32(0.5), np.float32(0))
    # the length is past the last key: on to the first one
    assert channel.times[-1] == 2.0
    assert "ogre.key-times" in {f.code for f in model.findings}


def test_linked_skeletons_bring_their_clips_scaled(tmp_path: Path) -> None:
    tracks = [(7, [B.key(0, translation=(2, 0, 0)), B.key(1)]), (99, [B.key(0)])]
    other = B.skeleton(*BONES, B.animation("run", 1, tracks))
    (tmp_path / "moves.skeleton").write_bytes(other)
    link = B.chunk(0x5000, B.text("moves.skeleton"), B.pack("f", 0.5))
    path = write(tmp_path, B.skeleton(*BONES, link), [(0, 3, 1)])
    model = load(path, SETTINGS)
    assert [clip.name for clip in model.clips] == ["run"]
    np.testing.assert_allclose(values(model.clips[0], "tip", "translation"), [[1, 1, 0], [0, 1, 0]])
    assert codes(model) & {"ogre.track"} == {"ogre.track"}  # bone 99
    assert sorted(name for name, _ in dependencies(path, SETTINGS)) == ["moves.skeleton", "t.skeleton"]


def test_faults_of_assignments_are_findings(tmp_path: Path) -> None:
    rows = [(0, 3, 0.25), (1, 3, 1), (2, 44, 1), (3, 7, 1), (88, 3, 1)]
    model = load(write(tmp_path, B.skeleton(*BONES), rows), SETTINGS)
    said = [f.message for f in model.findings if f.code in ("ogre.assignment", "ogre.weights")]
    assert len([m for m in said if "vertices beyond the 4" in m]) == 1
    assert len([m for m in said if "bones the skeleton lacks" in m]) == 1
    assert len([m for m in said if "do not sum to 1" in m]) == 1
    weights = np.asarray(model.meshes[0].streams["weights"], np.int64)
    assert weights.sum(axis=1).tolist() == [65535] * 4


def test_more_than_four_influences_take_a_second_set(tmp_path: Path) -> None:
    bones = [B.bone(f"b{k}", k) for k in range(12)]
    rows = [(0, k, 1 + k) for k in range(12)] + [(v, 0, 1.0) for v in (1, 2, 3)]
    model = load(write(tmp_path, B.skeleton(*bones), rows), SETTINGS)
    mesh = model.meshes[0]
    assert "joints1" in mesh.streams
    assert np.asarray(mesh.streams["joints"])[0].tolist() == [11, 10, 9, 8]
    assert np.asarray(mesh.streams["joints1"])[0].tolist() == [7, 6, 5, 4]


def test_missing_and_ringed_skeletons_leave_the_mesh_rigid(tmp_path: Path) -> None:
    path = write(tmp_path, B.skeleton(B.bone("a", 0), B.bone("b", 1), B.parent(0, 1), B.parent(1, 0)), [(0, 0, 1)])
    model = load(path, SETTINGS)
    assert model.meshes[0].skeleton is None
    assert "ogre.skeleton" in codes(model)
    assert any("ring" in f.message for f in model.findings)
    with pytest.raises(FormatError, match="ring"):
        load(tmp_path / "t.skeleton", SETTINGS)
    (tmp_path / "t.skeleton").unlink()
    model = load(path, SETTINGS)
    assert model.meshes[0].skeleton is None
    assert any("is not there" in f.message for f in model.findings)


def test_a_skeleton_alone_gives_joints_and_clips(tmp_path: Path) -> None:
    write(tmp_path, B.skeleton(*BONES, B.animation("walk", 1.0, [(3, [B.key(0), B.key(1)])])), [])
    model = load(tmp_path / "t.skeleton", SETTINGS)
    assert [n.name for n in model.nodes] == ["t", "root", "tip", "other"]
    assert (len(model.meshes), len(model.clips)) == (0, 1)


@pytest.mark.parametrize("name", ["ninja.mesh", "fish.mesh", "razor.mesh", "ninja.skeleton", "fish.skeleton"])
def test_binary_and_xml_say_the_same(name: str, shared_assets: Path) -> None:
    """Of the Ogre project's own files; the XML has six digits."""
    folder = shared_assets / "ogre_xml"
    a = read_source(folder / name, SETTINGS, Findings())
    b = read_source(folder / f"{name}.xml", SETTINGS, Findings())
    near = {"rtol": 5.1e-6, "atol": 1e-6}
    if isinstance(a, OgreMesh):
        assert isinstance(b, OgreMesh)
        pairs = [(a.shared, b.shared)]
        for p, q in zip(a.submeshes, b.submeshes, strict=True):
            assert (p.material, p.operation) == (q.material, q.operation)
            np.testing.assert_array_equal(p.indices, q.indices)
            pairs.append((p.geometry, q.geometry))
            for column in ("vertex", "bone"):
                np.testing.assert_array_equal(getattr(p.assignments, column), getattr(q.assignments, column))
            np.testing.assert_allclose(p.assignments.weight, q.assignments.weight, **near)
        for g, h in pairs:
            assert (g is None) == (h is None)
            if g is not None and h is not None:
                np.testing.assert_allclose(g.position, h.position, **near)
                np.testing.assert_allclose(g.normal, h.normal, **near)  # type: ignore[arg-type]  # both have them
                np.testing.assert_allclose(g.uv[0], h.uv[0], **near)
        return
    assert isinstance(a, OgreSkeleton)
    assert isinstance(b, OgreSkeleton)
    assert [(x.name, x.handle, x.parent) for x in a.bones] == [(x.name, x.handle, x.parent) for x in b.bones]
    for x, y in zip(a.bones, b.bones, strict=True):
        np.testing.assert_allclose(x.position, y.position, **near)
        assert abs(np.dot(x.rotation, y.rotation)) == pytest.approx(1, abs=1e-5)
    keys = 0
    for m, n in zip(a.animations, b.animations, strict=True):
        assert (m.name, pytest.approx(m.length, rel=5.1e-6)) == (n.name, n.length)
        for s, t in zip(m.tracks, n.tracks, strict=True):
            order = np.argsort(s.times, kind="stable")  # the converter sorts
            assert s.bone == t.bone
            np.testing.assert_allclose(s.times[order], t.times, **near)
            np.testing.assert_allclose(s.translation[order], t.translation, **near)
            np.testing.assert_allclose(np.abs((s.rotation[order] * t.rotation).sum(axis=1)), 1, atol=2e-5)
            keys += len(order)
    assert keys == {"ninja.skeleton": 1796, "fish.skeleton": 9}[name]
