"""A look into the middle of a frame: what a target holds then, and that nobody else notices."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.assets.primitives import plane
from engine.render.peek import Peek


def test_a_target_is_read_before_its_memory_serves_another(stage: Any, surface: Any) -> None:
    """The linear picture without its bloom, against the one that is made without bloom; and the finished picture is
    the same bits with and without the look."""
    stage.add(plane(1.0), surface(base_color=(0.5, 0.25, 0.125, 1.0), metallic=0.0))
    options = {"bloom": 0.4, "samples": 1}
    plain = stage.ldr((32, 24), **options)
    view = stage.view((32, 24), **options)
    renderer = stage.runtime.renderer
    graph = renderer.render(stage.runtime.scene, view).graph
    assert "hdr" in graph.plan.slots, "it is shared memory"
    renderer.peek = peek = Peek("hdr")
    assert peek.take() is None, "not before a frame"
    assert (stage.ldr((32, 24), **options) == plain).all()
    pixels = peek.take()
    assert pixels is not None
    expected = stage.hdr((32, 24), samples=1)
    assert np.allclose(pixels[..., :3].astype(np.float32), expected[..., :3], rtol=2e-3, atol=1e-4)
    stage.ldr((32, 24), **options)
    stage.ldr((32, 24), **options)
    assert peek.take() is None, "what nobody took is not read again"
    renderer.peek = None
