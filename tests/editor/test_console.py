"""The Python console: operations and edits by name, blocks, mistakes."""

from __future__ import annotations

from pathlib import Path

import pytest
from fake_engine import FakeHost

from editor.builtin_operations import builtin_operations
from editor.console import Console
from editor.preferences import Preferences
from editor.session import Session


@pytest.fixture
def console() -> Console:
    session = Session(FakeHost(), Preferences(), save_preferences=False)
    session.device = session.host.open_device(attach=False)
    session.open(Path("/nowhere/thing.glb"))
    assert session.job is not None
    session.job.wait(10)
    session.poll()
    return Console(session, builtin_operations())


def said(console: Console, kind: str) -> list[str]:
    return [line.text for line in console.lines if line.kind == kind]


def test_operations_and_nodes_are_completed_after_a_quote(console: Console) -> None:
    assert console.complete('"edit.dupl') == ['"edit.duplicate']
    assert console.complete("'li") == ["'lid"]
    assert console.complete("'thing that is not") == []
    console.offer([f"name{i}" for i in range(50)])
    assert said(console, "did")[-1].endswith("name39 and 10 more")


def test_what_it_edits_can_be_undone(console: Console) -> None:
    document = console.session.document
    assert document is not None
    console.push('edit("nodes", "translation", [node("lid")], [(1, 2, 3)])')
    assert not said(console, "error")
    assert document.runtime.scene.nodes.translation[2].tolist() == [1.0, 2.0, 3.0]
    console.push('run("edit.undo")')
    assert said(console, "out") == ["True"]
    assert document.runtime.scene.nodes.translation[2].tolist() == [0.0, 1.0, 0.0]


def test_operations_run_by_name(console: Console) -> None:
    document = console.session.document
    assert document is not None
    document.select(2)
    console.push('run("edit.duplicate")')
    assert document.runtime.scene.nodes.name[-1] == "lid 2"
    console.push("selection()")
    assert said(console, "out")[-1] == "(5,)"


def test_a_block_waits_for_its_end(console: Console) -> None:
    for line in ("for i in range(3):", "    print(i * i)"):
        console.push(line)
    assert console.pending
    assert not said(console, "out")
    console.push("")
    assert said(console, "out") == ["0", "1", "4"]
    assert not console.pending


@pytest.mark.parametrize("line", ["1 / 0", "run('no.such')", "node('nobody')", "this is no python", "exit()"])
def test_mistakes_are_written_down_and_nothing_else(console: Console, line: str) -> None:
    console.push(line)
    assert said(console, "error")
    console.push("6 * 7")
    assert said(console, "out") == ["42"]


def test_completion(console: Console) -> None:
    assert console.complete("sel") == ["select", "selection"]
    assert "session.camera" in console.complete("session.cam")
    assert console.complete("nothing.at") == []
