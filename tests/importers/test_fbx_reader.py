"""FBX files made here: units, axes, geometry, materials, skins, shapes and clips come out as they were put in."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from engine.animation.pose import PosedMesh, pose_meshes, pose_nodes
from engine.assets.clip import ClipAsset
from engine.core.errors import FormatError, InputError
from importers.convert import convert
from importers.export.obj import time_of_frame
from importers.fbx.reader import dependencies, load
from importers.model import ImportedModel
from importers.registry import find_importer
from importers.settings import ImportSettings
from tests.support.fbx_builder import QUAD, FbxBuilder

SETTINGS = ImportSettings(quality="draft")
UV = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
IDENTITY = [1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


def posed(model: ImportedModel, clip: ClipAsset | None = None, time: float = 0.0) -> list[PosedMesh]:
    return list(pose_meshes(model.nodes, model.meshes, pose_nodes(model.nodes, clip, time)))


def box(model: ImportedModel, clip: ClipAsset | None = None, time: float = 0.0) -> np.ndarray:
    """[2,3]: least and greatest corner of all meshes."""
    points = np.concatenate([p.positions for p in posed(model, clip, time)])
    return np.round([points.min(axis=0), points.max(axis=0)], 6)


@pytest.mark.parametrize(("unit", "size"), [(1.0, 1.0), (100.0, 100.0), (2.54, 2.54), (0.1, 0.1)])
def test_units_are_converted_in_the_data(tmp_path: Path, unit: float, size: float) -> None:
    fbx = FbxBuilder(unit=unit)
    fbx.mesh(fbx.node("plate", Lcl_Translation=(0.0, 0.0, 300.0)))
    model = load(fbx.write(tmp_path / "a.fbx"), SETTINGS)
    np.testing.assert_allclose(box(model), [[0, 0, 3 * size], [size, 2 * size, 3 * size]], rtol=1e-6)
    assert [n.name for n in model.nodes] == ["plate"]
    assert model.nodes[0].scale == (1.0, 1.0, 1.0)
    assert model.summary["unit_meters"] == pytest.approx(unit / 100)


def test_z_up_becomes_y_up(tmp_path: Path) -> None:
    fbx = FbxBuilder(up="z")
    fbx.mesh(fbx.node("plate"), [(0, 0, 0), (100, 0, 0), (100, 200, 300), (0, 200, 300)])
    model = load(fbx.write(tmp_path / "a.fbx"), SETTINGS)
    # z goes up, y away from the viewer
    np.testing.assert_allclose(box(model), [[0, 0, -2], [1, 3, 0]], atol=1e-6)
    assert model.summary["up_axis"] == "+z"


def test_polygon_uv_and_winding(tmp_path: Path) -> None:
    fbx = FbxBuilder()
    fbx.mesh(fbx.node("plate"), QUAD, ((0, 1, 2, 3),), UV)
    mesh = load(fbx.write(tmp_path / "a.fbx"), SETTINGS).meshes[0]
    assert mesh.vertex_count == 4
    assert len(mesh.indices) == 6
    corners = mesh.streams["position"][mesh.indices.reshape(-1, 3)].astype(float)
    assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0).all()
    assert (mesh.streams["normal"][:, 2] == 32767).all()
    # v is 0 at the bottom in FBX and at the top here
    low = mesh.streams["position"][:, 1].argmin()
    assert mesh.streams["uv0"][low, 1] == 1.0


def test_instances_share_a_mesh_and_mirrors_keep_facing_out(tmp_path: Path) -> None:
    fbx = FbxBuilder()
    first = fbx.node("one")
    geometry = fbx.mesh(first)
    mirrored = fbx.node("two", Lcl_Scaling=(-1.0, 1.0, 1.0))
    fbx.link(geometry, mirrored)
    model = load(fbx.write(tmp_path / "a.fbx"), SETTINGS)
    assert len(model.meshes) == 1
    assert [n.mesh.index for n in model.nodes if n.mesh] == [0, 0]
    for part in posed(model):
        corners = part.positions[part.triangles[0]]
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (np.sum(faces * part.normals[part.triangles[0][:, 0]], axis=1) > 0).all()
    np.testing.assert_allclose(box(model)[:, 0], [-1, 1])


def test_pivots_and_geometric_transform_are_folded_in(tmp_path: Path) -> None:
    fbx = FbxBuilder()
    # turned by 90 degrees about the point (100, 0, 0), the geometry first moved by 50 along x
    node = fbx.node("plate", Lcl_Rotation=(0.0, 0.0, 90.0), RotationPivot=(100.0, 0.0, 0.0), RotationActive=1,
                    GeometricTranslation=(50.0, 0.0, 0.0))  # fmt: skip
    fbx.mesh(node)
    model = load(fbx.write(tmp_path / "a.fbx"), SETTINGS)
    # x in 0.5..1.5, y in 0..2 -> (1 - y, x - 1)
    np.testing.assert_allclose(box(model), [[-1, -0.5, 0], [1, 0.5, 0]], atol=1e-6)


def test_skin_moves_with_its_joint_and_unweighted_points_stay(tmp_path: Path) -> None:
    fbx = FbxBuilder()
    node = fbx.node("plate", Lcl_Translation=(0.0, 0.0, 50.0))
    geometry = fbx.mesh(node)
    bone = fbx.node("bone", kind="LimbNode", Lcl_Translation=(0.0, 300.0, 0.0))
    bind = [*IDENTITY[:13], 200.0, 0.0, 1.0]  # bound at y = 2 m, now at 3 m
    fbx.skin(geometry, [(bone, [2, 3], [1.0, 1.0], bind)])
    model = load(fbx.write(tmp_path / "a.fbx"), SETTINGS)
    mesh = model.meshes[0]
    assert mesh.skeleton is not None
    assert sorted(mesh.skeleton.names) == ["bone", "plate"]
    assert len(model.nodes[0].joints) == 2
    points = {tuple(np.round(p, 5)) for p in posed(model)[0].positions}
    # the joint carries the upper two up by one metre, without the node's z; the lower two stay with the node
    assert points == {(0, 0, 0.5), (1, 0, 0.5), (1, 3, 0), (0, 3, 0)}
    assert any("no weight" in f.message for f in model.findings)


def test_maya_carries_a_skinned_mesh_with_its_animated_node(tmp_path: Path) -> None:
    for application, moved in (("Maya", 1.0), ("Test", 0.0)):
        fbx = FbxBuilder(application=application)
        node = fbx.node("plate")
        geometry = fbx.mesh(node)
        bone = fbx.node("bone", kind="LimbNode")
        fbx.skin(geometry, [(bone, [0, 1, 2, 3], [1.0] * 4, IDENTITY)])
        layer = fbx.stack("go", 0.0, 1.0)
        fbx.curve(layer, node, "Lcl Translation", "d|Z", [(0.0, 0.0), (1.0, 100.0)])
        model = load(fbx.write(tmp_path / "a.fbx"), SETTINGS)
        assert box(model, model.clips[0], 1.0)[0, 2] == pytest.approx(moved), application


def test_clips_start_at_zero_and_frames_are_the_files_own(tmp_path: Path) -> None:
    fbx = FbxBuilder()
    node = fbx.node("plate")
    fbx.mesh(node)
    layer = fbx.stack("slide", 1.0, 3.0)
    fbx.curve(layer, node, "Lcl Translation", "d|X", [(1.0, 100.0), (3.0, 500.0)])
    clip = (model := load(fbx.write(tmp_path / "a.fbx"), SETTINGS)).clips[0]
    assert (clip.name, clip.start, clip.frame_rate) == ("slide", 1.0, 24.0)
    assert clip.duration == pytest.approx(2.0)
    assert box(model, clip, time_of_frame(clip, 48))[0, 0] == pytest.approx(3.0)  # frame 48 is the file's second 2
    assert [(c.path, c.target) for c in clip.channels] == [("translation", "plate")]


def test_blend_shape_and_its_animation(tmp_path: Path) -> None:
    fbx = FbxBuilder()
    geometry = fbx.mesh(fbx.node("plate"))
    channel = fbx.shape(geometry, "lift", [2, 3], [(0.0, 0.0, 100.0), (0.0, 0.0, 50.0)])
    fbx.curve(fbx.stack("rise", 0.0, 1.0), channel, "DeformPercent", "d|DeformPercent", [(0.0, 0.0), (1.0, 100.0)])
    model = load(fbx.write(tmp_path / "a.fbx"), SETTINGS)
    assert [m.name for m in model.meshes[0].morphs] == ["lift"]
    assert model.nodes[0].weights == [0.0]
    assert box(model)[1, 2] == 0.0
    assert box(model, model.clips[0], 0.5)[1, 2] == pytest.approx(0.5)


def test_material_values(tmp_path: Path) -> None:
    fbx = FbxBuilder()
    node = fbx.node("plate")
    fbx.mesh(node)
    fbx.material(node, "glass", DiffuseColor=(0.5, 0.25, 1.0), DiffuseFactor=0.5, EmissiveColor=(2.0, 0.0, 0.0),
                 EmissiveFactor=1.0, TransparentColor=(1.0, 1.0, 1.0), TransparencyFactor=0.25)  # fmt: skip
    model = load(fbx.write(tmp_path / "a.fbx"), SETTINGS)
    asset = model.materials[0].asset
    assert model.slots == [[0]]
    assert asset.params["base_color"] == pytest.approx((0.25, 0.125, 0.5, 0.75))
    assert asset.params["emissive"] == pytest.approx((1.0, 0.0, 0.0))
    assert asset.params["emissive_strength"] == pytest.approx(2.0)
    assert (asset.params["metallic"], asset.queue) == (0.0, "transparent")


PNG = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108060000001f15c4890000000d49444154789c63f8cfc0f01f00050001ffa5f1"
    "1b0e0000000049454e44ae426082"
)


def textured(path: Path, file: str, relative: str = "") -> ImportedModel:
    fbx = FbxBuilder()
    node = fbx.node("plate")
    fbx.mesh(node, uv=UV)
    fbx.texture(fbx.material(node), file, relative=relative)
    return load(fbx.write(path), SETTINGS)


@pytest.mark.parametrize(
    ("named", "lies"),
    [
        ("wood.png", "wood.png"),
        ("tex/wood.png", "tex/wood.png"),
        ("tex\\wood.png", "tex/wood.png"),
        ("C:\\work\\art\\tex\\Wood.PNG", "tex/wood.png"),
        ("/home/somebody/tex/wood.png", "wood.png"),
        ("D:/x/wood.png", "a.fbm/wood.png"),
        ("D:/x/wood.png", "Textures/WOOD.png"),
        ("../maps/wood.png", "../maps/wood.png"),
        ("E:/assets/shared/wood.png", "../shared/wood.png"),
    ],
)
def test_textures_are_found(tmp_path: Path, named: str, lies: str) -> None:
    folder = tmp_path / "deep" / "model"
    image = folder / lies
    image.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(parents=True, exist_ok=True)
    image.write_bytes(PNG)
    model = textured(folder / "a.fbx", named)
    assert not [str(f) for f in model.findings if f.code == "fbx.texture"]
    assert model.images[model.materials[0].images["base_color_map"].image].data() == PNG
    assert [p.resolve() for _, p in dependencies(folder / "a.fbx", SETTINGS)] == [image.resolve()]


def test_a_missing_texture_names_what_was_tried_and_what_is_near(tmp_path: Path) -> None:
    (tmp_path / "wood_oak.png").write_bytes(PNG)
    model = textured(tmp_path / "a.fbx", "C:\\art\\wood_oka.png")
    (finding,) = [f for f in model.findings if f.code == "fbx.texture"]
    assert "wood_oka.png" in finding.message
    assert "wood_oak.png" in finding.hint
    assert model.materials[0].asset.textures["base_color_map"].path == ""
    assert "base_color_map" not in model.materials[0].images


def test_paths_out_of_the_folder_are_not_followed(tmp_path: Path) -> None:
    (tmp_path / "secret.bin").write_bytes(b"secret")
    (tmp_path / "model").mkdir()
    for named in ("../secret.bin", str(tmp_path / "secret.bin"), "..\\secret.bin"):
        model = textured(tmp_path / "model" / "a.fbx", named)
        assert model.images == []
        assert [f for f in model.findings if f.code == "fbx.texture"]


def test_a_link_out_of_the_folder_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "private").mkdir()
    (tmp_path / "private" / "x.png").write_bytes(PNG)
    (tmp_path / "model").mkdir()
    (tmp_path / "model" / "wood.png").symlink_to(tmp_path / "private" / "x.png")
    assert textured(tmp_path / "model" / "a.fbx", "wood.png").images == []


def test_convert_writes_a_scene(tmp_path: Path) -> None:
    (tmp_path / "wood.png").write_bytes(PNG)
    textured(tmp_path / "a.fbx", "wood.png")
    result = convert(tmp_path / "a.fbx", tmp_path / "out", SETTINGS)
    names = {p.name for p in result.outputs}
    assert names == {"a.scene.json", "a.lmesh", "a.paint.material.toml", "a.wood.dds"}
    again = convert(tmp_path / "a.fbx", tmp_path / "again", SETTINGS)
    assert [p.read_bytes() for p in result.outputs] == [p.read_bytes() for p in again.outputs]


def test_fbx_is_known_by_its_content(tmp_path: Path) -> None:
    fbx = FbxBuilder()
    fbx.mesh(fbx.node("plate"))
    path = fbx.write(tmp_path / "model.bin")
    assert find_importer(path).name == "FBX"


@pytest.mark.parametrize(
    ("content", "word"),
    [(b"", "empty"), (b"hello", "FBX"), (b"Kaydara FBX Binary  \0\x1a\0\xe8\x1c\0\0\xff\xff\xff\xff", "FBX")],
)
def test_what_is_no_fbx_is_refused_in_words(tmp_path: Path, content: bytes, word: str) -> None:
    path = tmp_path / "bad.fbx"
    path.write_bytes(content)
    with pytest.raises(FormatError) as caught:
        load(path, SETTINGS)
    assert "bad.fbx" in str(caught.value)
    assert word in str(caught.value)


def test_missing_files_and_folders(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        load(tmp_path / "none.fbx", SETTINGS)
    (tmp_path / "folder.fbx").mkdir()
    with pytest.raises(InputError, match="regular file"):
        load(tmp_path / "folder.fbx", SETTINGS)


def test_numbers_that_are_none(tmp_path: Path) -> None:
    fbx = FbxBuilder()
    node = fbx.node("plate")
    fbx.mesh(node, [*QUAD[:3], (math.inf, 0.0, 0.0), (0.0, 0.0, 100.0)], ((0, 1, 2), (0, 1, 3), (0, 1, 4)))
    path = tmp_path / "a.fbx"
    path.write_text(fbx.text().replace("inf", "1e400"), encoding="utf-8")
    model = load(path, SETTINGS)
    assert len(model.meshes[0].indices) == 6
    assert np.isfinite(model.meshes[0].streams["position"]).all()
    assert any(f.code == "fbx.not-finite" for f in model.findings)
