"""Looks, surroundings, turntable, and what a screenshot says of how it was seen."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fake_engine import FakeHost, FakeRuntime

from editor import looks, surroundings, turntable
from editor.builtin_operations import builtin_operations
from editor.camera_controls import OrbitCamera
from editor.document import Document
from editor.host import Resolved
from editor.preferences import Preferences
from editor.screenshot import save_viewport, stamp
from editor.session import Session
from editor.tables import SettingsTable
from engine.render.settings import RenderSettings
from engine.report.image import load_png, png_metadata

OPS = builtin_operations()


@pytest.fixture
def session(tmp_path: Path) -> Session:
    made = Session(FakeHost(), Preferences(welcome_seen=True))
    made.save_preferences = False
    made.device = made.host.open_device(attach=False)
    made.document = Document(Resolved(tmp_path / "thing.glb", tmp_path / "thing.scene.json"), FakeRuntime())
    made.document.tables["settings"] = SettingsTable(lambda: made.settings)  # as opening does
    made.image.update(made, 64, 48)
    return made


def test_looks_take_the_scenes_own_exposure_away(session: Session) -> None:
    assert session.document is not None
    session._settings = RenderSettings()
    session.document.runtime.scene.look.exposure = -0.75
    session.settings.bloom = 0.5
    assert looks.current(session) is None, "somebody's own"
    OPS.run("look.blender", session)
    values = session.settings.values()
    assert (values["tone_map"], values["exposure"], values["bloom"]) == ("agx", 0.75, 0.0)
    assert OPS["look.blender"].checked(session)  # type: ignore[misc]  # a toggle
    OPS.run("look.raw", session)
    assert session.settings.values()["tone_map"] == "none"
    OPS.run("look.scene", session)
    assert session.settings.values()["exposure"] == 0.0
    for _ in range(3):
        session.undo()
    assert session.settings.values()["bloom"] == 0.5, "all of a look is one entry"


def test_every_look_is_of_settings_that_are(session: Session) -> None:
    known = {p.name: p for p in RenderSettings.PARAMS}
    for look in looks.LOOKS:
        for name, value in looks.settings_of(look, 1.5).items():
            assert known[name].check(value) == value


def test_surroundings_are_edits_of_the_scene(session: Session) -> None:
    assert session.document is not None
    environment = session.document.runtime.scene.environment
    environment.sun_illuminance = 0.0
    OPS.run("surroundings.sky", session)
    assert (environment.kind, environment.sun_illuminance) == ("sky", surroundings.SUN)
    assert surroundings.label(session) == "Sun and sky"
    assert session.document.dirty
    session.undo()
    assert (environment.kind, environment.sun_illuminance) == ("studio", 0.0)
    environment.kind, environment.path = "image", "/far/away/meadow.env.dds"
    assert surroundings.label(session) == "meadow"
    OPS.run("surroundings.panorama", session)
    assert session.ui.choose is not None
    assert ".hdr" in session.ui.choose.endings


def test_a_screenshot_says_how_it_was_seen(session: Session, tmp_path: Path) -> None:
    session.settings.exposure = 1.5
    session.camera = OrbitCamera((1.0, 2.0, 3.0), yaw=0.0, pitch=0.0, distance=4.0)
    path = save_viewport(session)
    assert path is not None
    assert load_png(path).shape[:2] == (8, 8)
    said = png_metadata(path)
    assert said["lucarna.exposure"] == "1.5"
    assert said["lucarna.camera.eye"] == "1,2,7"
    assert said["lucarna.environment.kind"] == "studio"
    assert said["lucarna.look.tone_map"] == "neutral"
    assert said["lucarna.command"].startswith("lucarna render ")
    assert said == stamp(session)


def test_a_turn_comes_back_to_its_beginning(session: Session) -> None:
    start = session.camera
    OPS.run("view.turntable", session)
    for _ in range(round(turntable.TURN * 10)):
        turntable.step(session, 0.1)
    assert math.remainder(session.camera.yaw - start.yaw, math.tau) == pytest.approx(0.0, abs=1e-9)
    assert (session.camera.pitch, session.camera.distance) == (start.pitch, start.distance)
    OPS.run("view.turntable", session)
    turntable.step(session, 0.1)
    assert session.camera.yaw == pytest.approx(start.yaw)


def test_a_saved_turntable_is_numbered_pictures_all_round(
    session: Session, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []
    host = session.host
    monkeypatch.setattr(
        host, "view", lambda camera, w, h, settings: seen.append(camera) or SimpleNamespace(settings=settings)
    )
    work = turntable.SaveTurntable(count=4, video=False)
    while work.step(session):
        pass
    work.close()
    for i, camera in enumerate(seen):
        away = math.remainder(camera.yaw - session.camera.yaw - i * math.pi / 2, math.tau)
        assert away == pytest.approx(0.0, abs=1e-9)
    names = sorted(p.name for p in tmp_path.glob("*.png"))
    assert len(names) == 4
    assert [name[-8:-4] for name in names] == ["0001", "0002", "0003", "0004"]
    assert np.ptp(load_png(tmp_path / names[0])) > 0
