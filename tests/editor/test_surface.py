"""Standing on surfaces: the foot of what is held meets what is below, or what is under the pointer."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from real_session import opened, real_session
from small_scene import write_small_scene

from editor import gizmo, surface
from editor.builtin_operations import builtin_operations
from editor.session import Session


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    session = real_session()
    opened(session, write_small_scene(tmp_path))
    yield session
    session.close_all()


def test_a_dropped_node_stands_on_what_is_below_it_else_on_the_ground(session: Session) -> None:
    document = session.document
    assert document is not None
    session.edit("nodes", "translation", (2,), ((0.3, 4.0, 0.2),))
    document.select(2)
    ops = builtin_operations()
    assert ops.run("edit.drop", session)
    assert document.bounds((2,))[0][1] == pytest.approx(-0.5, abs=1e-6), "the top of the plinth"
    assert document.runtime.scene.nodes.translation[2][[0, 2]].tolist() == [0.3, 0.2]
    ops.run("edit.drop", session)
    assert document.bounds((2,))[0][1] == pytest.approx(-0.5, abs=1e-6), "it stands there already"
    session.edit("nodes", "translation", (2,), ((30.0, 4.0, 0.0),))
    ops.run("edit.drop", session)
    assert document.bounds((2,))[0][1] == pytest.approx(0.0, abs=1e-6), "nothing below: the ground"
    assert document.history.undo_label == "Drop cube"


def test_what_is_dragged_is_not_what_it_stands_on(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    document = session.document
    assert document is not None
    hits = [(2, np.array([0.0, 1.0, 0.0])), (1, np.array([0.5, -0.5, 0.25]))]
    monkeypatch.setattr(Session, "hits", lambda self, u, v: hits)
    point = surface.under(session, (2,), 0.5, 0.5)
    assert point is not None
    assert point.tolist() == [0.5, -0.5, 0.25]
    assert surface.under(session, (0,), 0.5, 0.5) is None, "all of it hangs below what is dragged"
    document.select(2)
    grip = gizmo.begin(document, local=False)
    assert grip is not None
    assert surface.foot_of(document, grip) == pytest.approx([0.0, -0.5, 0.0], abs=1e-6)
    document.select(3)
    grip = gizmo.begin(document, local=False)
    assert grip is not None
    assert surface.foot_of(document, grip).tolist() == [1.0, 2.0, 2.0], "a light has no size"
