"""Several passes of a technique: an outline by stencil and a hull pushed out, written as files of a project alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.gpu.types import Device
from tests.support.effect_project import PATHS, EffectProject, picture

EFFECT = """name = "outlined"
extends = "surface"
[states.marked]
stencil = { pass = "replace", reference = 1 }
[states.outside]
stencil = { compare = "notequal", reference = 1 }
raster = { cull = "none" }
[technique]
gbuffer = false
[[technique.forward.passes]]
name = "body"
states = ["marked"]
[[technique.forward.passes]]
name = "outline"
vertex = "effects/hull.vert"
fragment = "effects/hull.frag"
states = ["outside"]
defines = { WIDTH = 0.1 }
"""
HULL = """layout(location = 0) in vec3 a_position;
layout(location = 15) in uint a_object;
void main()
{
    uvec4 object = objects[a_object];
    vec4 p = vec4(a_position * (1.0 + 2.0 * WIDTH), 1.0);
    vec3 at = vec3(dot(transforms[3u * object.x], p), dot(transforms[3u * object.x + 1u], p),
        dot(transforms[3u * object.x + 2u], p));
    gl_Position = view.clip_from_origin * vec4(at, 1.0);
}
"""
RED = "layout(location = 0) out vec4 color;\nvoid main() { color = vec4(1.0, 0.0, 0.0, 1.0); }\n"
MATERIAL = 'name = "thing"\neffect = "{}"\n[params]\nbase_color = "gray"\nroughness = 0.6\nmetallic = 0.0\n'


@pytest.mark.parametrize("path", PATHS)
def test_an_outline_in_every_path(gl_device: Device, tmp_path: Path, path: str) -> None:
    """Nothing inside changes; outside there is a red rim, as wide in every path."""
    project = EffectProject(
        tmp_path,
        {
            "shaders/effects/outlined.effect.toml": EFFECT, "shaders/effects/hull.vert": HULL,
            "shaders/effects/hull.frag": RED, "thing.material.toml": MATERIAL.format("surface"),
        },
    )  # fmt: skip
    runtime = project.open(gl_device)
    try:
        plain = picture(runtime, path=path).astype(int)
        assert runtime.renderer.draws.uses_stencil is False
        project.write("thing.material.toml", MATERIAL.format("outlined"))
        assert runtime.hot_reload.poll(force=True) is not None
        assert not runtime.hot_reload.problems
        seen = picture(runtime, path=path).astype(int)
        rim = np.abs(seen - plain).max(axis=2) > 3
        assert 0.02 < rim.mean() < 0.3
        assert (seen[rim][:, 0] > 150).all()
        assert (seen[rim][:, 1:3] < 100).all()
        middle = seen.shape[0] // 2, seen.shape[1] // 2
        assert not rim[middle]
        assert np.array_equal(seen[middle], plain[middle])
        passes = {(v.request.index, v.request.role) for v in runtime.residency.effects.variants() if v.asked}
        assert (1, "forward") in passes
    finally:
        runtime.close()
