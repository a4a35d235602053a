"""Thumbnails of asset files: what is shown while, after and instead; what makes them, and their cache."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from editor import asset_thumbnails as pictures
from editor import thumbnail_maker as maker
from editor.asset_thumbnails import AssetThumbnails
from editor.panels.folder_listing import FolderListing
from engine.core.errors import FormatError, InputError
from engine.gpu.types import Device
from engine.report.image import load_png, save_png
from tests.editor.support.small_scene import write_small_scene

STAMP = (1, 100)


@pytest.fixture
def session(null_device: Device) -> Any:
    return SimpleNamespace(device=null_device, device_frame=nullcontext)


def painted(tmp_path: Path, colour: tuple[int, int, int]) -> Path:
    path = tmp_path / f"{colour[0]}.png"
    save_png(path, np.full((8, 8, 3), colour, np.uint8))
    return path


def until(thumbnails: AssetThumbnails, session: Any, what: Callable[[], bool]) -> bool:
    end = time.monotonic() + 20.0
    while not what() and time.monotonic() < end:
        thumbnails.pump(session)
        time.sleep(0.002)
    return what()


def test_it_waits_is_made_elsewhere_and_then_shows(session: Any, tmp_path: Path) -> None:
    gate, where = threading.Event(), []

    def make(path: Path, root: Path) -> Path:
        gate.wait(20.0)
        where.append((threading.current_thread(), path.name, root))
        return painted(tmp_path, (200, 10, 10))

    thumbnails = AssetThumbnails(make)
    path = tmp_path / "a.png"
    assert thumbnails.get(path, STAMP, tmp_path).state == pictures.WAITING
    thumbnails.pump(session)
    assert thumbnails.get(path, STAMP, tmp_path).state == pictures.WAITING, "the window does not wait"
    gate.set()
    assert until(thumbnails, session, lambda: thumbnails.get(path, STAMP, tmp_path).state == pictures.READY)
    assert where[0][0] is not threading.main_thread()
    assert where[0][1:] == ("a.png", tmp_path)
    assert session.device.live_objects()["texture"] == 1
    thumbnails.get(path, STAMP, tmp_path)
    assert len(where) == 1, "made once"
    thumbnails.stop()
    thumbnails.forget(session)
    assert session.device.live_objects()["texture"] == 0


def test_what_cannot_be_made_says_why(session: Any, tmp_path: Path) -> None:
    def make(path: Path, root: Path) -> Path:
        raise FormatError("is damaged", where=path, hint="export it again")

    thumbnails = AssetThumbnails(make)
    assert until(
        thumbnails, session, lambda: thumbnails.get(tmp_path / "x.glb", STAMP, tmp_path).state == pictures.BROKEN
    )
    found = thumbnails.get(tmp_path / "x.glb", STAMP, tmp_path)
    assert "x.glb: is damaged" in found.error
    assert thumbnails.get(tmp_path / "notes.md", STAMP, tmp_path).state == pictures.NONE
    thumbnails.stop()


def test_the_old_picture_stays_until_a_changed_file_has_a_new_one(session: Any, tmp_path: Path) -> None:
    gate = threading.Event()
    gate.set()

    def make(path: Path, root: Path) -> Path:
        gate.wait(20.0)
        return painted(tmp_path, (9, 9, 9))

    thumbnails = AssetThumbnails(make)
    path = tmp_path / "a.material.toml"
    assert until(thumbnails, session, lambda: thumbnails.get(path, STAMP, tmp_path).state == pictures.READY)
    gate.clear()
    changed = thumbnails.get(path, (2, 100), tmp_path)
    assert changed.state == pictures.READY, "not blank meanwhile"
    old = changed.texture
    reloaded = thumbnails.get(path, (2, 100), tmp_path, generation=1)
    assert reloaded.texture is old, "a hot reload makes a material's anew as well"
    gate.set()
    assert until(thumbnails, session, lambda: reloaded.texture is not old and not thumbnails.waiting)
    thumbnails.stop()
    thumbnails.forget(session)
    assert session.device.live_objects()["texture"] == 0


def test_what_scrolled_by_is_not_made_and_the_last_asked_for_comes_first(session: Any, tmp_path: Path) -> None:
    gate, order = threading.Event(), []

    def make(path: Path, root: Path) -> Path:
        gate.wait(20.0)
        order.append(path.stem)
        return painted(tmp_path, (1, 1, 1))

    thumbnails = AssetThumbnails(make)
    for name in "abcdef":
        thumbnails.get(tmp_path / f"{name}.png", STAMP, tmp_path)
    for _ in range(pictures.PATIENCE + 2):
        thumbnails.pump(session)
        for name in "ef":
            thumbnails.get(tmp_path / f"{name}.png", STAMP, tmp_path)
    gate.set()
    assert until(thumbnails, session, lambda: not thumbnails.waiting and len(order) >= 2)
    assert set(order) <= {"a", "e", "f"}, "the first was begun at once; b, c, d were never looked at again"
    thumbnails.stop()
    thumbnails.forget(session)


def test_a_material_is_made_anew_when_what_it_comes_from_changes(tmp_path: Path) -> None:
    write_small_scene(tmp_path)
    parent = tmp_path / "boxes.red.material.toml"
    child = tmp_path / "child.material.toml"
    child.write_text(f'schema = "lucarna.material/1"\nname = "child"\nparent = "{parent.name}"\n', encoding="utf-8")
    before = maker.key_of(child, tmp_path)
    assert maker.key_of(child, tmp_path) == before
    parent.write_text(parent.read_text().replace("roughness = 0.5", "roughness = 0.6"), encoding="utf-8")
    after = maker.key_of(child, tmp_path)
    assert after != before
    (tmp_path / "effects").mkdir()
    (tmp_path / "effects" / "extra.glsl").write_text("// a shader of the project", encoding="utf-8")
    assert maker.key_of(child, tmp_path) != after


@pytest.mark.parametrize(
    ("name", "sort"),
    [
        ("a.glb", "models"), ("a.scene.json", "models"), ("a.lmesh", "models"), ("wood.material.toml", "materials"),
        ("Wood_BaseColor.PNG", "textures"), ("sky.hdr", "environments"), ("toon.effect.toml", "effects"),
        ("walk.lanim", "animations"), ("readme.md", "other"), ("project.toml", "other"),
    ],
)  # fmt: skip
def test_sorts_by_name(name: str, sort: str) -> None:
    assert maker.sort_of(name) == sort


def test_a_texture_keeps_its_shape_and_its_colours(tmp_path: Path) -> None:
    pixels = np.zeros((100, 400, 3), np.uint8)
    pixels[:, :200], pixels[:, 200:] = (255, 0, 0), (0, 0, 255)
    save_png(tmp_path / "wide.png", pixels)
    made = maker.picture(tmp_path / "wide.png", tmp_path)
    size = maker.SIZE
    assert made.shape == (size, size, 4)
    assert made[size // 2, 10].tolist() == [255, 0, 0, 255]
    assert made[size // 2, -10].tolist() == [0, 0, 255, 255]
    assert made[4, 4, 3] == 0, "nothing above a wide one"
    assert made[:, size // 4, 3].sum() == 255 * size // 4


def test_a_checker_shrinks_in_linear_light(tmp_path: Path) -> None:
    checker = (np.indices((768, 768)).sum(axis=0) % 2 * 255).astype(np.uint8)
    save_png(tmp_path / "checker.png", np.repeat(checker[..., None], 3, axis=2))
    middle = maker.picture(tmp_path / "checker.png", tmp_path)[80:110, 80:110, :3]
    assert np.abs(middle.astype(int) - 188).max() <= 2, "half of white is 188 encoded, not 128"


def test_the_cache_goes_by_content(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    path = tmp_path / "a.png"
    save_png(path, np.full((4, 4, 3), 200, np.uint8))
    request = {"path": str(path), "root": str(tmp_path), "background": False}
    first = Path(maker.make(request)["file"])
    os.utime(path, (0, 0))
    assert Path(maker.make(request)["file"]) == first, "only touched"
    save_png(path, np.full((4, 4, 3), 100, np.uint8))
    second = Path(maker.make(request)["file"])
    assert second != first
    assert load_png(second)[90, 90, 0] == 100
    monkeypatch.setattr(maker, "MAX_SOURCE", 10)
    (tmp_path / "big.glb").write_bytes(bytes(100))
    with pytest.raises(InputError, match="too large"):
        maker.make({"path": str(tmp_path / "big.glb"), "root": str(tmp_path)})


@pytest.mark.window  # it opens a graphics device in a process of its own
def test_a_material_and_its_mistake_by_a_real_worker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    write_small_scene(tmp_path)
    make = pictures.WorkerMaker()
    made = load_png(make(tmp_path / "boxes.red.material.toml", tmp_path))
    middle = made[maker.SIZE // 2, maker.SIZE // 2].astype(int)
    assert middle[0] > 2 * middle[1], "a red ball"
    bad = tmp_path / "bad.material.toml"
    bad.write_text('schema = "lucarna.material/1"\nname = "bad"\n[params]\nrougness = 0.5\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"did you mean 'roughness'\?"):
        make(bad, tmp_path)
    make.close()


def test_searching_a_folder(tmp_path: Path) -> None:
    for name in ("a/wood.material.toml", "a/b/Wood_color.png", "c/stone.png", ".cache/wood.png"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("x")
    listing = FolderListing((".glb", ".png"))
    assert [e.name for e in listing.find(tmp_path, "wood", "")] == ["Wood_color.png", "wood.material.toml"]
    assert [e.name for e in listing.find(tmp_path, "", "textures")] == ["Wood_color.png", "stone.png"]
    assert listing.find(tmp_path, "nothing", "") == []
    assert listing.stamp(tmp_path / "c/stone.png")[1] == 1
    assert listing.stamp(tmp_path / "c/none.png") == (0, 0)
