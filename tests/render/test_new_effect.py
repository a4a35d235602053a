"""A complete new effect and its material, written as text in a project, drawn by the command in every path."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from engine.gpu.types import Device
from engine.report.image import load_png
from importers.cli.main import main
from tests.support.effect_project import PATHS, EffectProject

EFFECT = """# Stripes that glow, with a rim by the view's angle.
name = "stripes"
doc = "bands of two colours along y"

[features.rim]
doc = "brighter towards the silhouette"

[params.first]
type = "color3"
default = "#00ff00"
group = "Colours"
doc = "of every other band"

[params.second]
type = "color3"
default = { linear = [0.0, 0.0, 0.0] }
group = "Colours"
order = 1.0

[params.count]
type = "float"
default = 2.0
min = 1.0
max = 64.0
unit = "1/m"

[params.rim_power]
type = "float"
default = 2.0
min = 0.5
max = 8.0
when = "rim and count > 1"

[states.solid]
depth = { test = true, write = true }
raster = { cull = "none" }

[technique.forward]
vertex = "effects/stripes.vert"
fragment = "effects/stripes.frag"
states = ["solid"]

[technique.depth]
vertex = "effects/stripes.vert"
states = ["solid"]
features = []

[technique.shadow]
vertex = "effects/stripes.vert"
states = ["solid"]
features = []

[technique.velocity]
vertex = "effects/stripes.vert"
"""
VERTEX = """layout(location = 0) in vec3 a_position;
layout(location = 15) in uint a_object;
invariant gl_Position;
layout(location = 0) out float v_height;
layout(location = 1) flat out uint v_material;
void main()
{
    uvec4 object = objects[a_object];
    vec4 p = vec4(a_position, 1.0);
    uint row = 3u * object.x;
    vec3 at = vec3(dot(transforms[row], p), dot(transforms[row + 1u], p), dot(transforms[row + 2u], p));
    v_height = a_position.y;
    v_material = object.y;
    gl_Position = view.clip_from_origin * vec4(at, 1.0);
}
"""
FRAGMENT = """layout(location = 0) in float v_height;
layout(location = 1) flat in uint v_material;
layout(location = 0) out vec4 color;
void main()
{
    MaterialParams m = materials[v_material];
    color = vec4(fract(v_height * m.count + 0.001) < 0.5 ? m.first : m.second, 1.0);
}
"""
MATERIAL = 'name = "thing"\neffect = "stripes"\n[params]\nsecond = "blue"\n'


@pytest.fixture
def project(tmp_path: Path) -> EffectProject:
    return EffectProject(
        tmp_path,
        {
            "shaders/effects/stripes.effect.toml": EFFECT, "shaders/effects/stripes.vert": VERTEX,
            "shaders/effects/stripes.frag": FRAGMENT, "thing.material.toml": MATERIAL,
        },
    )  # fmt: skip


@pytest.mark.gl
def test_drawn_by_the_command_in_every_path(
    project: EffectProject, gl_device: Device, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two bands of exactly the two colours in the front face; a shadow below; the same whatever the path."""
    seen = []
    for path in PATHS:
        out = project.folder / f"{path}.png"
        arguments = ["render", str(project.scene), "--out", str(out), "--size", "64x48", "--path", path]
        assert main([*arguments, "--set", "tone_map=none", "--set", "samples=1", "--explain"]) == 0
        told = capsys.readouterr().out
        assert "stripes has no technique for gbuffer: what it draws is drawn by its technique for forward" in told
        seen.append(load_png(out)[..., :3].astype(int))
    colors = {tuple(color) for color in seen[0].reshape(-1, 3).tolist()}
    assert {(0, 255, 0), (0, 0, 255)} <= colors
    for other in seen[1:]:
        assert (np.abs(other - seen[0]).max(axis=2) > 3).mean() < 0.002


def test_it_is_described_and_checked(project: EffectProject, capsys: pytest.CaptureFixture[str]) -> None:
    effect = str(project.folder / "shaders/effects/stripes.effect.toml")
    assert main(["inspect", effect, "--json"]) == 0
    described = json.loads(capsys.readouterr().out)
    assert [t["role"] for t in described["techniques"]] == ["forward", "depth", "shadow", "velocity"]
    rim = next(p for p in described["params"] if p["name"] == "rim_power")
    assert rim["when"] == "rim and count > 1"
    assert described["params"][0]["group"] == "Colours"
    assert (
        "stripes has no technique for gbuffer: what it draws is drawn by its technique for forward, behind the lighting"
    ) in described["absent"]
    assert "no pass asks for the role 'velocity' yet" in described["findings"][0]["message"]
    main(["check", effect])
    told = capsys.readouterr().out
    assert "stripes.effect.toml:53:1" in told
    assert "no pass asks for the role 'velocity' yet" in told


def test_a_material_tells_where_its_values_are_from(project: EffectProject, capsys: pytest.CaptureFixture[str]) -> None:
    project.write("other.material.toml", 'parent = "thing.material.toml"\n[params]\ncount = 3.0\n')
    assert main(["inspect", str(project.folder / "other.material.toml"), "--json"]) == 0
    material = json.loads(capsys.readouterr().out)["materials"][0]
    assert material["parent"] == "thing.material.toml"
    assert material["from"] == {"effect": "thing.material.toml", "params.second": "thing.material.toml"}
