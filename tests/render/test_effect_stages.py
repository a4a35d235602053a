"""All stages of a technique in all roles: a surface moved out by tessellation or geometry stages looks as one whose
mesh was moved, in every path, with its shadow. And the levels that choose between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.app.runtime import Runtime
from engine.assets.primitives import cube
from engine.gpu.types import Device
from tests.support.effect_project import PATHS, EffectProject, picture

SHARED = """
level = "low"
levels.medium = { geometry = "effects/puff.geom" }
levels.high = { tess_control = "effects/puff.tesc", tess_evaluation = "effects/puff.tese", requires = ["tessellation"] }
streams = ["normal"]
"""
EFFECT = f"""name = "puff"
extends = "surface"
[params.height]
type = "float"
default = 0.2
max = 1.0
unit = "m"
[technique.forward]{SHARED}[technique.gbuffer]{SHARED}[technique.depth]{SHARED}[technique.shadow]{SHARED}
"""
CONTROL = """layout(vertices = 3) out;
layout(location = 0) in vec3 v_position[];
layout(location = 1) in vec3 v_normal[];
layout(location = 2) in uint v_material[];
layout(location = 0) out vec3 c_position[];
layout(location = 1) out vec3 c_normal[];
layout(location = 2) out uint c_material[];
void main()
{
    c_position[gl_InvocationID] = v_position[gl_InvocationID];
    c_normal[gl_InvocationID] = v_normal[gl_InvocationID];
    c_material[gl_InvocationID] = v_material[gl_InvocationID];
    gl_TessLevelInner[0] = 3.0;
    gl_TessLevelOuter[0] = gl_TessLevelOuter[1] = gl_TessLevelOuter[2] = 4.0;
}
"""
EVALUATION = """layout(triangles, equal_spacing, ccw) in;
layout(location = 0) in vec3 c_position[];
layout(location = 1) in vec3 c_normal[];
layout(location = 2) in uint c_material[];
invariant gl_Position;
layout(location = 0) out vec3 v_position;
layout(location = 1) out vec3 v_normal;
layout(location = 2) flat out uint v_material;
void main()
{
    vec3 b = gl_TessCoord;
    v_normal = b.x * c_normal[0] + b.y * c_normal[1] + b.z * c_normal[2];
    v_material = c_material[0];
    v_position = b.x * c_position[0] + b.y * c_position[1] + b.z * c_position[2];
    v_position += normalize(v_normal) * materials[v_material].height;
    gl_Position = view.clip_from_origin * vec4(v_position, 1.0);
}
"""
GEOMETRY = """layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;
layout(location = 0) in vec3 v_position[];
layout(location = 1) in vec3 v_normal[];
layout(location = 2) flat in uint v_material[];
invariant gl_Position;
layout(location = 0) out vec3 g_position;
layout(location = 1) out vec3 g_normal;
layout(location = 2) flat out uint g_material;
void main()
{
    for (int i = 0; i < 3; ++i) {
        g_position = v_position[i] + normalize(v_normal[i]) * materials[v_material[i]].height;
        g_normal = v_normal[i];
        g_material = v_material[i];
        gl_Position = view.clip_from_origin * vec4(g_position, 1.0);
        EmitVertex();
    }
}
"""
MATERIAL = """name = "thing"
effect = "{effect}"
[params]
base_color = "#c08040"
roughness = 0.5
metallic = 0.0
"""
FILES = {
    "shaders/effects/puff.effect.toml": EFFECT,
    "shaders/effects/puff.tesc": CONTROL,
    "shaders/effects/puff.tese": EVALUATION,
    "shaders/effects/puff.geom": GEOMETRY,
    "thing.material.toml": MATERIAL.format(effect="puff"),
}


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The puffed cube, one whose mesh was moved, and a plain one."""
    plain = {"thing.material.toml": MATERIAL.format(effect="surface")}
    moved = cube()
    normal = moved.streams["normal"][:, :3].astype(np.float32) / 32767.0
    streams = {**moved.streams, "position": moved.streams["position"] + np.float32(0.2) * normal}
    low, high = streams["position"].min(axis=0).tolist(), streams["position"].max(axis=0).tolist()
    part = replace(moved.submeshes[0], bounds_min=tuple(low), bounds_max=tuple(high))
    moved = replace(moved, streams=streams, submeshes=[part])
    made = {name: tmp_path_factory.mktemp(name) for name in ("puff", "moved", "plain")}
    EffectProject(made["puff"], FILES)
    EffectProject(made["moved"], plain, moved)
    EffectProject(made["plain"], plain)
    return made


