"""Skinned Ogre characters, imported, sampled and skinned, against float64 straight from their files."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.app.runtime import Runtime
from tests.skinned_table import ogre_row


@pytest.mark.parametrize(
    ("name", "coded"),
    [
        ("ogre/models/robot.mesh", False),
        ("ogre/models/robot.mesh", True),
        ("ogre/models/fish.mesh", True),
        ("ogre_xml/fish.mesh.xml", False),
    ],
)
def test_every_vertex_is_where_the_file_says(
    name: str, coded: bool, shared_assets: Path, tmp_path: Path, null_device
) -> None:
    if not (shared_assets / name).is_file():
        pytest.skip(f"no {name}")
    runtime = Runtime(null_device)
    try:
        row = ogre_row(runtime, shared_assets / name, tmp_path / "out", coded=coded)
    finally:
        runtime.close()
    assert row.poses > 1
    assert row.vertices > 100
    assert row.ok, row
