"""Sample scenes: as many lights as asked, sound meshes, closed loops, the same bytes every time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.assets.lanim import read_lanim
from engine.assets.lmesh import read_lmesh
from engine.assets.samples import SAMPLES
from engine.assets.samples.sample import make_sample, write_sample
from engine.assets.scene_json import read_scene
from engine.core.errors import UsageError


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("lights", [0, 1, 37, 1024])
def test_as_many_lights_as_asked(name: str, lights: int) -> None:
    sample = make_sample(name, lights=lights)
    assert sum(node.light is not None for node in sample.scene.nodes) == lights
    assert bool(sample.clips) == bool(lights)
    for clip in sample.clips:
        assert len(clip.channels) == lights, "all of them move"
        for channel in clip.channels:
            assert np.abs(channel.values[0] - channel.values[-1]).max() < 1e-5, "the loop closes"
            assert np.allclose(channel.values[0], getattr(sample.scene.nodes[channel.node], channel.path), atol=1e-5)


@pytest.mark.parametrize("name", SAMPLES)
def test_meshes_are_sound(name: str) -> None:
    for mesh in make_sample(name, lights=0).meshes:
        position = np.asarray(mesh.streams["position"], float)
        normal = np.asarray(mesh.streams["normal"], float)[:, :3] / 32767.0
        assert np.abs(np.linalg.norm(normal, axis=1) - 1.0).max() < 1e-3
        a, b, c = position[mesh.indices.reshape(-1, 3)].transpose(1, 0, 2)
        across = np.cross(b - a, c - a)
        area = np.linalg.norm(across, axis=1)
        flat = across[area > 1e-9] / area[area > 1e-9, None]
        facing = (flat * normal[mesh.indices.reshape(-1, 3)][area > 1e-9].mean(axis=1)).sum(axis=1)
        assert facing.min() > 0.3, f"{mesh.name}: triangles face the way their normals do"


@pytest.mark.parametrize("name", SAMPLES)
def test_written_files_are_whole_and_repeatable(name: str, tmp_path: Path) -> None:
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        path = write_sample(make_sample(name, lights=9), folder)
    scene = read_scene(path)
    assert scene.nodes[scene.active_camera].camera is not None
    assert len(read_lmesh(path.parent / f"{name}.lmesh")) == len(make_sample(name, lights=9).meshes)
    assert read_lanim(path.parent / scene.clips[0]).duration == pytest.approx(16.0)
    for file in (tmp_path / "a").iterdir():
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()


def test_what_there_is_not() -> None:
    with pytest.raises(UsageError, match="no sample 'atrum'"):
        make_sample("atrum")
    with pytest.raises(UsageError, match="-1 lights"):
        make_sample("poles", lights=-1)
