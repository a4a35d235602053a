"""View: what one picture is made of, besides the scene."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

from engine.render.camera import Camera
from engine.render.settings import RenderSettings


@dataclass(slots=True)
class View:
    """`width`, `height` in pixels, at least 1. `seconds`: since the picture before, for what takes time to adapt; None:
    it has had all the time it needs, so that a picture depends on nothing but the scene. `key` tells the views of one
    renderer apart: each has its own frame before (engine/render/motion). `cut`: that one tells nothing about this one.
    `shift`: pixels that the picture is moved to the right and down by, as by a lens that is shifted."""

    camera: Camera
    width: int
    height: int
    settings: RenderSettings = field(default_factory=RenderSettings)
    seconds: float | None = None
    key: Hashable = ""
    cut: bool = False
    shift: tuple[float, float] = (0.0, 0.0)

    @property
    def aspect(self) -> float:
        return self.width / max(self.height, 1)
