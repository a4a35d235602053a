"""Animated characters, imported, sampled and skinned, against float64 straight from the source file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.animation.animator import Animator
from engine.animation.graph import single
from engine.animation.rig import moved_nodes, rig_of
from engine.animation.sampler import ClipSampler
from engine.app.runtime import Runtime
from importers.convert import convert
from importers.settings import ImportSettings
from tests.animation.gltf_truth import Gltf

CHARACTERS = ("CesiumMan", "BrainStem", "RiggedFigure", "RiggedSimple")


def posed_vertices(runtime: Runtime) -> tuple[np.ndarray, np.ndarray]:
    """(bind, posed) of all skinned vertices, with the palette that the GPU is given."""
    skins = runtime.scene.skins
    palette = skins.palette(np.zeros(3)).astype(np.float64)
    bind, posed = [], []
    for s in range(len(skins)):
        table = runtime.scene.instances
        mesh = int(table.mesh[np.flatnonzero(table.node == skins.node[s])[0]])
        streams = runtime.residency.meshes[mesh].asset.streams
        weights = streams["weights"].astype(np.float64) / 65535.0
        matrices = palette[skins.first[s] + streams["joints"].astype(int)]
        blend = np.einsum("nk,nkij->nij", weights, matrices)
        position = streams["position"].astype(np.float64)
        bind.append(position)
        posed.append(np.einsum("nij,nj->ni", blend[:, :, :3], position) + blend[:, :, 3])
    return np.concatenate(bind), np.concatenate(posed)


def worst_error(truth: tuple[np.ndarray, np.ndarray], got: tuple[np.ndarray, np.ndarray]) -> float:
    """The greatest distance, metres, of a vertex from the nearest posed vertex with the same bind position."""
    at: dict[bytes, list[int]] = {}
    for i, place in enumerate(truth[0].astype(np.float32)):
        at.setdefault((place + np.float32(0.0)).tobytes(), []).append(i)
    worst = 0.0
    for place, point in zip(got[0].astype(np.float32), got[1], strict=True):
        same = at[(place + np.float32(0.0)).tobytes()]
        worst = max(worst, float(np.linalg.norm(truth[1][same] - point, axis=1).min()))
    return worst


@pytest.mark.parametrize("name", CHARACTERS)
def test_every_vertex_is_where_the_file_says(name: str, shared_assets: Path, tmp_path: Path, null_device) -> None:
    source = shared_assets / "gltf" / name / "glTF-Binary" / f"{name}.glb"
    if not source.is_file():
        pytest.skip(f"no {name}")
    scene = convert(source, tmp_path / "out", ImportSettings(quality="draft", key_error_mm=0.0)).scene
    truth = Gltf(source)
    runtime = Runtime(null_device)
    try:
        runtime.open(scene)
        clip = runtime.clips[0]
        rig = rig_of(runtime.asset.nodes, moved_nodes([clip], len(runtime.asset.nodes)))
        animator = Animator(single(ClipSampler(clip, rig), "once"))
        size = float(np.ptp(truth.skinned(0.0)[1], axis=0).max())
        errors = []
        for time in (0.0, 0.1, 0.337, clip.duration * 0.5, clip.duration * 0.93, clip.duration):
            expected = truth.skinned(time)
            runtime.play(0, mode="once")
            runtime.update(time)
            errors.append(worst_error(expected, posed_vertices(runtime)))
            animator.seek(time)
            animator.update(0.0)
            animator.write(runtime.scene.nodes, runtime.node_rows[rig.source][None])
            runtime.scene.update()
            errors.append(worst_error(expected, posed_vertices(runtime)))
        print(f"{name}: {size:.2f} m, max vertex error {max(errors) * 1e3:.5f} mm")
        # float32 keys' times and palette, 16-bit weights: 1.5e-5 of the size
        assert max(errors) < 5e-5 * size
    finally:
        runtime.close()
