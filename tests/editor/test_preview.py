"""The material preview without a window: which material, on what, remembered how, drawn when."""

from __future__ import annotations

from pathlib import Path

import pytest

from editor.document import Document
from editor.host import EngineHost, Resolved
from editor.material_editing import derive
from editor.preferences import Preferences, load, save
from editor.preview import FILE, MESH, SELECTED, PreviewSetup
from editor.session import Session
from engine.assets.material_toml import read_material
from engine.gpu.types import Device
from tests.editor.support.small_scene import write_small_scene


@pytest.fixture
def session(tmp_path: Path, null_device: Device) -> Session:
    scene = write_small_scene(tmp_path)
    session = Session(EngineHost(), Preferences(), device=null_device)
    session.save_preferences = False
    session.document = Document(Resolved(scene, scene), session.host.open_runtime(null_device, scene))
    session.preview.load(session)
    return session


def named(session: Session, material: int) -> str:
    assert session.document is not None
    return str(session.document.runtime.residency.material(material).asset.name)


def test_it_follows_the_selection_until_it_is_pinned(session: Session) -> None:
    assert session.document is not None
    preview = session.preview
    session.document.select(2)
    assert named(session, preview.subject(session)) == "red"
    preview.pinned = preview.subject(session)
    session.document.select(1)
    assert named(session, preview.subject(session)) == "red"
    preview.pinned = -1
    assert named(session, preview.subject(session)) == "grey"


def test_it_draws_when_something_shows_and_else_rests(session: Session) -> None:
    assert session.document is not None
    preview = session.preview
    session.document.select(2)

    def drawn() -> int:
        before = preview.renders
        preview.update(session, 64, 64)
        return preview.renders - before

    assert drawn() == 1
    assert drawn() == 0
    for change in (
        lambda: preview.orbit(10.0, 0.0),
        lambda: preview.turn_light(10.0),
        lambda: preview.come_nearer(0.9),
        lambda: setattr(preview.setup, "shape", "cloth"),
        lambda: setattr(preview.setup, "light", "studio"),
        lambda: session.edit("materials", "roughness", (preview.subject(session),), (0.9,)),
        lambda: session.edit("environment", "intensity", (0,), (2.0,)),
        lambda: session.document is not None and session.document.select(1),
    ):
        change()
        assert drawn() == 1
        assert drawn() == 0
    session.edit("nodes", "translation", (2,), ((5.0, 0.0, 0.0),))
    assert drawn() == 0, "where an object stands does not show"


def test_own_meshes_and_what_is_not_there(session: Session, tmp_path: Path) -> None:
    assert session.document is not None
    preview = session.preview
    session.document.select(2)
    assert preview.mesh_names(session) == ["box"]
    for shape, mesh, note in (
        (SELECTED, "", ""), (MESH, "box", ""), (MESH, "fox", "there is no mesh 'fox' here"),
        (FILE, str(tmp_path / "boxes.lmesh"), ""),
    ):  # fmt: skip
        preview.setup.shape, preview.setup.mesh = shape, mesh
        preview.update(session, 64, 64)
        assert preview.note == note
        assert preview.frame is not None
    session.document.select(3)  # the lamp has no mesh
    preview.setup.shape = SELECTED
    preview.update(session, 64, 64)
    assert preview.note == "nothing with a mesh is selected"


def test_files_dropped_on_it(session: Session, tmp_path: Path) -> None:
    preview = session.preview
    preview.take(session, tmp_path / "boxes.grey.material.toml")
    assert named(session, preview.pinned) == "grey"
    preview.take(session, tmp_path / "boxes.lmesh")
    assert (preview.setup.shape, preview.setup.mesh) == (FILE, str(tmp_path / "boxes.lmesh"))
    preview.take(session, tmp_path / "notes.md")
    assert "no material, model or scene" in session.ui.notice


def test_the_set_up_is_remembered_and_nonsense_in_it_is_not(session: Session, tmp_path: Path) -> None:
    session.preview.setup.shape, session.preview.setup.rotation = "ball", 30.0
    session.preview.remember(session)
    assert save(session.preferences, tmp_path / "p.json") == ""
    again = PreviewSetup.read(load(tmp_path / "p.json").preview)
    assert (again.shape, again.rotation) == ("ball", 30.0)
    bad = PreviewSetup.read({"shape": "teapot", "zoom": "x", "yaw": float("nan"), "pitch": 9.0, "light": 3})
    assert (bad.shape, bad.zoom, bad.yaw, bad.light) == ("sphere", 1.0, PreviewSetup().yaw, "scene")
    assert abs(bad.pitch) < 1.6


def test_a_material_that_inherits_says_only_where_it_comes_from(tmp_path: Path) -> None:
    write_small_scene(tmp_path)
    child = derive(tmp_path / "boxes.red.material.toml")
    assert child.name == "boxes.red.1.material.toml"
    assert read_material(child).params == read_material(tmp_path / "boxes.red.material.toml").params
    assert derive(tmp_path / "boxes.red.material.toml").name == "boxes.red.2.material.toml"
