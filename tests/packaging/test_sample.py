"""The shipped sample is sound glTF, closes its loop, and is what its script makes."""

from __future__ import annotations

import importlib
import json
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "project_template" / "assets" / "orrery.glb"
TYPES = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Document:
    """The sample, read without any of the product's own readers."""

    def __init__(self, data: bytes) -> None:
        magic, version, length = struct.unpack_from("<4sII", data)
        assert (magic, version, length) == (b"glTF", 2, len(data))
        size, kind = struct.unpack_from("<I4s", data, 12)
        assert kind == b"JSON"
        self.json: dict[str, Any] = json.loads(data[20 : 20 + size])
        blob_size, kind = struct.unpack_from("<I4s", data, 20 + size)
        assert kind == b"BIN\0"
        self.blob = data[28 + size : 28 + size + blob_size]

    def view(self, index: int) -> bytes:
        view = self.json["bufferViews"][index]
        end = view["byteOffset"] + view["byteLength"]
        assert end <= self.json["buffers"][0]["byteLength"] <= len(self.blob)
        return self.blob[view["byteOffset"] : end]

    def array(self, index: int) -> NDArray[Any]:
        accessor = self.json["accessors"][index]
        values = np.frombuffer(self.view(accessor["bufferView"]), TYPES[accessor["componentType"]])
        return values.reshape(accessor["count"], WIDTHS[accessor["type"]])

    def primitives(self) -> list[tuple[str, dict[str, Any]]]:
        return [(m["name"], p) for m in self.json["meshes"] for p in m["primitives"]]


@pytest.fixture(scope="module")
def sample() -> Document:
    return Document(SAMPLE.read_bytes())


def test_size() -> None:
    assert SAMPLE.stat().st_size <= 3_000_000


def test_bounds_are_true(sample: Document) -> None:
    for index, accessor in enumerate(sample.json["accessors"]):
        values = sample.array(index)
        assert np.isfinite(values).all()
        if "min" in accessor:
            np.testing.assert_array_equal(values.min(0), np.array(accessor["min"], values.dtype))
            np.testing.assert_array_equal(values.max(0), np.array(accessor["max"], values.dtype))


def test_triangles_are_sound(sample: Document) -> None:
    for name, primitive in sample.primitives():
        positions = sample.array(primitive["attributes"]["POSITION"]).astype(np.float64)
        triangles = sample.array(primitive["indices"]).reshape(-1, 3)
        assert triangles.max() < len(positions), name
        a, b, c = (positions[triangles[:, i]] for i in range(3))
        face = np.cross(b - a, c - a)
        assert (np.linalg.norm(face, axis=1) > 1e-13).all(), f"{name} has empty triangles"
        normals = sample.array(primitive["attributes"]["NORMAL"]).astype(np.float64)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-5, err_msg=name)
        # the mean of the corners' normals is on the side from which the triangle is counter-clockwise
        corner_mean = normals[triangles].mean(1)
        agreement = np.sum(face * corner_mean, 1)
        assert (agreement > 0).mean() > 0.999, f"{name}: {np.sum(agreement <= 0)} triangles face the wrong way"


def test_tangents_follow_the_uvs(sample: Document) -> None:
    """Unit, across the normal, and right-handed with the picture's up: B = cross(N, T) w points against growing v."""
    with_tangents = 0
    for name, primitive in sample.primitives():
        if "TANGENT" not in primitive["attributes"]:
            continue
        with_tangents += 1
        arrays = {key: sample.array(index).astype(np.float64) for key, index in primitive["attributes"].items()}
        normals, tangents, w = arrays["NORMAL"], arrays["TANGENT"][:, :3], arrays["TANGENT"][:, 3:]
        np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1, atol=1e-5, err_msg=name)
        assert np.abs(np.sum(normals * tangents, 1)).max() < 1e-4, name
        assert set(np.unique(w)) <= {-1.0, 1.0}
        triangles = sample.array(primitive["indices"]).reshape(-1, 3)
        a, b, c = (arrays["POSITION"][triangles[:, i]] for i in range(3))
        ta, tb, tc = (arrays["TEXCOORD_0"][triangles[:, i]] for i in range(3))
        e1, e2, d1, d2 = b - a, c - a, tb - ta, tc - ta
        det = d1[:, 0] * d2[:, 1] - d2[:, 0] * d1[:, 1]
        usable = np.abs(det) > 1e-10
        with np.errstate(all="ignore"):
            along_v = (e2 * d1[:, :1] - e1 * d2[:, :1]) / det[:, None]
        bitangent = np.cross(normals, tangents) * w
        agreement = np.sum(bitangent[triangles].mean(1) * -along_v, 1)[usable]
        assert (agreement > 0).mean() > 0.98, name
    assert with_tangents >= 5


def test_the_clip_closes(sample: Document) -> None:
    (clip,) = sample.json["animations"]
    assert clip["name"] == "orbit"
    paths = {channel["target"]["path"] for channel in clip["channels"]}
    assert paths == {"rotation", "translation"}
    targets = [(c["target"]["node"], c["target"]["path"]) for c in clip["channels"]]
    assert len(set(targets)) == len(targets) >= 15
    for channel in clip["channels"]:
        sampler = clip["samplers"][channel["sampler"]]
        times = sample.array(sampler["input"])[:, 0]
        values = sample.array(sampler["output"])
        assert times[0] == 0.0
        assert times[-1] == 12.0
        assert (np.diff(times) > 0).all()
        assert len(values) == len(times)
        if channel["target"]["path"] == "translation":
            np.testing.assert_array_equal(values[0], values[-1])
            continue
        np.testing.assert_allclose(np.linalg.norm(values, axis=1), 1, atol=1e-6)
        dots = np.sum(values[1:] * values[:-1], axis=1)
        assert (dots > 0.5).all(), (
            "the shorter way between keys is the meant one, for readers that check and that do not"
        )
        assert abs(values[0] @ values[-1]) == pytest.approx(1, abs=1e-6)


