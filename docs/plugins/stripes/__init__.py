"""An effect: `effect = "stripes"` in a material file."""

from __future__ import annotations

from editor.plugins.api import Plugin


def register(plugin: Plugin) -> None:
    plugin.effects("shaders")
