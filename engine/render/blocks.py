"""Blocks: the generated GLSL in front of shaders. The bindings are those of engine.render.frame."""

from __future__ import annotations

from engine.render.light_rows import light_glsl
from engine.render.view_block import VIEW_LAYOUT

#: uniform and storage blocks that surface shaders see; the bindings are those of engine.render.frame
SCENE_PRELUDE = (
    VIEW_LAYOUT.block_glsl("ViewBlock", 0, "view")
    + "\nlayout(std430, binding = 0) readonly buffer TransformBlock { vec4 transforms[]; };"
    + "\nlayout(std430, binding = 1) readonly buffer ObjectBlock { uvec4 objects[]; };\n"
    + light_glsl(3)
    + "layout(std430, binding = 4) readonly buffer PaletteBlock { vec4 palette[]; };\n"
)
VIEW_PRELUDE = VIEW_LAYOUT.block_glsl("ViewBlock", 0, "view") + "\n"
LIGHT_PRELUDE = VIEW_PRELUDE + light_glsl(3)
