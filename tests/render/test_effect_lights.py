"""Local lights in effects of a project's own: every one counts, also where they are more than a driver's loops turn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.assets.scene import LightAsset
from engine.gpu.types import Device
from tests.support.effect_project import EffectProject, picture

pytestmark = pytest.mark.gl

EFFECT = """name = "lit"
[technique.forward]
vertex = "effects/surface.vert"
fragment = "effects/lit.frag"
streams = ["normal"]
"""
FRAGMENT = """#include "lib/lights.glsl"
#include "lib/view.glsl"
layout(location = 0) in vec3 v_position;
layout(location = 1) in vec3 v_normal;
layout(location = 2) flat in uint v_material;
layout(location = 0) out vec4 o_color;
void main()
{
    vec3 n = normalize(v_normal);
    vec3 v = safe_normalize(view_vector(v_position));
    Reflector r = Reflector(n, v, vec3(0.04), 1.0, vec3(0.5), 0.5, max(dot(n, v), 1e-4));
    o_color = vec4(local_lighting(v_position, r), 1.0);
}
"""
MANY = 100_000


@pytest.mark.parametrize("path", ["forward", "forward-plus", "deferred"])
def test_every_light_of_very_many_counts(gl_device: Device, tmp_path: Path, path: str) -> None:
    """100,000 lights at one place make the picture of one that is as bright."""
    files = {
        "effects/lit.effect.toml": EFFECT, "effects/lit.frag": FRAGMENT,
        "thing.material.toml": 'schema = "lucarna.material/1"\nname = "thing"\neffect = "lit"\n',
    }  # fmt: skip
    project = EffectProject(tmp_path, files)
    pictures: list[NDArray[np.uint8]] = []
    for count in (1, MANY):
        runtime = project.open(gl_device)
        scene = runtime.scene
        scene.lights.remove(np.arange(len(scene.lights.node)))
        node = scene.nodes.add("lamps", -1, (1.0, 1.0, 1.5))
        light = LightAsset("point", intensity=6.0 / count, range=6.0)
        scene.lights.add_many([node] * count, light)
        runtime.update()
        pictures.append(picture(runtime, (16, 12), path=path))
        assert not runtime.renderer.programs.errors
        runtime.close()
    one, many = (p.astype(np.int64) for p in pictures)
    assert one[6, 8, :3].min() > 40  # the thing is lit
    assert np.abs(one - many).max() <= 2
