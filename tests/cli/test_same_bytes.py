"""The editor and the command line import the same bytes: a small sample; `python -m tests.same_bytes` does them all."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.same_bytes import compare


@pytest.mark.parametrize(
    "name",
    [
        "gltf/BoxTextured/glTF/BoxTextured.gltf", "gltf/RiggedFigure/glTF-Binary/RiggedFigure.glb",
        "malformed/huge_count.gltf", "malformed/no_newline.mesh",
    ],
)  # fmt: skip
def test_the_same_source_gives_the_same_bytes(name: str, shared_assets: Path, tmp_path: Path) -> None:
    source = shared_assets / name
    if not source.is_file():
        pytest.skip(f"{name} is not among the assets")
    verdict = compare(source, tmp_path)
    assert verdict.equal, verdict.different
    assert verdict.files or verdict.refused


def test_a_byte_more_is_a_difference(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from tests import same_bytes

    one, other = tmp_path / "one", tmp_path / "other"
    one.write_bytes(b"abc")
    other.write_bytes(b"abd")
    monkeypatch.setattr(same_bytes, "_by_editor", lambda source: ({"a": one, "b": one}, ""))
    monkeypatch.setattr(same_bytes, "_by_command", lambda source, out: ({"a": other, "b": one}, 0, ""))
    assert same_bytes.compare(Path("x.glb"), tmp_path).different == ["a"]
