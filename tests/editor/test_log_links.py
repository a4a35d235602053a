"""Where messages of the log lead."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from editor.log_links import follow, link_of


@pytest.fixture
def session(tmp_path: Path) -> Any:
    (tmp_path / "a.frag").write_text("void main() {}")
    (tmp_path / "wall.png").write_bytes(b"")
    nodes = SimpleNamespace(name=["a", "b"], alive=[True, False])
    chosen: list[int] = []
    document = SimpleNamespace(
        project_root=tmp_path, source=tmp_path / "a.glb", runtime=SimpleNamespace(scene=SimpleNamespace(nodes=nodes)),
        select=chosen.append,
    )  # fmt: skip
    opened: list[Any] = []
    ui = SimpleNamespace(show_texture="", focus_panel="")
    return SimpleNamespace(
        document=document, ui=ui, chosen=chosen, opened=opened, open_code=lambda *a: opened.append(a)
    )


@pytest.mark.parametrize("where", ["{}/a.frag:3:7", "a.frag:3:7", "{}/a.frag:3:7: MaterialParams"])
def test_a_text_at_its_line(session: Any, tmp_path: Path, where: str) -> None:
    link = link_of(where.format(tmp_path), session)
    assert link is not None
    follow(link, session)
    assert session.opened == [(tmp_path / "a.frag", 3, 7)]


def test_pictures_and_nodes(session: Any, tmp_path: Path) -> None:
    for where in (f"{tmp_path}/wall.png", f"{tmp_path}/a.glb: nodes[0].rotation"):
        link = link_of(where, session)
        assert link is not None
        follow(link, session)
    assert session.ui.show_texture == tmp_path / "wall.png"
    assert session.chosen == [0]


@pytest.mark.parametrize("where", ["", "nodes[1]", "nodes[9]", "/nowhere/a.frag:3", "meshes[0]"])
def test_what_there_is_not_leads_nowhere(session: Any, where: str) -> None:
    assert link_of(where, session) is None
