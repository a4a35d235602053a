"""A source that changes under an open document: nothing of the user's is lost, undo is exact, failures do no harm."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from real_session import opened, real_session, settle
from small_source import write_small_source

from editor import import_settings, journal, recovering, reimporting
from editor.builtin_operations import builtin_operations
from editor.session import Session
from engine.assets.scene_json import read_scene
from importers.cache import scene_for
from importers.presets import sidecar_path
from importers.reimport.record import record_path
from importers.settings import ImportSettings


@pytest.fixture
def source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    return write_small_source(tmp_path / "assets/crate.gltf")


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    session = real_session(tmp_path / "recovery")
    session.preferences.reimport = False  # asked for by hand, but where the watch is tested
    yield session
    session.sources.stop()
    session.close_all()


def rewrite(source: Path, **material: Any) -> None:
    """Give the source's material other factors, and a second crate."""
    data = json.loads(source.read_text())
    data["materials"][0]["pbrMetallicRoughness"].update(material)
    data["nodes"].append({"name": f"crate {len(data['nodes'])}", "mesh": 0})
    data["scenes"][0]["nodes"].append(len(data["nodes"]) - 1)
    source.write_text(json.dumps(data))
    info = source.stat()
    os.utime(source, ns=(info.st_atime_ns, info.st_mtime_ns + 1_000_000))


def params(document: Any) -> dict[str, Any]:
    return dict(document.runtime.residency.material(0).asset.params)


def test_edits_go_through_a_new_import_and_undo_is_exact(session: Session, source: Path) -> None:
    document = opened(session, source)
    session.edit("materials", "roughness", (0,), (0.125,))
    session.edit("nodes", "translation", (0,), ((0.0, 3.0, 0.0),))
    builtin_operations().run("edit.select-all", session)
    builtin_operations().run("edit.duplicate", session)
    before = (list(document.runtime.scene.nodes.name), params(document), document.selection, document.runtime)
    rewrite(source, metallicFactor=0.75, roughnessFactor=0.9)
    assert builtin_operations().run("file.reimport", session)
    settle(session)
    assert not session.ui.error_bar
    assert document.runtime.scene.nodes.name == ["crate", "crate 1", "crate 2"]
    assert document.runtime.scene.nodes.translation[0].tolist() == [0.0, 3.0, 0.0]
    assert (params(document)["roughness"], params(document)["metallic"]) == (0.125, 0.75)
    assert any("roughness" in line for line in document.news.report.conflicts)
    assert document.dirty
    session.undo()
    now = (list(document.runtime.scene.nodes.name), params(document), document.selection, document.runtime)
    assert now == before
    for _ in range(3):
        session.undo()
    assert document.runtime.scene.nodes.translation[0].tolist() == [0.0, 0.0, 0.0]
    assert not document.dirty
    for _ in range(4):
        session.redo()
    assert (params(document)["roughness"], params(document)["metallic"]) == (0.125, 0.75)
    session.edit("nodes", "visible", (1,), (False,))
    session.undo()
    assert document.runtime.scene.nodes.visible[1]


def test_saved_scenes_remember_what_they_came_from(session: Session, source: Path, tmp_path: Path) -> None:
    opened(session, source)
    session.edit("materials", "roughness", (0,), (0.125,))
    target = tmp_path / "scenes/crate.scene.json"
    assert session.save(target)
    assert record_path(target).is_file()
    session.close()
    rewrite(source, metallicFactor=0.75)
    document = opened(session, target)
    assert document.imported_from == source
    assert reimporting.start(session)
    settle(session)
    assert (params(document)["roughness"], params(document)["metallic"]) == (0.125, 0.75)
    assert session.save()
    assert [n.name for n in read_scene(target).nodes] == ["crate", "crate 1"]
    assert reimporting.start(session)
    settle(session)
    assert "nothing has changed" in session.ui.notice


