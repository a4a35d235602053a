"""Tangents: known answers, MikkTSpace's rules, and the tangents that real files carry."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from importers.geometry.tangents import tangent_frames
from importers.gltf.reader import load
from importers.settings import ImportSettings

F4 = np.float32
QUAD = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], F4)
QUAD_UV = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], F4)
QUAD_TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
UP = np.tile(np.array([0, 0, 1], F4), (4, 1))


def test_quad_follows_u_and_is_right_handed() -> None:
    source, tangents, triangles = tangent_frames(QUAD, UP, QUAD_UV, QUAD_TRIANGLES)
    # u grows along +x, v (downwards in glTF) shrinks along +y: bitangent = w * cross(n, t) = +y
    np.testing.assert_allclose(tangents, np.tile([1, 0, 0, 1], (4, 1)), atol=1e-6)
    np.testing.assert_array_equal(source[triangles], QUAD_TRIANGLES)
    assert len(source) == 4


def test_mirrored_uv_turns_the_handedness() -> None:
    mirrored = QUAD_UV * np.array([-1, 1], F4)
    _, tangents, _ = tangent_frames(QUAD, UP, mirrored, QUAD_TRIANGLES)
    np.testing.assert_allclose(tangents, np.tile([-1, 0, 0, -1], (4, 1)), atol=1e-6)


def test_mirror_seam_splits_vertices() -> None:
    """Two quads share an edge and its uv; u runs outwards on both sides: the edge's vertices need two frames."""
    p = np.array([[-1, 0, 0], [0, 0, 0], [1, 0, 0], [-1, 1, 0], [0, 1, 0], [1, 1, 0]], F4)
    uv = np.array([[1, 1], [0, 1], [1, 1], [1, 0], [0, 0], [1, 0]], F4)
    triangles = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]], np.uint32)
    source, tangents, out = tangent_frames(p, np.tile(UP[:1], (6, 1)), uv, triangles)
    assert len(source) == 8
    assert sorted(source.tolist()) == [0, 1, 1, 2, 3, 4, 4, 5]
    np.testing.assert_array_equal(source[out], triangles)
    np.testing.assert_allclose(tangents[out[:2]].reshape(-1, 4), np.tile([-1, 0, 0, -1], (6, 1)), atol=1e-6)
    np.testing.assert_allclose(tangents[out[2:]].reshape(-1, 4), np.tile([1, 0, 0, 1], (6, 1)), atol=1e-6)


def test_weighted_by_angle() -> None:
    """Three triangles fan about a vertex with angles 90, 45, 45 degrees and u turned by known angles."""
    angles = np.radians([0, 90, 135, 180])
    p = np.concatenate([[[0, 0, 0]], np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1)]).astype(F4)
    triangles = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4]], np.uint32)
    uv = np.concatenate([[[0.0, 0.0]], np.stack([angles, -np.ones(4)], 1)]).astype(F4)
    source, tangents, out = tangent_frames(p, np.tile(UP[:1], (5, 1)), uv, triangles)
    expected = np.zeros(2)
    for t, weight in zip(triangles, (np.pi / 2, np.pi / 4, np.pi / 4), strict=True):
        edges = (p[t[1:]] - p[t[0]])[:, :2].astype(np.float64)
        duv = (uv[t[1:]] - uv[t[0]]).astype(np.float64) * [1, -1]
        face = np.linalg.solve(duv, edges)[0]  # d position / d u
        expected += weight * face / np.linalg.norm(face)
    centre = tangents[out[0, 0]]
    np.testing.assert_allclose(centre[:2], expected / np.linalg.norm(expected), atol=1e-6)
    assert len(source) == 5


def test_degenerate_input_gives_finite_unit_orthogonal_frames() -> None:
    p = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 0, 0], [0, 1e-20, 0]], F4)
    n = np.array([[0, 0, 1], [0, 0, -1], [0, 0, 0], [1, 0, 0], [0, 1, 0]], F4)
    triangles = np.array([[0, 1, 2], [0, 3, 4], [1, 1, 2], [2, 3, 4]], np.uint32)
    for uv in (np.zeros((5, 2), F4), np.full((5, 2), 3e37, F4), np.eye(5, 2, dtype=F4) * F4(1e-30)):
        source, tangents, out = tangent_frames(p, n, uv, triangles)
        assert np.isfinite(tangents).all()
        np.testing.assert_allclose(np.linalg.norm(tangents[:, :3], axis=1), 1, atol=1e-5)
        assert set(np.abs(tangents[:, 3])) == {1.0}
        dots = np.abs((tangents[:, :3] * n[source]).sum(axis=1))
        assert dots.max() < 1e-5
        np.testing.assert_array_equal(source[out], triangles)


def test_vertices_of_no_triangle_stay() -> None:
    source, tangents, _ = tangent_frames(QUAD, UP, QUAD_UV, QUAD_TRIANGLES[:1])
    assert sorted(source.tolist()) == [0, 1, 2, 3]
    assert len(tangents) == 4


def test_agrees_with_the_tangents_that_a_real_file_carries(shared_assets: Path) -> None:
    model = load(shared_assets / "gltf" / "Avocado" / "glTF" / "Avocado.gltf", ImportSettings())
    mesh = model.meshes[0]
    position = np.asarray(mesh.streams["position"], F4)
    normal = np.asarray(mesh.streams["normal"], F4)[:, :3] / F4(32767)
    stored = np.asarray(mesh.streams["tangent"], F4) / F4(32767)
    uv = np.asarray(mesh.streams["uv0"], F4)
    triangles = mesh.indices.reshape(-1, 3)
    _, tangents, out = tangent_frames(position, normal, uv, triangles)
    made, given = tangents[out].reshape(-1, 4), stored[triangles].reshape(-1, 4)
    angle = np.degrees(np.arccos(np.clip((made[:, :3] * given[:, :3]).sum(axis=1), -1, 1)))
    # one triangle of 682 has no area in uv space: its frame is anybody's choice
    assert (made[:, 3] != np.sign(given[:, 3])).sum() <= 3
    assert np.median(angle) < 1.0
    assert np.percentile(angle, 95) < 5.0
