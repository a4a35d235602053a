"""The look card under light that is one all around: every patch as published, the grey ball 18 %."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.app.look_card import ASPECT, COLUMNS, GREY, PATCHES, LookCard
from engine.app.runtime import Runtime
from engine.assets.scene import EnvironmentAsset, SceneAsset
from engine.gpu.types import Device
from engine.math.color import linear_to_srgb
from engine.render.settings import RenderSettings

HEIGHT = 80


@pytest.fixture
def picture(gl_device: Device) -> np.ndarray:
    runtime = Runtime(gl_device, profile=False)
    asset = SceneAsset("lit", environment=EnvironmentAsset("uniform", color=(1.0, 1.0, 1.0), sun_illuminance=0.0))
    asset.look.tone_map, asset.look.exposure = "none", 0.0
    runtime.load(asset, Path())
    gl_device.begin_frame()
    made = LookCard(runtime)
    frame = made.render(np.eye(3), RenderSettings(), int(HEIGHT * ASPECT), HEIGHT)
    assert frame is not None
    pixels = np.asarray(frame.color.read())
    made.release()
    gl_device.end_frame()
    runtime.close()
    return pixels


def test_patches_are_as_published_and_grey_is_grey(picture: np.ndarray) -> None:
    """ColorChecker Classic (X-Rite), in sRGB; a Lambertian surface under radiance 1 all around sends its albedo."""
    scale = HEIGHT / 1.0  # the camera sees a height of one
    for i, text in enumerate(PATCHES):
        row, column = divmod(i, COLUMNS)
        x = (1.0 + (column - 2.5) * 0.23) * scale + 0.5 * picture.shape[1]
        y = (0.5 - (1.5 - row) * 0.23) * HEIGHT
        published = [int(text[k : k + 2], 16) for k in (0, 2, 4)]
        shown = picture[int(y), int(x), :3].astype(int)
        assert np.abs(shown - published).max() <= 2, (i + 1, shown, published)
    grey = picture[HEIGHT // 2, int(0.5 * picture.shape[1] - 1.25 * scale), :3].astype(int)
    assert np.abs(grey - 255 * float(linear_to_srgb(GREY))).max() <= 2
