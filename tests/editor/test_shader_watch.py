"""The session's side of hot reload: the badge, the log, next error, saving from the editor; on the null device."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from small_scene import write_small_scene

from editor.builtin_operations import builtin_operations
from editor.document import Document
from editor.host import EngineHost, Resolved
from editor.session import Session
from engine.core.paths import shaders_dir
from engine.gpu import open_device

EFFECT = "shaders/effects/surface.effect.toml"


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    scene = write_small_scene(tmp_path)
    shutil.copytree(shaders_dir(), tmp_path / "shaders")
    made = Session(EngineHost())
    made.save_preferences = False
    made.device = open_device("null")
    made.adopt(Document(Resolved(scene, scene), made.host.open_runtime(made.device, scene, tmp_path)))
    made.poll()
    made.image.update(made, 64, 48)
    yield made
    made.shaders.stop()
    made.close()


def edit(session: Session, file: str, old: str, new: str) -> None:
    assert session.document is not None
    path = session.document.source.parent / file
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    info = path.stat()
    os.utime(path, ns=(info.st_atime_ns, info.st_mtime_ns + 1_000_000))
    session.shaders.reload(session, force=False)


def test_a_mistake_shows_as_badge_and_in_the_log_and_goes(session: Session) -> None:
    assert session.shaders.badge == ""
    edit(session, EFFECT, "\ndoc = ", "\ndok = ")
    assert session.shaders.badge.startswith("running previous version: surface.effect.toml:3:1  unknown key 'dok'")
    message = session.messages.snapshot()[-1]
    assert message.where.endswith("surface.effect.toml:3:1")
    count = len(session.messages.snapshot())
    session.shaders.reload(session, force=True)
    assert len([m for m in session.messages.snapshot()[count:] if "dok" in m.text]) == 0, "said once"
    edit(session, EFFECT, "\ndok = ", "\ndoc = ")
    assert session.shaders.badge == ""
    assert session.messages.snapshot()[-1].text == "All shader errors are gone"


def test_next_error_goes_round(session: Session) -> None:
    operations = builtin_operations()
    operations.run("shader.next-error", session)
    assert session.ui.notice == "No errors"
    edit(session, EFFECT, "\ndoc = ", "\ndok = ")
    edit(session, "boxes.red.material.toml", "metallic = ", "metalic = ")
    opened = []
    for _ in range(3):
        operations.run("shader.next-error", session)
        assert session.code.front is not None
        opened.append((session.code.front.name, session.code.cursor))
    assert opened[0] == opened[2] == ("surface.effect.toml", (3, 1))
    assert opened[1][0] == "boxes.red.material.toml"
    assert session.ui.focus_panel == "Shader editor"


def test_the_effect_and_the_file_of_the_selected_material_open(session: Session) -> None:
    operations = builtin_operations()
    assert not operations.run("shader.effect", session), "nothing is selected"
    assert session.document is not None
    session.document.select(2)
    operations.run("shader.effect", session)
    assert [d.name for d in session.code.documents] == ["surface.effect.toml", "surface.frag"]
    operations.run("shader.material", session)
    assert session.code.front is not None
    assert session.code.front.name == "boxes.red.material.toml"


def test_saving_the_text_in_front_changes_the_scene(session: Session, tmp_path: Path) -> None:
    operations = builtin_operations()
    session.open_code(tmp_path / "boxes.red.material.toml")
    front = session.code.front
    assert front is not None
    front.edit(front.text.replace("roughness = 0.5", "roughness = 0.25"))
    session.code.focused = True
    operations.run("file.save", session)
    assert not front.dirty
    assert session.document is not None
    residency = session.document.runtime.residency
    ids = [i for i, r in enumerate(residency.materials.records) if r.path.endswith("boxes.red.material.toml")]
    assert residency.materials.get_param(ids[0], "roughness") == 0.25
    assert not (tmp_path / "boxes.scene.json.tmp").exists()


def test_undo_works_on_after_a_material_file_changed(session: Session) -> None:
    assert session.document is not None
    residency = session.document.runtime.residency
    red = next(i for i, r in enumerate(residency.materials.records) if r.path.endswith("red.material.toml"))
    session.edit("materials", "roughness", (red,), (0.9,))
    edit(session, "boxes.red.material.toml", "metallic = 0.0", "metallic = 0.6")
    assert residency.materials.get_param(red, "metallic") == 0.6
    assert residency.materials.get_param(red, "roughness") == 0.9, "unsaved edits outlive the reload"
    session.undo()
    assert residency.materials.get_param(red, "roughness") == 0.5


def test_the_thread_wakes_the_window(session: Session) -> None:
    woken: list[float] = []
    session.shaders.wake = lambda: woken.append(time.monotonic())
    assert session.document is not None
    path = session.document.source.parent / EFFECT
    path.write_text(path.read_text(encoding="utf-8") + "\n# changed\n", encoding="utf-8")
    end = time.monotonic() + 10.0
    while not woken and time.monotonic() < end:
        time.sleep(0.02)
    assert woken
    before = session.shaders.taken
    session.poll()
    assert session.shaders.taken == before + 1


def test_closing_the_scene_forgets_its_errors(session: Session) -> None:
    edit(session, EFFECT, "\ndoc = ", "\ndok = ")
    session.close()
    session.poll()
    assert session.shaders.problems == ()


def test_unsaved_text_is_asked_for_before_the_window_closes(session: Session, tmp_path: Path) -> None:
    assert session.request_quit()
    session.open_code(tmp_path / "boxes.red.material.toml")
    assert session.code.front is not None
    session.code.front.edit(session.code.front.text + "# a word\n")
    assert not session.request_quit()
    assert session.unsaved == ["boxes.red.material.toml"]
    assert session.save_all()
    assert session.request_quit()
    assert (tmp_path / "boxes.red.material.toml").read_text(encoding="utf-8").endswith("# a word\n")
