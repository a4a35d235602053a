"""Edits of a parent material and of texture files reach the picture; what is wrong keeps the last one."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.app.runtime import Runtime
from engine.assets.dds import write_dds
from engine.assets.texture import TextureAsset
from engine.gpu.types import Device
from tests.support.effect_project import EffectProject, picture

BASE = 'name = "base"\nfeatures = ["unlit"]\n[params]\nbase_color = "{}"\nmetallic = 0.0\n'
CHILD = '# mine\nparent = "base.material.toml"\n[params]\nroughness = 0.5\n'


class Opened:
    def __init__(self, device: Device, folder: Path) -> None:
        self.project = EffectProject(folder, {"base.material.toml": BASE.format("red"), "thing.material.toml": CHILD})
        self.runtime: Runtime = self.project.open(device)

    def color(self) -> NDArray[np.int64]:
        image = picture(self.runtime, (48, 36), tone_map="none")
        return image[image.shape[0] // 2, image.shape[1] // 2, :3].astype(int)

    def poll(self) -> tuple[str, ...]:
        done = self.runtime.hot_reload.poll(force=False, now=self.runtime.hot_reload._looked + 1.0)
        return tuple(done.names) if done is not None else ()

    @property
    def problems(self) -> list[str]:
        return [str(error).replace(f"{self.project.folder}/", "") for error in self.runtime.hot_reload.problems]


@pytest.fixture
def opened(gl_device: Device, tmp_path: Path) -> Iterator[Opened]:
    opened = Opened(gl_device, tmp_path)
    yield opened
    opened.runtime.close()


def test_a_changed_parent_changes_the_child(opened: Opened) -> None:
    assert opened.color().tolist() == [255, 0, 0]
    opened.project.write("base.material.toml", BASE.format("#0000ff"))
    assert opened.poll() == ("thing.material.toml",)
    assert opened.color().tolist() == [0, 0, 255]
    opened.project.write("base.material.toml", BASE.format("#0000fg"))
    opened.poll()
    assert opened.color().tolist() == [0, 0, 255], "the last good version stays"
    assert opened.problems[0].startswith("base.material.toml:4:14: ")
    (opened.project.folder / "base.material.toml").unlink()
    opened.poll()
    assert opened.problems[0].startswith("thing.material.toml:2:10: ")
    assert opened.color().tolist() == [0, 0, 255]
    opened.project.write("base.material.toml", BASE.format("lime"))
    opened.poll()
    assert not opened.problems
    assert opened.color().tolist() == [0, 255, 0]


def test_a_chain_may_grow_while_it_is_open(opened: Opened) -> None:
    opened.project.write("root.material.toml", BASE.format("white"))
    opened.project.write("base.material.toml", 'parent = "root.material.toml"\n[params]\nmetallic = 0.5\n')
    opened.poll()
    assert opened.color().tolist() == [255, 255, 255]
    opened.project.write("root.material.toml", BASE.format("aqua"))
    opened.poll()
    assert opened.color().tolist() == [0, 255, 255]
    opened.project.write("root.material.toml", 'parent = "thing.material.toml"\n')
    opened.poll()
    assert "the parents go in a circle" in opened.problems[0]
    assert opened.color().tolist() == [0, 255, 255]


def test_an_edit_in_the_editor_outlives_a_change_of_the_parent(opened: Opened) -> None:
    material = opened.runtime.residency.material_files[opened.project.folder.resolve() / "thing.material.toml"]
    opened.runtime.residency.set_material_param(material, "base_color", (0.0, 0.0, 0.0, 1.0))
    assert opened.color().tolist() == [0, 0, 0]
    opened.project.write("base.material.toml", BASE.format("red") + "emissive_strength = 0.5\n")
    opened.poll()
    assert opened.color().tolist() == [0, 0, 0]


def dds(color: tuple[int, int, int], size: int = 4) -> TextureAsset:
    return TextureAsset("rgba8", size, size, [[bytes([*color, 255]) * size * size]])


def test_a_texture_that_changes_on_disk(opened: Opened) -> None:
    """The same size, another size, gone, broken, there again."""
    path = opened.project.folder / "c.dds"
    texture = '[textures.base_color_map]\npath = "c.dds"\n'
    opened.project.write("thing.material.toml", CHILD + texture)
    opened.project.write("base.material.toml", BASE.format("white"))
    opened.poll()
    assert opened.color().tolist() == [255, 0, 255], "it is not there yet"
    for step, (color, size) in enumerate((((255, 0, 0), 4), ((0, 255, 0), 4), ((0, 0, 255), 8), ((255, 255, 0), 4))):
        write_dds(path, dds(color, size))
        opened.project.write("c.dds", path.read_bytes())
        assert opened.poll() == ("c.dds",), step
        assert opened.color().tolist() == list(color)
    arrays = opened.runtime.residency.pool._arrays
    assert sum(entry.used - len(entry.free) for entry in arrays) <= 6, "layers of old sizes are used again"
    path.unlink()
    opened.poll()
    assert opened.color().tolist() == [255, 255, 0]
    assert "c.dds" in opened.problems[0]
    opened.project.write("c.dds", b"DDS no more")
    opened.poll()
    assert opened.color().tolist() == [255, 255, 0]
    write_dds(path, dds((0, 255, 255)))
    opened.project.write("c.dds", path.read_bytes())
    opened.poll()
    assert not opened.problems
    assert opened.color().tolist() == [0, 255, 255]
