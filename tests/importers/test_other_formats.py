"""OBJ, STL, PLY, OFF and DAE by Assimp and by trimesh, on files whose contents are known."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from engine.animation.pose import pose_meshes, pose_nodes
from engine.core.errors import FormatError, InputError, UsageError
from importers.fallback import formats, library
from importers.fallback.reader import dependencies, load
from importers.model import ImportedModel
from importers.registry import find_importer
from importers.settings import ImportSettings
from tests.support import other_formats as make
from tests.support.gltf_builder import png

SETTINGS = ImportSettings()
BOX_AREA = 2 * (2 * 4 + 4 * 6 + 6 * 2)


@pytest.fixture(params=["assimp", "trimesh"])
def reader(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Both readers in turn; Assimp only where it is installed."""
    if request.param == "trimesh":
        monkeypatch.setattr(library, "find_library", lambda: "")
    elif not library.available():
        pytest.skip("Assimp is not installed")
    return str(request.param)


def _bounds(model: ImportedModel) -> tuple[np.ndarray, np.ndarray]:
    points = np.concatenate([p.positions for p in pose_meshes(model.nodes, model.meshes, pose_nodes(model.nodes))])
    return points.min(axis=0), points.max(axis=0)


def _area(model: ImportedModel) -> float:
    total = 0.0
    for posed in pose_meshes(model.nodes, model.meshes, pose_nodes(model.nodes)):
        for triangles in posed.triangles:
            a, b, c = (posed.positions[triangles[:, k]] for k in range(3))
            face = np.cross(b - a, c - a)
            total += float(np.linalg.norm(face, axis=1).sum()) / 2
            # wound outwards: the box is about the origin
            assert (np.einsum("ij,ij->i", face, a + b + c) > 0).all()
    return total


@pytest.mark.parametrize("write", [make.obj, make.stl, make.ply, make.off], ids=["obj", "stl", "ply", "off"])
def test_box(write: Callable[[Path], Path], tmp_path: Path, reader: str) -> None:
    model = load(write(tmp_path), SETTINGS)
    low, high = _bounds(model)
    np.testing.assert_allclose([low, high], [[-1, -2, -3], [1, 2, 3]], atol=1e-6)
    assert sum(len(mesh.indices) for mesh in model.meshes) == 36
    assert _area(model) == pytest.approx(BOX_AREA, rel=1e-6)
    for mesh in model.meshes:
        # edges of 90 degrees are sharp: every normal is along an axis
        normals = np.abs(np.asarray(mesh.streams["normal"])[:, :3])
        assert (np.sort(normals, axis=1)[:, :2] <= 1).all()
        assert (normals.max(axis=1) >= 32766).all()
    assert "source.units" in {f.code for f in model.findings}


def test_obj_materials(tmp_path: Path, reader: str) -> None:
    path = make.obj(tmp_path)
    (tmp_path / "skin.png").write_bytes(png(4, 4))
    model = load(path, SETTINGS)
    materials = {m.asset.name: m for m in model.materials}
    left, right = materials["left"].asset, materials["right"]
    assert left.params["base_color"][:3] == pytest.approx((0.2, 0.4, 0.6), abs=2e-3)
    assert left.params["base_color"][3] == pytest.approx(0.5, abs=2e-3)
    assert left.queue == "transparent"
    assert right.images["base_color_map"].role == "color"
    assert model.images[right.images["base_color_map"].image].data() == (tmp_path / "skin.png").read_bytes()
    # alpha^2 = 2 / (n + 2) of the exponent 98, roughness^2 = alpha
    assert right.asset.params["roughness"] == pytest.approx(0.02**0.25, rel=1e-3)
    names = {name for name, _ in dependencies(path, SETTINGS)}
    assert "skin.png" in names
    if reader == "assimp":
        assert {"box.mtl", "skin_normal.png"} <= names
        assert right.asset.textures["normal_map"].path == ""
        assert any(f.code == "assimp.texture" and "skin_normal.png" in f.message for f in model.findings)
        assert {node.name for node in model.nodes} == {"left", "right"}


def test_unit_and_axis(tmp_path: Path) -> None:
    """Millimetres with Z up: the box's height of 6 mm becomes 6 mm in y."""
    model = load(make.stl(tmp_path), SETTINGS.replace(source_unit=0.001, source_up="z"))
    low, high = _bounds(model)
    np.testing.assert_allclose(high - low, [0.002, 0.006, 0.004], rtol=1e-6)
    assert _area(model) == pytest.approx(BOX_AREA * 1e-6, rel=1e-6)


