"""The G-buffer's packing: the shader against its float64 twin, what 16 bits leave, and which layout is chosen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.gpu.types import Device
from engine.render import gbuffer
from tests.support.shader_probe import ShaderProbe

COUNT = 4000


def surfaces(seed: int = 5) -> dict[str, np.ndarray]:
    """Random surfaces; axes and the folds of the octahedron among the normals."""
    rng = np.random.default_rng(seed)
    n = rng.normal(size=(COUNT, 3))
    n[:6] = np.concatenate([np.eye(3), -np.eye(3)])
    n[6:300, 2] = rng.uniform(-1e-3, 1e-3, 294)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    color = rng.uniform(size=(COUNT, 3))
    color[0], color[1] = 0.0, 1.0
    return {
        "n": n, "base_color": color, "metallic": rng.choice([0.0, 0.25, 1.0], COUNT),
        "roughness": rng.uniform(0.045, 1.0, COUNT), "dielectric_f0": rng.uniform(0.0, 0.2, (COUNT, 3)),
        "specular": rng.uniform(size=COUNT),
    }  # fmt: skip


@pytest.fixture
def probe(gl_device: Device, tmp_path: Path) -> ShaderProbe:
    return ShaderProbe(gl_device, tmp_path)


@pytest.mark.gl
@pytest.mark.parametrize("layout", [0, 1, 2])
def test_shader_and_twin_agree(probe: ShaderProbe, layout: int) -> None:
    given = {name: values.astype(np.float32) for name, values in surfaces().items()}
    if layout == 0:
        given["metallic"] = np.zeros(COUNT, np.float32)
        given["dielectric_f0"][:] = 0.04
    if layout < 2:
        given["specular"] = np.ones(COUNT, np.float32)
        given["dielectric_f0"][:] = given["dielectric_f0"][:, :1]
    want = gbuffer.stored(layout, **{name: values.astype(np.float64) for name, values in given.items()})
    code = (
        "Reflector r = unpack_surface(pack_surface(n, base_color, metallic, roughness, dielectric_f0, specular), n);\n"
        "result = {};"
    )
    for name, text, tolerance in (
        ("n", "vec4(r.n, 0.0)", 7e-5), ("f0", "vec4(r.f0, 0.0)", 1.6e-5), ("f90", "vec4(r.f90)", 1.6e-5),
        ("diffuse_albedo", "vec4(r.diffuse_albedo, 0.0)", 1.6e-5), ("alpha", "vec4(r.alpha)", 3.2e-5),
    ):  # fmt: skip
        got = probe(code.format(text), "lib/gbuffer.glsl", declare="", defines={"GBUFFER_LAYOUT": layout}, **given)
        np.testing.assert_allclose(
            got[:, : want[name].shape[-1] if want[name].ndim > 1 else 1].reshape(want[name].shape), want[name],
            atol=tolerance, err_msg=name,
        )  # fmt: skip


@pytest.mark.gl
def test_what_is_unlit_reflects_nothing(probe: ShaderProbe) -> None:
    code = "Reflector r = unpack_surface(pack_nothing(), v);\nresult = vec4(reflected(r, l, vec3(1e4)), r.f90);"
    rng = np.random.default_rng(1)
    v, l = rng.normal(size=(2, 100, 3))
    got = probe(code, "lib/gbuffer.glsl", defines={"GBUFFER_LAYOUT": 1}, v=v, l=l)
    assert (got == 0.0).all()


def test_sixteen_bits_are_enough() -> None:
    """Normals to 0.004 degrees; a white furnace keeps white, 18 % grey its value."""
    given = surfaces()
    got = gbuffer.stored(1, **given)
    cross = np.linalg.norm(np.cross(got["n"], given["n"]), axis=1)
    assert np.degrees(np.arcsin(cross.max())) < 0.004
    grey = gbuffer.unorm16(np.array([0.18, 1.0, 0.0]))
    np.testing.assert_allclose(grey, [0.18, 1.0, 0.0], atol=8e-6)


def test_no_normal_is_the_mark_of_nothing() -> None:
    """Rounding to snorm16 never gives -32768, half of the mark."""
    n = surfaces()["n"]
    codes = np.round(gbuffer.octahedral(n) * 32767.0)
    assert codes.min() >= -32767
    assert gbuffer.NO_REFLECTION == (0x8000 << 16 | 0x8000)


@pytest.mark.parametrize(
    ("values", "layout"),
    [
        ({}, 0), ({"metallic": 1.0}, 1), ({"ior": 1.33}, 1), ({"specular": 0.5}, 2), ({"specular_color": 0.5}, 2),
    ],
)  # fmt: skip
def test_layout_is_the_narrowest(values: dict[str, float], layout: int) -> None:
    row = np.zeros(3, [("metallic", "f4"), ("ior", "f4"), ("specular", "f4"), ("specular_color", "f4", 3)])
    row["ior"], row["specular"], row["specular_color"] = 1.5, 1.0, 1.0
    for name, value in values.items():
        row[name][1] = value
    assert gbuffer.layout_of(row) == layout
    assert [gbuffer.bytes_per_pixel(i) for i in range(3)] == [12, 16, 20]
    assert gbuffer.layout_of(np.zeros(1, [("tint", "f4")])) == 2  # an effect of its own parameters
