"""Ogre poses all the way: a .mesh.xml with a pose animation, converted, opened and played, has the posed vertices."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.app.posed import posed_positions
from engine.app.runtime import Runtime
from importers.convert import convert
from importers.settings import ImportSettings
from tests.support.ogre_builder import MORPH_XML


def test_a_pose_animation_moves_the_vertices_as_it_says(tmp_path: Path, null_device) -> None:
    source = tmp_path / "face.mesh.xml"
    source.write_text(MORPH_XML)
    scene = convert(source, tmp_path / "out", ImportSettings()).scene
    assert scene is not None
    runtime = Runtime(null_device)
    runtime.open(scene)
    runtime.play("talk", mode="once")
    assert [c.name for c in runtime.clips] == ["talk"]
    assert runtime.scene.morphs.names == [("up", "side", "talk_1", "talk_2")]
    still = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], *[[x, y, 1] for y in (0, 1) for x in (0, 1)]], float)
    up = np.array([[0, 0, 0], [0, 2, 0], [0, 1, 0], *[[0, 0, 0]] * 4], float)
    side = np.array([[-1, 0, 0], *[[0, 0, 0]] * 6], float)
    for time in (0.0, 0.4, 1.0, 1.5, 2.0):
        runtime.update(time)
        level, aside = (np.interp(time, [0, 1, 2], values) for values in ([0.5, 1, 0], [0, 0.25, 0]))
        expected = still + level * up + aside * side
        expected[3:, 2] = np.interp(time, [0, 0.5, 2], [1, 3, 2])
        found = posed_positions(runtime.scene, runtime.residency, 0)
        apart = np.linalg.norm(found[:, None] - expected[None], axis=2)  # vertices may have been put in another order
        assert len(found) == len(expected)
        assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-6, time
    runtime.close()
