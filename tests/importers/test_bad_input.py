"""Every kind of bad input: the message names file and place, the exit code is right, nothing is half-written."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from engine.core.errors import LucarnaError
from importers.cli.main import main
from importers.convert import convert
from importers.gltf.reader import load
from importers.settings import ImportSettings
from tests.bad_input import CASES, Case, mutants, run
from tests.support.gltf_builder import textured_triangle


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_bad_input(case: Case, tmp_path: Path) -> None:
    outcome = run(case, tmp_path)
    assert outcome.code == case.code, outcome.text
    assert case.place in outcome.line, outcome.text
    assert "Traceback" not in outcome.text
    left = [name for name in outcome.files if name != "secret.bin"]
    assert not [name for name in left if ".tmp" in name]
    if case.writes:
        assert "out/bad.scene.json" in left
    else:
        assert not left


def test_missing_texture_still_writes_the_rest(tmp_path: Path) -> None:
    builder = textured_triangle()
    builder.root["images"][0] = {"uri": "gone.png"}
    result = convert(builder.write_gltf(tmp_path / "a.gltf"), tmp_path / "out", ImportSettings())
    material = (tmp_path / "out" / "a.paint.material.toml").read_text()
    assert 'path = ""' in material
    assert [p.suffix for p in result.outputs].count(".dds") == 1
    assert result.findings.has_errors


def test_truncated_at_every_length(tmp_path: Path) -> None:
    data = textured_triangle().glb()
    path = tmp_path / "cut.glb"
    for length in range(0, len(data), 7):
        path.write_bytes(data[:length])
        try:
            noticed = "".join(map(str, load(path, ImportSettings()).findings))
        except LucarnaError as error:
            noticed = str(error)
        assert "cut.glb" in noticed, f"cut to {length} bytes and nothing noticed"


def test_mutants_raise_only_our_errors(tmp_path: Path) -> None:
    path = tmp_path / "mutant.glb"
    survivors = 0
    for number, data in enumerate(mutants(300)):
        path.write_bytes(data)
        out = tmp_path / f"out{number}"
        try:
            convert(path, out, ImportSettings(jobs=1))
            survivors += 1
            continue
        except LucarnaError as error:
            message = str(error)
        assert "mutant.glb" in message
        assert not out.exists()
    # Both must happen, or the mutants are too tame or too wild to say anything
    assert 20 < survivors < 290


def test_output_folder_untouched_when_a_target_is_blocked(tmp_path: Path) -> None:
    source = textured_triangle().write_gltf(tmp_path / "a.gltf")
    out = tmp_path / "out"
    (out / "a.scene.json").mkdir(parents=True)
    (out / "a.lmesh").write_text("old")
    with pytest.raises(LucarnaError, match="name of an output file"):
        convert(source, out, ImportSettings())
    assert (out / "a.lmesh").read_text() == "old"
    assert sorted(p.name for p in out.iterdir()) == ["a.lmesh", "a.scene.json"]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.gltf", "out"]


def test_names_that_are_no_text(tmp_path: Path) -> None:
    """A file name that is no UTF-8, and half a surrogate pair in every name of the JSON."""
    builder = textured_triangle()
    builder.root["materials"][0]["name"] = builder.root["meshes"][0]["name"] = builder.root["nodes"][0]["name"] = (
        "\ud800"
    )
    builder.root["images"][0] = {"uri": "\udfff.png"}
    builder.root["materials"][0]["extensions"] = {"KHR_materials_sheen": {"\ud800": "\udc00", "big": 10**40}}
    path = tmp_path / os.fsdecode(b"\xff.glb")
    try:
        path.write_bytes(builder.glb())
    except OSError:
        pytest.skip("the file system takes text names only")
    result = convert(path, tmp_path / "out", ImportSettings())
    assert result.scene is not None
    assert result.scene.is_file()
    assert main(["convert", str(path), "--out", str(tmp_path / "out2")]) == 1


def test_signalling_nan_is_no_warning(tmp_path: Path) -> None:
    builder = textured_triangle()
    for view in range(3):
        at = builder.root["bufferViews"][view]["byteOffset"]
        builder.binary[at : at + 4] = bytes([1, 0, 0xA0, 0x7F])
    assert load(builder.write_glb(tmp_path / "a.glb"), ImportSettings()).findings.has_errors
