"""Saving: in place, out of the cache into a project, and what comes back. Real runtime, null device."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from small_scene import write_small_scene

from editor import saving
from editor.document import Document
from editor.host import EngineHost, Resolved
from editor.opening import resolve_path
from engine.assets.material_toml import read_material
from engine.assets.scene_json import read_scene
from engine.gpu import open_device


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def open_document(resolved: Resolved) -> Document:
    return Document(resolved, EngineHost().open_runtime(open_device("null"), resolved.scene))


@pytest.fixture
def from_cache(cache: Path, tmp_path: Path) -> Iterator[Document]:
    """A document of a loose source, whose scene lies in the import cache."""
    scene = write_small_scene(cache / "converted" / "key")
    (tmp_path / "boxes.glb").write_bytes(b"")
    document = open_document(Resolved(tmp_path / "boxes.glb", scene))
    yield document
    document.close()


def test_every_kind_of_edit_is_in_the_saved_scene(from_cache: Document, tmp_path: Path) -> None:
    document = from_cache
    document.edit("nodes", "translation", (2,), ((1.0, 2.0, 3.0),))
    document.edit("nodes", "visible", (1,), (False,))
    document.edit("lights", "intensity", (0,), (5.0,))
    document.edit("environment", "intensity", (0,), (0.5,))
    document.edit("look", "tone_map", (0,), ("agx",))
    document.edit("materials", "roughness", (0,), (0.25,))
    document.edit("nodes", "translation", (3,), ((9.0, 9.0, 9.0),))
    document.history.undo()
    target = tmp_path / "saved" / "boxes.scene.json"
    written = saving.save_document(document, target)
    assert written[-1] == target
    scene = read_scene(target)
    assert scene.nodes[2].translation == (1.0, 2.0, 3.0)
    assert not scene.nodes[1].visible
    assert scene.nodes[3].translation == (1.0, 2.0, 2.0), "what was undone is as it was"
    assert scene.nodes[3].light is not None
    assert scene.nodes[3].light.intensity == pytest.approx(5.0)
    assert (scene.environment.intensity, scene.look.tone_map) == (0.5, "agx")
    names = {p.name for p in target.parent.iterdir()}
    assert {"boxes.lmesh", "boxes.red.material.toml", "boxes.grey.material.toml"} <= names
    edited = Path(document.runtime.residency.material(0).path).name
    assert read_material(target.parent / edited).params["roughness"] == 0.25
    again = open_document(Resolved(target, target))
    assert len(again.runtime.residency.meshes) == 1
    assert len(again.runtime.findings.items) == 0
    again.close()


def test_the_cache_is_never_written_to(from_cache: Document, tmp_path: Path) -> None:
    folder = from_cache.scene_path.parent
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    from_cache.edit("materials", "roughness", (0,), (0.25,))
    from_cache.edit("nodes", "visible", (1,), (False,))
    saving.save_document(from_cache, tmp_path / "out" / "a.scene.json")
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before


def test_where_saving_goes(from_cache: Document, tmp_path: Path) -> None:
    assert saving.default_target(from_cache) is None, "a loose source: ask"
    assert saving.suggested_target(from_cache) == tmp_path / "boxes.scene.json"
    from_cache.project_root = tmp_path / "project"
    wanted = tmp_path / "project" / "scenes" / "boxes.scene.json"
    assert saving.default_target(from_cache) == wanted
    from_cache.saved_to = tmp_path / "b.scene.json"
    assert saving.default_target(from_cache) == tmp_path / "b.scene.json"


def test_a_scene_of_ones_own_is_saved_in_place_and_keeps_comments(cache: Path, tmp_path: Path) -> None:
    scene = write_small_scene(tmp_path / "mine")
    material = tmp_path / "mine" / "boxes.red.material.toml"
    material.write_text("# chosen with care\n" + material.read_text())
    document = open_document(Resolved(scene, scene))
    red = next(i for i, r in enumerate(document.runtime.residency.materials.records) if r.asset.name == "red")
    document.edit("materials", "roughness", (red,), (0.9,))
    assert saving.default_target(document) == scene
    written = saving.save_document(document, scene)
    assert [p.name for p in written] == ["boxes.red.material.toml", "boxes.scene.json"]
    assert material.read_text().startswith("# chosen with care\n")
    assert read_material(material).params["roughness"] == 0.9
    document.close()


def test_a_shear_comes_back_with_undo(cache: Path, tmp_path: Path) -> None:
    import numpy as np

    scene_path = write_small_scene(tmp_path / "mine")
    scene = read_scene(scene_path)
    shear = np.eye(4)
    shear[0, 1] = 0.5
    scene.nodes[2].matrix = tuple(shear.T.ravel().tolist())
    from engine.assets.scene_json import write_scene

    write_scene(scene_path, scene)
    document = open_document(Resolved(scene_path, scene_path))
    nodes = document.runtime.scene.nodes
    local = document.tables["nodes"].read("local", (2,))[0]
    document.edit("nodes", "local", (2,), ((local[0], local[1], (2.0, 2.0, 2.0), None),))
    assert not nodes.has_matrix[2]
    document.history.undo()
    assert nodes.local_matrix(2) == pytest.approx(shear)
    saving.save_document(document, scene_path)
    assert read_scene(scene_path).nodes[2].matrix == pytest.approx(tuple(shear.T.ravel()))
    document.close()


def test_a_project_opens_what_was_saved_in_it(cache: Path, tmp_path: Path) -> None:
    project = tmp_path / "project"
    write_small_scene(project / "assets")
    (project / "project.toml").write_text('[project]\nname = "P"\nstart = "assets/boxes.scene.json"\n')
    first = resolve_path(project, lambda _text, _fraction: None, (".glb",))
    assert (first.project_root, first.project_name) == (project, "P")
    assert first.scene == project / "assets" / "boxes.scene.json"
    write_small_scene(project / "scenes")
    assert resolve_path(project, lambda _text, _fraction: None, (".glb",)).scene.parent == project / "scenes"


def test_an_unwritable_folder_is_an_error_and_nothing_is_half_written(from_cache: Document, tmp_path: Path) -> None:
    from engine.core.errors import OutputError

    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        saving.save_document(from_cache, tmp_path / "file" / "a.scene.json")
