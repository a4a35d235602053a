"""Corrections of a source: exact sizes and turns with their keys, uvs, normals, tangents, both sides."""

from __future__ import annotations

import numpy as np
import pytest

from engine.assets.clip import Channel, ClipAsset
from engine.assets.material import MaterialAsset
from engine.assets.mesh import MeshAsset, Skeleton
from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import CameraAsset, LightAsset, NodeAsset
from engine.core.errors import UsageError
from engine.core.findings import Findings
from engine.math import quat
from importers.adjusting import TURNS, adjust, wanted
from importers.model import ImportedMaterial, ImportedModel
from importers.settings import ImportSettings, declared


def model(mesh: MeshAsset | None = None) -> ImportedModel:
    times = np.array([0.0, 1.0], np.float32)
    places = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], np.float32)
    turns = np.tile(np.array([0.0, 0.0, 0.0, 1.0], np.float32), (2, 1))
    clip = ClipAsset("walk", [
        Channel(0, "translation", "linear", times, places), Channel(1, "translation", "linear", times, places),
        Channel(0, "rotation", "linear", times, turns), Channel(0, "scale", "linear", times, places),
    ])  # fmt: skip
    nodes = [
        NodeAsset("root", translation=(1.0, 2.0, 3.0), matrix=tuple(np.eye(4).T.reshape(16).tolist())),
        NodeAsset("lamp", 0, (0.0, 1.0, 0.0), light=LightAsset("point", intensity=4.0, range=10.0)),
        NodeAsset("eye", 0, camera=CameraAsset(znear=0.1)),
    ]
    return ImportedModel(
        "x", Findings("x"), meshes=[mesh or cube()], slots=[[0]], materials=[ImportedMaterial(MaterialAsset("m"))],
        nodes=nodes, clips=[clip],
    )  # fmt: skip


def test_nothing_asked_for_is_nothing_done() -> None:
    assert not wanted(ImportSettings())
    assert set(TURNS) | {"none"} == set(declared()["turn"].choices)
    with pytest.raises(UsageError, match="scale"):
        ImportSettings(scale=0.0)


def test_a_scale_is_in_the_data_and_in_nothing_else() -> None:
    m = model()
    position = np.array(m.meshes[0].streams["position"])
    m.meshes[0].skeleton = Skeleton(["j"], np.array([-1], np.int32), np.eye(4, dtype=np.float32)[None].copy())
    m.meshes[0].skeleton.inverse_bind[0, :3, 3] = (1.0, 2.0, 3.0)
    adjust(m, ImportSettings(scale=0.01))
    assert np.array_equal(m.meshes[0].streams["position"], (position.astype(np.float64) * 0.01).astype(np.float32))
    assert m.meshes[0].submeshes[0].bounds_max == pytest.approx(position.max(axis=0) * 0.01)
    assert m.meshes[0].skeleton.inverse_bind[0, :3, 3] == pytest.approx([0.01, 0.02, 0.03])
    assert m.meshes[0].skeleton.inverse_bind[0, 0, 0] == 1.0
    assert m.nodes[0].translation == pytest.approx((0.01, 0.02, 0.03))
    assert m.nodes[0].scale == (1.0, 1.0, 1.0)
    light, camera = m.nodes[1].light, m.nodes[2].camera
    assert light is not None
    assert camera is not None
    assert (light.range, light.intensity) == pytest.approx((0.1, 4e-4)), "candela: as bright on what is nearer now"
    assert camera.znear == pytest.approx(0.001)
    by_path = {(c.node, c.path): c.values for c in m.clips[0].channels}
    assert by_path[1, "translation"][1] == pytest.approx([0.04, 0.05, 0.06])
    assert by_path[0, "scale"][0] == pytest.approx([1.0, 2.0, 3.0])


def test_z_up_turns_the_tops_and_their_keys_alone() -> None:
    m = model()
    adjust(m, ImportSettings(turn="z-up"))
    assert m.nodes[0].translation == pytest.approx((1.0, 3.0, -2.0))
    assert quat.to_matrix3(np.array(m.nodes[0].rotation)) @ [0.0, 0.0, 1.0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)
    assert m.nodes[0].matrix is not None
    assert np.array(m.nodes[0].matrix).reshape(4, 4).T[:3, :3] @ [0.0, 0.0, 1.0] == pytest.approx([0, 1, 0], abs=1e-15)
    assert m.nodes[1].translation == (0.0, 1.0, 0.0)
    by_path = {(c.node, c.path): c.values for c in m.clips[0].channels}
    assert by_path[0, "translation"][1] == pytest.approx([4.0, 6.0, -5.0])
    assert by_path[1, "translation"][1] == pytest.approx([4.0, 5.0, 6.0])
    assert quat.to_matrix3(by_path[0, "rotation"][0].astype(float)) @ [0, 0, 1] == pytest.approx([0, 1, 0], abs=1e-6)


def test_uvs_faces_normals_and_tangents() -> None:
    m = model(card())
    uv = np.array(m.meshes[0].streams["uv0"])
    adjust(m, ImportSettings(flip_v=True, two_sided=True, tangents=True))
    assert m.meshes[0].streams["uv0"][:, 1] == pytest.approx(1.0 - uv[:, 1])
    assert m.materials[0].asset.features == ["double_sided"]
    assert "tangent" in m.meshes[0].streams
    round_one = model(uv_sphere())
    count = round_one.meshes[0].vertex_count
    adjust(round_one, ImportSettings(normals="flat"))
    assert round_one.meshes[0].vertex_count > count
    adjust(round_one, ImportSettings(normals="smooth"))
    mesh = round_one.meshes[0]
    normal = np.array(mesh.streams["normal"][:, :3], np.float64) / 32767
    position = np.array(mesh.streams["position"], np.float64)
    outward = position / np.linalg.norm(position, axis=1, keepdims=True)
    corners = position[mesh.indices.reshape(-1, 3)]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    seen = np.unique(mesh.indices.reshape(-1, 3)[area > 1e-9])  # at the poles are triangles of no area
    assert (normal * outward).sum(axis=1)[seen].min() > 0.99, "smooth again, all round"
