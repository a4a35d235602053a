"""The journal: what a killed process leaves gives back every edit; torn and foreign files do no harm."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from edited_stage import act, document, state, without_view
from fake_engine import FakeHost
from journal_child import fingerprint

from editor import journal
from editor.commands import structure
from editor.document import Document
from editor.journal import Journal, pending, replay
from editor.preferences import Preferences
from editor.recovering import recover
from editor.session import Session
from engine.assets.scene_json import read_scene
from engine.core.errors import InputError

CHILD = Path(__file__).parent / "support" / "journal_child.py"


def open_document(folder: Path) -> Document:
    doc = document()
    doc.source = doc.scene_path = folder / "stage.scene.json"
    doc.scene_path.write_text("{}\n")
    return doc


@pytest.mark.parametrize("edits", [1, 120])
def test_killing_the_process_loses_no_edit(tmp_path: Path, edits: int) -> None:
    with subprocess.Popen([sys.executable, str(CHILD), str(tmp_path), str(edits)], stdout=subprocess.PIPE) as child:
        assert child.stdout is not None
        reached = json.loads(child.stdout.readline())
        assert pending(tmp_path / "recovery") == [], "a living session's journal is its own"
        child.send_signal(signal.SIGKILL if sys.platform != "win32" else signal.SIGTERM)
    (found,) = pending(tmp_path / "recovery")
    assert found.edits == len(reached["entries"])
    assert found.base is not None
    doc = document()
    replay(doc, found.path)
    assert fingerprint(doc) == reached["state"]
    assert [e.describe() for e in doc.history.entries] == reached["entries"]
    doc.history.go_to(0)
    assert without_view(state(doc)) == without_view(state(document()))


def test_a_good_end_leaves_nothing(tmp_path: Path) -> None:
    doc = open_document(tmp_path)
    kept = Journal(doc, tmp_path / "recovery")
    structure.delete(doc, (2,))
    kept.snapshot()
    kept.finish()
    assert list((tmp_path / "recovery").iterdir()) == []
    structure.delete(doc, (3,))  # nobody listens any more


def test_the_snapshot_is_a_scene(tmp_path: Path) -> None:
    doc = open_document(tmp_path)
    kept = Journal(doc, tmp_path / "recovery")
    structure.duplicate(doc, (1,))
    assert "arm 2" in [n.name for n in read_scene(kept.snapshot()).nodes]
    kept.leave()


def test_what_was_saved_is_not_asked_about(tmp_path: Path) -> None:
    doc = open_document(tmp_path)
    kept = Journal(doc, tmp_path / "recovery")
    doc.edit("nodes", "name", (1,), ("a",))
    doc.history.mark_saved()
    kept.leave()
    assert pending(tmp_path / "recovery") == []
    assert list((tmp_path / "recovery").iterdir()) == []


def test_a_drag_after_saving_is(tmp_path: Path) -> None:
    doc = open_document(tmp_path)
    kept = Journal(doc, tmp_path / "recovery")
    for i in range(5):
        doc.edit("nodes", "translation", (1,), ((float(i), 0.0, 0.0),), gesture="drag")
        if i == 2:
            doc.history.mark_saved()
    kept.leave()
    (found,) = pending(tmp_path / "recovery")
    again = document()
    replay(again, found.path)
    assert state(again)["tables"] == state(doc)["tables"]
    assert again.dirty


def test_a_torn_last_line_costs_only_itself(tmp_path: Path) -> None:
    doc = open_document(tmp_path)
    kept = Journal(doc, tmp_path / "recovery")
    for i in range(4):
        act(doc, "structure", i)
    kept.leave()
    text = kept.path.read_text()
    kept.path.write_text(text[:-20])
    again = document()
    assert replay(again, kept.path) == 3
    doc.history.undo()
    assert state(again)["tables"] == state(doc)["tables"]


def test_an_edit_that_no_longer_fits_says_so_and_keeps_the_rest(tmp_path: Path) -> None:
    doc = open_document(tmp_path)
    kept = Journal(doc, tmp_path / "recovery")
    doc.edit("nodes", "name", (1,), ("a",))
    doc.edit("nodes", "visible", (2,), (False,))
    kept.leave()
    lines = kept.path.read_text().replace('"rows":[2]', '"rows":[200]')
    kept.path.write_text(lines)
    again = document()
    with pytest.raises(InputError, match="no longer fits"):
        replay(again, kept.path)
    assert again.runtime.scene.nodes.name[1] == "a"


@pytest.mark.parametrize("content", ["", "not json\n", '{"lucarna-journal": 99}\n', "[1,2]\n", '{"e":"do"}\n'])
def test_foreign_files_are_no_journals(tmp_path: Path, content: str) -> None:
    (tmp_path / "x.journal").write_text(content)
    assert pending(tmp_path) == []


def test_a_session_recovers_and_journals_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = tmp_path / "thing.scene.json"
    scene.write_text("{}")

    def session() -> Session:
        made = Session(FakeHost(), Preferences(), save_preferences=False, recovery_folder=tmp_path / "recovery")
        made.device = made.host.open_device(attach=False)
        return made

    first = session()
    first.open(tmp_path / "thing.glb")
    assert first.job is not None
    first.job.wait(10)
    first.poll()
    first.set_visible((1,), False)
    assert first.document is not None
    structure.group(first.document, (2,))
    assert first.journal is not None
    first.journal.leave()  # as a crash: the lock goes, the file stays

    second = session()
    (found,) = pending(tmp_path / "recovery")
    assert found.name == "thing.glb"
    assert recover(second, found)
    assert second.document is not None
    assert [e.describe() for e in second.document.history.entries] == ["Hide body", "Group lid"]
    assert second.document.dirty
    assert not second.document.runtime.scene.nodes.visible[1]
    assert not found.path.exists()
    assert second.journal is not None
    assert second.journal.path.is_file()
    assert len(second.journal.path.read_text().splitlines()) == 3, "the restored edits are safe again"
    second.close()
    assert list((tmp_path / "recovery").iterdir()) == []


def test_a_folder_that_cannot_be_written_is_a_warning(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    session = Session(FakeHost(), Preferences(), save_preferences=False, recovery_folder=blocked / "recovery")
    session.device = session.host.open_device(attach=False)
    session.open(tmp_path / "thing.glb")
    assert session.job is not None
    session.job.wait(10)
    session.poll()
    assert session.document is not None
    assert session.journal is None
    assert any("not kept" in entry.text for entry in session.messages.snapshot())


def test_a_full_disk_stops_the_journal_and_not_the_user(tmp_path: Path) -> None:
    doc = open_document(tmp_path)
    kept = Journal(doc, tmp_path / "recovery")
    kept._file.close()
    doc.edit("nodes", "name", (1,), ("a",))
    assert kept.problem
    assert doc.runtime.scene.nodes.name[1] == "a"
    journal.discard(kept.path)
