"""The camera for scenes that have none: everything is in the picture, whatever its shape and size."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from engine.app.framing import frame_bounds


def _ndc(camera, aspect, low, high):
    corners = np.array(list(itertools.product(*zip(low, high, strict=True))))
    clip = np.c_[corners, np.ones(8)] @ camera.clip_from_world(aspect).T
    return clip[:, :3] / clip[:, 3:], clip[:, 3]


@pytest.mark.parametrize("aspect", [0.5, 1.0, 16 / 9, 4.0])
@pytest.mark.parametrize(
    "size",
    [(1, 1, 1), (1e-4, 1e-4, 1e-4), (1e5, 1e5, 1e5), (10, 0.1, 0.1), (0.1, 10, 0.1), (1, 1, 0), (1, 0, 1), (0, 1, 1)],
)
def test_every_corner_is_in_the_picture(aspect, size) -> None:
    high = np.array(size, float) / 2
    for center in (np.zeros(3), np.array([1e6, -3.0, 12.0])):
        low, top = center - high, center + high
        camera = frame_bounds(low, top, aspect)
        ndc, w = _ndc(camera, aspect, low, top)
        assert (w > camera.znear).all()
        assert np.abs(ndc[:, :2]).max() <= 1.0
        assert np.abs(ndc[:, :2]).max() > 0.5  # and it is not lost in the distance


def test_a_point_and_nothing_give_a_usable_camera() -> None:
    for low, high in ((np.zeros(3), np.zeros(3)), (np.full(3, np.inf), np.full(3, -np.inf)), (np.full(3, np.nan),) * 2):
        camera = frame_bounds(low, high, 1.0)
        assert np.isfinite(camera.world_from_camera).all()
        assert camera.znear > 0


def test_a_mesh_of_many_parts_counts_once(monkeypatch: pytest.MonkeyPatch, null_device) -> None:
    """Parts share their mesh's vertices, so a figure of fifty parts is framed by its vertices, not by loose boxes."""
    from dataclasses import replace

    from engine.app import framing
    from engine.assets.primitives import cube
    from tests.support.stage import Stage

    stage = Stage(null_device)
    mesh = cube()
    stage.add(replace(mesh, submeshes=[mesh.submeshes[0]] * 4))
    runtime = stage.runtime
    runtime.update()
    assert len(runtime.scene.instances.node) == 4
    monkeypatch.setattr(framing, "POINT_LIMIT", 2 * mesh.vertex_count)
    assert len(framing.scene_points(runtime.scene, runtime.residency)) == mesh.vertex_count
