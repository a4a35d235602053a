"""`lucarna check`: topology, budgets, JSON, SARIF."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from importers.checks.topology import edge_faults
from importers.cli.main import main
from tests.support.gltf_builder import GltfBuilder, png, textured_triangle, triangle

Capture = pytest.CaptureFixture[str]


def codes(path: Path, capsys: Capture, *flags: str) -> list[str]:
    main(["check", str(path), "--json", *flags])
    report = json.loads(capsys.readouterr().out)[0]
    return [finding["code"] for finding in report["findings"]]


def soup(triangles: list[list[int]], corners: int = 6) -> GltfBuilder:
    """Triangles between points on a helix, which are never in line; each triangle has vertices of its own."""
    import math

    points = [[math.cos(i), math.sin(i), i * 0.3] for i in range(corners)]
    positions = [points[i] for t in triangles for i in t]
    b = GltfBuilder()
    b.mesh({"attributes": {"POSITION": b.accessor(positions)}})
    return b


@pytest.mark.parametrize(
    ("triangles", "expected"),
    [
        ([[0, 1, 2], [2, 1, 3]], []),
        ([[0, 1, 2], [1, 2, 3]], ["mesh.winding"]),
        ([[0, 1, 2], [2, 1, 3], [2, 1, 4]], ["mesh.non-manifold"]),
        ([[0, 1, 2], [0, 1, 2]], []),
    ],
)
def test_topology_sees_through_seams(
    tmp_path: Path, capsys: Capture, triangles: list[list[int]], expected: list[str]
) -> None:
    found = codes(soup(triangles).write_glb(tmp_path / "a.glb"), capsys)
    assert [code for code in found if code.startswith("mesh.")] == expected


def test_edge_faults_of_a_closed_body() -> None:
    import numpy as np

    tetrahedron = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
    assert edge_faults(tetrahedron) == (0, 0)
    assert edge_faults(tetrahedron[:3]) == (0, 0)  # open is no fault
    assert edge_faults(np.vstack([tetrahedron, [[0, 1, 4]]])) == (1, 0)


def test_budgets_of_the_command_line(tmp_path: Path, capsys: Capture) -> None:
    b = textured_triangle(png(64, 64))
    b.root["nodes"] = [{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0]}]
    b.root["scenes"] = [{"nodes": [0, 1]}]
    source = b.write_glb(tmp_path / "a.glb")
    assert codes(source, capsys, "--budget", "triangles=2,texture-bytes=1e9") == []
    found = codes(source, capsys, "--budget", "triangles=1", "--budget", "texture-size=32,bones=0,nodes=1")
    assert found == ["budget.triangles", "budget.texture-size", "budget.nodes"]
    assert main(["check", str(source), "--budget", "triangles=1"]) == 1
    assert "2 triangles are drawn, the budget is 1" in capsys.readouterr().err
    main(["convert", str(source), "--out", str(tmp_path / "out"), "--quiet"])
    capsys.readouterr()
    assert codes(tmp_path / "out" / "a.scene.json", capsys, "--budget", "triangles=1") == ["budget.triangles"]


@pytest.mark.parametrize("text", ["trangles=1", "triangles", "triangles=-1", "triangles=x"])
def test_budgets_that_make_no_sense(text: str, tmp_path: Path, capsys: Capture) -> None:
    assert main(["check", str(tmp_path), "--budget", text]) == 2
    assert "--budget" in capsys.readouterr().err


def test_budgets_of_the_project(tmp_path: Path, capsys: Capture) -> None:
    source = triangle().write_glb(tmp_path / "a.glb")
    project = tmp_path / "project.toml"
    project.write_text('[project]\nname = "P"\nstart = "a.glb"\n[budgets]\nvertices = 2\n')
    assert codes(source, capsys) == ["budget.vertices"]
    assert codes(source, capsys, "--budget", "vertices=9") == []
    project.write_text('[project]\nname = "P"\nstart = "a.glb"\n[budgets]\nvertexes = 2\n')
    assert main(["check", str(source)]) == 1
    message = capsys.readouterr().err
    assert "project.toml:5:1" in message
    assert "did you mean 'vertices'?" in message


def test_missing_maps_and_strictness(tmp_path: Path, capsys: Capture) -> None:
    b = triangle()
    b.root["nodes"][0]["rotation"] = [0, 0, 0, 2]
    source = b.write_glb(tmp_path / "a.glb")
    assert main(["check", str(source)]) == 0
    assert main(["check", str(source), "--strict"]) == 1
    b = textured_triangle()
    b.root["images"][0] = {"uri": "gone.png"}
    capsys.readouterr()
    found = codes(b.write_gltf(tmp_path / "b.gltf"), capsys)
    assert found == ["gltf.image"]


def test_one_unreadable_file_does_not_hide_the_others(tmp_path: Path, capsys: Capture, monkeypatch: Any) -> None:
    monkeypatch.delenv("LUCARNA_IN_PROCESS")
    (tmp_path / "a.glb").write_bytes(b"nothing")
    triangle().write_glb(tmp_path / "b.glb")
    assert main(["check", str(tmp_path), str(tmp_path / "none.glb"), "--json"]) == 1
    reports = json.loads(capsys.readouterr().out)
    assert [Path(r["path"]).name for r in reports] == ["a.glb", "b.glb", "none.glb"]
    assert [bool(r["error"]) for r in reports] == [True, False, True]


def test_sarif(tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "my models"
    folder.mkdir()
    b = textured_triangle()
    b.root["images"][0] = {"uri": "gone.png"}
    b.write_gltf(folder / "a.gltf")
    (folder / "broken.glb").write_bytes(b"glTF")
    (folder / "bad.material.toml").write_text('schema = "lucarna.material/1"\nnme = "x"\n')
    assert main(["check", str(folder), "--sarif", "out/x.sarif", "--budget", "triangles=0"]) == 1
    log = json.loads((tmp_path / "out" / "x.sarif").read_text())
    assert_sarif(log)
    run = log["runs"][0]
    uris = {r["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] for r in run["results"]}
    assert uris == {"my%20models/a.gltf", "my%20models/broken.glb", "my%20models/bad.material.toml"}
    by_rule = {r["ruleId"]: r for r in run["results"]}
    assert by_rule["budget.triangles"]["level"] == "error"
    assert by_rule["budget.triangles"]["locations"][0]["logicalLocations"] == [{"fullyQualifiedName": "meshes[0]"}]


def assert_sarif(log: dict[str, Any]) -> None:
    """What the standard demands (SARIF 2.1.0, sections 3.13, 3.14, 3.18, 3.19, 3.27 to 3.30, 3.33, 3.49)."""
    assert set(log) == {"$schema", "version", "runs"}
    assert log["version"] == "2.1.0"
    for run in log["runs"]:
        driver = run["tool"]["driver"]
        assert driver["name"]
        assert re.fullmatch(r"\d+\.\d+\.\d+.*", driver["semanticVersion"])
        ids = [rule["id"] for rule in driver["rules"]]
        assert len(set(ids)) == len(ids)
        assert all(rule["shortDescription"]["text"] for rule in driver["rules"])
        assert all(base["uri"].endswith("/") for base in run["originalUriBaseIds"].values())
        assert run["columnKind"] in ("utf16CodeUnits", "unicodeCodePoints")
        for result in run["results"]:
            assert driver["rules"][result["ruleIndex"]]["id"] == result["ruleId"]
            assert result["level"] in ("none", "note", "warning", "error")
            assert result["message"]["text"]
            assert all(isinstance(v, str) for v in result["partialFingerprints"].values())
            for location in result["locations"]:
                physical = location["physicalLocation"]
                artifact = physical["artifactLocation"]
                assert artifact["uriBaseId"] in run["originalUriBaseIds"]
                assert re.fullmatch(r"[A-Za-z0-9._~/%()!$&'*+,;=:@-]+", artifact["uri"])
                region = physical.get("region", {"startLine": 1})
                assert region["startLine"] >= 1
                assert region.get("startColumn", 1) >= 1


def test_a_damaged_picture_by_itself(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "sound.png").write_bytes(png(4, 4))
    (tmp_path / "cut.png").write_bytes(png(64, 64)[:60])
    assert main(["check", str(tmp_path), "--json"]) == 1
    found = {Path(report["path"]).name: report for report in json.loads(capsys.readouterr().out)}
    assert [f["code"] for f in found["cut.png"]["findings"] if f["severity"] == "error"] == ["texture.image"]
    assert all(f["severity"] == "info" for f in found["sound.png"]["findings"])