def test_vertex_colours(tmp_path: Path, reader: str) -> None:
    mesh = load(make.ply(tmp_path), SETTINGS).meshes[0]
    color = np.asarray(mesh.streams["color"], np.float64) / 65535
    positive = np.asarray(mesh.streams["position"])[:, 0] > 0
    np.testing.assert_allclose(color[positive], [[1, 0, 0, 1]] * int(positive.sum()), atol=1e-4)
    assert color[~positive, 0] == pytest.approx(0.5, abs=0.005)


@pytest.mark.skipif(not library.available(), reason="Assimp is not installed")
def test_dae_skin_and_clip(tmp_path: Path) -> None:
    """Centimetres and Z up are converted; the joint carries the concave polygon round by 90 degrees."""
    path = make.dae(tmp_path)
    model = load(path, SETTINGS)
    mesh = model.meshes[0]
    assert len(mesh.indices) == 9
    assert mesh.skeleton is not None
    assert mesh.skeleton.names == ["bone"]
    (clip,) = model.clips
    for time, wanted in ((0.0, [[0, 0, -1.0], [1, 0, 1]]), (1.0, [[-1, 0, -1], [1, 0, 0]])):
        (posed,) = pose_meshes(model.nodes, model.meshes, pose_nodes(model.nodes, clip, time))
        box = [posed.positions.min(axis=0), posed.positions.max(axis=0)]
        np.testing.assert_allclose(box, wanted, atol=1e-5)
        # the arrow's area: a concave polygon cut into a fan would have more
        a, b, c = (posed.positions[posed.triangles[0][:, k]] for k in range(3))
        assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(0.75, rel=1e-5)
    assert model.materials[0].asset.params["base_color"][:3] == pytest.approx((0.8, 0.1, 0.1))


def test_dae_without_assimp(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "find_library", lambda: "")
    (tmp_path / "a.blend").write_bytes(b"BLENDER")
    with pytest.raises(InputError, match="Assimp, which is not installed") as caught:
        load(tmp_path / "a.blend", SETTINGS)
    assert "apt install libassimp5" in caught.value.hint


@pytest.mark.skipif(not library.available(), reason="Assimp is not installed")
def test_assimp_stays_in_the_folder(tmp_path: Path) -> None:
    """An MTL outside the folder is not opened; one that was opened is a dependency, also where it is missing."""
    inner = tmp_path / "inner"
    inner.mkdir()
    path = make.obj(inner, mtl="../box.mtl")
    (inner / "box.mtl").rename(tmp_path / "box.mtl")
    model = load(path, SETTINGS)
    assert any("outside the source's folder" in f.message for f in model.findings)
    wanted = pytest.approx((0.2, 0.4, 0.6), abs=0.01)
    assert all(m.asset.params["base_color"][:3] != wanted for m in model.materials)
    with_it = load(path, SETTINGS.replace(allow_outside=True))
    assert any(m.asset.params["base_color"][:3] == wanted for m in with_it.materials)


@pytest.mark.skipif(not library.available(), reason="Assimp is not installed")
def test_dependencies_follow_the_side_files(tmp_path: Path) -> None:
    path = make.obj(tmp_path)
    assert "skin.png" in {name for name, _ in dependencies(path, SETTINGS)}
    (tmp_path / "box.mtl").write_text("newmtl right\nmap_Kd other.png\n")
    names = {name for name, _ in dependencies(path, SETTINGS)}
    assert "other.png" in names
    assert "skin.png" not in names


def test_library_of_another_kind_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "libassimp.so").write_bytes(b"no library")
    with pytest.raises(FormatError, match="cannot be loaded"):
        library.open_library(str(tmp_path / "libassimp.so"))
    library.find_library.cache_clear()
    monkeypatch.setenv(library.VARIABLE, str(tmp_path / "nothing"))
    with pytest.raises(UsageError, match="names no file"):
        library.find_library()
    monkeypatch.undo()
    library.find_library.cache_clear()


def test_registry_knows_them() -> None:
    for extension in (".obj", ".DAE", ".3ds", ".blend"):
        assert find_importer(Path(f"x{extension}")).name == "other"
    assert set(formats.TRIMESH).isdisjoint(formats.ASSIMP)


def test_damaged_file(tmp_path: Path, reader: str) -> None:
    """Refused by both, or by one of them taken for nothing."""
    (tmp_path / "bad.obj").write_text("v 0 0\nf 1 2 900\n")
    with contextlib.suppress(FormatError):
        assert not any(len(mesh.indices) for mesh in load(tmp_path / "bad.obj", SETTINGS).meshes)
