"""What the Variants panel shows, measuring features in steps, shaders that are made while the last picture stays."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from small_scene import write_small_scene

from editor import work
from editor.builtin_operations import builtin_operations
from editor.code.feature_work import MeasureFeatures, told, verdict_of
from editor.code.variant_rows import source_lines, stages_of, variant_rows
from editor.document import Document
from editor.host import EngineHost, Resolved
from editor.session import Session
from engine.assets.material_toml import update_material
from engine.core.paths import shaders_dir
from engine.gpu.types import Device


@pytest.fixture
def session(gl_device: Device, tmp_path: Path) -> Iterator[Session]:
    """Two materials: a red one that is unlit, a grey one that is alpha tested though it is solid."""
    scene = write_small_scene(tmp_path)
    update_material(tmp_path / "boxes.red.material.toml", {"features": ["unlit"]})
    update_material(tmp_path / "boxes.grey.material.toml", {"features": ["alpha_test"]})
    made = Session(EngineHost())
    made.save_preferences = False
    made.device = gl_device
    made.adopt(Document(Resolved(scene, scene), made.host.open_runtime(gl_device, scene, tmp_path)))
    yield made
    made.shaders.stop()
    made.close()


def test_rows_sources_and_generated_blocks(session: Session) -> None:
    session.image.update(session, 64, 48)
    assert session.document is not None
    runtime = session.document.runtime
    rows = variant_rows(runtime)
    unlit = next(row for row in rows if "unlit" in row.features)
    assert unlit.materials == ("red",)
    assert dict(unlit.reasons)["unlit"] == "the material asks for it"
    assert not unlit.loaded
    library = runtime.residency.effects
    assert stages_of(library, unlit.variant) == ["vertex", "fragment"]
    lines = source_lines(library, unlit.variant, "fragment")
    assert any(Path(file).name == "surface.frag" and line > 1 for file, line, _ in lines)
    generated = [code for _, _, code in source_lines(library, unlit.variant, "generated")]
    assert any(code.startswith("struct MaterialParams") for code in generated)


def test_measuring_goes_on_between_frames_and_says_which_feature_is_idle(session: Session) -> None:
    session.image.update(session, 64, 48)
    before = session.image.pixels()
    builtin_operations().run("view.measure-features", session)
    assert isinstance(session.work, MeasureFeatures)
    steps = 0
    while session.work is not None:
        work.step(session)
        steps += 1
        session.image.update(session, 64, 48)
        np.testing.assert_array_equal(session.image.pixels(), before)
    assert steps > 4
    found = session.feature_effects
    assert found is not None
    assert "alpha_test" in told(found)
    assert "unlit" not in told(found)
    idle = verdict_of(found, "surface", frozenset({"alpha_test"}), "alpha_test")
    assert idle is not None
    assert idle.verdict == "never changes a pixel"


def test_called_off(session: Session) -> None:
    session.image.update(session, 64, 48)
    before = session.image.pixels()
    work.start(session, MeasureFeatures())
    for _ in range(2):
        work.step(session)
    work.cancel(session)
    assert session.feature_effects is None
    session.image.invalidate()
    session.image.update(session, 64, 48)
    np.testing.assert_array_equal(session.image.pixels(), before)


def test_the_window_goes_on_while_shaders_are_made(session: Session) -> None:
    session.image.patience = 0.0
    told_of = []
    for _ in range(60):
        frame = session.image.update(session, 64, 48)
        if session.image.compiling is None:
            break
        told_of.append(session.image.compiling)
    assert frame is not None
    assert session.image.renders == 1
    assert len(told_of) > 1
    assert all(0 <= done < total for done, total in told_of)
    settled = session.image.pixels()
    session.settings.view = "normal"
    stays = 0
    while session.image.update(session, 64, 48) is frame:
        np.testing.assert_array_equal(session.image.pixels(), settled)
        stays += 1
    assert stays > 1
    assert session.image.renders == 2
    assert (session.image.pixels() != settled).any()


def test_a_shader_that_writes_nan_gets_a_badge_until_it_is_mended(session: Session, tmp_path: Path) -> None:
    path = tmp_path / "shaders/effects/surface.frag"
    path.parent.mkdir(parents=True)
    sound = (shaders_dir() / "effects/surface.frag").read_text(encoding="utf-8")
    good = "vec4(sanitise(color), 1.0)"
    assert good in sound
    session.poll()
    session.image.update(session, 64, 48)

    def saved(text: str) -> None:
        path.write_text(text, encoding="utf-8")
        session.shaders.reload(session, force=True)
        session.poll()  # nothing to look at before the first picture
        session.image.update(session, 64, 48)
        session.poll()

    saved(sound.replace(good, "vec4(log(-dot(color, color) - 1.0))"))
    assert session.shaders.badge.startswith("not finite: surface.frag")
    assert "NaN" in session.shaders.badge
    saved(sound)
    assert session.shaders.badge == ""
