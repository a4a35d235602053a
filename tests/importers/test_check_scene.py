"""`lucarna check`'s numeric part: each planted mistake gives its one finding, a sound scene none."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.assets.clip import Channel, ClipAsset
from engine.assets.lmesh import write_lmesh
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.material_toml import write_material
from engine.assets.mesh import MeshAsset, MorphTarget, Skeleton
from engine.assets.primitives import cube, mesh_from_arrays, uv_sphere
from engine.assets.scene import CameraAsset, EnvironmentAsset, LightAsset, MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import write_scene
from engine.core.findings import Finding, Findings, Severity
from engine.report.image import save_exr
from importers.checks.files import check_file
from importers.checks.light_inside import is_inside
from importers.checks.mesh import check_mesh_numbers
from importers.checks.scene import SceneParts, check_scene_numbers
from importers.cli.main import main
from importers.settings import ImportSettings


def sound() -> SceneParts:
    nodes = [
        NodeAsset("body"),
        NodeAsset("lamp", translation=(0.0, 3.0, 0.0), light=LightAsset("point")),
        NodeAsset("eye", translation=(0.0, 0.0, 5.0), camera=CameraAsset()),
    ]
    material = MaterialAsset("paint", params={"roughness": 0.4, "base_color": (0.5, 0.5, 0.5, 1.0)})
    times = np.array([0.0, 1.0], np.float32)
    clip = ClipAsset("move", [Channel(0, "translation", "linear", times, np.zeros((2, 3), np.float32))])
    return SceneParts(SceneAsset("scene", nodes), [uv_sphere(), None, None], {"paint": material}, {"move": clip})


def check(parts: SceneParts) -> list[Finding]:
    findings = Findings("scene")
    check_scene_numbers(parts, findings)
    return list(findings)


def node(index: int, **values: object) -> Callable[[SceneParts], None]:
    def change(parts: SceneParts) -> None:
        for name, value in values.items():
            setattr(parts.scene.nodes[index], name, value)

    return change


def mesh(stream: str, value: float) -> Callable[[SceneParts], None]:
    def change(parts: SceneParts) -> None:
        parts.meshes[0].streams[stream][3] = value  # type: ignore[index, union-attr]  # a float or int array

    return change


def param(name: str, value: object) -> Callable[[SceneParts], None]:
    def change(parts: SceneParts) -> None:
        parts.materials["paint"].params[name] = value

    return change


def keys(times: list[float], bad: float = 0.0) -> Callable[[SceneParts], None]:
    def change(parts: SceneParts) -> None:
        channel = parts.clips["move"].channels[0]
        channel.times = np.array(times, np.float32)
        channel.values = np.zeros((len(times), 3), np.float32)
        channel.values[0, 0] = bad

    return change


def morph(value: float) -> Callable[[SceneParts], None]:
    def change(parts: SceneParts) -> None:
        made = parts.meshes[0]
        assert made is not None
        offsets = np.zeros((made.vertex_count, 3), np.float32)
        offsets[2, 1] = value
        made.morphs.append(MorphTarget("smile", {"position": offsets}))

    return change


def mesh_at(distance: float) -> Callable[[SceneParts], None]:
    def change(parts: SceneParts) -> None:
        made = parts.meshes[0]
        assert made is not None
        made.streams["position"] = (made.streams["position"] + np.float32([distance, 0.0, 0.0])).astype(np.float32)

    return change


def beside(scale: float) -> Callable[[SceneParts], None]:
    def change(parts: SceneParts) -> None:
        parts.scene.nodes.append(NodeAsset("speck", translation=(2.0, 0.0, 0.0), scale=(scale,) * 3))
        parts.meshes = [*parts.meshes, parts.meshes[0]]

    return change


def turning(length: float) -> Callable[[SceneParts], None]:
    def change(parts: SceneParts) -> None:
        channel = parts.clips["move"].channels[0]
        channel.path, channel.values = "rotation", np.float32([[0, 0, 0, 1], [0, 0, 0, length]])

    return change


def test_a_sound_scene_gives_no_finding() -> None:
    assert check(sound()) == []


@pytest.mark.parametrize(
    ("change", "code", "severity", "place", "name"),
    [
        (node(0, translation=(math.nan, 0.0, 0.0)), "number.transform", "error", "nodes[0].translation", "body"),
        (node(0, scale=(math.inf, 1.0, 1.0)), "number.transform", "error", "nodes[0].scale", "body"),
        (node(0, rotation=(0.0, 0.0, 0.0, 0.0)), "number.rotation", "error", "nodes[0].rotation", "body"),
        (node(0, rotation=(0.0, 0.0, 0.0, 2.0)), "number.rotation", "warning", "nodes[0].rotation", "body"),
        (node(0, scale=(1.0, 0.0, 1.0)), "number.scale-zero", "warning", "nodes[0].scale", "body"),
        (node(0, scale=(1.0, 1e-9, 1.0)), "number.flat", "warning", "nodes[0]", "body"),
        (node(0, scale=(1e-5, 1e-5, 1e-5)), "number.units", "warning", "nodes", "m across"),
        (node(0, scale=(1e7, 1e7, 1e7)), "number.units", "warning", "nodes", "m across"),
        (node(0, scale=(3e3, 3e3, 3e3)), "number.units", "info", "nodes", "suspicious scale"),
        (node(0, scale=(2e-3, 2e-3, 2e-3)), "number.units", "info", "nodes", "suspicious scale"),
        (node(0, scale=(1e300, 1e300, 1e300)), "number.scale", "error", "nodes[0]", "body"),
        (node(1, translation=(0.1, 0.1, 0.0)), "number.light-inside", "warning", "nodes[1].light", "lamp"),
        (node(1, light=LightAsset("point", intensity=-1.0)), "light.range-of-value", "warning", "nodes[1].light", ""),
        (node(2, camera=CameraAsset(znear=1e-7)), "number.depth-range", "warning", "nodes[2].camera.znear", "eye"),
        (node(2, camera=CameraAsset(znear=0.001, zfar=1e6)), "number.depth-range", "warning", "nodes[2].camera", "eye"),
        (node(2, camera=CameraAsset(znear=100.0)), "number.near", "warning", "nodes[2].camera.znear", "eye"),
        (mesh("position", math.nan), "number.position", "error", "nodes[0].mesh.position", "sphere"),
        (mesh("uv0", math.inf), "number.uv", "error", "nodes[0].mesh.uv0", "sphere"),
        (mesh("normal", 0), "number.normal", "warning", "nodes[0].mesh.normal", "sphere"),
        (mesh("tangent", 0), "number.tangent", "warning", "nodes[0].mesh.tangent", "sphere"),
        (param("roughness", 0.0), "number.roughness", "info", "paint.params.roughness", "paint"),
        (param("roughness", -1.0), "number.material", "error", "paint.params.roughness", "paint"),
        (param("base_color", (math.nan, 0, 0, 1)), "number.material", "error", "paint.params.base_color", "paint"),
        (node(0, weights=[0.5, math.nan]), "number.morph-weight", "error", "nodes[0].weights", "body"),
        (node(0, weights=[1e30]), "number.morph-weight", "error", "nodes[0].weights", "body"),
        (morph(math.inf), "number.morph", "error", "nodes[0].mesh.morphs[0].position", "smile"),
        (mesh_at(1e6), "number.far-origin", "warning", "nodes[0].mesh.position", "sphere"),
        (beside(1e-9), "number.speck", "warning", "nodes[3]", "speck"),
        (turning(0.5), "number.clip-rotation", "warning", "move.channels[0].values", "move"),
        (keys([0.0, 0.0]), "clip.order", "warning", "move.channels[0]", "move"),
        (keys([1.0, 0.5]), "clip.order", "warning", "move.channels[0]", "move"),
        (keys([0.0, 1.0], math.nan), "clip.finite", "warning", "move.channels[0]", "move"),
    ],
)  # fmt: skip
def test_each_mistake_is_found_with_its_place_and_a_remedy(
    change: Callable[[SceneParts], None], code: str, severity: str, place: str, name: str
) -> None:
    parts = sound()
    change(parts)
    found = [f for f in check(parts) if f.code == code]
    assert len(found) == 1
    assert found[0].severity == Severity(severity)
    assert found[0].where.path.startswith(place)
    assert name in found[0].message
    assert found[0].hint


def test_a_mistake_is_not_found_twice() -> None:
    """A mesh on many nodes is looked at once."""
    parts = sound()
    mesh("normal", 0)(parts)
    parts.scene.nodes.append(NodeAsset("again", translation=(2.0, 0.0, 0.0)))
    parts.meshes = [*parts.meshes, parts.meshes[0]]
    assert [f.code for f in check(parts)] == ["number.normal"]


def test_zero_area_triangles() -> None:
    flat = mesh_from_arrays(
        "flat", [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)], [(0, 0, 1)] * 4, [(1, 0, 0, 1)] * 4, [(0, 0)] * 4,
        [0, 1, 2, 0, 1, 3],
    )  # fmt: skip
    findings = Findings()
    check_mesh_numbers(flat, "meshes[0]", findings)
    assert [f.code for f in findings] == ["number.zero-area"]
    assert "1 of 2" in findings.items[0].message


def skinned(weights: list[int], bind: float) -> MeshAsset:
    base = cube()
    count = base.vertex_count
    inverse = np.tile(np.eye(4, dtype=np.float32), (2, 1, 1))
    inverse[1, :3, :3] *= 1e-4  # sound, if small
    inverse[1, 0, 0] *= bind
    joints = np.zeros((count, 4), np.uint16)
    streams = {**base.streams, "joints": joints, "weights": np.tile(np.array(weights, np.uint16), (count, 1))}
    return replace(base, streams=streams, skeleton=Skeleton(["a", "b"], np.array([-1, 0], np.int32), inverse))


@pytest.mark.parametrize(
    ("weights", "bind", "codes"),
    [
        ([65535, 0, 0, 0], 1.0, []),
        ([40000, 25535, 0, 0], 1.0, []),
        ([40000, 0, 0, 0], 1.0, ["number.weights"]),
        ([0, 0, 0, 0], 1.0, ["number.weights"]),
        ([65535, 0, 0, 0], 0.0, ["number.bind"]),
    ],
)
def test_skins(weights: list[int], bind: float, codes: list[str]) -> None:
    findings = Findings()
    check_mesh_numbers(skinned(weights, bind), "meshes[0]", findings)
    assert [f.code for f in findings] == codes


def test_inside_and_outside() -> None:
    pose = np.diag([2.0, 2.0, 2.0, 1.0])
    pose[:3, 3] = (10.0, 0.0, 0.0)
    ball, room = uv_sphere(), cube()
    assert is_inside(np.array([10.0, 0.1, 0.2]), ball, pose)
    assert not is_inside(np.array([12.0, 0.0, 0.0]), ball, pose)
    assert not is_inside(np.array([10.9, 0.9, 0.9]), ball, pose)  # in the box, beside the ball
    inward = replace(room, indices=room.indices.reshape(-1, 3)[:, ::-1].reshape(-1).copy())
    assert is_inside(np.array([10.0, 0.0, 0.0]), room, pose)
    assert not is_inside(np.array([10.0, 0.0, 0.0]), inward, pose)  # a lamp in a room
    half = replace(ball, indices=ball.indices[: len(ball.indices) // 2])
    assert not is_inside(np.array([10.0, -0.2, 0.0]), half, pose)  # under a dome


def write(folder: Path, roughness: float, scale: float) -> Path:
    write_lmesh(folder / "ball.lmesh", [uv_sphere()])
    write_material(folder / "paint.material.toml", MaterialAsset("paint", params={"roughness": roughness}))
    ref = MeshRef("ball.lmesh", 0, "sphere", ["paint.material.toml"])
    write_scene(folder / "s.scene.json", SceneAsset("s", [NodeAsset("ball", scale=(1.0, 1.0, scale), mesh=ref)]))
    return folder / "s.scene.json"


def test_the_command_fails_for_errors_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(write(tmp_path, 0.0, 0.0))]) == 0
    out = capsys.readouterr().out
    assert "'ball'" in out
    assert "flattens" in out
    assert "roughness 0" in out
    assert main(["check", "--json", str(write(tmp_path, -1.0, 1.0))]) == 1
    report = json.loads(capsys.readouterr().out)[0]
    assert [f["code"] for f in report["findings"] if f["severity"] == "error"] == ["number.material"]


def test_a_mesh_and_a_material_by_themselves(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(tmp_path, 0.0, 1.0)
    bad = cube()
    bad.streams["position"] = bad.streams["position"].copy()
    bad.streams["position"][3] = math.nan
    write_lmesh(tmp_path / "bad.lmesh", [cube(), bad])
    assert main(["check", str(tmp_path / "bad.lmesh"), str(tmp_path / "paint.material.toml")]) == 1
    said = capsys.readouterr()
    assert "meshes[1].position: mesh 'cube': 1 positions are not finite" in said.err
    assert " params.roughness: material 'paint'" in said.out


def test_names_that_the_effect_lacks(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "paint.material.toml"
    write_material(file, MaterialAsset("paint", params={"rugness": 0.5}, textures={"base_map": TextureRef("a.dds")}))
    main(["check", str(file)])
    said = capsys.readouterr().out
    assert "params.rugness: material 'paint': the effect 'surface' has no parameter 'rugness'" in said
    assert "did you mean 'roughness'?" in said
    assert "textures.base_map: material 'paint': the effect 'surface' has no texture 'base_map'" in said


def test_texels_of_an_environment_that_are_no_light(tmp_path: Path) -> None:
    sky = np.full((16, 32, 3), 0.5, np.float32)
    sky[3, 4, 1], sky[5, 6, 0] = math.nan, -1.0
    save_exr(tmp_path / "sky.exr", sky)
    look = EnvironmentAsset("image", "sky.exr")
    write_scene(tmp_path / "s.scene.json", SceneAsset("s", [NodeAsset("a")], environment=look))
    for name, place in (("sky.exr", ""), ("s.scene.json", "environment.path")):
        found = [f for f in check_file(tmp_path / name, ImportSettings()) if f.code == "number.texel"]
        assert [f.where.path for f in found] == [place]
        assert "2 texels of 'sky.exr'" in found[0].message
        assert found[0].hint