@pytest.fixture
def opened(gl_device: Device, folders: dict[str, Path]) -> Iterator[dict[str, Runtime]]:
    runtimes = {}
    for name, folder in folders.items():
        runtimes[name] = Runtime(gl_device, profile=False)
        runtimes[name].open(folder / "a.scene.json")
    yield runtimes
    for runtime in runtimes.values():
        runtime.close()


def test_every_stage_in_every_path(opened: dict[str, Runtime]) -> None:
    """Depth, shadow, G-buffer and forward agree: one that did not would show holes, or another shadow."""
    for path in PATHS:
        moved = picture(opened["moved"], path=path).astype(int)
        plain = picture(opened["plain"], path=path).astype(int)
        assert moved.std() > 20
        assert (np.abs(moved - plain).max(axis=2) > 30).mean() > 0.1
        for quality, expected in (("high", moved), ("medium", moved), ("low", plain), ("auto", moved)):
            seen = picture(opened["puff"], path=path, quality=quality).astype(int)
            # the bounds of the cube are those of the mesh, so its shadow maps lie a little otherwise
            differs = np.abs(seen - expected).max(axis=2) > 3
            assert differs.mean() < 0.02, (path, quality, differs.sum())
        assert not opened["puff"].hot_reload.problems
        assert not opened["puff"].renderer.programs.errors


def test_the_level_that_is_drawn_and_why(opened: dict[str, Runtime]) -> None:
    library = opened["puff"].residency.effects
    picture(opened["puff"], path="forward-plus", quality="low")
    seen = {(v.request.role, v.level, v.level_reason) for v in library.variants() if v.request.effect == "puff"}
    assert seen == {(role, "low", "low is wanted") for role in ("forward", "depth", "shadow")}
    picture(opened["puff"], path="forward-plus")
    assert ("shadow", "high", "the highest") in {(v.request.role, v.level, v.level_reason) for v in library.variants()}


def test_a_level_by_hand_goes_over_the_setting(gl_device: Device, tmp_path: Path) -> None:
    """And one that names it in its parent has it too."""
    project = EffectProject(tmp_path, FILES)
    project.write("base.material.toml", FILES["thing.material.toml"] + "\n")
    project.write("thing.material.toml", 'parent = "base.material.toml"\nlevel = "low"\n')
    runtime = project.open(gl_device)
    try:
        low = picture(runtime, quality="high")
        project.write("thing.material.toml", 'parent = "base.material.toml"\n')
        runtime.hot_reload.poll(force=True)
        high = picture(runtime, quality="high")
        assert (low != high).any()
        np.testing.assert_array_equal(picture(runtime, quality="low"), low)
    finally:
        runtime.close()


def test_a_broken_stage_keeps_the_picture_and_is_named(gl_device: Device, tmp_path: Path) -> None:
    project = EffectProject(tmp_path, FILES)
    runtime = project.open(gl_device)
    try:
        good = picture(runtime)
        for name, sound in (("puff.tese", EVALUATION), ("puff.tesc", CONTROL)):
            wrong = sound.replace("gl_Position = view", "gl_Position = viewer").replace("= 3.0;", "= tree;")
            assert wrong != sound
            project.write(f"shaders/effects/{name}", wrong)
            runtime.hot_reload.poll(force=True)
            problem = runtime.hot_reload.problems[0]
            assert Path(problem.where.file).name == name
            line = next(i for i, text in enumerate(wrong.splitlines(), 1) if "viewer" in text or "tree" in text)
            assert problem.where.line == line
            np.testing.assert_array_equal(picture(runtime), good)
            project.write(f"shaders/effects/{name}", sound)
            runtime.hot_reload.poll(force=True)
            assert not runtime.hot_reload.problems
        np.testing.assert_array_equal(picture(runtime), good)
    finally:
        runtime.close()
