"""The switch of the floor that only shadows are seen of, and where the import card finds room."""

from __future__ import annotations

from pathlib import Path

import pytest
from real_session import opened, real_session
from small_scene import write_small_scene

from editor.builtin_operations import builtin_operations
from editor.dialogs.import_card import EDGE, WIDTH, placed


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


@pytest.mark.parametrize("size", [(55.0, 30.0), (26.0, 16.0), (20.0, 9.0), (8.0, 6.0)])
def test_the_import_card_ends_inside_the_viewport_or_is_one_line(size: tuple[float, float]) -> None:
    place = placed(*size)
    assert place.top + place.height <= size[1] or not place.whole
    assert place.width <= max(min(WIDTH, size[0] - 2 * EDGE), 8.0)
    assert place.whole == (size[1] >= 16.0)
