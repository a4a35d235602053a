"""`lucarna inspect --json`: the same object for a source and for what it is converted to."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from importers.cli.main import main
from tests.support.gltf_builder import GltfBuilder, textured_triangle, triangle

Capture = pytest.CaptureFixture[str]
KEYS = {"file", "kind", "meshes", "clips", "materials", "textures", "nodes", "lights", "cameras", "findings"}


def inspect(path: Path, capsys: Capture, *flags: str) -> dict[str, Any]:
    main(["inspect", str(path), "--json", *flags])
    data: dict[str, Any] = json.loads(capsys.readouterr().out)
    return data


def rich() -> GltfBuilder:
    """A triangle shown twice, moved and turned; a camera, a light, a clip."""
    b = textured_triangle()
    b.root["meshes"][0]["name"] = "tri"
    b.root["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]
    b.root["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 5}]}}
    b.root["extensionsUsed"] = ["KHR_lights_punctual"]
    b.root["nodes"] = [
        {"name": "root", "children": [1, 2, 3, 4]},
        {"name": "left", "mesh": 0, "translation": [-10, 0, 0]},
        {"name": "right", "mesh": 0, "scale": [2, 2, 2], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]},
        {"name": "eye", "camera": 0},
        {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]
    b.root["scenes"] = [{"nodes": [0]}]
    sampler = {"input": b.accessor([0, 2]), "output": b.accessor([[0, 0, 0], [1, 0, 0]])}
    channel = {"sampler": 0, "target": {"node": 1, "path": "translation"}}
    b.root["animations"] = [{"name": "go", "samplers": [sampler], "channels": [channel]}]
    return b


def test_the_object_of_a_source_and_of_its_scene(tmp_path: Path, capsys: Capture) -> None:
    source = rich().write_glb(tmp_path / "a.glb")
    main(["convert", str(source), "--out", str(tmp_path / "out"), "--quiet"])
    capsys.readouterr()
    before, after = inspect(source, capsys), inspect(tmp_path / "out" / "a.scene.json", capsys)
    assert set(before) == set(after) == KEYS
    assert (before["kind"], after["kind"]) == ("source", "scene")
    for data in (before, after):
        mesh = data["meshes"][0]
        assert (mesh["name"], mesh["vertices"], mesh["triangles"], mesh["joints"]) == ("tri", 3, 1, 0)
        # the corners (0,0), (1,0), (0,1): at -10, and doubled and turned a quarter to the left
        np.testing.assert_allclose(mesh["bounds"], [[-10, 0, 0], [0, 2, 0]], atol=1e-6)
        clip = data["clips"][0]
        assert (clip["name"], clip["duration"], clip["tracks"]) == ("go", 2.0, 1)
        assert data["materials"][0]["name"] == "paint"
        assert sorted(data["materials"][0]["textures"]) == ["base_color_map", "normal_map"]
        assert [texture["size"] for texture in data["textures"]] == [[4, 4], [4, 4]]
        assert [node["name"] for node in data["nodes"]] == ["root", "left", "right", "eye", "lamp"]
        assert data["nodes"][1] == {"name": "left", "parent": 0, "mesh": "tri"}
        assert [(light["name"], light["type"]) for light in data["lights"]] == [("lamp", "point")]
        assert [(camera["name"], camera["type"]) for camera in data["cameras"]] == [("eye", "perspective")]
        assert data["findings"] == []


def test_findings_have_a_place_and_a_remedy(tmp_path: Path, capsys: Capture) -> None:
    b = textured_triangle()
    b.root["images"][0] = {"uri": "gone.png"}
    source = b.write_gltf(tmp_path / "a.gltf")
    found = inspect(source, capsys)["findings"]
    assert set(found[0]) == {"severity", "where", "message", "remedy"}
    assert (found[0]["severity"], found[0]["where"]) == ("error", "images[0].uri")
    assert found[0]["remedy"]


def test_every_engine_file_has_the_same_keys(tmp_path: Path, capsys: Capture) -> None:
    source = rich().write_glb(tmp_path / "a.glb")
    main(["convert", str(source), "--out", str(tmp_path / "out"), "--quiet"])
    capsys.readouterr()
    kinds = {}
    for path in sorted((tmp_path / "out").iterdir()):
        if path.is_file():
            data = inspect(path, capsys)
            assert set(data) == KEYS, path
            kinds[path.name.split(".", 1)[1]] = data["kind"]
    assert set(kinds.values()) == {"scene", "mesh", "clip", "material", "texture"}
    loose = inspect(tmp_path / "out" / "a.lmesh", capsys)["meshes"][0]
    np.testing.assert_allclose(loose["bounds"], [[0, 0, 0], [1, 1, 0]], atol=1e-6)
    details = inspect(tmp_path / "out" / "a.lmesh", capsys, "--details")["details"]
    assert details["provenance"]["source"] == "a.glb"


def test_a_skin_is_measured_where_its_joints_put_it(shared_assets: Path, capsys: Capture) -> None:
    man = inspect(shared_assets / "gltf" / "CesiumMan" / "glTF-Binary" / "CesiumMan.glb", capsys)["meshes"][0]
    low, high = np.array(man["bounds"])
    assert 1.4 < high[1] - low[1] < 1.6  # he stands, +Y up, 1.5 m tall
    assert man["joints"] == 19
    assert man["triangles"] == 4672


def test_a_mesh_of_nans_and_one_without_a_node(tmp_path: Path, capsys: Capture) -> None:
    b = triangle([[0, 0, 0], [4, 0, 0], [0, 5, 0]])
    b.root["nodes"] = [{"name": "empty"}]
    mesh = inspect(b.write_glb(tmp_path / "a.glb"), capsys)["meshes"]
    if mesh:  # a mesh that no node shows may be left out by the reader
        np.testing.assert_allclose(mesh[0]["bounds"], [[0, 0, 0], [4, 5, 0]], atol=1e-6)


def test_text_for_people(tmp_path: Path, capsys: Capture) -> None:
    assert main(["inspect", str(rich().write_glb(tmp_path / "a.glb"))]) == 0
    text = capsys.readouterr().out
    assert "meshes: 1" in text
    assert "nodes: count 5, with a mesh 2" in text
    assert "triangles: 1" in text
