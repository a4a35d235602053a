"""Skinned Ogre characters, imported, sampled and skinned, against float64 straight from their files."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.app.runtime import Runtime
from tests.skinned_table import ogre_row


@pytest.mark.parametrize("name", ["ogre/models/robot.mesh", "ogre/models/fish.mesh", "ogre_xml/fish.mesh.xml"])
def test_every_vertex_is_where_the_file_says(name: str, shared_assets: Path, tmp_path: Path, null_device) -> None:
    if not (shared_assets / name).is_file():
        pytest.skip(f"no {name}")
    runtime = Runtime(null_device)
    try:
        row = ogre_row(runtime, shared_assets / name, tmp_path / "out")
    finally:
        runtime.close()
    assert row.poses > 1
    assert row.vertices > 100
    assert row.ok, row
