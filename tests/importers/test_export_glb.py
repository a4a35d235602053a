"""GLB export: what goes out and comes back is the same; the file is sound for others, too."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.animation.pose import pose_meshes, pose_nodes
from importers.cli.main import main
from importers.convert import convert
from importers.export.glb import glb_bytes
from importers.export.source import ExportSource, load_source, posed
from importers.settings import ImportSettings
from tests.support.gltf_builder import GltfBuilder, png

SETTINGS = ImportSettings()


def everything() -> GltfBuilder:
    """A skinned, morphed, textured, animated quad with a camera, a light, hidden and extra things."""
    b = GltfBuilder()
    rng = np.random.default_rng(3)
    normal = rng.normal(size=(4, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    attributes = {
        "POSITION": b.accessor([[0, 0, 0], [1, 0, 0.1], [1, 1, 0], [0, 1, 0.3]]),
        "NORMAL": b.accessor(normal),
        "TEXCOORD_0": b.accessor(rng.random((4, 2))),
        "COLOR_0": b.accessor(rng.integers(0, 65536, (4, 4)), "u2", normalized=True),
        "JOINTS_0": b.accessor([[0, 1, 0, 0]] * 4, "u1"),
        "WEIGHTS_0": b.accessor([[0.3, 0.7, 0, 0], [1, 0, 0, 0], [0.5, 0.5, 0, 0], [0.1, 0.9, 0, 0]]),
    }
    targets = [{"POSITION": b.accessor(rng.random((4, 3))), "NORMAL": b.accessor(rng.random((4, 3)))} for _ in "ab"]
    image = b.texture(png(3, 2))
    b.root["samplers"] = [{"wrapS": 33071, "magFilter": 9728, "minFilter": 9985}]
    b.root["textures"][0]["sampler"] = 0
    moved = {"KHR_texture_transform": {"offset": [0.25, 0.5], "rotation": 0.5, "scale": [2, 3]}}
    b.material(
        name="paint", alphaMode="MASK", alphaCutoff=0.25, doubleSided=True, emissiveFactor=[0.5, 0.25, 0],
        pbrMetallicRoughness={"baseColorTexture": {"index": image, "extensions": moved}, "roughnessFactor": 0.3},
        normalTexture={"index": image, "scale": 0.5}, occlusionTexture={"index": image, "strength": 0.75},
        extensions={
            "KHR_materials_ior": {"ior": 1.4}, "KHR_materials_emissive_strength": {"emissiveStrength": 3.5},
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatTexture": {"index": image}},
        },
        extras={"shop": "A"},
    )  # fmt: skip
    b.material(name="red", pbrMetallicRoughness={"baseColorFactor": [1, 0, 0, 1], "metallicFactor": 0.0})
    variants = {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}}
    primitive = {"attributes": attributes, "targets": targets, "material": 0, "extensions": variants}
    b.mesh(
        primitive | {"indices": b.accessor([0, 1, 2], "u2")},
        {"attributes": attributes, "targets": targets, "material": 1, "mode": 1,
         "indices": b.accessor([0, 2, 2, 3], "u2")},
        name="quad", extras={"targetNames": ["smile", "frown"], "mine": [1, 2]},
    )  # fmt: skip
    bind = np.tile(np.eye(4), (2, 1, 1))
    bind[1, 3, :3] = [0, -1, 0.5]
    times, k = b.accessor([0, 0.5, 2]), 3
    turn = np.array([[0, 0, 0, 1], [0, 0.6, 0, 0.8], [1, 0, 0, 0]], np.float32)
    channels = [
        (1, "rotation", "LINEAR", b.accessor(turn)),
        (1, "translation", "CUBICSPLINE", b.accessor(rng.random((3 * k, 3)))),
        (2, "scale", "STEP", b.accessor(rng.random((k, 3)))),
        (0, "weights", "LINEAR", b.accessor(rng.random(2 * k))),
    ]
    shear = [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    b.root |= {
        "nodes": [
            {"name": "body", "mesh": 0, "skin": 0, "weights": [0.25, 0.5], "extras": {"tag": "x"}},
            {"name": "hip", "children": [2, 3], "translation": [1 / 3, 2, 3]},
            {"name": "knee", "rotation": [0, 0.6, 0, 0.8], "camera": 0,
             "extensions": {"KHR_node_visibility": {"visible": False}}},
            {"name": "lamp", "scale": [1, 2, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"name": "bent", "matrix": shear},
        ],
        "scenes": [{"nodes": [0, 1, 4], "extras": {"lucarna": {"look": {"tone_map": "agx", "exposure": 1.5}}}}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": b.accessor(bind.reshape(2, 16))}],
        "cameras": [{"type": "perspective",
                     "perspective": {"yfov": 0.7, "znear": 0.1, "zfar": 50, "aspectRatio": 1.5}}],
        "animations": [{
            "name": "wave", "extras": {"lucarna": {"start": 0.25, "frame_rate": 24.0}},
            "samplers": [{"input": times, "output": out, "interpolation": way} for _, _, way, out in channels],
            "channels": [{"sampler": i, "target": {"node": n, "path": p}} for i, (n, p, _, _) in enumerate(channels)],
        }],
        "extensions": {
            "KHR_lights_punctual": {"lights": [{"type": "spot", "color": [1, 0.5, 0.25], "intensity": 20, "range": 5,
                                                "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.6}}]},
            "KHR_materials_variants": {"variants": [{"name": "plain"}, {"name": "sport"}]},
        },
    }  # fmt: skip
    return b


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return everything().write_glb(tmp_path_factory.mktemp("glb") / "all.glb")


def check_same(a: ExportSource, b: ExportSource, *, pictures: bool = True) -> None:
    for x, y in zip(a.nodes, b.nodes, strict=True):
        for key in ("name", "parent", "translation", "rotation", "scale", "matrix", "visible", "camera", "light",
                    "joints", "weights", "extras"):  # fmt: skip
            assert getattr(x, key) == getattr(y, key), (x.name, key)
    for m, n in zip(a.meshes, b.meshes, strict=True):
        assert (m.name, m.layout, m.submeshes, m.extras) == (n.name, n.layout, n.submeshes, n.extras)
        np.testing.assert_array_equal(m.indices, n.indices)
        for stream in m.layout:
            np.testing.assert_array_equal(m.streams[stream], n.streams[stream], err_msg=stream)
        assert [t.name for t in m.morphs] == [t.name for t in n.morphs]
        for t, u in zip(m.morphs, n.morphs, strict=True):
            assert t.streams.keys() == u.streams.keys()
            for stream in t.streams:
                np.testing.assert_array_equal(t.streams[stream], u.streams[stream])
        assert (m.skeleton is None) == (n.skeleton is None)
        if m.skeleton is not None and n.skeleton is not None:
            assert m.skeleton.names == n.skeleton.names
            np.testing.assert_array_equal(m.skeleton.inverse_bind, n.skeleton.inverse_bind)
    for p, q in zip(a.clips, b.clips, strict=True):
        assert (p.name, p.start, p.frame_rate) == (q.name, q.start, q.frame_rate)
        for c, d in zip(p.channels, q.channels, strict=True):
            assert (c.node, c.path, c.interpolation, c.target) == (d.node, d.path, d.interpolation, d.target)
            np.testing.assert_array_equal(c.times, d.times)
            np.testing.assert_array_equal(c.values, d.values)
    for row in range(len(a.nodes)):
        for i, j in zip(a.materials_of[row], b.materials_of[row], strict=True):
            assert (i < 0) == (j < 0)
            if i < 0:
                continue
            x_material, y_material = a.materials[i], b.materials[j]
            for key in ("name", "queue", "features", "params"):
                assert getattr(x_material, key) == getattr(y_material, key), key
            assert x_material.textures.keys() == y_material.textures.keys()
            for slot in x_material.textures:
                one, two = a.picture(i, slot), b.picture(j, slot)
                assert one is not None
                assert two is not None
                assert not pictures or one.data == two.data
    assert (a.environment, a.look) == (b.environment, b.look)


def test_there_and_back_is_the_same(file: Path, tmp_path: Path) -> None:
    a = load_source(file, SETTINGS)
    assert [c.interpolation for c in a.clips[0].channels] == ["linear", "cubic", "step", "linear"]
    out = tmp_path / "all.glb"
    out.write_bytes(glb_bytes(a))
    b = load_source(out, SETTINGS)
    assert not b.findings.has_errors
    check_same(a, b)
    for x, y in zip(a.materials, b.materials, strict=True):
        assert x.extensions == y.extensions
        assert x.textures == y.textures
    assert (a.materials[0].effect, b.materials[0].effect) == ("layered", "layered")
    assert "clearcoat_map" in b.materials[0].textures
    assert glb_bytes(b) == out.read_bytes(), "a second trip changes nothing"


def test_a_converted_scene_gives_the_same(file: Path, tmp_path: Path) -> None:
    scene = convert(file, tmp_path / "conv", SETTINGS.replace(compress=False)).scene
    assert scene is not None
    out = tmp_path / "out.glb"
    out.write_bytes(glb_bytes(load_source(scene, SETTINGS)))
    a, b = load_source(scene, SETTINGS), load_source(out, SETTINGS)
    for one, two in zip(a.meshes, b.meshes, strict=True):  # a scene knows its materials by file, not by number
        kept = [mesh.extras.pop("material_variants") for mesh in (one, two)]
        named = [
            [[s.materials[i].name if i >= 0 else "" for i in slot] for slot in k["slots"]]  # type: ignore[index]  # JSON
            for s, k in zip((a, b), kept, strict=True)
        ]
        assert named[0] == named[1] == [["", "red"], ["", ""]]
    check_same(a, b, pictures=False)
    picture = b.picture(b.materials_of[0][0], "base_color_map")
    assert picture is not None
    from importers.textures.image import decode

    assert decode(picture.data, "p", SETTINGS)[0, 0].tolist() == [200, 100, 50, 255]


def test_baked_pose(file: Path, tmp_path: Path) -> None:
    source = load_source(file, SETTINGS)
    clip = source.clips[0]
    out = tmp_path / "posed.glb"
    out.write_bytes(glb_bytes(posed(source, clip, 0.75)))
    back = load_source(out, SETTINGS)
    wanted = next(pose_meshes(source.nodes, source.meshes, pose_nodes(source.nodes, clip, 0.75)))
    corners = wanted.positions.astype("f4")[wanted.mesh.indices]
    np.testing.assert_array_equal(back.meshes[0].streams["position"][back.meshes[0].indices], corners)
    assert not back.clips
    assert back.meshes[0].skeleton is None
    assert [s.topology for s in back.meshes[0].submeshes] == ["triangles", "lines"]
    lamp = next(n for n in back.nodes if n.light is not None)
    world = pose_nodes(source.nodes, clip, 0.75).world[3]
    np.testing.assert_allclose(lamp.translation, world[:3, 3], atol=1e-12)


def tree(data: bytes) -> tuple[dict[str, Any], bytes]:
    """By the letter of the container, without our reader."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<II", data, 12)
    assert kind == 0x4E4F534A
    assert size % 4 == 0
    root: dict[str, Any] = json.loads(data[20 : 20 + size])
    binary_size, binary_kind = struct.unpack_from("<II", data, 20 + size)
    assert binary_kind == 0x004E4942
    return root, data[28 + size : 28 + size + binary_size]


