"""The glTF reader on small files: accessors, meshes, materials, nodes, animations."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.assets.scene_json import read_scene
from engine.core.findings import Findings, Severity
from importers.convert import convert
from importers.gltf.container import json_depth
from importers.gltf.reader import dependencies, load
from importers.model import ImportedModel
from importers.settings import ImportSettings
from tests.support.gltf_builder import GltfBuilder, png, textured_triangle, triangle

SETTINGS = ImportSettings()


def read(builder: GltfBuilder, folder: Path) -> ImportedModel:
    return load(builder.write_glb(folder / "t.glb"), SETTINGS)


def serious(findings: Findings) -> list[str]:
    return [str(f) for f in findings if f.severity is not Severity.INFO]


def positions(model: ImportedModel, mesh: int = 0) -> list[list[float]]:
    return np.asarray(model.meshes[mesh].streams["position"]).tolist()


def attributes(builder: GltfBuilder) -> dict[str, Any]:
    found: dict[str, Any] = builder.root["meshes"][0]["primitives"][0]["attributes"]
    return found


def test_glb_and_gltf_give_the_same_model(tmp_path: Path) -> None:
    a = load(textured_triangle().write_glb(tmp_path / "a.glb"), SETTINGS)
    b = load(textured_triangle().write_gltf(tmp_path / "b.gltf"), SETTINGS)
    c = load(textured_triangle().write_gltf(tmp_path / "c.gltf", "c data.bin"), SETTINGS)
    for other in (b, c):
        for stream in a.meshes[0].layout:
            np.testing.assert_array_equal(a.meshes[0].streams[stream], other.meshes[0].streams[stream])
        assert not serious(other.findings)
    assert a.meshes[0].layout == ("position", "normal", "tangent", "uv0")
    assert c.dependencies == [(tmp_path / "c data.bin").resolve()]


def test_percent_encoded_uri_and_dependencies(tmp_path: Path) -> None:
    path = triangle().write_gltf(tmp_path / "a.gltf", "my data.bin")
    root = json.loads(path.read_text())
    root["buffers"][0]["uri"] = "my%20data.bin"
    root["images"] = [{"uri": "sub/skin.png"}, {"uri": "../out.png"}, {"uri": "data:image/png;base64,"}]
    path.write_text(json.dumps(root))
    assert not serious(load(path, SETTINGS).findings)
    assert [name for name, _ in dependencies(path, SETTINGS)] == ["my%20data.bin", "sub/skin.png"]


def test_allow_outside_follows_the_uri(tmp_path: Path) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    path = triangle().write_gltf(inner / "a.gltf", "../shared.bin")
    assert load(path, SETTINGS).findings.has_errors
    assert not load(path, ImportSettings(allow_outside=True)).findings.has_errors


def test_interleaved_with_stride(tmp_path: Path) -> None:
    b = triangle()
    rows = np.zeros(3, np.dtype([("p", "<f4", 3), ("n", "<f4", 3)]))
    rows["p"], rows["n"] = [[1, 2, 3], [4, 5, 6], [7, 8, 0]], [0, 1, 0]
    view = b.view(rows.tobytes(), byteStride=24)
    for name, offset in (("POSITION", 0), ("NORMAL", 12)):
        b.root["accessors"].append(
            {"bufferView": view, "byteOffset": offset, "componentType": 5126, "count": 3, "type": "VEC3"}
        )
        attributes(b)[name] = len(b.root["accessors"]) - 1
    model = read(b, tmp_path)
    assert positions(model) == [[1, 2, 3], [4, 5, 6], [7, 8, 0]]
    assert np.asarray(model.meshes[0].streams["normal"])[:, 1].tolist() == [32767] * 3


def test_sparse_over_nothing_and_over_a_view(tmp_path: Path) -> None:
    b = triangle()
    sparse = {
        "count": 2,
        "indices": {"bufferView": b.view(np.array([0, 2], "<u2").tobytes()), "componentType": 5123},
        "values": {"bufferView": b.view(np.array([[9, 9, 9], [7, 0, 7]], "<f4").tobytes())},
    }
    b.root["accessors"][0]["sparse"] = sparse
    assert positions(read(b, tmp_path)) == [[9, 9, 9], [1, 0, 0], [7, 0, 7]]
    del b.root["accessors"][0]["bufferView"]
    assert positions(read(b, tmp_path)) == [[9, 9, 9], [0, 0, 0], [7, 0, 7]]


@pytest.mark.parametrize(
    ("dtype", "values", "expected"),
    [("u1", [0, 255, 51], [0, 1, 0.2]), ("u2", [0, 65535, 13107], [0, 1, 0.2]), ("i1", [-128, 127, 0], [-1, 1, 0])],
)
def test_normalised_integers(tmp_path: Path, dtype: str, values: list[int], expected: list[float]) -> None:
    b = triangle()
    attributes(b)["TEXCOORD_0"] = b.accessor([[v, 0] for v in values], dtype, normalized=True)
    uv = np.asarray(read(b, tmp_path).meshes[0].streams["uv0"])
    np.testing.assert_allclose(uv[:, 0], expected, atol=1e-7)


def test_matrix_columns_of_bytes_are_padded(tmp_path: Path) -> None:
    """A MAT3 of unsigned bytes has each column on a 4-byte boundary."""
    from importers.gltf.accessors import Accessors
    from importers.gltf.container import Buffers, read_container
    from importers.gltf.document import Document

    b = triangle()
    view = b.view(bytes([1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0]))
    b.root["accessors"].append({"bufferView": view, "componentType": 5121, "count": 1, "type": "MAT3"})
    findings = Findings()
    container = read_container(b.write_glb(tmp_path / "m.glb"), SETTINGS, findings)
    doc = Document(container.root, findings)
    accessors = Accessors(doc, Buffers(container, doc.objects("buffers"), findings), 1 << 20)
    matrix = accessors.raw(len(b.root["accessors"]) - 1)
    assert matrix is not None
    assert matrix.tolist() == [[1, 2, 3, 4, 5, 6, 7, 8, 9]]


def test_decoded_bytes_are_budgeted(tmp_path: Path) -> None:
    path = triangle().write_glb(tmp_path / "t.glb")
    findings = load(path, ImportSettings(max_decoded_bytes=50)).findings
    assert any("left of the limit" in f.message for f in findings)


def test_primitives_share_vertices_and_slots(tmp_path: Path) -> None:
    b = triangle()
    first = b.root["meshes"][0]["primitives"][0]
    b.material(name="a")
    b.root["meshes"][0]["primitives"] = [first, first | {"material": 0}, first | {"mode": 2}]
    model = read(b, tmp_path)
    mesh = model.meshes[0]
    assert mesh.vertex_count == 3
    assert [(s.first_index, s.index_count, s.material_slot, s.topology) for s in mesh.submeshes] == [
        (0, 3, 0, "triangles"), (3, 3, 1, "triangles"), (6, 6, 0, "lines")
    ]  # fmt: skip
    assert model.slots[0] == [-1, 0]
    assert mesh.submeshes[0].bounds_max == (1.0, 1.0, 0.0)


def test_lines_without_normals_get_an_unlit_material(tmp_path: Path) -> None:
    b = triangle()
    del attributes(b)["NORMAL"]
    b.material(name="wire")
    b.root["meshes"][0]["primitives"][0] |= {"mode": 3, "material": 0}
    model = read(b, tmp_path)
    used = model.materials[model.slots[0][0]].asset
    assert used.name == "wire unlit"
    assert "unlit" in used.features
    assert "unlit" not in model.materials[0].asset.features


def test_missing_normals_are_flat_and_uv_follow(tmp_path: Path) -> None:
    b = triangle([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, -1]])
    del attributes(b)["NORMAL"]
    b.root["meshes"][0]["primitives"][0]["indices"] = b.accessor([0, 1, 2, 0, 3, 1], "u1")
    mesh = read(b, tmp_path).meshes[0]
    assert mesh.vertex_count == 6
    normals = np.asarray(mesh.streams["normal"])[mesh.indices][:, :3] / 32767
    np.testing.assert_allclose(normals, [[0, 0, 1]] * 3 + [[0, -1, 0]] * 3, atol=1e-4)
    uv, p = np.asarray(mesh.streams["uv0"]), np.asarray(mesh.streams["position"])
    np.testing.assert_array_equal(uv[:, 0], p[:, 0])


def test_vertex_colours_become_four_linear_shorts(tmp_path: Path) -> None:
    b = triangle()
    attributes(b)["COLOR_0"] = b.accessor([[1, 0.5, 0]] * 3)
    color = np.asarray(read(b, tmp_path).meshes[0].streams["color"])
    assert color.tolist() == [[65535, 32768, 0, 65535]] * 3


def test_skin_is_reordered_depth_first(tmp_path: Path) -> None:
    b = triangle()
    attributes(b)["JOINTS_0"] = b.accessor([[0, 1, 2, 0]] * 3, "u1")
    attributes(b)["WEIGHTS_0"] = b.accessor([[0.5, 0.3, 0.2, 0]] * 3)
    b.root["nodes"] = [
        {"mesh": 0, "skin": 0}, {"name": "root", "children": [2, 3]}, {"name": "a"}, {"name": "b"}
    ]  # fmt: skip
    b.root["scenes"] = [{"nodes": [0, 1]}]
    matrices = np.tile(np.eye(4, dtype="f4"), (3, 1, 1))
    matrices[:, 3, 0] = [10, 20, 30]  # column-major: x translation of joints 3, 1, 2
    b.root["skins"] = [{"joints": [3, 1, 2], "inverseBindMatrices": b.accessor(matrices.reshape(3, 16))}]
    model = read(b, tmp_path)
    mesh = model.meshes[0]
    assert mesh.skeleton is not None
    assert mesh.skeleton.names == ["root", "a", "b"]
    assert mesh.skeleton.parents.tolist() == [-1, 0, 0]
    assert mesh.skeleton.inverse_bind[:, 0, 3].tolist() == [20, 30, 10]
    # the source's joint 0 is `b`, now row 2
    assert np.asarray(mesh.streams["joints"])[0].tolist() == [2, 0, 1, 0]
    assert [model.nodes[j].name for j in model.nodes[0].joints] == ["root", "a", "b"]


def test_morph_targets_with_names_and_weights(tmp_path: Path) -> None:
    b = triangle()
    mesh = b.root["meshes"][0]
    mesh["primitives"][0]["targets"] = [{"POSITION": b.accessor([[0, 0, 1]] * 3)}]
    mesh |= {"weights": [0.25], "extras": {"targetNames": ["rise"]}}
    model = read(b, tmp_path)
    assert model.meshes[0].morphs[0].name == "rise"
    assert model.meshes[0].morphs[0].streams["position"].tolist() == [[0, 0, 1]] * 3
    assert model.nodes[0].weights == [0.25]


def test_material_parameters_textures_and_features(tmp_path: Path) -> None:
    b = textured_triangle()
    b.root["samplers"] = [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9985}]
    b.root["textures"][0]["sampler"] = 0
    transform = {"KHR_texture_transform": {"offset": [0.5, 0.25], "rotation": 1.5, "scale": [2, 3], "texCoord": 1}}
    b.root["materials"][0] = {
        "name": "paint", "alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": True,
        "pbrMetallicRoughness": {
            "baseColorFactor": [1, 0.5, 0.25, 0.75], "metallicFactor": 0.1, "roughnessFactor": 0.7,
            "baseColorTexture": {"index": 0, "extensions": transform},
            "metallicRoughnessTexture": {"index": 1},
        },
        "occlusionTexture": {"index": 1, "strength": 0.4},
        "emissiveFactor": [0, 1, 0],
        "extensions": {
            "KHR_materials_unlit": {}, "KHR_materials_emissive_strength": {"emissiveStrength": 5},
            "KHR_materials_clearcoat": {"clearcoatFactor": 1}, "KHR_materials_ior": {"ior": 1.3},
        },
    }  # fmt: skip
    model = read(b, tmp_path)
    asset = model.materials[0].asset
    assert (asset.effect, asset.queue, asset.features) == ("surface", "alpha_test", ["double_sided", "unlit"])
    assert asset.params == {
        "base_color": (1, 0.5, 0.25, 0.75), "metallic": 0.1, "roughness": 0.7, "normal_scale": 1.0,
        "occlusion_strength": 0.4, "emissive": (0, 1, 0), "emissive_strength": 5.0, "alpha_cutoff": 0.3, "ior": 1.3,
    }  # fmt: skip
    base = asset.textures["base_color_map"]
    assert (base.wrap_u, base.wrap_v, base.mag_filter, base.min_filter) == (
        "clamp", "mirror", "nearest", "linear_mip_nearest"
    )  # fmt: skip
    assert (base.offset, base.scale, base.rotation, base.uv_set) == ((0.5, 0.25), (2.0, 3.0), 1.5, 1)
    roles = {slot: (use.image, use.role) for slot, use in model.materials[0].images.items()}
    assert roles == {
        "base_color_map": (0, "color"), "metal_rough_map": (1, "metal_rough"), "occlusion_map": (1, "occlusion")
    }  # fmt: skip
    assert asset.extensions == {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}
    assert any("clearcoat is imported and kept" in f.message for f in model.findings)


def test_specular_glossiness_is_converted(tmp_path: Path) -> None:
    b = triangle()
    gold = {"diffuseFactor": [0, 0, 0, 1], "specularFactor": [1.0, 0.77, 0.34], "glossinessFactor": 0.8}
    plastic = {"diffuseFactor": [0.5, 0.5, 0.5, 1], "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 0.3}
    for values in (gold, plastic):
        b.material(extensions={"KHR_materials_pbrSpecularGlossiness": values})
    model = read(b, tmp_path)
    metal, plain = (m.asset.params for m in model.materials)
    assert metal["metallic"] == pytest.approx(1, abs=0.02)
    assert metal["base_color"][:3] == pytest.approx((1, 0.77, 0.34), abs=0.02)
    assert metal["roughness"] == pytest.approx(0.2)
    assert plain["metallic"] == pytest.approx(0, abs=1e-6)
    assert plain["base_color"][:3] == pytest.approx((0.5, 0.5, 0.5), abs=0.01)


def test_matrix_becomes_trs_and_shear_is_kept(tmp_path: Path) -> None:
    b = triangle()
    turned = [0, 0, -2, 0, 0, 3, 0, 0, 4, 0, 0, 0, 5, 6, 7, 1]  # about +Y by 90 degrees, scaled 2, 3, 4
    sheared = [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    tiny = [1e-6 * v for v in turned[:12]] + turned[12:]
    b.root["nodes"] = [{"matrix": turned, "mesh": 0}, {"matrix": sheared}, {"matrix": tiny}]
    b.root["scenes"] = [{"nodes": [0, 1, 2]}]
    model = read(b, tmp_path)
    first, second, third = model.nodes
    assert first.translation == (5, 6, 7)
    assert first.scale == pytest.approx((2, 3, 4))
    assert first.rotation == pytest.approx((0, 0.5**0.5, 0, 0.5**0.5))
    assert first.matrix is None
    assert second.matrix == pytest.approx(sheared)
    assert third.scale == pytest.approx((2e-6, 3e-6, 4e-6))
    assert not serious(model.findings)


def test_parents_come_first_and_cameras_and_lights_are_read(tmp_path: Path) -> None:
    b = triangle()
    b.root["nodes"] = [
        {"mesh": 0}, {"children": [0, 2]}, {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}
    ]  # fmt: skip
    b.root["scenes"] = [{"nodes": [1]}]
    b.root["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1, "aspectRatio": 1.5}}]
    spot = {"type": "spot", "intensity": 20, "color": [1, 0, 0], "range": 9, "spot": {"outerConeAngle": 0.5}}
    b.root["extensions"] = {"KHR_lights_punctual": {"lights": [spot]}}
    model = read(b, tmp_path)
    assert [n.parent for n in model.nodes] == [-1, 0, 0]
    assert model.active_camera == 2
    camera, light = model.nodes[2].camera, model.nodes[2].light
    assert camera is not None
    assert light is not None
    assert (camera.type, camera.yfov, camera.znear, camera.zfar, camera.aspect) == ("perspective", 0.6, 0.1, 0.0, 1.5)
    assert (light.type, light.intensity, light.range, light.outer_angle) == ("spot", 20, 9, 0.5)
    assert light.color == (1, 0, 0)


def test_animation_of_all_kinds(tmp_path: Path) -> None:
    b = triangle()
    times = b.accessor([0, 1, 2])
    samplers = [
        {"input": times, "output": b.accessor([[0, 0, 0], [1, 0, 0], [2, 0, 0]]), "interpolation": "STEP"},
        {"input": times, "output": b.accessor([[0, 0, 0, 127]] * 3, "i1", normalized=True)},
        {"input": times, "output": b.accessor(np.arange(27).reshape(9, 3)), "interpolation": "CUBICSPLINE"},
    ]
    channels = [
        {"sampler": i, "target": {"node": 0, "path": p}} for i, p in enumerate(("translation", "rotation", "scale"))
    ]
    b.root["animations"] = [{"name": "go", "samplers": samplers, "channels": channels}]
    clip = read(b, tmp_path).clips[0]
    assert clip.name == "go"
    assert clip.duration == 2
    assert [c.interpolation for c in clip.channels] == ["step", "linear", "cubic"]
    assert clip.channels[1].values.tolist() == [[0, 0, 0, 1]] * 3
    assert clip.channels[2].values.shape == (3, 3, 3)
    assert clip.channels[2].values[1, 2].tolist() == [15, 16, 17]


def test_key_times_are_sorted_and_bad_keys_dropped(tmp_path: Path) -> None:
    b = triangle()
    sampler = {
        "input": b.accessor([1, 0, 2, 2, float("nan")]),
        "output": b.accessor([[1, 0, 0], [0, 0, 0], [2, 0, 0], [3, 0, 0], [9, 9, 9]]),
    }
    b.root["animations"] = [
        {"samplers": [sampler], "channels": [{"sampler": 0, "target": {"node": 0, "path": "scale"}}]}
    ]
    model = read(b, tmp_path)
    channel = model.clips[0].channels[0]
    assert channel.times.tolist() == [0, 1, 2]
    assert channel.values[:, 0].tolist() == [0, 1, 3]
    assert {f.code for f in model.findings} >= {"gltf.not-finite", "gltf.key-times"}


def test_json_depth_ignores_brackets_in_strings() -> None:
    assert json_depth(b'{"a": [[["\\"[[[[[[["]]]}', 2) == 4
    assert json_depth(b'{"a": "' + b"[" * 100 + b'"}', 2) == 1
    assert json_depth(b'{"open [[[[', 2) == 1


def test_no_image_and_webp_source(tmp_path: Path) -> None:
    b = textured_triangle()
    b.root["textures"][0] = {"extensions": {"EXT_texture_webp": {"source": 1}}}
    b.root["textures"][1] = {}
    model = read(b, tmp_path)
    assert model.materials[0].images["base_color_map"].image == 1
    assert "normal_map" not in model.materials[0].images
    assert any("names no image" in f.message for f in model.findings)


def test_an_image_in_the_buffer_is_read_whole(tmp_path: Path) -> None:
    data = png(3, 2)
    model = read(textured_triangle(data), tmp_path)
    assert model.images[0].data() == data


IES = "IESNA91\nTILT=NONE\n1 1000 2 3 1 1 2 0 0 0\n1 1 10\n0 90 180\n0\n100 50 0\n"


def test_light_profiles_come_along(tmp_path: Path) -> None:
    """EXT_lights_ies: the file's candela times the multiplier, the file itself beside the scene, a dependency."""
    b = triangle()
    (tmp_path / "spot lamp.ies").write_text(IES, "utf-8")
    of = {"light": 0, "multiplier": 0.5, "color": [1, 0.5, 0]}
    b.root["nodes"].append({"name": "lamp", "extensions": {"EXT_lights_ies": of}})
    b.root["nodes"].append({"name": "lost", "extensions": {"EXT_lights_ies": {"light": 1}}})
    b.root["nodes"].append({"name": "none", "extensions": {"EXT_lights_ies": {"light": 7}}})
    b.root["scenes"] = [{"nodes": [0, 1, 2, 3]}]
    b.root["extensions"] = {"EXT_lights_ies": {"lights": [{"uri": "spot%20lamp.ies"}, {"uri": "gone.ies"}]}}
    b.root["extensionsRequired"] = ["EXT_lights_ies"]
    model = read(b, tmp_path)
    lamp, lost, none = (node.light for node in model.nodes[1:])
    assert lamp is not None
    assert lost is not None
    assert none is None
    assert (lamp.type, lamp.intensity, lamp.color, lamp.profile) == ("point", 100.0, (1.0, 0.5, 0.0), "spot lamp.ies")
    assert (lost.intensity, lost.profile) == (1.0, "")
    assert {f.code for f in model.findings} == {"gltf.light", "gltf.index"}
    assert ("spot%20lamp.ies", (tmp_path / "spot lamp.ies").resolve()) in dependencies(tmp_path / "t.glb", SETTINGS)
    result = convert(next(tmp_path.glob("*.gl*")), tmp_path / "out", ImportSettings())
    scene = read_scene(result.scene or tmp_path)
    assert scene.nodes[1].light is not None
    file = tmp_path / "out" / scene.nodes[1].light.profile
    assert file.read_text("utf-8") == IES
    assert file in result.outputs
