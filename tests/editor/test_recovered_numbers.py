"""A replay gives meshes and materials the numbers that they have then, not those of the run that died."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from real_session import opened, real_session
from small_scene import write_small_scene

from editor import journal, prefabs, recovering
from editor.commands import structure
from editor.session import Session


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    for name in ("shown", "placed"):
        write_small_scene(tmp_path / name)
    return write_small_scene(tmp_path / "scene")


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    session = real_session(tmp_path / "recovery")
    yield session
    session.close_all()


def drawn(document: Any) -> list[tuple[str, Path, Path, Any]]:
    """Of each part its node, the file of its mesh and of its material, and what the object has of its own."""
    residency, table = document.runtime.residency, document.runtime.scene.instances
    mesh_of = {n: path for path, ids in residency.mesh_files.items() for n in ids}
    return [
        (
            document.runtime.scene.nodes.name[int(table.node[row])], mesh_of[int(table.mesh[row])],
            Path(residency.material(residency.materials.base_of(int(table.material[row]))).path),
            dict(residency.material(int(table.material[row])).overrides),
        )
        for row in table.alive_rows()
    ]  # fmt: skip


def recovered(session: Session, tmp_path: Path) -> Any:
    recovering.leave(session)
    again = real_session(tmp_path / "again")
    (left,) = journal.pending(tmp_path / "recovery")
    assert recovering.recover(again, left), again.ui.error_bar
    return again


def test_what_a_preview_loaded_does_not_shift_the_rest(session: Session, scene: Path, tmp_path: Path) -> None:
    document = opened(session, scene)
    residency = document.runtime.residency
    residency.load_mesh_file(tmp_path / "shown/boxes.lmesh")
    residency.load_material(tmp_path / "shown/boxes.red.material.toml")
    assert prefabs.place(session, tmp_path / "placed/boxes.scene.json", np.eye(4))
    material = int(residency.material_files[tmp_path / "placed/boxes.red.material.toml"])
    session.edit("materials", "roughness", (material,), (0.125,))
    before = drawn(document)
    assert any("placed" in str(mesh) for _node, mesh, _material, _own in before)
    again = recovered(session, tmp_path)
    assert drawn(again.document) == before
    here = again.document.runtime.residency
    number = here.material_files[tmp_path / "placed/boxes.red.material.toml"]
    assert number != material, "the preview is gone"
    assert here.material(number).asset.params["roughness"] == 0.125
    again.undo()
    assert here.material(number).asset.params["roughness"] == 0.5
    again.close_all()


def test_an_object_that_comes_back_shows_what_it_says(session: Session, scene: Path, tmp_path: Path) -> None:
    """Its variation of the material may have been given up since, or have another object's values."""
    document = opened(session, scene)
    cube = list(document.runtime.scene.nodes.name).index("cube")
    session.edit("objects", "0:roughness", (cube,), (0.125,))
    session.edit("objects", "0:roughness", (cube,), (0.25,))
    structure.delete(document, [cube])
    for _ in range(3):
        session.undo()
    for _ in range(3):
        session.redo()
    session.undo()
    own = {node: values for node, _mesh, _material, values in drawn(document)}
    assert own["cube"] == {"roughness": 0.25}
    structure.duplicate(document, [cube])
    session.edit("objects", "0:roughness", (cube,), (0.75,))
    session.edit("objects", "0:emissive", (cube,), ((1.0, 0.0, 0.0),))
    structure.duplicate(document, [cube])
    said = [document.runtime.objects.values(row, 0) for row in range(6)]
    assert said[5] == {"roughness": 0.75, "emissive": (1.0, 0.0, 0.0)}
    before = drawn(document)
    assert {node: v["roughness"] for node, _m, _n, v in before if v} == {"cube": 0.75, "cube 2": 0.25, "cube 3": 0.75}
    again = recovered(session, tmp_path)
    assert drawn(again.document) == before
    assert [again.document.runtime.objects.values(row, 0) for row in range(6)] == said
    again.close_all()


def test_a_variation_is_edited_as_its_material(session: Session, scene: Path) -> None:
    document = opened(session, scene)
    cube = list(document.runtime.scene.nodes.name).index("cube")
    session.edit("objects", "0:metallic", (cube,), (1.0,))
    table = document.runtime.scene.instances
    variation = int(table.material[table.node == cube][0])
    session.edit("materials", "roughness", (variation,), (0.125,))
    assert session.save()
    assert "roughness = 0.125" in (scene.parent / "boxes.red.material.toml").read_text()
    assert document.runtime.residency.material(variation).asset.params["roughness"] == 0.125


def test_variations_that_nothing_shows_are_used_again(session: Session, scene: Path) -> None:
    document = opened(session, scene)
    cube = list(document.runtime.scene.nodes.name).index("cube")
    session.edit("objects", "0:base_color", (cube,), ((1.0, 0.0, 0.0, 1.0),))
    count = len(document.runtime.residency.materials.records)
    for _ in range(5):
        session.undo()
        session.redo()
    assert len(document.runtime.residency.materials.records) == count
    assert document.runtime.objects.values(cube, 0) == {"base_color": (1.0, 0.0, 0.0, 1.0)}
