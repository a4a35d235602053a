"""The panels, in the order of their tabs. Each module defines `PANEL`, its class."""

from __future__ import annotations

import importlib

from editor.panels.base import Panel

PANELS = (
    "scene_tree", "assets", "viewport", "inspector", "lights", "render_settings", "log", "timings", "variants",
    "shader_editor",
    "animation_timeline", "state_graph", "blend_space", "bone_masks", "history", "frame_graph", "texture_viewer",
    "report", "asset_report", "numbers", "console", "plugins", "preferences",
    "material_preview", "brdf_explorer", "compare",
)  # fmt: skip


def make_panels() -> list[Panel]:
    """One of each, fresh."""
    panels: list[Panel] = []
    for name in PANELS:
        panel = importlib.import_module(f"editor.panels.{name}").PANEL()
        assert isinstance(panel, Panel)
        panels.append(panel)
    return panels
