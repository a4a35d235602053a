"""An edited shader that compiles but writes NaN goes back to the last good version before anyone sees it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from engine.gpu.types import Device
from engine.materials.versions import changes
from tests.resources.test_hot_reload import EFFECT, FRAG, INCLUDE, LAST, Project

pytestmark = pytest.mark.gl

#: in a shader of the project: (file, what stands there, what is put there and writes NaN)
SURFACE = (FRAG, LAST, "sanitise(color), sqrt(-1.0 - dot(color, color)))")
SKY = ("shaders/passes/sky.frag", "o_color = ", "o_color = log(-1.0 - gl_FragCoord.x) * ")


@pytest.fixture
def project(gl_device: Device, tmp_path: Path) -> Iterator[Project]:
    made = Project(gl_device, tmp_path)
    yield made
    made.runtime.close()


def line_of(project: Project, file: str, text: str) -> int:
    whole = (project.folder / file).read_text(encoding="utf-8")
    return whole.count("\n", 0, whole.index(text)) + 1


@pytest.mark.parametrize(("file", "old", "new"), [SURFACE, SKY], ids=["effect", "pass"])
def test_the_last_good_picture_stays_and_all_is_well_once_it_is_mended(
    project: Project, file: str, old: str, new: str
) -> None:
    behind = "environment" if file == SKY[0] else "scene"
    project.picture(background=behind)
    project.runtime.residency.set_material_param(0, "roughness", 0.9)
    good = project.picture(background=behind)
    project.edit(file, old, new)
    text = (project.folder / file).read_text(encoding="utf-8")
    project.poll()
    np.testing.assert_array_equal(project.picture(background=behind), good)
    ((state, error),) = project.runtime.hot_reload.standing()
    line = line_of(project, file, new)
    assert (state, Path(error.where.file), error.where.line) == ("previous", project.folder / file, line)
    assert f"the change begins at line {line}" in error.message
    assert "^" in error.message
    assert "NaN" in error.message
    assert project.value("roughness") == 0.9
    assert (project.folder / file).read_text(encoding="utf-8") == text, "the user's text is the user's"
    # what is refused is not taken again because something else moved
    project.write("shaders/lib/other.glsl", "// nothing\n")
    project.edit(INCLUDE, "\n\n", "\n\n\n")
    project.edit(INCLUDE, "\n\n\n", "\n\n")
    project.poll()
    assert project.runtime.hot_reload.unproven == (() if file == FRAG else ("surface",))
    np.testing.assert_array_equal(project.picture(background=behind), good)
    assert [e for _, e in project.runtime.hot_reload.standing()] == [error]
    project.edit(file, new, old)
    project.poll()
    np.testing.assert_array_equal(project.picture(background=behind), good)
    assert project.problems == ()
    assert project.value("roughness") == 0.9


def test_values_of_a_layout_that_goes_back_are_as_they_were(project: Project) -> None:
    project.runtime.residency.set_material_param(0, "roughness", 0.75)
    good = project.picture()
    text = (project.folder / EFFECT).read_text(encoding="utf-8")
    project.write(EFFECT, text.replace("[params.roughness]", "[params.rough]"))
    project.edit(FRAG, "m.roughness;", "m.rough;")
    project.edit(*SURFACE)
    project.poll()
    np.testing.assert_array_equal(project.picture(), good)
    assert project.value("roughness") == 0.75
    assert len(project.problems) == 1


def test_it_is_drawn_anyway_where_that_is_asked_for(project: Project) -> None:
    good = project.picture()
    reload = project.runtime.hot_reload
    assert reload.draw_anyway() == ()
    project.edit(*SURFACE)
    project.edit(FRAG, "sanitise(color), sqrt", "color.bgr, sqrt")
    project.poll()
    project.picture()
    assert reload.refused == ("surface",)
    assert reload.draw_anyway() == ("surface",)
    assert (project.picture() != good).any()
    assert [state for state, _ in reload.standing()] == ["nonfinite"]
    assert not project.runtime.hot_reload.refused
    # from here on NaN is nothing new: further edits are taken, and told of
    bad = project.picture()
    project.edit(FRAG, "color.bgr, sqrt", "0.1 * color, sqrt")
    project.poll()
    assert (project.picture() != bad).any()
    assert [state for state, _ in reload.standing()] == ["nonfinite"]


def test_a_scene_that_had_nan_before_takes_the_new_version(project: Project) -> None:
    project.edit(*SURFACE)
    project.runtime.open(project.folder / "a.scene.json")
    before = project.picture()
    project.edit(FRAG, "sanitise(color), sqrt", "color.bgr, sqrt")
    project.poll()
    after = project.picture()
    assert (after != before).any()
    ((state, error),) = project.runtime.hot_reload.standing()
    assert state == "nonfinite"
    assert error.where.file.endswith("surface.frag")
    assert project.runtime.hot_reload.refused == ()


def test_only_the_first_picture_is_looked_into(project: Project) -> None:
    def frame() -> dict[str, int]:
        project.picture()
        return project.runtime.device.counters.snapshot()

    frame()
    steady = frame()
    project.edit(FRAG, LAST, "sanitise(color.bgr), 1.0)")
    project.poll()
    first = frame()
    assert first["dispatches"] > steady["dispatches"], "the new version is looked into"
    frame()  # what the change left to upload
    assert frame() == steady
    assert project.runtime.hot_reload.proofs == 1


def test_where_a_change_begins() -> None:
    a, b, c = Path("a"), Path("b"), Path("c")
    found = changes({a: "one\ntwo\n", b: "same"}, {a: "one\ntoo\nthree\n", b: "same", c: "new"})
    assert [(p.file, p.line, p.column) for p in found] == [("a", 2, 2)]
    assert [(p.line, p.column) for p in changes({a: "one\n"}, {a: "one\ntwo"})] == [(2, 1)]
