"""View: what one picture is made of, besides the scene."""

from __future__ import annotations

from dataclasses import dataclass, field

from engine.render.camera import Camera
from engine.render.settings import RenderSettings


@dataclass(slots=True)
class View:
    """`width`, `height` in pixels, at least 1. `seconds`: since the picture before, for what takes time to adapt; None:
    it has had all the time it needs, so that a picture depends on nothing but the scene."""

    camera: Camera
    width: int
    height: int
    settings: RenderSettings = field(default_factory=RenderSettings)
    seconds: float | None = None

    @property
    def aspect(self) -> float:
        return self.width / max(self.height, 1)
