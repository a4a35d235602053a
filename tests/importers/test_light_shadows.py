"""Which lights cast shadows: imported ones as their file says; kept in tables and files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from engine.assets.scene import LightAsset, NodeAsset, SceneAsset
from engine.assets.scene_json import read_scene, write_scene
from engine.scene.scene import Scene
from importers.registry import find_importer
from importers.settings import ImportSettings


def test_lamps_of_gltf_cast_none_until_asked(tmp_path: Path) -> None:
    """glTF has no word for it, and its lamps often stand in closed bulbs, which would swallow their light."""
    kinds = ("point", "spot", "directional")
    lights = [{"type": kind, **({"spot": {}} if kind == "spot" else {})} for kind in kinds]
    source = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
        "extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": lights}},
        "nodes": [{"extensions": {"KHR_lights_punctual": {"light": i}}} for i in range(3)],
    }  # fmt: skip
    path = tmp_path / "lamps.gltf"
    path.write_text(json.dumps(source))
    model = find_importer(path).load(path, ImportSettings())
    found = {node.light.type: node.light.casts_shadow for node in model.nodes if node.light is not None}
    assert found == {"point": False, "spot": False, "directional": False}


def test_tables_and_files_keep_it(tmp_path: Path) -> None:
    path = tmp_path / "a.scene.json"
    nodes = [NodeAsset(f"lamp {i}", light=LightAsset("spot", casts_shadow=bool(i))) for i in range(2)]
    write_scene(path, SceneAsset("a", nodes=nodes))
    kept = [node.light for node in read_scene(path).nodes]
    assert [light.casts_shadow for light in kept if light is not None] == [False, True]
    assert "casts_shadow" in path.read_text()
    scene = Scene("a")
    for light in kept:
        scene.lights.add(scene.nodes.add("lamp"), light)
    more = [scene.nodes.add("more"), scene.nodes.add("more")]
    rows = scene.lights.add_many(more, LightAsset("disk", casts_shadow=True))
    scene.update()
    assert [scene.lights.asset(i).casts_shadow for i in range(4)] == [False, True, True, True]
    world = scene.lights.world()
    assert np.array_equal(world["casts_shadow"], [False, True, True, True])
    scene.lights.set(int(rows[0]), type="point")
    assert scene.lights.world()["casts_shadow"].tolist() == [False, True, True, True]
