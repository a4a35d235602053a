"""The box of what a skin bends holds every posed vertex, and not much else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.app.posed import posed_positions
from engine.app.posed_box import joint_boxes, posed_box
from engine.app.runtime import Runtime
from engine.gpu import open_device
from importers.opening import open_path
from importers.settings import ImportSettings


@pytest.mark.parametrize(
    ("file", "slack"),
    [
        ("gltf/CesiumMan/glTF-Binary/CesiumMan.glb", 0.3),
        ("gltf/AnimatedMorphCube/glTF-Binary/AnimatedMorphCube.glb", 1e-5),
    ],
)
def test_the_box_follows_the_pose(shared_assets: Path, file: str, slack: float) -> None:
    runtime = Runtime(open_device("null"))
    try:
        open_path(runtime, shared_assets / file, settings=ImportSettings(quality="draft"))
        scene = runtime.scene
        mesh = runtime.residency.meshes[int(scene.instances.mesh[0])].asset
        boxes = joint_boxes(mesh)
        for time in (0.3, 0.7 * runtime.duration):
            runtime.seek(time)
            found = posed_box(scene, mesh, boxes, 0)
            assert found is not None
            points = posed_positions(scene, runtime.residency, 0)
            size = np.ptp(points, axis=0).max()
            assert (found[0] <= points.min(axis=0) + 1e-5 * size).all()
            assert (found[1] >= points.max(axis=0) - 1e-5 * size).all()
            assert (found[1] - found[0] <= np.ptp(points, axis=0) + slack * size).all()
    finally:
        runtime.close()
