"""Samples a pixel: what is asked for becomes what textures have, so that every sample is read."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine.experiments.harness.samples import build
from engine.gpu import open_device
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View


def test_the_next_that_there_is() -> None:
    caps = replace(open_device("null").caps, sample_counts=(4, 8), max_samples=8)
    assert [caps.samples_for(n) for n in (1, 2, 3, 4, 5, 8, 16)] == [1, 4, 4, 4, 8, 8, 8]
    unknown = replace(caps, sample_counts=(), max_samples=4)
    assert [unknown.samples_for(n) for n in (1, 2, 4, 8)] == [1, 2, 4, 4]


@pytest.mark.gl
def test_two_samples_move_nothing(gl_device: Device) -> None:
    """Half of a texture's samples lie to one side of the pixel's middle: their mean alone would move the picture."""
    scene = build("flat", gl_device)
    try:
        middles = []
        for samples in (1, 2, 4):
            settings = RenderSettings(samples=samples, background="color", tone_map="none")
            hdr = scene.render(View(scene.camera(1.5), 60, 40, settings), hdr=True).hdr
            assert hdr is not None
            light = np.asarray(hdr.read(), np.float64)[..., 1]
            light -= light.min()
            y, x = np.mgrid[0:40, 0:60]
            middles.append([(light * x).sum() / light.sum(), (light * y).sum() / light.sum()])
        np.testing.assert_allclose(middles, middles[2] * np.ones((3, 1)), atol=0.08)
    finally:
        scene.close()
