"""What is done to every model: triangles cleaned and ordered, vertices gathered, keys reduced, streams quantised."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.animation.pose import pose_nodes
from engine.assets import quantized
from engine.assets.clip import Channel, ClipAsset
from engine.assets.lmesh import read_lmesh, write_lmesh
from engine.assets.mesh import MeshAsset, MorphTarget, Submesh
from engine.assets.primitives import uv_sphere
from engine.assets.scene import MeshRef, NodeAsset
from engine.core.errors import FormatError
from engine.core.findings import Findings
from importers.geometry.crease import crease_normals
from importers.geometry.vertex_order import acmr, atvr, cache_misses, cache_order, fetch_order, line_misses
from importers.key_reduction import clip_error, key_count, node_reach, reduce_model
from importers.lods import add_lods
from importers.model import ImportedModel
from importers.processing import clean, finish, order_mesh
from importers.settings import ImportSettings

SETTINGS = ImportSettings()


def _grid(side: int, seed: int = 3) -> MeshAsset:
    """A square of (side-1)^2 * 2 triangles in random order, vertices in random order; x and y from 0 to 1."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:side, 0:side].astype(np.float32) / (side - 1)
    position = np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3)
    a = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).reshape(-1)
    triangles = np.concatenate([np.stack([a, a + 1, a + side], 1), np.stack([a + 1, a + side + 1, a + side], 1)])
    triangles = rng.permutation(triangles)
    place = rng.permutation(side * side)
    old = np.argsort(place)
    count = side * side
    streams: dict[str, np.ndarray] = {
        "position": position[old].astype("<f4"),
        "normal": np.tile(np.array([0, 0, 32767, 0], "<i2"), (count, 1)),
        "uv0": position[old, :2].astype("<f4"),
    }
    moved = MorphTarget("lift", {"position": (position[old] * [0, 0, 1] + [0, 0, 1]).astype("<f4") * position[old, :1]})
    indices = place[triangles].astype("<u4").reshape(-1)
    mesh = MeshAsset("grid", streams, indices, [Submesh(0, len(indices), 0, "triangles", (0, 0, 0), (1, 1, 0))])
    mesh.morphs = [moved]
    mesh.extras["dual_quaternion_share"] = position[old, 0].tolist()
    return mesh


def _model(*meshes: MeshAsset) -> ImportedModel:
    model = ImportedModel("m", Findings("m"), list(meshes), [[-1] for _ in meshes])
    model.nodes = [NodeAsset(mesh.name, mesh=MeshRef("", i)) for i, mesh in enumerate(meshes)]
    return model


def _faces(mesh: MeshAsset) -> set[tuple[tuple[float, ...], ...]]:
    """Every triangle as its corners' values of all streams, the smallest first, the sense kept."""
    found = set()
    rows = [
        (*mesh.streams["position"][i].tolist(), *mesh.streams["uv0"][i].tolist(),
         *(m.streams["position"][i, 2].item() for m in mesh.morphs))
        for i in range(mesh.vertex_count)
    ]  # fmt: skip
    for a, b, c in mesh.indices.reshape(-1, 3).tolist():
        turns = [(rows[a], rows[b], rows[c]), (rows[b], rows[c], rows[a]), (rows[c], rows[a], rows[b])]
        found.add(min(turns))
    return found


def test_cache_misses_of_a_strip() -> None:
    """Known by hand: neighbours share two vertices; a FIFO of three forgets the first after three more."""
    strip = np.array([[0, 1, 2], [2, 1, 3], [2, 3, 4]], np.uint32)
    assert cache_misses(strip, 16) == 5
    assert acmr(strip, 16) == pytest.approx(5 / 3)
    assert atvr(strip, 16) == 1.0
    assert cache_misses(np.array([[0, 1, 2], [3, 4, 5], [0, 1, 2]], np.uint32), 3) == 9


def test_order_of_a_grid() -> None:
    """A shuffled grid costs nearly 3 a triangle, an ordered one under 0.8; the surface, uvs and shapes are the same."""
    mesh = _grid(40)
    before, faces = mesh.indices.reshape(-1, 3), _faces(mesh)
    assert acmr(before) > 2.5
    order, begins = cache_order(before)
    assert sorted(order.tolist()) == list(range(len(before)))
    assert begins[0] == 0
    assert (np.diff(begins) > 0).all()
    plain, spread = _grid(40), _grid(40)
    order_mesh(plain, overdraw=False)
    order_mesh(spread, overdraw=True)
    for done in (plain, spread):
        assert _faces(done) == faces
        assert acmr(done.indices.reshape(-1, 3)) < 0.8
        # the share of a vertex is its x, and stays with it
        assert done.extras["dual_quaternion_share"] == pytest.approx(done.streams["position"][:, 0].tolist())
    again = _grid(40)
    order_mesh(again, overdraw=True)
    assert np.array_equal(again.indices, spread.indices)


