"""Three-way merges of scenes and materials: who changed what, what wins, what has no place any more."""

from __future__ import annotations

import copy
from pathlib import Path

import pytest

from engine.assets.lmesh import write_lmesh
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.material_toml import read_material, write_material
from engine.assets.primitives import cube
from engine.assets.scene import LightAsset, MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import read_scene, write_scene
from importers.reimport.merge import Report, merge_value
from importers.reimport.merge_material import changes, merge_material
from importers.reimport.merge_scene import merge_scene
from importers.reimport.merging import merge_import
from importers.reimport.record import of_import, read_record, write_record


def scene() -> SceneAsset:
    mesh = MeshRef("x.lmesh", 0, "box", ["x.wood.material.toml"])
    return SceneAsset(
        "x",
        [
            NodeAsset("root"),
            NodeAsset("crate", 0, (1.0, 0.0, 0.0), mesh=mesh),
            NodeAsset("lamp", 0, light=LightAsset("point", intensity=5.0)),
            NodeAsset("lid", 1, mesh=copy.deepcopy(mesh)),
        ],
    )


def merged(base: SceneAsset, theirs: SceneAsset, ours: SceneAsset, origin: list[int]) -> tuple[SceneAsset, Report]:
    report = Report()
    result, keys = merge_scene(base, theirs, ours, origin, report)
    assert len(keys) == len(result.nodes)
    for index, node in enumerate(result.nodes):
        assert node.parent < index, "parents come first"
    return result, report


@pytest.mark.parametrize(
    ("base", "theirs", "ours", "expected", "told"),
    [(1, 1, 1, 1, ""), (1, 2, 1, 2, "taken"), (1, 1, 3, 3, "kept"), (1, 2, 3, 3, "conflicts"), (1, 2, 2, 2, "")],
)
def test_every_case_of_three_values(base: int, theirs: int, ours: int, expected: int, told: str) -> None:
    report = Report()
    assert merge_value(base, theirs, ours, "x", report) == expected
    lists = {n: len(getattr(report, n)) for n in ("taken", "kept", "conflicts", "orphans")}
    assert lists == {n: int(n == told) for n in lists}


def test_an_import_that_changed_nothing_leaves_the_users_scene(tmp_path: Path) -> None:
    base, ours = scene(), scene()
    ours.nodes[1].translation = (9.0, 0.0, 0.0)
    ours.nodes[2].light = LightAsset("point", intensity=7.0)
    ours.nodes.append(NodeAsset("mine", 3))
    result, report = merged(base, scene(), ours, [0, 1, 2, 3, -1])
    assert [n.name for n in result.nodes] == ["root", "crate", "lamp", "lid", "mine"]
    assert result.nodes[1].translation == (9.0, 0.0, 0.0)
    assert result.nodes[2].light == ours.nodes[2].light
    assert (report.taken, report.conflicts, report.orphans) == ([], [], [])


def test_both_sides_go_through_where_they_differ() -> None:
    base, theirs, ours = scene(), scene(), scene()
    theirs.nodes.insert(0, NodeAsset("new first"))
    for node in theirs.nodes[1:]:
        node.parent += 1 if node.parent >= 0 else 0
    theirs.nodes[2].translation = (2.0, 0.0, 0.0)
    theirs.nodes[3].light = LightAsset("point", intensity=6.0, range=3.0)
    ours.nodes[2].light = LightAsset("point", intensity=8.0)
    ours.nodes[3].visible = False
    result, report = merged(base, theirs, ours, [0, 1, 2, 3])
    by_name = {n.name: n for n in result.nodes}
    assert list(by_name) == ["new first", "root", "crate", "lamp", "lid"]
    assert by_name["crate"].translation == (2.0, 0.0, 0.0)
    light = by_name["lamp"].light
    assert light is not None
    assert (light.intensity, light.range) == (8.0, 3.0), "yours where both changed, theirs where only they did"
    assert not by_name["lid"].visible
    assert len(report.conflicts) == 1
    assert "intensity" in report.conflicts[0]


def test_parameters_of_one_object_stay_on_it() -> None:
    def scene(materials: list[str], overrides: list[dict[str, object]]) -> SceneAsset:
        return SceneAsset("s", [NodeAsset("box", mesh=MeshRef("m.lmesh", 0, "box", materials, overrides))])

    before, now = scene(["a", "b"], []), scene(["a"], [])
    report = Report()
    merged, _ = merge_scene(before, now, scene(["a", "b"], [{"roughness": 0.1}, {"metallic": 0.5}]), [0], report)
    assert merged.nodes[0].mesh is not None
    assert merged.nodes[0].mesh.overrides == [{"roughness": 0.1}]
    assert any("metallic of material slot 1, which is gone" in told for told in report.orphans)


def test_what_the_source_lost_is_told_with_what_you_had_done_to_it() -> None:
    base, theirs, ours = scene(), scene(), scene()
    del theirs.nodes[3], theirs.nodes[2]
    ours.nodes[2].light = LightAsset("point", intensity=8.0)
    ours.nodes.append(NodeAsset("mine", 3))
    result, report = merged(base, theirs, ours, [0, 1, 2, 3, -1])
    assert [n.name for n in result.nodes] == ["root", "crate", "mine"]
    assert result.nodes[2].parent == -1
    assert any("lamp" in line and "light intensity" in line for line in report.orphans)
    assert any("mine" in line for line in report.orphans)
    assert "root/crate/lid: gone" in report.taken, "nothing of yours was there"


