"""A pass: darker corners, on the finished picture."""

from __future__ import annotations

from typing import ClassVar

from editor.plugins.api import Plugin
from engine.core.param import ParamBlock, param
from engine.render.screen_pass import ScreenPass


class Vignette(ScreenPass):
    name: ClassVar[str] = "vignette"
    fragment: ClassVar[str] = "vignette.frag"

    class Params(ParamBlock):
        strength: float = param(0.8, min=0.0, max=1.0, doc="0 leaves the corners as they are, 1 makes them black")
        start: float = param(0.4, min=0.0, max=1.0, doc="where it begins, from the middle to the corner")


def register(plugin: Plugin) -> None:
    plugin.effects("shaders")
    plugin.render_pass(Vignette)
