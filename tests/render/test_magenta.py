"""What never compiled is magenta, unlit, in every path and queue, and says why; its neighbours are as they were."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.app.framing import frame_bounds
from engine.app.headless import render_image
from engine.app.runtime import Runtime
from engine.assets.material import MaterialAsset
from engine.assets.primitives import cube
from engine.assets.scene import EnvironmentAsset, LightAsset, SceneAsset
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View

PATHS = ("forward", "deferred", "tiled-deferred", "forward-plus")
MAGENTA = (255, 0, 255)
EFFECT = 'name = "bad"\nextends = "surface"\n'


def picture(device: Device, folder: Path, effect: str, path: str, queue: str) -> tuple[Runtime, np.ndarray]:
    """Two cubes, the left one of `effect`, lit by a sun and a lamp."""
    runtime = Runtime(device, profile=False)
    look = EnvironmentAsset("uniform", color=(0.2, 0.4, 0.3), background="color", sun_illuminance=2.0)
    runtime.load(SceneAsset("magenta", environment=look), folder, shaders=(folder,))
    mesh = runtime.residency.add_meshes([cube()])[0]
    for i, name in enumerate((effect, "surface")):
        material = runtime.residency.add_material(
            MaterialAsset(name, effect=name, queue=queue if i == 0 else "opaque"), folder
        )
        node = runtime.scene.nodes.add(f"cube {i}", -1, (1.5 * i, 0.0, 0.0))
        runtime.add_instances([(node, mesh, 0, material)])
    lamp = runtime.scene.nodes.add("lamp", -1, (0.7, 1.2, 1.4))
    runtime.scene.lights.add(lamp, LightAsset("point", intensity=40.0))
    runtime.update()
    camera = frame_bounds(np.full(3, -0.5), np.array([2.0, 0.5, 0.5]), 4 / 3)
    view = View(camera, 64, 48, RenderSettings(samples=1, path=path, tone_map="none", shadows=False))
    return runtime, np.array(render_image(runtime, view)[0])[..., :3]


def magenta(image: np.ndarray) -> np.ndarray:
    found: np.ndarray = (image == MAGENTA).all(axis=-1)
    return found


@pytest.mark.parametrize(
    ("path", "queue"),
    [*((path, "opaque") for path in PATHS), ("deferred", "alpha_test"), ("forward-plus", "transparent")],
)
def test_in_every_path(gl_device: Device, tmp_path: Path, path: str, queue: str) -> None:
    _effect(tmp_path, EFFECT + _techniques("fragment", "effects/bad.frag"))
    (tmp_path / "effects/bad.frag").write_text("void main() { nothing; }\n", encoding="utf-8")
    good, sound = picture(gl_device, tmp_path, "surface", path, queue)
    good.close()
    runtime, seen = picture(gl_device, tmp_path, "bad", path, queue)
    try:
        assert runtime.renderer.path.path == path
        left, right = seen[:, :28], seen[:, 36:]
        drawn = (sound[:, :28] != sound[0, 0]).any(axis=-1)
        assert drawn.sum() > 150
        assert magenta(left)[drawn].mean() > 0.99, "all of it, and no light on it"
        assert not magenta(right).any()
        np.testing.assert_array_equal(right, sound[:, 36:])
        states = runtime.hot_reload.standing()
        assert {state for state, _ in states} == {"magenta"}
        assert states[0][1].where.file.endswith("bad.frag")
        assert states[0][1].where.line == 1
        assert "nothing" in str(states[0][1])
    finally:
        runtime.close()


def test_a_bad_vertex_shader_too(gl_device: Device, tmp_path: Path) -> None:
    _effect(tmp_path, EFFECT + _techniques("vertex", "effects/bad.vert"))
    (tmp_path / "effects/bad.vert").write_text("void main() { gl_Position = nowhere; }\n", encoding="utf-8")
    runtime, seen = picture(gl_device, tmp_path, "bad", "forward", "opaque")
    try:
        assert magenta(seen[:, :28]).sum() > 150
        assert any(error.where.file.endswith("bad.vert") for _, error in runtime.hot_reload.standing())
    finally:
        runtime.close()


def test_one_that_is_no_surface_at_all(gl_device: Device, tmp_path: Path) -> None:
    """Nothing can stand in for its vertex shader: it is left out, and told of."""
    (tmp_path / "effects").mkdir()
    text = 'name = "bad"\n[technique.forward]\nvertex = "effects/bad.vert"\nfragment = "effects/bad.vert"\n'
    (tmp_path / "effects/bad.effect.toml").write_text(text, encoding="utf-8")
    (tmp_path / "effects/bad.vert").write_text("void main() { nowhere; }\n", encoding="utf-8")
    runtime, _ = picture(gl_device, tmp_path, "bad", "forward", "opaque")
    try:
        assert any(error.where.file.endswith("bad.vert") for _, error in runtime.hot_reload.standing())
    finally:
        runtime.close()


def _effect(folder: Path, text: str) -> None:
    (folder / "effects").mkdir()
    (folder / "effects/bad.effect.toml").write_text(text, encoding="utf-8")


def _techniques(stage: str, file: str) -> str:
    return "".join(f'[technique.{role}]\n{stage} = "{file}"\n' for role in ("forward", "gbuffer"))
