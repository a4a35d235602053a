"""The import card: where it finds room, how much of the viewport it takes, and when it folds to one line."""

from __future__ import annotations

from pathlib import Path

import pytest
from real_session import opened, real_session
from small_source import write_small_source

from editor.builtin_operations import builtin_operations
from editor.dialogs.import_card_place import EDGE, LINE, NARROW, SHARE, WIDTH, YOUNG, Folding, placed


@pytest.mark.parametrize("size", [(90.0, 50.0), (50.0, 25.0), (40.0, 19.0), (25.0, 14.0), (25.0, 5.0), (8.0, 6.0)])
def test_it_ends_inside_the_picture_and_covers_no_more_than_a_third_of_it(size: tuple[float, float]) -> None:
    place = placed(*size)
    assert place.whole == (size[0] >= 40.0), "else a line, unless it is asked for"
    assert place.width <= max(min(WIDTH, size[0] - 2 * EDGE), NARROW)
    assert place.top + place.height <= size[1]
    assert place.line + LINE <= size[1]
    assert place.width * place.height <= SHARE * size[0] * size[1] + 1e-6 or place.height == LINE
    assert placed(*size, wanted=3.0).top >= place.top, "what takes less stays below the axes"


def test_a_picture_of_less_than_a_line_has_no_card() -> None:
    assert not placed(18.0, 0.8).fits
    assert placed(18.0, 5.0).fits


def drawn(folding: Folding, news: object, deed: object, times: int = 1, *, busy: bool = False) -> bool | None:
    for _ in range(times):
        folding.follow(news, deed, busy=busy)
    return folding.whole


def test_the_first_thing_that_the_user_does_folds_it() -> None:
    folding, news = Folding(), object()
    assert drawn(folding, news, "framing") is None
    assert drawn(folding, news, "framed", YOUNG) is None, "what the window does by itself is nobody's deed"
    assert drawn(folding, news, "framed", 100) is None
    assert drawn(folding, news, "selected") is False
    assert drawn(folding, object(), "selected") is None, "another import is shown"


def test_one_that_was_opened_by_hand_stays_and_one_that_was_folded_too() -> None:
    folding, news = Folding(), object()
    drawn(folding, news, "at first", 2 * YOUNG)
    folding.choose(whole=True)
    assert drawn(folding, news, "turned") is True
    folding.choose(whole=False)
    assert drawn(folding, news, "turned again", 10) is False


def test_its_own_fixes_leave_it_open() -> None:
    folding, first, second = Folding(), object(), object()
    drawn(folding, first, "at first", 2 * YOUNG)
    assert drawn(folding, first, "at first", 3, busy=True) is None
    assert drawn(folding, second, "imported again", 20) is None
    assert drawn(folding, first, "taken back") is False, "an undo is a deed, and what was seen is not shown anew"


def test_the_menu_opens_what_is_folded_and_puts_away_what_is_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    session = real_session()
    opened(session, write_small_source(tmp_path / "crate.gltf"))
    operations, requests = builtin_operations(), session.ui
    seen = [(requests.import_card, False)]
    for folded in (True, False, False):
        requests.import_card_folded, requests.import_card_opened = folded, False
        operations.run("file.import-card", session)
        seen.append((requests.import_card, requests.import_card_opened))
    assert seen == [(True, False), (True, True), (False, False), (True, True)]
    session.sources.stop()
    session.close_all()
