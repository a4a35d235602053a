"""Ogre meshes: chunks, vertex declarations, operations, morphs; binary against XML; what is wrong is told."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.core.errors import FormatError, InputError
from engine.core.findings import Findings, Severity
from importers.model import ImportedModel
from importers.ogre.data import OgreMesh
from importers.ogre.mesh_binary import read_mesh
from importers.ogre.mesh_xml import read_mesh_xml
from importers.ogre.morphs import Morphs
from importers.ogre.reader import load
from importers.ogre.vertices import Buffer, Element, decode
from importers.registry import find_importer
from importers.settings import ImportSettings
from tests.support.ogre_builder import MORPH_XML, SQUARE, SQUARE_INDICES, SQUARE_UV, OgreBytes

SETTINGS = ImportSettings()
LITTLE = OgreBytes()


def parse(data: bytes) -> OgreMesh:
    return read_mesh(data, "t.mesh", Findings("t.mesh"))


def model_of(data: bytes, folder: Path) -> ImportedModel:
    path = folder / "t.mesh"
    path.write_bytes(data)
    return load(path, SETTINGS)


def codes(model: ImportedModel) -> set[str]:
    return {f.code for f in model.findings if f.severity is not Severity.INFO}


@pytest.mark.parametrize("order", ["<", ">"])
def test_square_of_either_endianness(order: str, tmp_path: Path) -> None:
    mesh = parse(OgreBytes(order).square())
    part = mesh.submeshes[0]
    assert (part.material, part.operation, mesh.version) == ("Test", 4, "1.100")
    assert part.indices.tolist() == SQUARE_INDICES
    assert part.geometry is not None
    np.testing.assert_array_equal(part.geometry.position, np.array(SQUARE, "f4"))
    np.testing.assert_array_equal(part.geometry.uv[0], np.array(SQUARE_UV, "f4"))
    model = model_of(OgreBytes(order).square(), tmp_path)
    assert model.meshes[0].layout == ("position", "normal", "uv0")
    assert model.meshes[0].streams["normal"].tolist() == [[0, 0, 32767, 0]] * 4
    assert find_importer(tmp_path / "t.mesh").name == "Ogre"


@pytest.mark.parametrize(
    ("kind", "raw", "expected"),
    [
        (0, struct.pack("<f", 2.5), [2.5]),
        (3, struct.pack("<4f", 1, 2, 3, 4), [1, 2, 3, 4]),
        (6, struct.pack("<2h", -3, 7), [-3, 7]),
        (8, struct.pack("<4h", 1, -2, 3, -4), [1, -2, 3, -4]),
        (9, bytes([1, 2, 3, 255]), [1, 2, 3, 255]),
        (10, struct.pack("<I", 0x80FF0033), [1, 0, 51 / 255, 128 / 255]),
        (11, struct.pack("<I", 0x803300FF), [1, 0, 51 / 255, 128 / 255]),
        (4, struct.pack("<I", 0x80FF0033), [1, 0, 51 / 255, 128 / 255]),
        (13, struct.pack("<2d", 0.1, -0.2), [0.1, -0.2]),
        (17, struct.pack("<2H", 1, 65535), [1, 65535]),
        (29, struct.pack("<4b", 127, -127, -128, 0), [1, -1, -1, 0]),
        (30, bytes([255, 0, 51, 102]), [1, 0, 0.2, 0.4]),
        (31, struct.pack("<2h", 32767, -32768), [1, -1]),
        (33, struct.pack("<2H", 65535, 0), [1, 0]),
        (35, struct.pack("<I", 511 | (0x201 << 10) | (0 << 20) | (1 << 30)), [1, -1, 0, 1]),
        (37, struct.pack("<2e", 0.5, -2), [0.5, -2]),
    ],
)
def test_element_types(kind: int, raw: bytes, expected: list[float]) -> None:
    data = b"\xaa\xbb" + raw + b"\xcc\xdd" + raw + b"\xcc"
    element = Element(0, kind, 5, 2, 0)
    values = decode(element, Buffer(data, len(raw) + 2, "<"), 2)
    np.testing.assert_allclose(values, [expected, expected], atol=1e-6)


def test_several_buffers_and_sources() -> None:
    b = LITTLE
    position = b"".join(b.pack("3f", *p) for p in SQUARE)
    rest = b"".join(b.pack("3f", 0, 0, 1) + b.pack("2f", *uv) for uv in SQUARE_UV)
    geometry = b.geometry(4, [([(2, 1, 0)], position), ([(2, 4, 0), (1, 7, 0)], rest)])
    found = parse(b.mesh(b.submesh("m", SQUARE_INDICES, geometry))).submeshes[0].geometry
    assert found is not None
    assert found.normal is not None
    np.testing.assert_array_equal(found.position, np.array(SQUARE, "f4"))
    np.testing.assert_array_equal(found.normal, [[0, 0, 1]] * 4)
    np.testing.assert_array_equal(found.uv[0], np.array(SQUARE_UV, "f4"))


@pytest.mark.parametrize(
    ("operation", "indices", "expected", "topology"),
    [
        (1, [0, 2], [0, 2], "points"),
        (2, [0, 1, 2, 3], [0, 1, 2, 3], "lines"),
        (3, [0, 1, 2], [0, 1, 1, 2], "lines"),
        (5, [0, 1, 3, 2], [0, 1, 3, 1, 2, 3], "triangles"),
        (6, [0, 1, 2, 3], [1, 2, 0, 2, 3, 0], "triangles"),
        (4, [], [0, 1, 2], "triangles"),
    ],
)
def test_operations(operation: int, indices: list[int], expected: list[int], topology: str, tmp_path: Path) -> None:
    data = LITTLE.mesh(LITTLE.submesh("m", indices, LITTLE.square_geometry(), operation, wide=True))
    mesh = model_of(data, tmp_path).meshes[0]
    assert mesh.submeshes[0].topology == topology
    assert mesh.indices.tolist() == expected


def test_submeshes_share_geometry(tmp_path: Path) -> None:
    b = LITTLE
    data = b.mesh(
        b.square_geometry(), b.submesh("a", [0, 1, 2]), b.submesh("b", [0, 2, 3]),
        b.submesh("c", SQUARE_INDICES, b.square_geometry()),
    )  # fmt: skip
    model = model_of(data, tmp_path)
    mesh = model.meshes[0]
    assert mesh.vertex_count == 8
    assert mesh.indices.tolist() == [0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7]
    assert [part.material_slot for part in mesh.submeshes] == [0, 1, 2]
    assert [model.materials[i].asset.name for i in model.slots[0]] == ["a", "b", "c"]


def test_without_normals_flat_ones_are_made(tmp_path: Path) -> None:
    mesh = model_of(LITTLE.mesh(LITTLE.submesh("m", SQUARE_INDICES, LITTLE.square_geometry(False))), tmp_path).meshes[0]
    assert mesh.streams["normal"].tolist() == [[0, 0, 32767, 0]] * 4


def test_old_versions_with_fixed_columns() -> None:
    b = LITTLE
    geometry = b.chunk(
        0x5000, b.pack("I", 3), b.pack("9f", 0, 0, 0, 1, 0, 0, 0, 1, 0), b.chunk(0x5100, b.pack("9f", *[0, 0, 1] * 3)),
        b.chunk(0x5300, b.pack("H", 2), b.pack("6f", 0, 0, 1, 0, 0, 1)),
    )  # fmt: skip
    for version, v in (("1.20", [0, 0, 1]), ("1.10", [1, 1, 0])):
        mesh = parse(b.mesh(b.submesh("m", [0, 1, 2], geometry), version=f"MeshSerializer_v{version}"))
        found = mesh.submeshes[0].geometry
        assert found is not None
        assert found.uv[0][:, 1].tolist() == v
        assert found.normal is not None


def test_levels_of_detail_and_edges_are_skipped_with_a_finding(tmp_path: Path) -> None:
    b = LITTLE
    body = b.submesh("m", SQUARE_INDICES, b.square_geometry())
    model = model_of(
        b.mesh(body, b.chunk(0x8000, b"\1\2"), b.chunk(0xB000, b"x" * 9), b.chunk(0x9000, bytes(28))), tmp_path
    )
    said = [f.message for f in model.findings if f.code == "ogre.left-out"]
    assert said == ["edge lists are not imported", "levels of detail are not imported"]


def _cut(data: bytes) -> bytes:
    return data[:-40]


def _count(offset_of: bytes, value: int) -> Any:
    def change(data: bytes) -> bytes:
        at = data.index(offset_of) + len(offset_of)
        return data[:at] + struct.pack("<I", value) + data[at + 4 :]

    return change


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (_cut, "are left"),
        (lambda d: d[:22], "does not end"),
        (lambda d: b"\x00\x10[MeshSerializer_v9.9]\n" + d[26:], "not known"),
        (lambda d: b"junk" + d, "does not begin"),
        (lambda d: d[:1], "1 bytes"),
        (_count(b"Test\n\0", 0x7FFFFFFF), "2,147,483,647"),
    ],
)
def test_broken_files_say_where(change: Any, says: str) -> None:
    with pytest.raises(FormatError) as caught:
        parse(change(LITTLE.square()))
    assert says in str(caught.value)
    assert "byte" in caught.value.where.path


def test_declaration_that_does_not_fit_the_buffer() -> None:
    b = LITTLE
    good = b.square_geometry()
    at = good.index(b.pack("HIHH", 0x5200, 6 + 4 + 6 + 4 * 32, 0, 32)) + 8
    bad = good[:at] + b.pack("H", 28) + good[at + 2 :]
    with pytest.raises(FormatError, match=r"28 bytes a vertex, its declaration 32 \(to the end of texture"):
        parse(b.mesh(b.submesh("m", SQUARE_INDICES, bad)))


def test_indices_and_positions_that_make_no_sense_are_left_out(tmp_path: Path) -> None:
    model = model_of(LITTLE.mesh(LITTLE.submesh("m", [0, 1, 2, 0, 2, 9], LITTLE.square_geometry())), tmp_path)
    assert model.meshes[0].indices.tolist() == [0, 1, 2]
    assert "ogre.index-range" in codes(model)
    pattern = LITTLE.pack("6f", *SQUARE[3], 0, 0, 1)
    broken = LITTLE.square_geometry().replace(pattern, LITTLE.pack("6f", 0, float("nan"), 0, 0, 0, 1))
    model = model_of(LITTLE.mesh(LITTLE.submesh("m", SQUARE_INDICES, broken)), tmp_path)
    assert model.meshes[0].indices.tolist() == [0, 1, 2]
    assert "ogre.not-finite" in codes(model)


@pytest.mark.parametrize("mirrored", [False, True])
def test_given_tangents_get_the_handedness_of_the_uv(mirrored: bool, tmp_path: Path) -> None:
    b = LITTLE
    raw = b""
    for p, (u, v) in zip(SQUARE, SQUARE_UV, strict=True):
        along = (-1.0 if mirrored else 1.0, 0.0, 0.0)
        raw += b.pack("3f", *p) + b.pack("3f", 0, 0, 1) + b.pack("3f", *along)
        raw += b.pack("2f", 1 - u if mirrored else u, v)
    geometry = b.geometry(4, [([(2, 1, 0), (2, 4, 0), (2, 9, 0), (1, 7, 0)], raw)])
    unit = "texture n.png\n rtshader_system { normal_map tangent_space }"
    (tmp_path / "m.material").write_text(f"material m {{ technique {{ pass {{ texture_unit {{ {unit} }} }} }} }}")
    mesh = model_of(b.mesh(b.submesh("m", SQUARE_INDICES, geometry)), tmp_path).meshes[0]
    # bitangent = w * cross(n, t) must follow shrinking v, which is +Y here
    sign = -1 if mirrored else 1
    assert mesh.streams["tangent"].tolist() == [[32767 * sign, 0, 0, 32767 * sign]] * 4


def test_poses_and_morphs_become_targets_and_weights(tmp_path: Path) -> None:
    path = tmp_path / "m.mesh.xml"
    path.write_text(MORPH_XML)
    model = load(path, SETTINGS)
    assert model.name == "m"
    mesh = model.meshes[0]
    assert [t.name for t in mesh.morphs] == ["up", "side", "talk_1", "talk_2"]
    assert mesh.morphs[0].streams["position"].tolist() == [[0, 0, 0], [0, 2, 0], [0, 1, 0], *[[0, 0, 0]] * 4]
    assert mesh.morphs[2].streams["position"][3:].tolist() == [[0, 0, 2]] * 4
    assert model.nodes[0].weights == [0.0] * 4
    (channel,) = model.clips[0].channels
    assert (model.clips[0].duration, channel.path, channel.node) == (2.0, "weights", 0)
    for time in (0.0, 0.25, 0.5, 1.0, 1.3, 2.0):
        weights = [np.interp(time, channel.times, channel.values[:, k]) for k in range(4)]
        heights = np.asarray(mesh.streams["position"])[3, 2] + sum(
            w * t.streams["position"][3, 2] for w, t in zip(weights, mesh.morphs, strict=True)
        )
        assert heights == pytest.approx(np.interp(time, [0, 0.5, 2], [1, 3, 2]), abs=1e-6)
        assert weights[0] == pytest.approx(np.interp(time, [0, 1, 2], [0.5, 1, 0]), abs=1e-6)
        assert weights[1] == pytest.approx(np.interp(time, [0, 1, 2], [0, 0.25, 0]), abs=1e-6)


def test_memory_limits(tmp_path: Path) -> None:
    path = tmp_path / "m.mesh.xml"
    path.write_text(MORPH_XML)
    with pytest.raises(InputError, match="the limit is 7"):
        load(path, SETTINGS.replace(max_decoded_bytes=60))
    findings = Findings()
    morphs = Morphs(read_mesh_xml(MORPH_XML.encode(), "m", findings), findings, 60)
    assert [target.name for target in morphs.targets] == ["up"]
    assert {f.code for f in findings} >= {"ogre.morph-limit"}


def test_xml_says_the_line() -> None:
    for text, says in [
        (MORPH_XML.replace('vertexcount="3"', 'vertexcount="5"'), "vertexcount says 5"),
        (MORPH_XML.replace('v2="1"', 'v2="x"', 1), "whole number"),
        (MORPH_XML.replace('<position x="0"', "<position", 1), "lacks the attribute 'x'"),
        (MORPH_XML[:900], "not valid XML"),
        ('<!DOCTYPE mesh [<!ENTITY a "b">]>' + MORPH_XML, "entities"),
        ("<mesh>" * 100, "deep"),
    ]:
        with pytest.raises(FormatError, match=says) as caught:
            read_mesh_xml(text.encode(), "t.mesh.xml", Findings())
        assert caught.value.where.line


def test_units_are_told(tmp_path: Path) -> None:
    model = model_of(LITTLE.square(), tmp_path)
    (said,) = [f for f in model.findings if f.code == "ogre.units"]
    assert "1 x 1 x 0 m" in said.message
