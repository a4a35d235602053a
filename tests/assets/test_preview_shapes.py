"""Shapes of the material preview: outward, unit, about a metre, with usable texture coordinates."""

from __future__ import annotations

import numpy as np
import pytest

from engine.assets.preview_shapes import SHAPES, shape


@pytest.mark.parametrize("name", SHAPES)
def test_normals_and_tangents_are_unit_and_at_right_angles(name: str) -> None:
    mesh = shape(name)
    normal = mesh.streams["normal"][:, :3] / 32767.0
    tangent = mesh.streams["tangent"][:, :3] / 32767.0
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=2e-4)
    np.testing.assert_allclose(np.linalg.norm(tangent, axis=1), 1.0, atol=2e-4)
    assert np.abs((normal * tangent).sum(axis=1)).max() < 2e-3


@pytest.mark.parametrize("name", SHAPES)
def test_faces_look_the_way_their_normals_do(name: str) -> None:
    mesh = shape(name)
    a, b, c = mesh.streams["position"].astype(np.float64)[mesh.indices.reshape(-1, 3)].transpose(1, 0, 2)
    facing = np.cross(b - a, c - a)
    area = np.linalg.norm(facing, axis=1)
    seen = mesh.streams["normal"][mesh.indices.reshape(-1, 3), :3].mean(axis=1)
    real = area > 1e-7  # poles are points
    assert ((facing * seen).sum(axis=1)[real] > 0.0).all()


@pytest.mark.parametrize("name", SHAPES)
def test_it_is_about_a_metre_and_stands_about_the_origin(name: str) -> None:
    position = shape(name).streams["position"]
    low, high = position.min(axis=0), position.max(axis=0)
    assert 0.9 <= float((high - low).max()) <= 1.2
    assert np.abs(low + high).max() < 0.12


def test_the_ball_has_a_groove_and_rests_on_its_stand() -> None:
    mesh = shape("ball")
    position = mesh.streams["position"].astype(np.float64)
    from_center = np.linalg.norm(position - [0.0, 0.08, 0.0], axis=1)
    ball = position[:, 1] > -0.2
    assert from_center[ball].max() == pytest.approx(0.42, abs=1e-4)
    assert from_center[ball & (position[:, 1] > 0.05)].min() == pytest.approx(0.35, abs=1e-3), "the floor of the groove"
    rim = position[np.abs(position[:, 1] + 0.27) < 1e-6]  # where the ring begins and ends
    inner = rim[np.hypot(rim[:, 0], rim[:, 2]) < 0.25]
    assert len(inner) > 0
    assert np.linalg.norm(inner - [0.0, 0.08, 0.0], axis=1).max() < 0.42, "the ring's inner rim is inside the ball"