def test_fetch_order() -> None:
    """Vertices as they are first used, what no triangle uses behind; memory is then read straight through."""
    assert fetch_order(np.array([4, 2, 4, 0], np.uint32), 6).tolist() == [4, 2, 0, 1, 3, 5]
    mesh = _grid(64)
    before = line_misses(mesh.indices, 28)
    order_mesh(mesh, overdraw=False)
    used = [int(i) for i in dict.fromkeys(mesh.indices.tolist())]
    assert used == sorted(used)
    assert line_misses(mesh.indices, 28) < 0.5 * before


def test_outside_comes_first() -> None:
    """Two spheres, one in the other: with overdraw order, the outer one's runs come first on the whole."""
    outer, inner = uv_sphere(1.0, 12, 24), uv_sphere(0.3, 12, 24)
    count = outer.vertex_count
    streams = {k: np.concatenate([inner.streams[k], outer.streams[k]]) for k in outer.streams}
    indices = np.concatenate([inner.indices, outer.indices + np.uint32(inner.vertex_count)])
    mesh = MeshAsset("both", streams, indices, [Submesh(0, len(indices), 0, "triangles", (-1,) * 3, (1,) * 3)])
    order_mesh(mesh, overdraw=True)
    far = np.linalg.norm(mesh.streams["position"][mesh.indices[::3]], axis=1) > 0.5
    assert count
    half = len(far) // 2
    assert far[:half].mean() > 0.9
    assert not far[half:].mean() > 0.1


def test_clean() -> None:
    """A collapsed triangle and one that is there twice, once turned, go; its back face and other submeshes stay."""
    mesh = _grid(3)
    good = mesh.indices.copy()
    a, b, c = good[:3].tolist()
    mesh.indices = np.concatenate([good, [a, a, b], [b, c, a], [c, b, a]]).astype("<u4")
    mesh.submeshes[0].index_count = len(mesh.indices)
    model = _model(mesh)
    clean(model, SETTINGS)
    assert mesh.indices.tolist() == [*good.tolist(), c, b, a]
    assert mesh.submeshes[0].index_count == len(good) + 3
    assert [f.code for f in model.findings] == ["mesh.collapsed", "mesh.doubled"]
    untouched = _grid(3)
    untouched.indices[:3] = untouched.indices[0]
    clean(_model(untouched), SETTINGS.replace(clean_triangles=False))
    assert len(untouched.indices) == len(good)


def test_quantized_file(tmp_path: Path) -> None:
    """Half the bytes for positions and uvs; the error is what the finding says and within half a step of the box."""
    mesh = _grid(20)
    mesh.streams["position"] = (mesh.streams["position"] * [2.0, 8.0, 0.0] + [5.0, -1.0, 0.25]).astype("<f4")
    write_lmesh(tmp_path / "plain.lmesh", [mesh])
    model = _model(mesh)
    finish(model, SETTINGS.replace(quantize=True, triangle_order="source"))
    write_lmesh(tmp_path / "small.lmesh", [mesh])
    (back,) = read_lmesh(tmp_path / "small.lmesh")
    off = np.abs(back.streams["position"].astype(np.float64) - mesh.streams["position"])
    half_step = np.array([1.0, 4.0, 0.0]) / 65535
    assert (off.max(axis=0) <= half_step + 1e-6).all()
    assert (off.max(axis=0) >= 0.8 * half_step).all()
    assert off[:, 2].max() == 0
    assert quantized.error(mesh.streams["position"]) == pytest.approx(np.linalg.norm(off, axis=1).max())
    worst = 1000 * max(quantized.error(mesh.streams["position"]), quantized.error(mesh.morphs[0].streams["position"]))
    assert f"{worst:.3g} mm" in next(f.message for f in model.findings if f.code == "mesh.quantized")
    np.testing.assert_allclose(back.morphs[0].streams["position"], mesh.morphs[0].streams["position"], atol=1e-5)
    saved = (tmp_path / "plain.lmesh").stat().st_size - (tmp_path / "small.lmesh").stat().st_size
    assert saved == pytest.approx(400 * (6 + 4 + 6), abs=600)
    data = (tmp_path / "small.lmesh").read_bytes()
    (tmp_path / "bad.lmesh").write_bytes(data.replace(b'\\"position\\":[[', b'\\"position\\":[9,', 1))
    with pytest.raises(FormatError):
        read_lmesh(tmp_path / "bad.lmesh")


