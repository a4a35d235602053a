"""The viewport goes on drawing while the exposure adapts, by the clock, and sleeps when it has settled."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from fake_engine import FakeHost

from editor.preferences import Preferences
from editor.session import Session
from editor.viewport_image import UNSURE


@pytest.mark.parametrize("metered", [False, True])
def test_it_draws_until_the_exposure_has_settled(metered: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    session = Session(FakeHost(), Preferences())
    session.device, session.save_preferences = session.host.open_device(attach=False), False
    session.open(Path("/nowhere/thing.glb"))
    if session.job is not None:
        session.job.wait(10)
    session.poll()
    session.playback.playing = False
    image, views = session.image, []
    times = iter(range(1000))
    image.clock = lambda: float(next(times))
    settings = SimpleNamespace(auto_exposure=metered, takes_time=metered)
    monkeypatch.setattr(Session, "view", lambda _: SimpleNamespace(settings=settings, seconds=None))

    def render(view: Any) -> Any:
        views.append(view)
        settled = len(views) in (1, 2) or len(views) > 9  # what it says is late by some pictures
        return SimpleNamespace(facts=settings, settled=settled, stats=None)

    monkeypatch.setattr(session.document.runtime, "render", render)  # type: ignore[union-attr]  # it is open
    for _ in range(4):
        image.update(session, 64, 48)
    assert len(views) == 1, "it begins settled, whatever was before"
    assert views[0].seconds is None
    session.settings.exposure = 2.0  # type: ignore[attr-defined]  # the fake host has render settings
    for _ in range(40):
        image.update(session, 64, 48)
    assert len(views) == (max(1 + UNSURE, 9) + 1 if metered else 2)
    # the clock ticks each time it is looked at: when a picture was shown, when the window was disturbed
    assert {view.seconds for view in views[1:]} == ({2.0} if metered else {None})
    assert not image.settling
