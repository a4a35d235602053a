"""Preferences, messages, playback, navigation, listings, timings, parameters: the small parts without a window."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from editor import navigation, preferences
from editor.messages import Messages
from editor.opening import pick_from_folder, scene_stem
from editor.playback import Playback
from editor.preferences import Preferences
from engine.core.errors import FormatError, InputError, UsageError
from engine.core.findings import Severity

# --- preferences ---


def test_preferences_come_back(tmp_path: Path) -> None:
    path = tmp_path / "editor.json"
    wanted = Preferences(recent=["/a", "/b"], keymap="blender", ui_scale=1.5, welcome_seen=True, fly_speed=2.0)
    assert preferences.save(wanted, path) == ""
    assert preferences.load(path) == wanted


@pytest.mark.parametrize("text", ["", "{", "[]", '{"ui_scale": "big", "recent": 3, "keymap": null, "new": 1}'])
def test_damaged_preferences_fall_back_one_by_one(tmp_path: Path, text: str) -> None:
    path = tmp_path / "editor.json"
    path.write_text(text)
    assert preferences.load(path) == Preferences()


def test_values_out_of_range_are_not_taken(tmp_path: Path) -> None:
    path = tmp_path / "editor.json"
    path.write_text(json.dumps({"ui_scale": 90, "fly_speed": -1, "welcome_seen": True, "recent": ["/a", 7]}))
    assert preferences.load(path) == Preferences(welcome_seen=True, recent=["/a"])


def test_preferences_that_cannot_be_written_are_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert "cannot write" in preferences.save(Preferences(), tmp_path / "file" / "editor.json")


def test_recent_files_are_unique_newest_first_and_few(tmp_path: Path) -> None:
    p = Preferences()
    for name in [*"abcdefghijklmnop", "c"]:
        p.add_recent(tmp_path / name)
    assert len(p.recent) == preferences.RECENT_LIMIT
    assert p.recent[:2] == [str(tmp_path / "c"), str(tmp_path / "p")]
    assert len(set(p.recent)) == len(p.recent)


# --- messages ---


def test_messages_carry_place_and_hint() -> None:
    messages = Messages(limit=3)
    messages.error(FormatError("is broken", where="a.glb", hint="export it again"))
    assert messages.snapshot()[0].line().endswith("error: a.glb: is broken (export it again)")
    for i in range(5):
        messages.info(f"n{i}")
    assert [m.text for m in messages.snapshot()] == ["n2", "n3", "n4"]
    assert messages.counts()[Severity.INFO] == 3


# --- playback ---


def test_playback_loops_or_stops() -> None:
    looping = Playback(duration=2.0, playing=True)
    assert looping.tick(2.5)
    assert looping.time == pytest.approx(0.5)
    once = Playback(duration=2.0, playing=True, loop=False)
    once.tick(2.5)
    assert (once.time, once.playing) == (2.0, False)
    once.toggle()
    assert (once.time, once.playing) == (0.0, True)
    still = Playback()
    still.toggle()
    assert not still.playing


def test_steps_are_whole_frames() -> None:
    p = Playback(duration=1.0, time=0.5, playing=True)
    p.step(1)
    assert p.time == pytest.approx(16 / 30)
    assert not p.playing
    p.step(-100)
    assert p.time == 0.0


# --- navigation ---


@pytest.mark.parametrize("preset", navigation.PRESETS)
def test_every_preset_reaches_every_motion(preset: str) -> None:
    motions = {b.motion for b in navigation.PRESETS[preset]}
    assert {"orbit", "pan", "dolly", "environment"} <= motions <= set(navigation.MOTIONS)
    keys = [(b.button, b.modifiers) for b in navigation.PRESETS[preset]]
    assert len(set(keys)) == len(keys), "no gesture means two things"
    assert navigation.hints(preset)


def test_modifiers_match_exactly() -> None:
    assert navigation.motion_for("industry", "left", frozenset({"alt"})) == "orbit"
    assert navigation.motion_for("industry", "left", frozenset()) == "select"
    assert navigation.motion_for("industry", "middle", frozenset({"shift"})) == "pan"
    assert navigation.motion_for("industry", "right", frozenset({"shift"})) == "environment"
    assert navigation.motion_for("industry", "right", frozenset({"ctrl", "alt", "shift"})) == ""
    assert navigation.motion_for("no such preset", "left", frozenset({"alt"})) == "orbit"


# --- opening ---


def test_the_file_of_a_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nothing that can be opened"):
        pick_from_folder(tmp_path, (".glb",))
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "big.glb").write_bytes(b"x" * 100)
    (tmp_path / "small.glb").write_bytes(b"x")
    (tmp_path / "larger.GLB").write_bytes(b"x" * 5)
    (tmp_path / ".hidden").mkdir()
    (tmp_path / ".hidden" / "no.scene.json").write_text("{}")
    assert pick_from_folder(tmp_path, (".glb",)).name == "larger.GLB"
    (tmp_path / "deep" / "a.scene.json").write_text("{}")
    assert pick_from_folder(tmp_path, (".glb",)).name == "a.scene.json"


def test_stems() -> None:
    assert scene_stem(Path("/a/fox.scene.json")) == "fox"
    assert scene_stem(Path("/a/fox.v2.glb")) == "fox.v2"


# --- listings ---


def test_listings_are_sorted_and_read_again(tmp_path: Path) -> None:
    import os

    from editor.panels.folder_listing import FolderListing, kind_of

    for name in ("b.glb", "A.png", ".git", "x.material.toml"):
        (tmp_path / name).write_text("1")
    (tmp_path / "zz").mkdir()
    listing = FolderListing((".glb",))
    assert [e.name for e in listing.entries(tmp_path)] == ["zz", "A.png", "b.glb", "x.material.toml"]
    (tmp_path / "c.scene.json").write_text("{}")
    os.utime(tmp_path, ns=(1, 1))
    assert "c.scene.json" in [e.name for e in listing.entries(tmp_path)]
    assert listing.entries(tmp_path / "gone") == []
    assert [kind_of(n, (".glb",)) for n in ("a.GLB", "p.dds", "project.toml", "q.txt")] == [
        "source", "picture", "project", "file",
    ]  # fmt: skip


# --- timings ---


def test_the_remainder_is_shown_and_shares_add_up() -> None:
    from editor.panels.timings import asleep_line, time_rows
    from engine.report.stats import FrameStats, PassStat

    rows = time_rows(FrameStats([PassStat("a", 2.0), PassStat("b", 1.0)], 4.0))
    assert [(r.name, r.ms) for r in rows] == [("a", 2.0), ("b", 1.0), ("unaccounted", 1.0)]
    assert sum(r.share for r in rows) == pytest.approx(1.0)
    assert asleep_line({"animations": 3, "animations_asleep": 2}) == "2 of 3 animations asleep"
    over = time_rows(FrameStats([PassStat("a", 5.0)], 4.0))
    assert over[-1].ms == 0.0
    assert over[0].share == pytest.approx(1.0)


# --- parameters ---


def test_colours_shown_are_srgb() -> None:
    from editor.param_widgets import linear_from_srgb, srgb_from_linear
    from engine.math.color import linear_to_srgb

    for value in (0.0, 0.001, 0.18, 0.5, 1.0):
        assert srgb_from_linear(value) == pytest.approx(float(linear_to_srgb(value)), abs=1e-6)
        assert linear_from_srgb(srgb_from_linear(value)) == pytest.approx(value, abs=1e-9)
    assert linear_from_srgb(srgb_from_linear(12.0)) == pytest.approx(12.0)


# --- overlay and axes ---


def test_box_brackets_stay_in_front_of_the_camera() -> None:
    from editor.camera_controls import OrbitCamera
    from editor.overlay import EDGES, box_segments

    assert len(EDGES) == 12
    camera = OrbitCamera(yaw=0.0, pitch=0.0, distance=5.0)
    outside = box_segments(camera, np.full(3, -1.0), np.full(3, 1.0), 400, 300)
    assert outside.shape == (24, 2, 2)
    assert (outside >= 0).all()
    inside = box_segments(camera, np.full(3, -20.0), np.full(3, 20.0), 400, 300)
    assert np.isfinite(inside).all()
    assert len(inside) < 24


def test_axes_point_where_the_world_does() -> None:
    from editor.axis_widget import ends_on_screen
    from editor.camera_controls import OrbitCamera

    front = {row[0]: row for row in ends_on_screen(OrbitCamera(yaw=0.0, pitch=0.0), 10.0)}
    assert front["X"][2:4] == pytest.approx((10, 0))
    assert front["Y"][2:4] == pytest.approx((0, -10)), "screen y is down"
    assert front["Z"][4] == pytest.approx(1), "towards the viewer"


# --- tree ---


def test_tree_rows() -> None:
    from fake_engine import FakeRuntime

    from editor.document import Document
    from editor.host import Resolved
    from editor.panels.tree_rows import ancestors, kinds, matching_rows, visible_rows

    document = Document(Resolved(Path("a.glb"), Path("a.scene.json")), FakeRuntime())
    assert [(r.row, r.depth) for r in visible_rows(document, set())] == [(0, 0), (4, 0)]
    assert [(r.row, r.depth) for r in visible_rows(document, {0, 1})] == [(0, 0), (1, 1), (2, 2), (3, 1), (4, 0)]
    assert [r.row for r in matching_rows(document, "lid")] == [0, 1, 2]
    assert ancestors(document, (2,)) == {1, 0}
    assert kinds(document) == {1: "mesh", 2: "mesh", 3: "light", 4: "camera"}


# --- command line ---


@pytest.mark.parametrize("text", ["", "12", "1280x", "ax720", "1280x-3", "10x10", "99999x720"])
def test_bad_sizes(text: str) -> None:
    from editor.command import parse_size

    assert parse_size("1280x720") == (1280, 720)
    with pytest.raises(UsageError, match="is not a size"):
        parse_size(text)


def test_a_missing_file_and_a_missing_display_are_said_before_a_window_opens(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from editor.command import run
    from engine.core.errors import DeviceError

    args = SimpleNamespace(path=tmp_path / "no.glb", screenshot=None, frames=3, size="800x600", select="", fps=None)
    with pytest.raises(InputError, match="no such file"):
        run(args)
    args.path = None
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    with pytest.raises(DeviceError, match="no display"):
        run(args)
