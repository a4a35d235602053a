"""Focus by a click; what needs one sample a pixel brings it along; one entry of the history each."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fake_engine import FakeHost, FakeRuntime

from editor.builtin_operations import builtin_operations
from editor.document import Document
from editor.focusing import focus_at
from editor.host import Resolved
from editor.preferences import Preferences
from editor.session import Session
from editor.tables import SettingsTable
from engine.render.settings import RenderSettings

OPS = builtin_operations()


@pytest.fixture
def session(tmp_path: Path) -> Session:
    host = FakeHost()
    host.new_settings = RenderSettings
    made = Session(host, Preferences(welcome_seen=True))
    made.save_preferences = False
    made.document = Document(Resolved(tmp_path / "thing.glb", tmp_path / "thing.scene.json"), FakeRuntime())
    made.document.tables["settings"] = SettingsTable(lambda: made.settings)  # as opening does
    return made


def hit_at(session: Session, monkeypatch: pytest.MonkeyPatch, *points: tuple[float, float, float]) -> None:
    """A camera at (1, 2, 3) that looks along -Z, and what a click hits."""
    eye = np.eye(4)
    eye[:3, 3] = 1.0, 2.0, 3.0
    monkeypatch.setattr(Session, "view", lambda self: SimpleNamespace(camera=SimpleNamespace(world_from_camera=eye)))
    monkeypatch.setattr(Session, "hits", lambda self, u, v: [(i, np.array(p)) for i, p in enumerate(points)])


def test_a_click_focuses_and_one_undo_takes_it_back(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    before = session.settings.values()
    OPS.run("tool.pick-focus", session)
    assert session.tools.focusing
    hit_at(session, monkeypatch, (4.0, 6.0, -2.0), (0.0, 0.0, -9.0))
    focus_at(session, 0.5, 0.5)
    now = session.settings
    assert (now.depth_of_field, now.samples, session.tools.focusing) == (True, 1, False)
    assert now.focus == pytest.approx(5.0), "along the view: a plane is sharp"
    assert session.document is not None
    assert len(session.document.history.entries) == 1
    session.undo()
    assert session.settings.values() == before


def test_a_click_on_nothing_changes_nothing(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    before = session.settings.values()
    OPS.run("tool.pick-focus", session)
    hit_at(session, monkeypatch)
    focus_at(session, 0.5, 0.5)
    assert session.settings.values() == before
    assert "Nothing there" in session.ui.notice


@pytest.mark.parametrize(("name", "value", "samples"), [("antialias", "taa", 1), ("antialias", "none", 4)])
def test_a_choice_brings_its_samples_along(session: Session, name: str, value: str, samples: int) -> None:
    OPS.run("view.set", session, name=name, value=value)
    assert session.settings.samples == samples
    session.undo()
    assert (session.settings.samples, session.settings.antialias) == (4, "none")
