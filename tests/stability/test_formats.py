"""Formats and determinism: what targets hold, how far tables are off, whether order matters."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from engine.assets.primitives import card, uv_sphere
from engine.assets.scene import LightAsset
from engine.core.paths import shaders_dir
from engine.gpu.types import (
    ColorAttachment,
    Device,
    RasterState,
    RenderPipelineDesc,
    SamplerDesc,
    ShaderSource,
    TextureDesc,
)
from engine.math import ggx
from engine.resources.environment import DfgTable
from tests.stability.rows import covers
from tests.support.shader_probe import ShaderProbe
from tests.support.stage import Stage, front_camera, surface


@pytest.mark.gl
@covers("format.one-bad-pixel", "format.half-store")
def test_sanitise_leaves_nothing_bad(probe: ShaderProbe) -> None:
    """The one clamp in front of every store: what a half float cannot hold never reaches it, on any driver."""
    good = np.array([0.0, 1e-30, 1e-3, 0.5, 1.0, 31999.0])
    bad = np.array([np.nan, np.inf, -np.inf, -1.0, -0.0, -1e-40, 32001.0, 65504.0, 65520.0, 1e38])
    both = np.concatenate([good, bad])
    got = probe("result.xyz = sanitise(vec3(x, 0.25, x));", "lib/math.glsl", x=both)
    assert np.isfinite(got).all()
    assert ((got >= 0.0) & (got <= 32000.0)).all()
    np.testing.assert_array_equal(got[: len(good), 0], good.astype(np.float32))
    assert (got[:, 1] == 0.25).all()  # the neighbours keep theirs


@pytest.mark.gl
@covers("format.half-store")
def test_half_float_store_is_within_one_ulp(gl_device: Device) -> None:
    """Drivers round to nearest or truncate: at most 1 ulp, never up."""
    count = 256
    text = f"""
        layout(location = 0) out vec4 o_color;
        void main() {{
            float x = floor(gl_FragCoord.x) / {count}.0;
            o_color = vec4(exp2(x * 30.0 - 14.0), 7e4, 1.0, 1.0);
        }}"""
    vertex = "void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0, 0.0, 1.0); }"
    target = gl_device.texture(TextureDesc("rgba16f", count, 1))
    full = gl_device.texture(TextureDesc("rgba32f", count, 1))
    pipeline = gl_device.render_pipeline(
        RenderPipelineDesc(
            "ramp", ShaderSource("vertex", vertex), ShaderSource("fragment", text), (), "triangles", None, (None,),
            RasterState("none"),
        )
    )  # fmt: skip
    for texture in (target, full):
        with gl_device.render_pass("ramp", [ColorAttachment(texture)]) as encoder:
            encoder.set_pipeline(pipeline)
            encoder.draw(3)
    stored, exact = target.read()[0].astype(np.float64), full.read()[0].astype(np.float64)
    ulp = np.spacing(np.abs(stored[:, 0]).astype(np.float16)).astype(np.float64)
    error = (stored[:, 0] - exact[:, 0]) / ulp
    inside = exact[:, 0] < 65504.0
    assert (error[inside] >= -1.0).all()
    assert (error[inside] <= 0.5).all()
    assert np.isin(stored[:, 1], [65504.0, np.inf]).all()  # why lighting is clamped before it is stored
    for thing in (target, full, pipeline):
        thing.release()


@covers("format.no-infinities-in-data", "format.integer-noise")
def test_shaders_hold_no_infinities_and_no_sine_noise() -> None:
    for file in shaders_dir().rglob("*.*"):
        if file.suffix not in (".glsl", ".vert", ".frag", ".comp"):
            continue
        code = re.sub(r"//.*|/\*.*?\*/", "", file.read_text(encoding="utf-8"), flags=re.S if "/*" in file.name else 0)
        assert not re.search(r"/\s*0(\.0*)?f?\s*[;),]", code), f"{file.name}: division by a literal zero"
        assert not re.search(r"fract\s*\(\s*sin\s*\(", code), (
            f"{file.name}: noise from fract(sin()): use an integer hash"
        )
        assert not re.search(r"\b(1e39|1e40|0x7f800000)\b", code), f"{file.name}: an infinity as a sentinel"


@pytest.mark.gl
@covers("format.table-filter")
def test_dfg_table_between_its_texels(gl_device: Device, probe: ShaderProbe) -> None:
    """The filtered table against float64 quadrature, half-way between texels where it is worst."""
    table = DfgTable(gl_device)
    mu, rough = (x.reshape(-1) for x in np.meshgrid([0.1, 0.207, 0.5, 0.83, 0.99], [0.1, 0.25, 0.51, 0.77, 1.0]))
    look_up = "float n = float(textureSize(t_probe, 0).x); vec2 at = (vec2(mu, rough) * (n - 1.0) + 0.5) / n;"
    got = probe(
        look_up + " result.xy = textureLod(t_probe, at, 0.0).rg;", textures={11: (table.texture, table.sampler)},
        declare="layout(binding = 11) uniform sampler2D t_probe;", mu=mu, rough=rough,
    )[:, :2]  # fmt: skip
    table.release()
    error = np.abs(got - ggx.dfg(rough, mu))
    assert np.sqrt((error**2).mean()) < 1.5e-3
    assert error.max() < 5e-3, f"largest error {error.max():.2e}"


@pytest.mark.gl
@covers("format.transcendentals")
@pytest.mark.parametrize(
    ("code", "twin", "low", "high", "tolerance"),
    [
        ("exp2(x)", np.exp2, -20.0, 20.0, 2e-5), ("log2(x)", np.log2, 1e-6, 1e6, 2e-5),
        ("exp(x)", np.exp, -20.0, 20.0, 2e-5), ("sqrt(x)", np.sqrt, 1e-12, 1e12, 1e-6),
        ("inversesqrt(x)", lambda x: x**-0.5, 1e-12, 1e12, 1e-6),
        ("pow(x, 1.0 / 2.4)", lambda x: x ** (1.0 / 2.4), 1e-4, 100.0, 2e-5),
        ("atan(x)", np.arctan, -50.0, 50.0, 1e-4), ("sin(x)", np.sin, -6.0, 6.0, 2e-4),
        ("cos(x)", np.cos, -6.0, 6.0, 2e-4),
    ],
)  # fmt: skip
def test_transcendentals_of_this_device(
    probe: ShaderProbe, code: str, twin: Any, low: float, high: float, tolerance: float
) -> None:
    """What the shaders build on is as exact as they take it for: of values near 0 the error is absolute."""
    x = np.linspace(low, high, 20_000).astype(np.float32)
    if low > 0.0:
        x = np.geomspace(low, high, 20_000).astype(np.float32)
    got = probe(f"result.x = {code};", x=x)[:, 0].astype(np.float64)
    expected = twin(x.astype(np.float64))
    error = np.abs(got - expected) / np.maximum(
        np.abs(expected), 1.0 if code.startswith(("sin", "cos", "log")) else 1e-30
    )
    assert error.max() < tolerance, f"{code}: {error.max():.2e} at {x[error.argmax()]:g}"


@pytest.mark.gl
@covers("format.table-filter")
def test_filter_steps_of_this_device(gl_device: Device, probe: ShaderProbe, record_property: object) -> None:
    """Between two texels a device may know only 2^8 steps; recorded, and never fewer."""
    ramp = gl_device.texture(TextureDesc("r32f", 2, 1))
    ramp.write(np.array([0.0, 1.0], np.float32).tobytes())
    sampler = gl_device.sampler(SamplerDesc("clamp", "clamp", "clamp", "linear", "linear"))
    got = probe(
        "result.x = textureLod(t_probe, vec2(0.25 + 0.5 * x, 0.5), 0.0).r;", textures={11: (ramp, sampler)},
        declare="layout(binding = 11) uniform sampler2D t_probe;", x=np.linspace(0.0, 1.0, 4096),
    )[:, 0]  # fmt: skip
    steps = len(np.unique(got))
    record_property("filter_steps", steps)  # type: ignore[operator]  # a pytest fixture
    assert steps >= 128
    assert (np.diff(got) >= 0.0).all()
    ramp.release()


@pytest.mark.gl
@covers("format.light-order", "light.order")
def test_lights_in_any_order(stage: Stage) -> None:
    """32 lights shuffled: the sum moves by one half-float ulp at most."""
    rng = np.random.default_rng(3)
    places = np.add(rng.uniform(-1.0, 1.0, (32, 3)), (0.0, 0.0, 1.5))
    colors = rng.uniform(0.0, 1.0, (32, 3))
    pictures = []
    for seed in (None, 1, 2):
        order = np.arange(32) if seed is None else np.random.default_rng(seed).permutation(32)
        stage.dark()
        stage.add(uv_sphere(), surface(base_color=(0.8, 0.7, 0.6, 1), metallic=0.3, roughness=0.4))
        for i in order:
            r, g, b = colors[i].tolist()
            stage.lamp(LightAsset("point", (r, g, b), intensity=0.3, range=4.0), places[i])
        pictures.append(stage.hdr())
    for other in pictures[1:]:
        ulp = np.spacing(np.maximum(pictures[0], other).astype(np.float16)).astype(np.float32)
        assert (np.abs(pictures[0] - other) <= ulp).all()
    assert pictures[0].max() > 0.1


@pytest.mark.gl
@covers("light.order")
def test_nodes_in_any_order(stage: Stage) -> None:
    shapes = [(uv_sphere(0.3), (x, y, z)) for x, y, z in [(0, 0, 0), (0.4, 0.1, 0.2), (-0.4, 0, 0.1), (0, 0.4, -0.3)]]
    pictures = []
    for order in ((0, 1, 2, 3), (3, 1, 0, 2)):
        stage.look(kind="uniform", sun_illuminance=2.0, background="color")
        for i in order:
            mesh, place = shapes[i]
            stage.add(mesh, surface(base_color=(0.2 + 0.2 * i, 0.5, 0.3, 1), roughness=0.5), place)
        pictures.append(stage.hdr(camera=front_camera(0.8)))
    assert (pictures[0] == pictures[1]).all()


@covers("depth.reversed-float")
@pytest.mark.gl
def test_device_has_reversed_depth(gl_device: Device) -> None:
    assert gl_device.caps.reversed_z


@covers("depth.near-and-far")
@pytest.mark.gl
@pytest.mark.parametrize("distance", [1.0, 1e2, 1e4, 1e5])
@pytest.mark.parametrize("gap", [1e-3, 1e-6])
def test_two_planes_stay_apart(stage: Stage, distance: float, gap: float) -> None:
    """Near plane at 1 mm, no far plane: the nearer of two cards covers every pixel in both orders of drawing.

    The scene is looked at from the origin, so that positions keep their digits: it is the depth that is tried."""
    for order in ((0, 1), (1, 0)):
        stage.dark()
        for i in order:
            place = (0.0, 0.0, -distance * (1.0 - gap * i))
            color = (float(i), 1.0 - i, 0.0, 1.0)
            stage.add(card(4.0 * distance), surface(features=("unlit",), base_color=color), place)
        camera = front_camera()
        camera.world_from_camera[:3, 3] = 0.0
        camera.znear = 1e-3
        wrong = (stage.hdr((32, 32), camera)[..., 0] != 1.0).sum()
        assert wrong == 0, f"{wrong} pixels show the plane behind"
