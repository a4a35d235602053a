"""The walker: a sound skin, clips that loop and keep in step, and a timeline and a mask that do what they say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.app.runtime import Runtime
from engine.app.sample_project import new_sample_project
from engine.assets.samples.sample import make_sample
from engine.assets.samples.walker import BONES, CLIPS
from engine.core.errors import UsageError
from engine.gpu import open_device

NAMES = [bone[0] for bone in BONES]
LEGS = [i for i, name in enumerate(NAMES) if "leg" in name or "foot" in name]


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return new_sample_project(tmp_path_factory.mktemp("walker") / "p", "walker").start


def test_the_skin_is_sound() -> None:
    (body, _floor) = make_sample("walker").meshes
    normal = body.streams["normal"][:, :3].astype(float) / 32767.0
    assert np.abs(np.linalg.norm(normal, axis=1) - 1.0).max() < 1e-3
    corners = np.asarray(body.streams["position"], float)[body.indices.reshape(-1, 3)]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    good = area > 1e-7
    flat = across[good] / area[good, None]
    assert (flat * normal[body.indices.reshape(-1, 3)][good].mean(axis=1)).sum(axis=1).min() > 0.3
    assert (body.streams["weights"].astype(int).sum(axis=1) == 65535).all()
    assert body.skeleton is not None
    assert body.streams["joints"].max() < len(body.skeleton.names) == len(NAMES)


def test_clips_close_and_both_sides_do_the_same_half_a_clip_later() -> None:
    for clip in make_sample("walker").clips:
        found = {(c.target, c.path): c.values for c in clip.channels}
        for (target, path), values in found.items():
            assert np.abs(values[0] - values[-1]).max() < 1e-6, (clip.name, target)
            other = target.replace("left", "right")
            if clip.name in ("walk", "run") and target.startswith("left") and path == "rotation":
                half = np.interp(np.linspace(0.5, 1.0, 50), np.linspace(0, 1, len(values)), values[:, 0])
                there = found[other, path]
                now = np.interp(np.linspace(0.0, 0.5, 50), np.linspace(0, 1, len(values)), there[:, 0])
                assert np.abs(np.abs(half) - np.abs(now)).max() < 0.02, (clip.name, target)
        assert clip.duration == pytest.approx(CLIPS[clip.name])


def test_it_fades_from_walk_to_run_and_waves_with_one_arm_while_the_legs_run_on(project: Path) -> None:
    runtime = Runtime(open_device("null"))
    try:
        runtime.open(project)
        assert not list(runtime.findings)
        assert runtime.drive == "timeline"
        assert runtime.duration == pytest.approx(5.0)
        first = runtime.scene.nodes.name.index("hips")
        rows = np.arange(first, first + len(NAMES))

        def pose(time: float) -> np.ndarray:
            runtime.update(time)
            return runtime.scene.nodes.rotation[rows].copy()

        leans = [pose(time)[NAMES.index("spine"), 0] for time in (1.0, 2.75, 3.3)]
        assert leans[0] < leans[1] < leans[2], "a run leans ahead, a walk hardly, and between them lies between"
        waving = pose(4.3)
        lowest = min(float(runtime.scene.nodes.world[rows[i], 1, 3]) for i in LEGS)
        assert 0.0 < lowest < 0.2, "it stands on its floor"
        runtime.play("run")
        runtime.set_drive("clips")
        arm = NAMES.index("right upper arm")
        # the run's own phase at that moment: the block began at 2.2 s, in step with the walk
        best = min((np.abs(pose(t)[LEGS] - waving[LEGS]).max(), t) for t in np.linspace(0, 0.7, 141))
        assert best[0] < 0.05, "the legs do what the run does"
        assert np.abs(pose(best[1])[arm] - waving[arm]).max() > 0.3, "the arm does not"
    finally:
        runtime.close()


def test_lights_are_not_for_it(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no lights"):
        new_sample_project(tmp_path / "p", "walker", lights=3)
    with pytest.raises(UsageError, match="no sample 'walkr'"):
        new_sample_project(tmp_path / "p", "walkr")