def _swing(keys: int) -> ImportedModel:
    """A sphere of 1 m at the end of an arm of 2 m that swings by a sine of one radian; its child stays in place."""
    model = _model(uv_sphere(1.0, 6, 12))
    model.nodes = [NodeAsset("arm"), NodeAsset("ball", 0, (2.0, 0.0, 0.0), mesh=MeshRef("", 0))]
    times = np.linspace(0, 2, keys).astype("<f4")
    half = np.sin(times * np.pi) / 2
    turn = np.stack([0 * half, 0 * half, np.sin(half), np.cos(half)], 1).astype("<f4")
    still = np.tile(np.array([[2.0, 0.0, 0.0]], "<f4"), (keys, 1))
    model.clips = [
        ClipAsset(
            "swing", [Channel(0, "rotation", "linear", times, turn), Channel(1, "translation", "linear", times, still)]
        )
    ]
    return model


@pytest.mark.parametrize("millimetres", [1.0, 20.0])
def test_key_reduction(millimetres: float) -> None:
    """The farthest point of the sphere is 3 m from the arm's joint: an error there of the given size, and no more."""
    model = _swing(201)
    before = model.clips[0]
    reduce_model(model, millimetres / 1000)
    after = model.clips[0]
    assert len(after.channels[1].times) <= 2
    assert key_count(after) < key_count(before) / 2
    reach = node_reach(model.nodes, model.meshes)
    assert reach.tolist() == pytest.approx([0.0, 1.0], abs=1e-6)
    error = clip_error(before, after, model.nodes, reach)
    assert 0.05 * millimetres / 1000 < error <= millimetres / 1000
    # the same by hand: how far the tip of the ball goes astray
    tip = np.array([1.0, 0.0, 0.0, 1.0])
    worst = max(
        np.linalg.norm((pose_nodes(model.nodes, before, t).world[1] - pose_nodes(model.nodes, after, t).world[1]) @ tip)
        for t in np.linspace(0, 2, 57)
    )
    assert worst <= millimetres / 1000
    assert f"{1000 * error:.3g} mm" in next(f.message for f in model.findings)


def test_lods_of_a_sphere() -> None:
    """Half and a quarter of the triangles, all on the sphere's own vertices, off by what a chord may be."""
    pytest.importorskip("fast_simplification")
    mesh = uv_sphere(1.0, 24, 48)
    model = _model(mesh)
    add_lods(model, 2)
    assert [m.name for m in model.meshes[1:]] == [f"{mesh.name}.lod1", f"{mesh.name}.lod2"]
    for level, lod in enumerate(model.meshes[1:], 1):
        share = len(lod.indices) / len(mesh.indices)
        assert share == pytest.approx(0.5**level, abs=0.06)
        assert np.linalg.norm(lod.streams["position"], axis=1) == pytest.approx(1.0, abs=1e-5)
        a, b, c = (lod.streams["position"][lod.indices[k::3]] for k in range(3))
        assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) > 0).mean() > 0.99
    errors = [float(str(entry["error_m"])) for entry in mesh.extras["lods"]]  # type: ignore[attr-defined]  # a list
    assert 0.001 < errors[0] < errors[1] < 0.15


def test_crease_normals_of_a_roof() -> None:
    """Two slopes that meet at 90 degrees: smooth above that angle, each flat below it."""
    points = np.array([[0, 0, -1], [0, 0, 1], [1, -1, 1], [1, -1, -1], [-1, -1, 1], [-1, -1, -1]], np.float64)
    triangles = np.array([[0, 1, 2], [0, 2, 3], [1, 0, 5], [1, 5, 4]])
    right, left = np.array([1, 1, 0]) / 2**0.5, np.array([-1, 1, 0]) / 2**0.5
    flat = crease_normals(points[triangles], triangles, np.radians(60))
    np.testing.assert_allclose(flat[:2].reshape(-1, 3), np.tile(right, (6, 1)), atol=1e-12)
    np.testing.assert_allclose(flat[2:].reshape(-1, 3), np.tile(left, (6, 1)), atol=1e-12)
    smooth = crease_normals(points[triangles], triangles, np.radians(100))
    np.testing.assert_allclose(smooth[triangles == 0][:, 2], 0, atol=1e-12)
    # two angles of 45 degrees on the right and one of 90 on the left at the ridge's end: the mean is straight up
    np.testing.assert_allclose(smooth[triangles == 0], np.tile([0, 1, 0], (3, 1)), atol=1e-12)
    np.testing.assert_allclose(smooth[0, 2], right, atol=1e-12)