def test_the_file_by_the_letter(file: Path) -> None:
    root, binary = tree(glb_bytes(load_source(file, SETTINGS)))
    assert root["buffers"] == [{"byteLength": len(binary)}]
    sizes = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
    for accessor in root["accessors"]:
        view = root["bufferViews"][accessor["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        assert view["byteOffset"] + view["byteLength"] <= len(binary)
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}[accessor["type"]]
        size = sizes[accessor["componentType"]] * width
        assert (accessor["count"] - 1) * view.get("byteStride", size) + size <= view["byteLength"]
        assert view.get("byteStride", 4) % 4 == 0
        if "min" in accessor and accessor["type"] == "VEC3":
            values = np.frombuffer(binary, "<f4", accessor["count"] * 3, view["byteOffset"]).reshape(-1, 3)
            assert accessor["min"] == values.min(axis=0).tolist()
    assert len(root["images"]) == 1, "equal images go in once"
    used = set(root["extensionsUsed"])
    assert used >= {"KHR_lights_punctual", "KHR_texture_transform", "KHR_materials_ior", "KHR_materials_variants"}
    positions = root["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
    assert {"min", "max"} <= root["accessors"][positions].keys()


def test_trimesh_reads_it(file: Path, tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    out = tmp_path / "out.glb"
    source = load_source(file, SETTINGS)
    out.write_bytes(glb_bytes(source))
    scene = trimesh.load(out, process=False)
    shape = next(g for g in scene.geometry.values() if hasattr(g, "faces"))
    np.testing.assert_array_equal(shape.faces, [[0, 1, 2]])
    np.testing.assert_allclose(shape.vertices, source.meshes[0].streams["position"], atol=1e-7)


@pytest.mark.parametrize(
    ("words", "code", "clips"),
    [
        ([], 0, 1),
        (["--clip", "WAVE"], 0, 1),
        (["--time", "0.5"], 0, 0),
        (["--frame", "9"], 0, 0),
        (["--clip", "no"], 2, -1),
    ],
)
def test_command(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], code: int, clips: int
) -> None:
    out = tmp_path / "o.glb"
    assert main(["export", str(file), "--out", str(out), *words]) == code
    assert out.exists() == (code == 0)
    if clips >= 0:
        assert len(load_source(out, SETTINGS).clips) == clips
    assert not [p for p in tmp_path.iterdir() if p != out], "nothing else is left"
    capsys.readouterr()


def test_what_cannot_go_is_said(file: Path) -> None:
    source = load_source(file, SETTINGS)
    source.materials[0].effect = "water"
    source.environment.kind = "image"
    lamp = source.nodes[3].light
    assert lamp is not None
    lamp.type, lamp.width, lamp.height, lamp.color = "disk", 2.0, 3.0, (4.0, 2.0, 1.0)
    source.picture = lambda material, slot: None
    root, _ = tree(glb_bytes(source))
    light = root["extensions"]["KHR_lights_punctual"]["lights"][0]
    assert light["type"] == "spot"
    assert light["color"] == [1.0, 0.5, 0.25]
    np.testing.assert_allclose(light["intensity"], 20 * 4 * np.pi * 1.0 * 1.5)  # nit times the ellipse's area, times 4
    assert "no word for a disk light" in " ".join(str(f) for f in source.findings)
    said = " ".join(str(f) for f in source.findings)
    assert "no effect 'water'" in said
    assert "environment's image" in said
    assert "the image of normal_map is not at hand" in said
