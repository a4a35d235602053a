"""What materials say besides numbers (textures, features, queue): edited, undone, saved; comments stay."""

from __future__ import annotations

import json
import time
from pathlib import Path

import numpy as np
import pytest

from editor import material_editing as editing
from editor import work
from editor.document import Document
from editor.host import EngineHost, Resolved
from editor.journal import edit_from_plain, edit_to_plain
from editor.picture_texture import write_texture
from editor.preferences import Preferences
from editor.saving import save_document
from editor.session import Session
from editor.tables import FEATURES, QUEUE
from engine.assets.dds import read_dds, write_dds
from engine.assets.material_toml import read_material
from engine.assets.texture import TextureAsset
from engine.gpu.types import Device
from engine.report.image import save_png
from tests.editor.support.small_scene import write_small_scene

RED = "boxes.red.material.toml"
#: by hand, with comments in all places, an order of its own, an inline table
BY_HAND = """\
# Red paint, as agreed with the client.
schema = "lucarna.material/1"  # do not touch
name = "red"

[params]
roughness = 0.5      # satin
# the colour of the client's logo
base_color = [0.8, 0.05, 0.05, 1.0]
metallic = 0.0

[textures]
base_color_map = { path = "paint.dds", wrap_u = "clamp" }  # one tile
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_small_scene(tmp_path)
    (tmp_path / RED).write_text(BY_HAND, encoding="utf-8")
    for name in ("paint", "rust"):
        write_dds(tmp_path / f"{name}.dds", TextureAsset("rgba8-srgb", 1, 1, [[bytes((200, 100, 50, 255))]], name=name))
    return tmp_path


@pytest.fixture
def session(folder: Path, null_device: Device) -> Session:
    return opened(folder, null_device)


def opened(folder: Path, null_device: Device) -> Session:
    scene = folder / "boxes.scene.json"
    session = Session(EngineHost(), Preferences(), device=null_device)
    session.save_preferences = False
    runtime = session.host.open_runtime(null_device, scene)
    session.document = Document(Resolved(scene, scene), runtime)
    return session


def red(session: Session) -> int:
    assert session.document is not None
    records = session.document.runtime.residency.materials.records
    return next(i for i, record in enumerate(records) if record.asset.name == "red")


def test_a_texture_is_put_into_a_slot_undone_and_saved_beside_the_comments(session: Session, folder: Path) -> None:
    assert session.document is not None
    residency, material = session.document.runtime.residency, red(session)
    first = residency.materials.slot_texture(material, "base_color_map")[1]
    editing.set_texture(session, [material], "base_color_map", folder / "rust.dds")
    assert residency.materials.slot_texture(material, "base_color_map")[1] != first
    session.undo()
    assert residency.materials.slot_texture(material, "base_color_map")[1] == first
    session.redo()
    editing.set_texture(session, [material], "emissive_map", folder / "paint.dds")
    editing.set_param(session, [material], "metallic", 0.25)
    save_document(session.document, folder / "boxes.scene.json")
    text = (folder / RED).read_text(encoding="utf-8")
    said = read_material(folder / RED)
    assert said.textures["base_color_map"].path == "rust.dds", "named as the file lies beside it"
    assert said.textures["base_color_map"].wrap_u == "clamp", "sampled as the one before"
    assert said.textures["emissive_map"].path == "paint.dds"
    assert said.params["metallic"] == 0.25
    for comment in (
        "# Red paint, as agreed",
        "# do not touch",
        "# satin",
        "# the colour of the client's logo",
        "# one tile",
    ):
        assert comment in text, comment
    assert text.index("roughness") < text.index("base_color") < text.index("metallic"), "the author's order"


def test_what_is_not_edited_stays_byte_for_byte(session: Session, folder: Path) -> None:
    assert session.document is not None
    editing.set_param(session, [red(session)], "roughness", 0.25)
    save_document(session.document, folder / "boxes.scene.json")
    assert (folder / RED).read_text(encoding="utf-8") == BY_HAND.replace("roughness = 0.5 ", "roughness = 0.25 ")


def test_inline_parameters_stay_inline(session: Session, folder: Path) -> None:
    text = 'schema = "lucarna.material/1"\nname = "red"\nparams = { roughness = 0.5, metallic = 0.0 }  # short\n'
    (folder / RED).write_text(text, encoding="utf-8")
    assert session.document is not None
    editing.set_param(session, [red(session)], "roughness", 0.25)
    save_document(session.document, folder / "boxes.scene.json")
    assert (folder / RED).read_text(encoding="utf-8") == text.replace("0.5", "0.25")


def test_features_and_queue_are_undoable_and_saved(session: Session, folder: Path) -> None:
    assert session.document is not None
    residency, material = session.document.runtime.residency, red(session)
    editing.set_parts(session, [material], {FEATURES: ("unlit",), QUEUE: "transparent"}, "Glass")
    assert (residency.material(material).asset.features, residency.material(material).asset.queue) == (
        ["unlit"],
        "transparent",
    )
    save_document(session.document, folder / "boxes.scene.json")
    said = read_material(folder / RED)
    assert (said.features, said.queue) == (["unlit"], "transparent")
    session.undo()
    assert (residency.material(material).asset.features, residency.material(material).asset.queue) == ([], "opaque")
    assert len(session.document.history.entries) == 0, "both were one entry"


def test_a_whole_material_is_pasted_on_another(session: Session) -> None:
    assert session.document is not None
    residency, material = session.document.runtime.residency, red(session)
    other = next(i for i, r in enumerate(residency.materials.records) if r.asset.name == "grey")
    editing.paste(session, [other], editing.copy_text(session, material))
    asset = residency.material(other).asset
    assert asset.name == "grey"
    assert asset.params["base_color"] == (0.8, 0.05, 0.05, 1.0)
    assert asset.textures["base_color_map"].wrap_u == "clamp"
    session.undo()
    assert residency.material(other).asset.textures == {}
    assert residency.material(other).asset.params["base_color"] == (0.4, 0.4, 0.4, 1.0)


def test_of_a_picture_a_texture_is_made_aside(session: Session, folder: Path) -> None:
    assert session.document is not None
    save_png(folder / "photo.png", np.full((8, 8, 3), (200, 100, 50), np.uint8))
    residency, material = session.document.runtime.residency, red(session)
    editing.set_texture(session, [material], "emissive_map", folder / "photo.png")
    assert "emissive_map" not in residency.material(material).asset.textures, "not at once"
    end = time.monotonic() + 20.0
    while session.work is not None and time.monotonic() < end:
        work.step(session)
    ref = residency.material(material).asset.textures["emissive_map"]
    assert Path(ref.path) == (folder / "photo.emissive.dds").resolve()
    texture = read_dds(folder / "photo.emissive.dds")
    assert (texture.format, texture.width, texture.mip_count) == ("bc7-srgb", 8, 4)
    assert write_texture(folder / "photo.png", folder, "emissive_map", "srgb").name == "photo.emissive.dds", "the same"
    save_png(folder / "photo.png", np.zeros((8, 8, 3), np.uint8))
    assert write_texture(folder / "photo.png", folder, "emissive_map", "srgb").name == "photo.emissive.2.dds"
    session.undo()
    assert "emissive_map" not in residency.material(material).asset.textures


def test_a_damaged_picture_and_what_is_none_are_told(session: Session, folder: Path) -> None:
    assert session.document is not None
    (folder / "photo.png").write_bytes(b"no picture")
    editing.set_texture(session, [red(session)], "base_color_map", folder / "photo.png")
    end = time.monotonic() + 20.0
    while session.work is not None and time.monotonic() < end:
        work.step(session)
    assert "photo.png" in session.ui.error_bar
    editing.set_texture(session, [red(session)], "base_color_map", folder / "notes.md")
    assert "no picture or texture" in session.ui.notice
    assert len(session.document.history.entries) == 0


def test_a_chosen_texture_goes_along_when_the_scene_is_saved_elsewhere(session: Session, folder: Path) -> None:
    assert session.document is not None
    editing.set_texture(session, [red(session)], "emissive_map", folder / "rust.dds")
    save_document(session.document, folder / "copy" / "boxes.scene.json")
    said = read_material(folder / "copy" / RED)
    assert said.textures["emissive_map"].path == "rust.dds"
    assert (folder / "copy" / "rust.dds").is_file()


def test_what_a_material_inherits_is_its_default_and_is_not_written_down(folder: Path, null_device: Device) -> None:
    child = editing.derive(folder / RED)
    grey = folder / "boxes.grey.material.toml"
    grey.write_bytes(child.read_bytes())  # the scene's grey one now comes from the red one
    session = opened(folder, null_device)
    assert session.document is not None
    residency = session.document.runtime.residency
    material = next(i for i, r in enumerate(residency.materials.records) if r.path.endswith("grey.material.toml"))
    roughness = next(s for s in editing.shared_params(residency, [material]) if s.param.name == "roughness")
    assert (roughness.values, roughness.param.default, roughness.changed) == ((0.5,), 0.5, False)
    editing.set_param(session, [material], "roughness", 0.9)
    editing.set_param(session, [material], "metallic", 1.0)
    editing.reset(session, [material], ["roughness"])
    assert residency.material(material).asset.params["roughness"] == 0.5, "back to the parent's, not to the effect's"
    save_document(session.document, folder / "boxes.scene.json")
    text = grey.read_text(encoding="utf-8")
    assert "roughness" not in text
    assert "metallic = 1.0" in text
    assert read_material(grey).params["roughness"] == 0.5


def test_such_edits_go_through_the_journal(session: Session, folder: Path) -> None:
    assert session.document is not None
    editing.set_texture(session, [red(session)], "emissive_map", folder / "rust.dds")
    editing.set_parts(session, [red(session)], {FEATURES: ("unlit",), QUEUE: "transparent"}, "Glass")
    for edit in session.document.history.entries:
        line = json.loads(json.dumps(edit_to_plain(edit)))
        assert edit_from_plain(line, session.document) == edit
