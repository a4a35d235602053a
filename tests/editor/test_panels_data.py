"""What the frame graph, texture viewer, selection and "copy as command" compute, without a window."""

from __future__ import annotations

import shlex
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from edited_stage import document
from fake_engine import FakeHost

from editor.as_command import render_command
from editor.camera_controls import OrbitCamera
from editor.graph_layout import diagram
from editor.overlay import metres
from editor.preferences import Preferences
from editor.selecting import hidden_by_isolating, nodes_in_box
from editor.session import Session
from editor.texture_view import INF_COLOR, NAN_COLOR, as_float, overwritten, picture, value_range
from engine.framegraph.builder import Declaration
from engine.framegraph.compiled import LeftOut


def passes() -> list[Declaration]:
    return [
        Declaration("shadow", creates=["map"], writes=["map"]),
        Declaration("opaque", creates=["hdr", "depth"], reads=["map"], writes=["hdr", "depth"]),
        Declaration("sky", reads=["depth"], writes=["hdr"]),
        Declaration("tone_map", creates=["color"], reads=["hdr"], writes=["color"], presents=["color"]),
    ]


def test_passes_stand_behind_what_they_need() -> None:
    found = diagram(passes(), [LeftOut("resolve", "one sample", 4096)])
    assert [(b.name, b.column) for b in found.boxes[:4]] == [("shadow", 0), ("opaque", 1), ("sky", 2), ("tone_map", 3)]
    ways = {(e.start, e.end): e.resources for e in found.edges}
    assert ways == {(0, 1): ("map",), (1, 2): ("depth", "hdr"), (2, 3): ("hdr",)}
    out = found.boxes[4]
    assert (out.reason, out.saved, out.row) == ("one sample", 4096, 1)
    assert len({(b.column, b.row) for b in found.boxes}) == 5, "no two boxes in one place"


def test_histories_are_edges_of_their_own_and_take_no_column() -> None:
    declarations = [
        Declaration("reproject", creates=["a"], writes=["a"], histories=["taa"]),
        Declaration("taa", creates=["taa"], reads=["a"], writes=["taa"]),
    ]
    found = diagram(declarations, [])
    assert [b.column for b in found.boxes] == [0, 1]
    assert [(e.start, e.end, e.history) for e in found.edges] == [(0, 1, False), (1, 0, True)]


def test_an_empty_graph_is_an_empty_diagram() -> None:
    assert diagram([], []).boxes == ()


def test_whole_numbers_become_shares() -> None:
    assert as_float(np.array([[0, 255]], np.uint8))[0, :, 0].tolist() == [0.0, 1.0]
    assert as_float(np.array([[[65535]]], np.uint16))[0, 0, 0] == 1.0


@pytest.mark.parametrize(
    ("channels", "expected"),
    [("rgb", (255, 128, 0)), ("r", (255, 255, 255)), ("g", (128, 128, 128)), ("b", (0, 0, 0)), ("a", (64, 64, 64))],
)
def test_channels(channels: str, expected: tuple[int, ...]) -> None:
    values = np.array([[[1.0, 0.5, 0.0, 0.25]]], np.float32)
    assert tuple(picture(values, channels, 0.0, 0.0, 1.0, encode=False)[0, 0, :3].tolist()) == expected


def test_exposure_range_and_encoding() -> None:
    values = np.full((1, 1, 3), 0.25, np.float32)
    assert picture(values, "rgb", 1.0, 0.0, 1.0, encode=False)[0, 0, 0] == 128
    assert picture(values, "rgb", 0.0, 0.0, 0.5, encode=False)[0, 0, 0] == 128
    assert picture(np.full((1, 1, 3), 0.18, np.float32), "rgb", 0.0, 0.0, 1.0, encode=True)[0, 0, 0] == 118


def test_what_is_no_number_is_marked() -> None:
    values = np.array([[[np.nan, 0.0, 0.0], [0.0, np.inf, 0.0], [0.0, 0.0, 0.0]]], np.float32)
    shown = picture(values, "rgb", 0.0, 0.0, 1.0, encode=True)
    assert [tuple(p[:3]) for p in shown[0].tolist()] == [NAN_COLOR, INF_COLOR, (0, 0, 0)]
    assert value_range(values) == (0.0, 0.0)
    assert value_range(np.full((1, 1, 1), np.nan, np.float32)) == (0.0, 1.0)


def test_a_normal_gets_its_third_component() -> None:
    flat = np.full((1, 1, 2), 0.5, np.float32)
    assert picture(flat, "rgb", 0.0, 0.0, 1.0, encode=False, normal=True)[0, 0, 2] == 255
    assert picture(flat, "rgb", 0.0, 0.0, 1.0, encode=False)[0, 0, 2] == 0


def test_memory_used_again_is_told() -> None:
    spans = {"a": SimpleNamespace(first=0), "b": SimpleNamespace(first=2), "c": SimpleNamespace(first=1)}
    plan = SimpleNamespace(slots={"a": 0, "b": 0, "c": 1}, spans=spans)
    assert [overwritten(plan, n) for n in ("a", "b", "c", "imported")] == [True, False, False, False]


def test_a_box_takes_visible_unlocked_middles() -> None:
    doc = document()
    camera = OrbitCamera((0.0, 0.0, 0.0), 0.0, 0.0, distance=50.0)
    everything = nodes_in_box(doc, camera, (0.0, 0.0), (1.0, 1.0), 1.5)
    assert everything == [2, 3, 4, 7]
    doc.locked.add(3)
    doc.edit("nodes", "visible", (7,), (False,))
    assert nodes_in_box(doc, camera, (1.0, 1.0), (0.0, 0.0), 1.5) == [2, 4]
    assert nodes_in_box(doc, camera, (0.0, 0.0), (0.1, 0.1), 1.5) == []


def test_isolating_keeps_lights_and_ancestors() -> None:
    doc = document()
    assert hidden_by_isolating(doc, (7,)) == [2]
    assert hidden_by_isolating(doc, (1,)) == [7]
    assert hidden_by_isolating(doc, (0,)) == []


@pytest.mark.parametrize(
    ("length", "said"), [(2.5, "2.5 m"), (0.034, "3.4 cm"), (0.002, "2 mm"), (12345.0, "12.35 km")]
)
def test_lengths_are_said_as_a_person_would(length: float, said: str) -> None:
    assert metres(length) == said


def test_the_command_renders_what_is_shown() -> None:
    from importers.cli import render

    session = Session(FakeHost(), Preferences(), save_preferences=False)
    session.device = session.host.open_device(attach=False)
    session.open(Path("/no where/thing.glb"))
    assert session.job is not None
    session.job.wait(10)
    session.poll()
    session.camera = OrbitCamera((1.0, 2.0, 3.0), 0.5, -0.2, distance=4.0, orthographic=True)
    session.settings.exposure = 1.5
    words = shlex.split(render_command(session))
    assert words[:3] == ["lucarna", "render", "/no where/thing.glb"]
    assert "exposure=1.5" in words
    import argparse

    parser = argparse.ArgumentParser()
    render.add_arguments(parser)
    args: Any = parser.parse_args(words[2:])
    from importers.cli.render_camera import free_camera

    made = free_camera(args)
    assert made is not None
    assert made.world_from_camera == pytest.approx(session.camera.world_from_camera(), abs=1e-7)
    assert (made.yfov, made.ymag) == (pytest.approx(session.camera.yfov), pytest.approx(session.camera.ymag))