def test_the_rest_pose_is_the_first_key(sample: Document) -> None:
    (clip,) = sample.json["animations"]
    for channel in clip["channels"]:
        node = sample.json["nodes"][channel["target"]["node"]]
        first = sample.array(clip["samplers"][channel["sampler"]]["output"])[0]
        rest = node.get(channel["target"]["path"], [0, 0, 0, 1])
        np.testing.assert_allclose(first, rest, atol=1e-6)


def test_it_shows_what_the_engine_can(sample: Document) -> None:
    materials = sample.json["materials"]
    assert {m.get("alphaMode", "OPAQUE") for m in materials} == {"OPAQUE", "MASK", "BLEND"}
    assert any(m.get("doubleSided") for m in materials)
    assert any("normalTexture" in m for m in materials)
    assert any(m.get("occlusionTexture", {}).get("texCoord") == 1 for m in materials)
    assert any("KHR_materials_emissive_strength" in m.get("extensions", {}) for m in materials)
    assert any("COLOR_0" in p["attributes"] for _, p in sample.primitives())
    assert {c["name"] for c in sample.json["cameras"]} >= {"main", "close"}
    (light,) = sample.json["extensions"]["KHR_lights_punctual"]["lights"]
    assert light["type"] == "point"
    assert set(sample.json["extensionsUsed"]) == {"KHR_lights_punctual", "KHR_materials_emissive_strength"}


def test_names_are_there_and_unique(sample: Document) -> None:
    for kind in ("nodes", "meshes", "materials", "images"):
        names = [item["name"] for item in sample.json[kind]]
        assert all(names)
        assert len(set(names)) == len(names), kind
    used = {p["material"] for _, p in sample.primitives()}
    assert used == set(range(len(sample.json["materials"]))), "no material is left over"


def test_gears_mesh(sample: Document) -> None:
    """Pinions turn three times as often as the wheel, the other way, and show it a gap where it has a tooth."""
    (clip,) = sample.json["animations"]
    names = [node["name"] for node in sample.json["nodes"]]
    keys = {}
    for channel in clip["channels"]:
        keys[names[channel["target"]["node"]]] = sample.array(clip["samplers"][channel["sampler"]]["output"])
    # y of the quaternion, unwrapped: half the angle walked
    walked = {}
    for name in ("wheel", "pinion 1", "pinion 2"):
        quaternions = keys[name]
        steps = 2 * np.arctan2(
            quaternions[1:, 1] * quaternions[:-1, 3] - quaternions[1:, 3] * quaternions[:-1, 1],
            np.sum(quaternions[1:] * quaternions[:-1], axis=1),
        )
        walked[name] = steps.sum()
    assert walked["pinion 1"] == pytest.approx(-3 * walked["wheel"], rel=1e-5)
    assert walked["pinion 2"] == pytest.approx(-3 * walked["wheel"], rel=1e-5)
    teeth, pinion_teeth = 36, 12
    for name in ("pinion 1", "pinion 2"):
        node = sample.json["nodes"][names.index(name)]
        x, _, z = node["translation"]
        towards = np.arctan2(x, z)  # seen from the wheel
        rest = 2 * np.arctan2(node["rotation"][1], node["rotation"][3])
        wheel_phase = towards / (2 * np.pi / teeth) % 1  # 0: a tooth points at the pinion
        pinion_phase = (towards + np.pi - rest) / (2 * np.pi / pinion_teeth) % 1
        # mirrored at the contact, teeth and gaps must alternate: the phases sum to a half
        assert (wheel_phase + pinion_phase) % 1 == pytest.approx(0.5, abs=1e-4)


#: what paints, and how many images each makes; painting takes ten seconds and is not what is compared
PAINTERS = {
    "brushed": 2, "marble": 1, "walnut": 2, "stone_floor": 3, "floor_occlusion": 1, "clay": 3, "porcelain": 1,
    "hammered": 2, "sun_surface": 1, "filigree": 1, "planet_ring": 1, "engraved_scale": 3,
}  # fmt: skip


def test_the_script_makes_this_file(monkeypatch: pytest.MonkeyPatch) -> None:
    """Structure and geometry are the script's; images depend on the codecs' versions and are left out."""
    monkeypatch.syspath_prepend(str(ROOT / "packaging"))
    names = (
        "make_sample", "sample_materials", "sample_planets", "sample_workshop", "sample_textures", "sample_shapes",
        "sample_glb",
    )  # fmt: skip
    for name in names:
        monkeypatch.delitem(sys.modules, name, raising=False)
    make_sample = importlib.import_module("make_sample")
    textures = importlib.import_module("sample_textures")
    blank = np.zeros((4, 4, 3), np.uint8)
    for painter, count in PAINTERS.items():
        result = blank if count == 1 else (blank,) * count
        monkeypatch.setattr(textures, painter, lambda *_, result=result: result)
    made, shipped = Document(make_sample.make()), Document(SAMPLE.read_bytes())
    for name in names:
        monkeypatch.delitem(sys.modules, name, raising=False)
    for kind in ("nodes", "meshes", "materials", "textures", "cameras", "animations", "scenes"):
        assert made.json[kind] == shipped.json[kind], f"run packaging/make_sample.py ({kind} differ)"
    for _, primitive in shipped.primitives():
        for index in (*primitive["attributes"].values(), primitive["indices"]):
            np.testing.assert_allclose(made.array(index), shipped.array(index), atol=1e-5)
