"""View: what one picture is made of, besides the scene."""

from __future__ import annotations

from dataclasses import dataclass, field

from engine.render.camera import Camera
from engine.render.settings import RenderSettings


@dataclass(slots=True)
class View:
    """`width`, `height` in pixels, at least 1."""

    camera: Camera
    width: int
    height: int
    settings: RenderSettings = field(default_factory=RenderSettings)

    @property
    def aspect(self) -> float:
        return self.width / max(self.height, 1)