def test_what_you_deleted_stays_deleted_and_what_you_hung_elsewhere_hangs_there() -> None:
    base, theirs, ours = scene(), scene(), scene()
    del ours.nodes[2]
    ours.nodes[2].parent = 0
    result, report = merged(base, theirs, ours, [0, 1, 3])
    assert [n.name for n in result.nodes] == ["root", "crate", "lid"]
    assert result.nodes[2].parent == 0
    assert any("lamp: deleted" in line for line in report.kept)


def test_copies_show_the_mesh_by_its_name_and_keep_moving_with_their_clips() -> None:
    base, theirs, ours = scene(), scene(), scene()
    for asset in (base, theirs, ours):
        asset.clips = ["x.walk.lanim"]
    for node in theirs.nodes:
        if node.mesh is not None:
            node.mesh.index = 3
    theirs.nodes.insert(1, NodeAsset("spacer", 0))
    theirs.nodes[4].parent = 2
    copied = copy.deepcopy(ours.nodes[1])
    copied.name, copied.clip_node, copied.placed = "crate 2", 1, True
    ours.nodes.append(copied)
    result, _ = merged(base, theirs, ours, [0, 1, 2, 3, -1])
    mine = result.nodes[-1]
    assert mine.mesh is not None
    assert (mine.name, mine.mesh.index, mine.clip_node) == ("crate 2", 3, 2)
    theirs.nodes = [n for n in theirs.nodes if n.mesh is None]
    result, report = merged(base, theirs, ours, [0, 1, 2, 3, -1])
    assert result.nodes[-1].mesh is None
    assert any("shows the mesh box" in line for line in report.orphans)


def test_materials_merge_parameter_by_parameter() -> None:
    base = MaterialAsset("wood", params={"roughness": 0.5, "metallic": 0.0}, features=["double_sided"])
    base.textures["base_color_map"] = TextureRef("a.dds")
    theirs, ours = copy.deepcopy(base), copy.deepcopy(base)
    theirs.params["metallic"], theirs.params["alpha_cutoff"] = 1.0, 0.25
    theirs.textures["normal_map"] = TextureRef("n.dds")
    theirs.features = []
    ours.params["roughness"] = 0.1
    ours.textures["base_color_map"] = TextureRef("mine.dds", scale=(2.0, 2.0))
    report = Report()
    result = merge_material(base, theirs, ours, report)
    assert result.params == {"roughness": 0.1, "metallic": 1.0, "alpha_cutoff": 0.25}
    assert {s: t.path for s, t in result.textures.items()} == {"base_color_map": "mine.dds", "normal_map": "n.dds"}
    assert result.features == []
    assert report.conflicts == []
    delta = changes(ours, result)
    assert set(delta) == {"features", "params.metallic", "params.alpha_cutoff", "textures.normal_map.path"} | {
        k for k in delta if k.startswith("textures.normal_map.")
    }


def imported(folder: Path, metallic: float, names: tuple[str, ...] = ("wood", "steel")) -> Path:
    folder.mkdir(parents=True)
    write_lmesh(folder / "x.lmesh", [cube()])
    nodes = []
    for name in names:
        write_material(folder / f"x.{name}.material.toml", MaterialAsset(name, params={"metallic": metallic}))
        nodes.append(NodeAsset(name, mesh=MeshRef("x.lmesh", 0, "cube", [f"x.{name}.material.toml"])))
    write_scene(folder / "x.scene.json", SceneAsset("x", nodes, provenance={"source_hash": f"{metallic}{names}"}))
    return folder / "x.scene.json"


def test_folders_merge_with_comments_and_unsaved_values_and_nothing_is_written_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    first, second = imported(tmp_path / "one", 0.0), imported(tmp_path / "two", 1.0, ("wood",))
    last = of_import(tmp_path / "x.glb", first, read_scene(first))
    saved = tmp_path / "saved"
    saved.mkdir()
    for path in first.parent.iterdir():
        (saved / path.name).write_bytes(path.read_bytes())
    wood = saved / "x.wood.material.toml"
    wood.write_text(wood.read_text() + "roughness = 0.25 # polished\n")
    write_record(saved / "x.scene.json", last)
    record = read_record(saved / "x.scene.json")
    assert record is not None
    assert (record.source, record.keys, record.materials) == (last.source, last.keys, last.materials)
    before = {p: p.read_bytes() for f in (first.parent, second.parent, saved) for p in f.iterdir()}
    unsaved = {(saved / "x.steel.material.toml").resolve(): {"params.roughness": 0.5}}
    scene_path, report = merge_import(record, second, read_scene(saved / "x.scene.json"), [0, 1], saved, unsaved)
    assert {p: p.read_bytes() for f in (first.parent, second.parent, saved) for p in f.iterdir()} == before
    text = (scene_path.parent / "x.wood.material.toml").read_text()
    assert "roughness = 0.25 # polished" in text
    assert read_material(scene_path.parent / "x.wood.material.toml").params["metallic"] == 1.0
    assert [n.name for n in read_scene(scene_path).nodes] == ["wood"]
    assert any("x.steel" in line and "roughness" in line for line in report.orphans)
    assert read_material(scene_path.parent / "x.steel.material.toml").params["roughness"] == 0.5, "kept as a file"
    again = read_record(scene_path)
    assert again is not None
    assert again.orphans == report.orphans
    assert again.materials["x.wood.material.toml"] == (second.parent / "x.wood.material.toml").read_text()
