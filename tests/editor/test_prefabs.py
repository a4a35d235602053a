"""Prefabs: made, placed, changed here and there, reverted, applied, in each other, through a crash, and headless."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from real_session import opened, real_session
from small_scene import write_small_scene
from small_source import write_small_source

from editor import journal, prefab_updates, prefab_values, prefabs, recovering, saving
from editor.builtin_operations import builtin_operations
from editor.commands import structure
from editor.session import Session
from engine.app.runtime import Runtime
from engine.assets.material_toml import read_material
from engine.assets.prefab import FIELDS, file_of, has_instances, load_prefab, refresh
from engine.assets.scene import MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import format_scene, read_scene, write_scene
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.gpu import open_device


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    root = tmp_path / "game"
    write_small_scene(root / "scenes")
    (root / "project.toml").write_text('[project]\nname = "Game"\nstart = "scenes/boxes.scene.json"\n')
    return root


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    session = real_session(tmp_path / "recovery")
    yield session
    session.sources.stop()
    session.close_all()


def names(document: Any) -> list[str]:
    nodes = document.runtime.scene.nodes
    return [str(nodes.name[r]) for r in range(len(nodes.name)) if nodes.alive[r]]


def row(document: Any, name: str, nth: int = 0) -> int:
    nodes = document.runtime.scene.nodes
    return [r for r in range(len(nodes.name)) if nodes.alive[r] and nodes.name[r] == name][nth]


def made(session: Session, project: Path) -> Path:
    """The stage of the small scene as a prefab."""
    document = opened(session, project / "scenes/boxes.scene.json")
    document.select(row(document, "stage"))
    assert prefabs.make(session), session.ui.error_bar
    return project / "prefabs/stage.scene.json"


def look_now(session: Session) -> None:
    session.prefabs_at = 0.0
    session.poll()


def test_a_selection_becomes_a_file_and_an_instance_of_it(session: Session, project: Path) -> None:
    document = opened(session, project / "scenes/boxes.scene.json")
    before = names(document)
    world = document.runtime.scene.nodes.world_matrix(row(document, "cube"))
    target = made(session, project)
    assert [n.name for n in read_scene(target).nodes] == ["stage", "plinth", "cube", "lamp"]
    assert np.allclose(document.runtime.scene.nodes.world_matrix(row(document, "cube")), world, atol=1e-12)
    assert prefab_values.changes(document, document.primary) == ({}, [])
    alone = Runtime(open_device("null"))
    alone.open(target)
    assert not alone.findings.items, "its files are found from where it lies"
    assert int(alone.scene.instances.drawn.sum()) == 2
    alone.close()
    session.undo()
    assert names(document) == before
    session.redo()
    assert prefabs.root_of(document, row(document, "lamp")) == row(document, "stage 2")


def test_a_prefab_of_one_node_keeps_its_size_and_leaves_its_place_to_the_instance(
    session: Session, project: Path
) -> None:
    document = opened(session, project / "scenes/boxes.scene.json")
    plinth = row(document, "plinth")
    world = document.runtime.scene.nodes.world_matrix(plinth)
    document.select(plinth)
    assert prefabs.make(session), session.ui.error_bar
    alone = read_scene(project / "prefabs/plinth.scene.json").nodes[0]
    assert (alone.translation, alone.rotation, alone.scale) == ((0.0,) * 3, (0.0, 0.0, 0.0, 1.0), (2.0, 0.2, 2.0))
    assert np.allclose(document.runtime.scene.nodes.world_matrix(plinth), world, atol=1e-12)


def test_instances_keep_what_is_their_own_and_follow_the_rest(session: Session, project: Path) -> None:
    target = made(session, project)
    document = session.document
    assert document is not None
    matrix = np.eye(4)
    matrix[:3, 3] = (5.0, 0.0, 0.0)
    assert prefabs.place(session, target, matrix), session.ui.error_bar
    assert document.runtime.scene.instances.drawn.sum() == 4
    second = row(document, "cube", 1)
    session.edit("nodes", "translation", (second,), ((0.0, 7.0, 0.0),))
    assert prefab_values.changes(document, document.primary)[0] == {"stage/cube": ["place"]}
    assert session.save()
    prefab = read_scene(target)
    prefab.nodes[2].translation = (0.0, 1.0, 0.0)
    prefab.nodes[1].visible = False
    prefab.nodes.append(NodeAsset("flag", 0))
    write_scene(target, prefab)
    look_now(session)
    assert "changed" in session.ui.notice
    nodes = document.runtime.scene.nodes
    assert nodes.translation[row(document, "cube")].tolist() == [0.0, 1.0, 0.0]
    assert nodes.translation[row(document, "cube", 1)].tolist() == [0.0, 7.0, 0.0], "its own"
    assert not nodes.visible[row(document, "plinth")]
    assert not nodes.visible[row(document, "plinth", 1)]
    assert names(document).count("flag") == 2
    headless = Runtime(open_device("null"))
    headless.open(project / "scenes/boxes.scene.json")
    assert sorted(n for n in headless.scene.nodes.name if n) == sorted(names(document)), (
        "the command line sees the same"
    )
    at = [i for i, n in enumerate(headless.scene.nodes.name) if n == "cube"]
    assert headless.scene.nodes.translation[at].tolist() == [[0.0, 1.0, 0.0], [0.0, 7.0, 0.0]]
    headless.close()
    session.undo()
    assert "flag" not in names(document)
    session.undo()
    assert document.runtime.scene.nodes.translation[row(document, "cube", 1)].tolist() == [0.0, 0.0, 0.0]


def test_revert_and_apply(session: Session, project: Path) -> None:
    target = made(session, project)
    document = session.document
    assert document is not None
    assert prefabs.place(session, target, np.eye(4))
    text = target.read_text()
    session.edit("nodes", "translation", (row(document, "cube", 1),), ((0.0, 7.0, 0.0),))
    session.edit("lights", "intensity", (1,), (99.0,))
    session.edit("materials", "roughness", (0,), (0.125,))
    document.select(row(document, "cube", 1))
    ops = builtin_operations()
    assert ops.run("prefab.revert", session)
    lights = document.runtime.scene.lights
    assert document.runtime.scene.nodes.translation[row(document, "cube", 1)].tolist() == [0.0, 0.0, 0.0]
    assert [lights.asset(i).intensity for i in lights.alive_rows()] == [8.0, 8.0]
    assert document.runtime.residency.material(0).asset.params["roughness"] == 0.125, "unsaved, and no part of it"
    session.undo()
    document.select(row(document, "cube", 1))
    assert ops.run("prefab.apply", session)
    lights = document.runtime.scene.lights
    assert document.runtime.scene.nodes.translation[row(document, "cube")].tolist() == [0.0, 7.0, 0.0]
    assert [lights.asset(i).intensity for i in lights.alive_rows()] == [99.0, 99.0]
    assert read_scene(target).nodes[2].translation == (0.0, 7.0, 0.0)
    session.undo()
    assert target.read_text() == text
    look_now(session)
    assert document.history.redo_label, "what undo put back is no change of its own"


def test_prefabs_in_prefabs_and_circles(session: Session, project: Path) -> None:
    inner = made(session, project)
    write_scene(project / "prefabs/empty.scene.json", SceneAsset("empty", [NodeAsset("spot")]))
    outer = opened(session, project / "prefabs/empty.scene.json")
    assert prefabs.place(session, inner, np.eye(4)), session.ui.error_bar
    assert session.save()
    assert not prefabs.place(session, project / "prefabs/empty.scene.json", np.eye(4))
    assert "cannot stand in itself" in session.ui.error_bar
    level = project / "scenes/level.scene.json"
    write_scene(level, SceneAsset("level"))
    document = opened(session, level)
    assert prefabs.place(session, project / "prefabs/empty.scene.json", np.eye(4)), session.ui.error_bar
    assert [n for n in names(document) if n in ("spot", "cube", "lamp")] == ["spot", "cube", "lamp"]
    assert session.save()
    data = read_scene(inner)
    data.nodes[2].name = "die"
    write_scene(inner, data)
    assert "die" in [n.name for n in load_prefab(project / "prefabs/empty.scene.json").nodes]
    look_now(session)
    assert "die" in names(document)
    assert outer is not document
    data.nodes.append(NodeAsset("loop", 0, extras={"prefab": {"file": "empty.scene.json"}}))
    write_scene(inner, data)
    with pytest.raises(InputError, match=r"stage\.scene\.json -> empty\.scene\.json -> stage\.scene\.json"):
        load_prefab(inner)


def test_a_lost_prefab_is_a_finding_and_the_instance_stays(session: Session, project: Path) -> None:
    target = made(session, project)
    assert session.save()
    target.unlink()
    findings = Findings("x")
    asset = read_scene(project / "scenes/boxes.scene.json")
    assert has_instances(asset)
    again = refresh(asset, project / "scenes", findings)
    assert [n.name for n in again.nodes] == [n.name for n in asset.nodes]
    assert [f.code for f in findings.items] == ["prefab.unreadable"]


def test_sources_are_converted_into_the_project_and_placed(session: Session, project: Path) -> None:
    source = write_small_source(project / "assets/crate.gltf")
    document = opened(session, project / "scenes/boxes.scene.json")
    assert builtin_operations().run("prefab.place", session, path=source, at=(1.0, 2.0, 3.0))
    assert not session.ui.error_bar
    assert (project / "prefabs/crate/crate.scene.json").is_file()
    assert document.runtime.scene.nodes.world_matrix(document.primary)[:3, 3].tolist() == [1.0, 2.0, 3.0]
    assert session.save()
    saved = read_scene(project / "scenes/boxes.scene.json")
    mesh = next(n.mesh for n in saved.nodes if n.name == "crate" and n.mesh is not None)
    assert isinstance(mesh, MeshRef)
    assert mesh.file == "../prefabs/crate/crate.lmesh"


def test_another_prefab_of_a_source_leaves_the_files_of_the_first_as_they_are(session: Session, project: Path) -> None:
    source = write_small_source(project / "assets/crate.gltf")
    document = opened(session, source)
    document.select(row(document, "crate"))
    first, second = project / "prefabs/first.scene.json", project / "prefabs/second.scene.json"
    assert prefabs.make(session, first), session.ui.error_bar
    wood = project / "prefabs/crate.wood.material.toml"
    wood.write_text(wood.read_text().replace("0.6", "0.2"))
    assert prefabs.make(session, second), session.ui.error_bar
    assert "0.2" in wood.read_text(), "what was said of the first one's material"
    for path, roughness in ((first, 0.2), (second, 0.6)):
        mesh = next(n.mesh for n in read_scene(path).nodes if n.mesh is not None)
        assert (path.parent / mesh.file).is_file()
        assert read_material(path.parent / mesh.materials[0]).params["roughness"] == roughness


def test_placed_instances_survive_a_crash(session: Session, project: Path, tmp_path: Path) -> None:
    target = made(session, project)
    document = session.document
    assert document is not None
    assert prefabs.place(session, target, np.eye(4))
    session.edit("nodes", "translation", (row(document, "cube", 1),), ((0.0, 7.0, 0.0),))
    source = write_small_source(project / "assets/crate.gltf")
    assert prefabs.place(session, source, np.eye(4))
    session.undo()
    session.redo()
    expected = names(document), int(document.runtime.scene.instances.drawn.sum())
    recovering.leave(session)
    again = real_session()
    (left,) = journal.pending(tmp_path / "recovery")
    assert recovering.recover(again, left), again.ui.error_bar
    found = again.document
    assert found is not None
    assert (names(found), int(found.runtime.scene.instances.drawn.sum())) == expected
    assert prefabs.root_of(found, row(found, "cube", 1)) >= 0
    assert prefab_values.changes(found, prefabs.root_of(found, row(found, "cube", 1)))[0] == {"stage/cube": ["place"]}
    again.close_all()


def test_every_field_has_one_owner() -> None:
    owned = [name for names_ in FIELDS.values() for name in names_]
    assert len(owned) == len(set(owned))
    assert not file_of(NodeAsset("plain"))


def crashed(session: Session, recovery: Path) -> Any:
    """The document as a new session restores it; the old one writes nothing any more, as if it had been killed."""
    expected = _all_of(session.document)
    recovering.leave(session)
    again = real_session()
    (left,) = journal.pending(recovery)
    assert recovering.recover(again, left), again.ui.error_bar
    assert _all_of(again.document) == expected
    return again


def _all_of(document: Any) -> tuple[str, bool]:
    return format_scene(saving.current_scene(document)), document.dirty


def test_edits_after_an_undone_prefab_update_survive_a_crash(session: Session, project: Path, tmp_path: Path) -> None:
    made(session, project)
    document = session.document
    assert document is not None
    session.edit("nodes", "translation", (row(document, "cube"),), ((1.0, 2.0, 3.0),))
    document.select(row(document, "stage"))
    operations = builtin_operations()
    assert operations.run("view.set-bookmark-2", session)
    assert operations.run("prefab.apply", session)
    assert sorted(document.bookmarks) == [2], "another scene stands there, and the places of the camera stay"
    assert operations.run("view.set-bookmark-3", session)
    session.undo()
    session.edit("nodes", "translation", (row(document, "cube"),), ((4.0, 2.0, 3.0),))
    session.undo()
    session.undo()
    structure.delete(document, (row(document, "lamp"),))
    structure.duplicate(document, (row(document, "cube"),))
    session.edit("nodes", "name", (document.primary,), ("late",))
    session.undo()
    session.redo()
    again = crashed(session, tmp_path / "recovery")
    for _ in range(10):
        again.undo()
        session.undo()
        if again.document.history.entries:
            assert _all_of(again.document) == _all_of(document)
    assert not again.document.history.entries
    again.close_all()


def test_a_prefab_that_was_saved_since_comes_in_after_the_edits_are_restored(
    session: Session, project: Path, tmp_path: Path
) -> None:
    target = made(session, project)
    document = session.document
    assert document is not None
    assert session.save()
    assert prefabs.place(session, target, np.eye(4))
    cube = row(document, "cube", 1)
    session.edit("nodes", "translation", (cube,), ((0.0, 7.0, 0.0),))
    session.edit("nodes", "visible", (row(document, "cube", 0),), (False,))
    prefab = read_scene(target)
    prefab.nodes.insert(0, NodeAsset("first", -1))
    for node in prefab.nodes[1:]:
        node.parent += 1 if node.parent >= 0 else 0
        node.joints = [j + 1 for j in node.joints]
    write_scene(target, prefab)
    again = crashed(session, tmp_path / "recovery")
    found = again.document
    prefab_updates.poll(again)
    assert names(found).count("first") == 2, "what the prefab says now came in"
    nodes = found.runtime.scene.nodes
    places = [
        nodes.translation[r].tolist() for r in range(len(nodes.name)) if nodes.alive[r] and nodes.name[r] == "cube"
    ]
    assert [0.0, 7.0, 0.0] in places
    hidden = [r for r in range(len(nodes.name)) if nodes.alive[r] and nodes.name[r] == "cube" and not nodes.visible[r]]
    assert len(hidden) == 1
    again.close_all()


def test_a_session_that_dies_again_restores_what_the_first_one_did(
    session: Session, project: Path, tmp_path: Path
) -> None:
    made(session, project)
    document = session.document
    assert document is not None
    session.edit("nodes", "translation", (row(document, "cube"),), ((1.0, 2.0, 3.0),))
    document.select(row(document, "stage"))
    assert builtin_operations().run("prefab.apply", session)
    assert document.dirty
    again = crashed(session, tmp_path / "recovery")
    again.recovery_folder = tmp_path / "second"
    recovering.start(again, again.document)
    again.document.history.mark_unsaved()
    crashed(again, tmp_path / "second").close_all()
    again.close_all()
