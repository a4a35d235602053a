"""Every Ogre file of the shared assets: it loads or says why not; and agrees with OgreXMLConverter, where that is
installed (Debian: ogre-1.12-tools)."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import FormatError
from engine.core.findings import Findings, Severity
from importers.ogre.data import OgreMesh
from importers.ogre.reader import load
from importers.ogre.sources import read_source
from importers.settings import ImportSettings

SETTINGS = ImportSettings()
#: file -> (vertices, triangles, joints, clips)
KNOWN = {
    "ninja.mesh": (842, 1008, 28, 20),
    "robot.mesh": (295, 308, 18, 5),
    "fish.mesh": (531, 815, 5, 1),
    "ogrehead.mesh": (2242, 4336, 0, 0),
    "athene.mesh": (5338, 6000, 0, 0),
    "tudorhouse.mesh": (1294, 979, 0, 0),
}


@pytest.mark.parametrize("name", KNOWN)
def test_known_counts(name: str, shared_assets: Path) -> None:
    model = load(shared_assets / "ogre" / "models" / name, SETTINGS)
    (mesh,) = model.meshes
    joints = len(mesh.skeleton.names) if mesh.skeleton is not None else 0
    assert (mesh.vertex_count, len(mesh.indices) // 3, joints, len(model.clips)) == KNOWN[name]
    assert not [f for f in model.findings if f.severity is Severity.ERROR]


def test_ninja_shows_its_skin(shared_assets: Path) -> None:
    model = load(shared_assets / "ogre" / "models" / "ninja.mesh", SETTINGS)
    (number,) = model.slots[0]
    assert model.materials[number].asset.name == "Examples/Ninja"
    assert model.images[model.materials[number].images["base_color_map"].image].path == "nskingr.jpg"
    walk = next(clip for clip in model.clips if clip.name == "Walk")
    assert walk.duration == pytest.approx(1.08333, abs=1e-4)


def test_packed_normals_are_unit_vectors(shared_assets: Path) -> None:
    """Ogre 13's 10-10-10-2 normals, which the 1.12 tools refuse."""
    path = shared_assets / "ogre" / "models" / "TestLevel_b0.mesh"
    mesh = read_source(path, SETTINGS, Findings())
    assert isinstance(mesh, OgreMesh)
    for part in mesh.submeshes:
        assert part.geometry is not None
        assert part.geometry.normal is not None
        np.testing.assert_allclose(np.linalg.norm(part.geometry.normal, axis=1), 1.0, atol=0.01)


def test_a_cut_version_line(shared_assets: Path) -> None:
    with pytest.raises(FormatError, match="does not end"):
        load(shared_assets / "malformed" / "no_newline.mesh", SETTINGS)


def test_all_meshes_load_and_agree_with_the_converter(shared_assets: Path, tmp_path: Path) -> None:
    tool = shutil.which("OgreXMLConverter")
    folders = ("ogre/models", "ogre/PCZAppMedia", "ogre_xml")
    paths = [p for folder in folders for p in sorted((shared_assets / folder).glob("*.mesh"))]
    assert len(paths) == 42
    compared = 0
    for number, path in enumerate(paths):
        mesh = read_source(path, SETTINGS, Findings())
        assert isinstance(mesh, OgreMesh)
        if tool is None or path.name == "TestLevel_b0.mesh":
            continue
        target = tmp_path / f"{number}.mesh.xml"
        subprocess.run([tool, "-q", str(path), str(target)], cwd=tmp_path, check=True, capture_output=True, timeout=60)
        truth = read_source(target, SETTINGS, Findings())
        assert isinstance(truth, OgreMesh)
        pairs = [(mesh.shared, truth.shared)]
        for a, b in zip(mesh.submeshes, truth.submeshes, strict=True):
            np.testing.assert_array_equal(a.indices, b.indices)
            pairs.append((a.geometry, b.geometry))
        for g, h in pairs:
            assert (g is None) == (h is None)
            if g is not None and h is not None:
                np.testing.assert_allclose(g.position, h.position, rtol=5.1e-6, atol=1e-6, err_msg=path.name)
                assert sorted(g.uv) == sorted(h.uv)
                for k in g.uv:
                    np.testing.assert_allclose(g.uv[k], h.uv[k], rtol=5.1e-6, atol=1e-6, err_msg=path.name)
        compared += 1
    if tool is None:
        pytest.skip("all load; not compared: OgreXMLConverter is not installed")
    assert compared == 41


@pytest.mark.parametrize("name", ["ninja", "robot", "knot"])
def test_all_serializer_versions(name: str, shared_assets: Path, tmp_path: Path) -> None:
    """Written anew by Ogre's own tool in every version and byte order that it knows, the mesh is the same for us."""
    tool = shutil.which("OgreMeshUpgrader")
    if tool is None:
        pytest.skip("OgreMeshUpgrader is not installed")
    source = shared_assets / "ogre" / "models" / f"{name}.mesh"
    wanted = load(source, ImportSettings()).meshes[0]
    heads = set()
    for version in ("1.10", "1.8", "1.7", "1.4", "1.0"):
        for order in ("little", "big"):
            path = tmp_path / f"{version}_{order}.mesh"
            command = [tool, "-V", version, "-E", order, "-r", str(source), str(path)]
            subprocess.run(command, capture_output=True, cwd=tmp_path, timeout=60, check=False)
            heads.add(path.read_bytes()[:30])
            mesh = load(path, ImportSettings()).meshes[0]
            np.testing.assert_array_equal(mesh.indices, wanted.indices)
            assert set(mesh.streams) >= {"position", "normal", "uv0"}
            np.testing.assert_allclose(mesh.streams["position"], wanted.streams["position"], atol=1e-5)
            np.testing.assert_allclose(mesh.streams["uv0"], wanted.streams["uv0"], atol=1e-6)
    assert len(heads) >= 8


def test_levels_of_detail_are_named(shared_assets: Path, tmp_path: Path) -> None:
    """Of a mesh with levels that Ogre's tool made, the first is imported, and a finding counts the others."""
    tool = shutil.which("OgreMeshUpgrader")
    if tool is None:
        pytest.skip("OgreMeshUpgrader is not installed")
    source, path = shared_assets / "ogre" / "models" / "athene.mesh", tmp_path / "athene.mesh"
    subprocess.run(
        [tool, "-l", "2", "-d", "100", "-p", "50", str(source), str(path)],
        capture_output=True,
        cwd=tmp_path,
        timeout=60,
        check=False,
    )
    model, plain = load(path, ImportSettings()), load(source, ImportSettings())
    assert len(model.meshes[0].indices) == len(plain.meshes[0].indices)
    assert any("levels of detail" in f.message for f in model.findings), [str(f) for f in model.findings]
