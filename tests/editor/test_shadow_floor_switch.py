"""The switch of the floor that only shadows are seen of."""

from __future__ import annotations

from pathlib import Path

from real_session import opened, real_session
from small_scene import write_small_scene

from editor.builtin_operations import builtin_operations


def test_the_floor_is_one_entry_that_is_undone(tmp_path: Path) -> None:
    session = real_session(tmp_path / "recovery")
    write_small_scene(tmp_path / "game")
    opened(session, tmp_path / "game/boxes.scene.json")
    operation = builtin_operations()["view.shadow-floor"]
    assert operation.checked is not None
    assert not operation.checked(session)
    builtin_operations().run("view.shadow-floor", session)
    assert operation.checked(session)
    assert session.settings.shadow_floor > 0.0
    session.undo()
    assert session.settings.shadow_floor == 0.0
    session.close_all()
