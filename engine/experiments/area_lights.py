"""Area lights by linearly transformed cosines: the fit, the table's size, a disk's corners; and a point instead."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.dds import read_dds
from engine.core.paths import shaders_dir
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.gpu.preprocess import flatten
from engine.gpu.types import Bindings, ComputePipelineDesc, Device, Pipeline, SamplerDesc, Texture, TextureDesc
from engine.math import ggx, ltc
from engine.render.blocks import LIGHT_PRELUDE
from engine.render.light_rows import LIGHT_LAYOUT
from engine.report.records import Extreme, Floor

F8 = NDArray[np.float64]

CASES, LOOK_UPS = 128, 1 << 13
#: of the truth: samples of the lobe and nodes over the light, each squared
SAMPLES, NODES = 96, 24
#: the renderer's table, and its polygon for a disk
SIZE, CORNERS = 64, 16
DEFAULT: dict[str, Any] = {"light": "rectangle", "method": "ltc", "size": SIZE, "corners": CORNERS}
KINDS = {"rectangle": 3, "disk": 4}

SHADER = """
layout(local_size_x = 64) in;
#include "lib/lights.glsl"
layout(std430, binding = 4) readonly buffer Surfaces { vec4 surfaces[]; };
layout(std430, binding = 5) writeonly buffer Out { float found[]; };
void main()
{
    uint k = gl_GlobalInvocationID.x;
    if (k >= uint(found.length())) return;
    uint i = k % uint(surfaces.length() / 2);
    vec4 a = surfaces[2u * i];
    vec4 b = surfaces[2u * i + 1u];
    Reflector r = Reflector(vec3(0.0, 0.0, 1.0), a.xyz, vec3(b.x), 1.0, vec3(b.y), a.w * a.w, max(a.z, 1e-4));
    found[k] = light_contribution(i, vec3(0.0), r).x;
}
"""


@dataclass(slots=True)
class Cases:
    """Lights before surface points at 0 with normal +Z: `center`, `right`, `up` f8[n,3] (half edges), `view` f8[n,3],
    `roughness`, `f0`, `diffuse` f8[n]. Every light faces the point; some are cut by the horizon."""

    center: F8
    right: F8
    up: F8
    view: F8
    roughness: F8
    f0: F8
    diffuse: F8


def cases(ctx: Context) -> Cases:
    rng = ctx.rng("cases")
    center = rng.normal(size=(CASES, 3))
    center[:, 2] = np.abs(center[:, 2]) + 0.1
    center *= (rng.uniform(0.5, 3.0, CASES) / np.linalg.norm(center, axis=1))[:, None]
    right, up = _unit(rng.normal(size=(CASES, 3))), rng.normal(size=(CASES, 3))
    up = _unit(np.cross(up, right))
    up *= np.sign((np.cross(right, up) * center).sum(axis=1))[:, None]  # so that the light faces the point
    mu = rng.uniform(0.1, 1.0, CASES)
    metal = rng.random(CASES) < 0.5
    return Cases(
        center, right * rng.uniform(0.05, 1.0, (CASES, 1)), up * rng.uniform(0.05, 1.0, (CASES, 1)),
        np.stack([np.sqrt(1.0 - mu * mu), np.zeros(CASES), mu], axis=1), np.geomspace(0.05, 1.0, CASES),
        np.where(metal, 1.0, 0.04), np.where(metal, 0.0, 0.5),
    )  # fmt: skip


def radiance(c: Cases, kind: str, samples: int, nodes: int) -> F8:
    """f8[n]: what is reflected of a light of 1 nit. The coat: stratified samples of the visible normals, which hit the
    light or do not; what is below: quadrature over the light."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    if kind == "rectangle":
        s, t = (v.ravel() for v in np.meshgrid(x, x))
        weight = np.outer(w, w).ravel()
    else:
        radius, angle = np.meshgrid((x + 1.0) / 2.0, (np.arange(2 * nodes) + 0.5) / nodes * np.pi)
        s, t = (radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel()
        weight = (np.broadcast_to(w / 2.0, radius.shape) * radius * np.pi / nodes).ravel()
    u = np.stack(np.meshgrid(*[(np.arange(samples) + 0.5) / samples] * 2), axis=-1).reshape(-1, 2)
    out = np.zeros(len(c.center))
    for i in range(len(out)):
        out[i] = _coat(c, i, kind, u) + _below(c, i, s, t, weight)
    return out


def _coat(c: Cases, i: int, kind: str, u: F8) -> float:
    v, alpha = c.view[i], float(c.roughness[i]) ** 2
    half = ggx.sample_visible_half(u, np.broadcast_to(v, (len(u), 3)), alpha)
    vh = half @ v
    l = 2.0 * vh[:, None] * half - v
    normal = np.cross(c.right[i], c.up[i])
    along = l @ normal
    hit = l * (float(c.center[i] @ normal) / np.where(along > 0.0, along, 1.0))[:, None] - c.center[i]
    x = hit @ c.right[i] / float(c.right[i] @ c.right[i])
    y = hit @ c.up[i] / float(c.up[i] @ c.up[i])
    inside = (np.abs(x) < 1.0) & (np.abs(y) < 1.0) if kind == "rectangle" else x * x + y * y < 1.0
    nl, nv = l[:, 2], float(v[2])
    # BRDF times cosine over the density of visible normals: F G2 / G1
    g2 = 4.0 * nl * nv * ggx.V_SmithGGXCorrelated(nv, nl, alpha)
    value = ggx.F_Schlick(vh, c.f0[i]) * g2 / ggx.G1_Smith(nv, alpha)
    return float(np.where(inside & (along > 0.0) & (nl > 0.0), value, 0.0).mean())


def _below(c: Cases, i: int, s: F8, t: F8, weight: F8) -> float:
    p = c.center[i] + s[:, None] * c.right[i] + t[:, None] * c.up[i]
    d2 = (p * p).sum(axis=1)
    l = p / np.sqrt(d2)[:, None]
    area = np.abs(l @ np.cross(c.right[i], c.up[i])) / d2
    through = 1.0 - ggx.F_Schlick(_unit(l + c.view[i]) @ c.view[i], c.f0[i])
    return float((through * c.diffuse[i] / np.pi * np.maximum(l[:, 2], 0.0) * area * weight).sum())


def truth(ctx: Context, kind: str) -> F8:
    c = cases(ctx)
    return ctx.references.get(
        "area-lights", {"kind": kind, "center": c.center, "samples": SAMPLES, "nodes": NODES},
        lambda: {"radiance": radiance(c, kind, SAMPLES, NODES)}, seed=ctx.seed,
    )["radiance"]  # fmt: skip


def table(ctx: Context, size: int) -> NDArray[np.float16]:
    """The fitted table f2[size,size,4]; the renderer's at its own size."""
    if size == SIZE:
        asset = read_dds(shaders_dir() / "data" / "ltc.dds")
        return np.frombuffer(asset.levels[0][0], "<f2").reshape(asset.height, asset.width, 4)
    made = ctx.references.get("ltc-table", {"size": size}, lambda: {"table": ltc.fit_table(size)})
    return made["table"].astype(np.float16)


def lights(c: Cases, kind: str, *, as_point: bool) -> NDArray[np.void]:
    """The cases' lights as the shader reads them; `as_point`: a point of the same candela straight ahead."""
    rows = np.zeros(len(c.center), LIGHT_LAYOUT.dtype)
    rows["position"] = c.center
    size = np.stack([np.linalg.norm(c.right, axis=1), np.linalg.norm(c.up, axis=1)], axis=1)
    normal = _unit(np.cross(c.right, c.up))
    rows["direction"], rows["right"] = -normal, _unit(c.right)
    rows["half_size"], rows["color"], rows["profile"], rows["type"] = size, 1.0, -1, KINDS[kind]
    if as_point:
        area = size.prod(axis=1) * (4.0 if kind == "rectangle" else np.pi)
        lean = (_unit(c.center) * normal).sum(axis=1)
        rows["type"], rows["color"] = 1, (area * lean)[:, None]
    return rows


def run(ctx: Context, knobs: Knobs) -> Trial:
    device = ctx.device
    assert device is not None, "needs gpu"
    kind, c = str(knobs["light"]), cases(ctx)
    pipeline = _pipeline(device, int(knobs["corners"]), area=knobs["method"] != "point")
    values = table(ctx, int(knobs["size"]) or SIZE)
    textures = {13: _texture(device, "rgba16f", values), 9: _dfg(device)}
    surfaces = np.zeros((len(c.view), 2, 4), np.float32)
    surfaces[:, 0, :3], surfaces[:, 0, 3] = c.view, c.roughness
    surfaces[:, 1, 0], surfaces[:, 1, 1] = c.f0, c.diffuse
    given = [
        device.buffer(lights(c, kind, as_point=knobs["method"] == "point").tobytes(), label="lights"),
        device.buffer(surfaces.tobytes(), label="surfaces"),
    ]
    made = device.buffer(LOOK_UPS * 4, label="found")
    sampler = device.sampler(SamplerDesc("clamp", "clamp", "clamp", "linear", "linear"))
    bindings = Bindings(
        storage={3: given[0], 4: given[1], 5: made}, textures={u: (t, sampler) for u, t in textures.items()}
    )

    def work() -> None:
        with device.compute_pass("area lights") as encoder:
            encoder.set_pipeline(pipeline)
            encoder.set_bindings(bindings)
            encoder.dispatch(LOOK_UPS // 64)

    def judge(_: object) -> Outcome:
        error = np.frombuffer(made.read(0, len(c.view) * 4), np.float32).astype(np.float64) - truth(ctx, kind)
        return Outcome(
            {"rmse": float(np.sqrt(np.mean(error**2))), "max_error": float(np.abs(error).max())},
            extra={"bytes": 0 if knobs["method"] == "point" else values.nbytes},
            profile=list(zip(c.roughness.tolist(), np.abs(error).tolist(), strict=True)),
        )

    def close() -> None:
        for buffer in (*given, made):
            buffer.release()
        for texture in textures.values():
            texture.release()
        pipeline.release()

    return Trial(work, judge, gpu=True, close=close)


def _pipeline(device: Device, corners: int, *, area: bool) -> Pipeline:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "area_lights.comp"
        path.write_text(SHADER, "utf-8")
        defines = {"AREA_LIGHTS": int(area), "LIGHT_PROFILES": 0, "DISK_CORNERS": corners}
        source = flatten(path, "compute", search=[shaders_dir()], prelude=LIGHT_PRELUDE, defines=defines)
    return device.compute_pipeline(ComputePipelineDesc("area lights", source))


def _texture(device: Device, format: str, values: NDArray[Any]) -> Texture:
    texture = device.texture(TextureDesc(format, values.shape[1], values.shape[0], label="table"))
    texture.write(np.ascontiguousarray(values))
    return texture


def _dfg(device: Device) -> Texture:
    asset = read_dds(shaders_dir() / "data" / "dfg_lut.dds")
    return _texture(
        device, asset.format, np.frombuffer(asset.levels[0][0], "<f2").reshape(asset.height, asset.width, 2)
    )


def _unit(v: F8) -> F8:
    result: F8 = v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)
    return result


def extremes(ctx: Context) -> Iterator[Extreme]:
    whole = table(ctx, SIZE).astype(np.float64)
    determinant = np.linalg.det(ltc.matrix_of(whole))
    yield Extreme(
        "determinant of the transform, over the whole table",
        f"{determinant.min():.2g} to {determinant.max():.3f}",
        bool(np.isfinite(determinant).all() and determinant.min() >= 0.0),
    )
    sky = np.array([(1e5, 1e5, 1), (-1e5, 1e5, 1), (-1e5, -1e5, 1), (1e5, -1e5, 1.0)])
    upright = ltc.form_factor(sky, ltc.look_up(whole, [0.1, 0.5, 1.0], 1.0))
    yield Extreme(
        "a light as large as the sky, seen from straight above: all of the lobe",
        f"{upright.min():.5f} to {upright.max():.5f}",
        bool(np.abs(upright - 1.0).max() < 1e-3),
    )


def noise_floor(ctx: Context) -> Floor:
    c = cases(ctx)
    some = Cases(*(getattr(c, name)[::8] for name in Cases.__slots__))
    fine, finest = radiance(some, "rectangle", SAMPLES, NODES), radiance(some, "rectangle", 2 * SAMPLES, NODES)
    return Floor(float(np.sqrt(np.mean((fine - finest) ** 2))), f"truth: {SAMPLES}² against {2 * SAMPLES}² samples")


EXPERIMENT = Experiment(
    title="Area lights by linearly transformed cosines",
    method="GGX and Lambert under a rectangle or a disk: a fitted cosine over the light's polygon, cut by the horizon, "
    "on the device; and a point light of the same candela in its middle",
    truth=f"{SAMPLES}² stratified samples of the lobe, which hit the light or not, and quadrature with {NODES}² nodes "
    "over the light for what is below the coat, float64; roughness 0.05 to 1, half of the cases metal",
    metric="rmse",
    unit="of the light's luminance",
    knobs=[
        {"light": kind, "method": method, "size": size, "corners": corners}
        for kind in KINDS
        for method, size, corners in (
            *(("ltc", size, CORNERS) for size in (4, 8, 16, SIZE)),
            *((("ltc", SIZE, n) for n in (6, 8, 12, 24, 48)) if kind == "disk" else ()),
            ("point", 0, CORNERS),
        )
    ],
    default=DEFAULT,
    curve="method",
    problem="light",
    run=run,
    quick=lambda k: k["size"] in (0, 4, SIZE) and k["corners"] in (8, CORNERS),
    also=("bytes",),
    needs=frozenset({"gpu"}),
    timed="gpu",
    noise_floor=noise_floor,
    extremes=extremes,
    profile_label="perceptual roughness",
    time_label=f"median time of {LOOK_UPS:,} points under one light each",
    note="No order is expected: what is left is the difference between GGX and the nearest transformed cosine, not the "
    "table's. Half of that difference went when the fit's axis was let loose from the lobe's mean direction. A small "
    "table blurs the reflections of smooth surfaces, which are a small part of all cases.",
)
