"""Posed FBX geometry against the OBJ files that the authoring tools wrote (`python -m tests.fbx_truth` prints it)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.animation.pose import pose_meshes, pose_nodes
from importers.fbx.reader import load
from importers.settings import ImportSettings
from tests.fbx_truth import find_truths, measure, read_vertices


def test_every_truth_is_met(shared_assets: Path) -> None:
    outcomes = list(measure(shared_assets))
    assert len(outcomes) >= 100, "the truth files are not where they were"
    bad = [f"{o.truth.fbx.name} {o.truth.obj.name}: {o.note or o.error}" for o in outcomes if not o.ok]
    assert not bad, "\n".join(bad)


def test_every_axis_convention_gives_the_same_scene(shared_assets: Path) -> None:
    files = sorted((shared_assets / "fbx_ufbx" / "blender_axes").glob("*.fbx"))
    if not files:
        pytest.skip("no blender_axes")
    first = None
    for file in files:
        model = load(file, ImportSettings())
        parts = list(pose_meshes(model.nodes, model.meshes, pose_nodes(model.nodes)))
        points = np.unique(np.concatenate([p.positions for p in parts]).round(3), axis=0)
        first = points if first is None else first
        np.testing.assert_allclose(points, first, atol=1e-3, err_msg=file.name)


def test_truths_are_paired_by_name(tmp_path: Path) -> None:
    names = ["a_7400_binary.fbx", "a.obj", "a_12.obj", "a_walk_3.obj", "a_lefthanded_3.obj", "a_b_6100_ascii.fbx",
             "a_b.obj", "a_b_1.obj", "a_other.obj", "a_0_obj.obj"]  # fmt: skip
    for name in names:
        (tmp_path / name).write_text("v 0 0 0\n", encoding="utf-8")
    found = {(t.fbx.name, t.obj.name, t.clip, t.frame) for t in find_truths(tmp_path)}
    assert found == {
        ("a_7400_binary.fbx", "a.obj", "", None), ("a_7400_binary.fbx", "a_12.obj", "", 12),
        ("a_7400_binary.fbx", "a_walk_3.obj", "walk", 3), ("a_b_6100_ascii.fbx", "a_b.obj", "", None),
        ("a_b_6100_ascii.fbx", "a_b_1.obj", "", 1),
    }  # fmt: skip


def test_unused_vertices_do_not_count() -> None:
    text = "v 0 0 0\nv 1 0 0\nv 9 9 9\nv 0 1 0\nf 1/1/1 2/2/2 -1\n"
    np.testing.assert_array_equal(read_vertices(text), [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
