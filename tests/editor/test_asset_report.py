"""The asset report of a scene whose numbers are known."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from editor.asset_report import as_text, asset_report, nodes_of
from editor.document import Document
from editor.host import Resolved
from engine.core.findings import Findings, Severity
from engine.gpu.types import TextureDesc
from tests.editor.support.fake_engine import FakeRuntime


@pytest.fixture
def document(tmp_path: Path) -> Document:
    source = tmp_path / "a.glb"
    source.write_bytes(b"x" * 100)
    (tmp_path / "paint.dds").write_bytes(b"y" * 50)
    findings = Findings(str(source))
    findings.warn("fake.odd", "something odd", "nodes[0]")
    runtime: Any = FakeRuntime()
    mesh = runtime.residency.meshes[0].asset
    mesh.streams = {"position": np.zeros((24, 3), np.float32), "normal": np.zeros((24, 4), np.int16)}
    mesh.indices = np.zeros(36, np.uint32)
    for record in runtime.residency.records:
        record.folder = tmp_path
    texture = SimpleNamespace(desc=TextureDesc("rgba8", 4, 2, "2d-array", layers=8, mips=3))
    runtime.residency.materials = SimpleNamespace(slot_texture=lambda material, slot: (texture, 5))
    return Document(Resolved(source, tmp_path / "a.scene.json", None, "", findings), runtime)


def test_sizes_and_memory(document: Document) -> None:
    report = asset_report(document)
    (mesh,) = report.meshes
    assert (mesh.vertices, mesh.triangles, mesh.uses) == (24, 12, 2)
    assert mesh.bytes == 24 * 12 + 24 * 8 + 36 * 4
    (texture,) = report.textures
    assert texture.bytes == 4 * (4 * 2 + 2 * 1 + 1), "one layer with its mips"
    assert (texture.disk, texture.users) == (50, ("paint: base color",))
    assert [(m.name, m.textures, m.parts) for m in report.materials] == [("paint", 1, 1), ("steel", 0, 1)]
    assert {what: amount for what, amount, _doc in report.totals}["Triangles"] == "12, drawn 24"
    assert {what: amount for what, amount, _doc in report.totals}["On disk"] == "150 B"
    assert report.counts == {Severity.WARNING: 1}


def test_a_row_knows_the_nodes_that_show_it(document: Document) -> None:
    assert nodes_of(document, mesh=0) == [1, 2]
    assert nodes_of(document, material=1) == [2]


def test_all_of_it_as_text(document: Document) -> None:
    told = as_text(asset_report(document), "a.glb")
    assert told.startswith("a.glb\nMemory\t")
    assert "box\t24\t12\t2\t624" in told
    assert "paint.dds\trgba8\t4x2\t3\t44\tpaint: base color" in told
    assert told.endswith("nodes[0]: something odd")
