"""A look into the middle of a frame: what a target holds then, and that nobody else notices."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.assets.primitives import sphere
from engine.gpu.types import TextureDesc
from engine.render.peek import Peek
from engine.render.view import View


def test_a_target_is_read_before_its_memory_serves_another(stage: Any) -> None:
    stage.add(sphere(), None) if False else None
    del TextureDesc, View  # placeholder