def test_a_broken_source_changes_nothing_and_says_why(session: Session, source: Path) -> None:
    document = opened(session, source)
    session.edit("materials", "roughness", (0,), (0.125,))
    runtime, good = document.runtime, source.read_text()
    source.write_text(good[: len(good) // 2])
    assert reimporting.start(session)
    settle(session)
    assert document.runtime is runtime
    assert params(document)["roughness"] == 0.125
    assert session.ui.error_bar
    assert len(document.history.entries) == 1


def test_the_watch_sees_the_source_and_its_sidecar(session: Session, source: Path) -> None:
    document = opened(session, source)
    session.preferences.reimport = True
    deadline = time.monotonic() + 20.0
    while not session.sources._stamps and time.monotonic() < deadline:
        session.poll()
        time.sleep(0.02)
    rewrite(source, metallicFactor=0.75)
    while params(document)["metallic"] != 0.75 and time.monotonic() < deadline:
        session.poll()
        time.sleep(0.02)
    assert params(document)["metallic"] == 0.75


def test_a_source_that_changed_while_nobody_looked_comes_in_when_its_scene_is_opened(
    session: Session, source: Path, tmp_path: Path
) -> None:
    opened(session, source)
    session.edit("materials", "roughness", (0,), (0.125,))
    target = tmp_path / "scenes/crate.scene.json"
    assert session.save(target)
    session.close()
    rewrite(source, metallicFactor=0.75)
    session.preferences.reimport = True
    document = opened(session, target)
    deadline = time.monotonic() + 20.0
    while params(document)["metallic"] != 0.75 and time.monotonic() < deadline:
        session.poll()
        time.sleep(0.02)
    assert (params(document)["roughness"], params(document)["metallic"]) == (0.125, 0.75)


def test_fixes_are_remembered_undone_and_the_same_on_the_command_line(session: Session, source: Path) -> None:
    document = opened(session, source)

    def size() -> list[float]:
        low, high = document.bounds()
        return [round(float(v), 6) for v in high - low]

    assert size() == [1.0, 1.0, 2.0]
    assert session.ui.import_card, "what came in is shown"
    assert import_settings.facts(document)["As large as"] == "a door"
    ops = builtin_operations()
    for id in ("import.z-up", "import.scale-up"):
        assert ops.run(id, session)
        settle(session)
    assert size() == [100.0, 200.0, 100.0]
    assert sidecar_path(source).read_text() == 'turn = "z-up"\nscale = 100.0\n'
    scene, _ = scene_for(source, settings=ImportSettings())
    flags, _ = scene_for(source, settings=ImportSettings(turn="z-up", scale=100.0))
    assert scene.read_bytes() == flags.read_bytes()
    session.undo()
    assert size() == [1.0, 2.0, 1.0]
    assert sidecar_path(source).read_text() == 'turn = "z-up"\n'
    session.undo()
    assert not sidecar_path(source).exists()
    session.redo()
    assert sidecar_path(source).is_file()
    assert ops.run("import.z-up", session), "again takes it back"
    settle(session)
    assert size() == [1.0, 1.0, 2.0]
    assert ops.run("import.set", session, setting="turn", value="sideways")
    assert "sideways" in session.ui.error_bar
    assert not sidecar_path(source).exists()


def test_a_crash_after_an_import_loses_nothing(session: Session, source: Path, tmp_path: Path) -> None:
    opened(session, source)
    session.edit("nodes", "translation", (0,), ((0.0, 3.0, 0.0),))
    session.edit("materials", "roughness", (0,), (0.125,))
    rewrite(source, metallicFactor=0.75)
    assert reimporting.start(session)
    settle(session)
    assert session.journal is not None
    assert not session.journal.problem
    session.edit("nodes", "name", (1,), ("late",))
    recovering.leave(session)
    again = real_session()
    (left,) = journal.pending(tmp_path / "recovery")
    assert recovering.recover(again, left), again.ui.error_bar
    document = again.document
    assert document is not None
    assert document.runtime.scene.nodes.name == ["crate", "late"]
    assert document.runtime.scene.nodes.translation[0].tolist() == [0.0, 3.0, 0.0]
    assert (params(document)["roughness"], params(document)["metallic"]) == (0.125, 0.75)
    again.close_all()
