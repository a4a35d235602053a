"""Programs in slices: the last picture stays, each frame does a little, the end is what waiting would have given."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.app.framing import frame_bounds
from engine.app.runtime import Runtime
from engine.assets.material import MaterialAsset
from engine.assets.primitives import card, cube, plane
from engine.assets.scene import EnvironmentAsset, SceneAsset
from engine.gpu.types import Device
from engine.render.frame import Frame
from engine.render.settings import RenderSettings
from engine.render.view import View

FEATURES: tuple[list[str], ...] = ([], ["double_sided"], ["unlit"], ["double_sided", "unlit"])


def opened(device: Device, *, shaders: tuple[Path, ...] = ()) -> Runtime:
    """Eight variants, and a sun that casts shadows."""
    runtime = Runtime(device, profile=False)
    look = EnvironmentAsset("uniform", color=(0.4, 0.5, 0.6), sun_illuminance=3.0)
    runtime.load(SceneAsset("ahead", environment=look), Path(), shaders=shaders)
    meshes = runtime.residency.add_meshes([cube(), card(), plane()])
    for i, features in enumerate((*FEATURES, *FEATURES)):
        queue = "transparent" if i >= len(FEATURES) else "opaque"
        params: dict[str, Any] = {"base_color": (0.9, 0.1 * i, 0.3, 0.6), "roughness": 0.4}
        asset = MaterialAsset(f"m{i}", features=features, queue=queue, params=params)
        node = runtime.scene.nodes.add(f"n{i}", -1, (1.2 * (i % 4), 1.2 * (i // 4), 0.3 * i))
        material = runtime.residency.add_material(asset, Path())
        runtime.add_instances([(node, meshes[i % 3], 0, material)])
    runtime.update()
    return runtime


def view_of(**settings: Any) -> View:
    camera = frame_bounds(np.array([-0.5, -0.5, -0.5]), np.array([4.2, 1.8, 2.6]), 4 / 3)
    return View(camera, 64, 48, RenderSettings(**{"samples": 1, "shadow_size": 256, **settings}))


def until_whole(runtime: Runtime, view: View, limit: int = 80) -> tuple[Frame, int]:
    for count in range(limit):
        frame = runtime.follow(view, 0.0)
        if frame is not None:
            assert not runtime.renderer.programs.ahead.waiting
            return frame, count
        ahead = runtime.renderer.programs.ahead
        assert 0 <= ahead.done < ahead.total
    raise AssertionError(f"not whole after {limit} frames")


def pixels(frame: Frame) -> NDArray[np.uint8]:
    return np.array(frame.color.read())


@pytest.fixture
def waited(gl_device: Device) -> NDArray[np.uint8]:
    runtime = opened(gl_device)
    try:
        return pixels(runtime.render(view_of()))
    finally:
        runtime.close()


def test_slices_end_in_the_same_picture(gl_device: Device, waited: NDArray[np.uint8]) -> None:
    assert len(np.unique(waited.reshape(-1, 4), axis=0)) > 20
    runtime = opened(gl_device)
    try:
        frame, slices = until_whole(runtime, view_of())
        # without patience each frame makes one thing: a variant, a shadow caster, a pass
        assert slices > 12
        np.testing.assert_array_equal(pixels(frame), waited)
        assert until_whole(runtime, view_of())[1] == 0, "nothing is new any more"
        runtime.scene.nodes.set_translation([0], [(0.1, 0.0, 0.0)])
        runtime.scene.update()
        assert until_whole(runtime, view_of())[1] == 0, "a movement needs no program"
    finally:
        runtime.close()


def test_the_last_picture_stays_meanwhile(gl_device: Device, waited: NDArray[np.uint8]) -> None:
    runtime = opened(gl_device)
    try:
        last, _ = until_whole(runtime, view_of())
        count = 0
        while runtime.follow(view_of(view="normal"), 0.0) is None:
            np.testing.assert_array_equal(pixels(last), waited)
            count += 1
        assert count > 3
        # something new in the same graph: a material's feature is switched on
        runtime.residency.effects.release()
        runtime.renderer.programs.forget()
        count = 0
        while (frame := runtime.follow(view_of(), 0.0)) is None:
            np.testing.assert_array_equal(pixels(last), waited)
            count += 1
        assert count > 3
        np.testing.assert_array_equal(pixels(frame), waited)
    finally:
        runtime.close()


def test_a_great_patience_is_one_frame(gl_device: Device, waited: NDArray[np.uint8]) -> None:
    runtime = opened(gl_device)
    try:
        frame = runtime.follow(view_of(), 60.0)
        assert frame is not None
        np.testing.assert_array_equal(pixels(frame), waited)
    finally:
        runtime.close()


def test_what_was_begun_and_never_drawn_is_let_go(gl_device: Device) -> None:
    before = gl_device.live_objects()["program"]
    runtime = opened(gl_device)
    for _ in range(3):
        runtime.follow(view_of(), 0.0)
    runtime.follow(view_of(view="normal"), 0.0)
    runtime.close()
    assert gl_device.live_objects()["program"] == before


def test_a_mistake_met_on_the_way_is_told_and_drawn_in_magenta(gl_device: Device, tmp_path: Path) -> None:
    folder = tmp_path / "effects"
    folder.mkdir()
    (folder / "surface.frag").write_text("void main() { nothing; }\n", encoding="utf-8")
    runtime = opened(gl_device, shaders=(tmp_path,))
    try:
        frame, _ = until_whole(runtime, view_of(tone_map="none"))
        assert "nothing" in str(next(iter(runtime.renderer.programs.errors.values())))
        assert (pixels(frame)[..., :3] == (255, 0, 255)).all(axis=-1).any()
    finally:
        runtime.close()


def test_facts_that_alternate_get_done_all_the_same(gl_device: Device) -> None:
    runtime = opened(gl_device)
    try:
        views = [view_of(), view_of(view="normal")]
        whole = [0, 0]
        for turn in range(80):
            whole[turn % 2] += runtime.follow(views[turn % 2], 0.0) is not None
        assert min(whole) > 3
    finally:
        runtime.close()
