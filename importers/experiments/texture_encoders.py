"""Which encoder, at which effort, for which block format: error against time, and what stands in its way.

Encoders: ispc_texcomp, which the importers use; etcpak and quicktex, where they are installed (the extra `encoders`).
Images are made here: colours with a 1/f spectrum and hard edges, unrelated data channels, normals of a bumpy height
field, a mask of soft and hard shapes, leaves with alpha.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.texture import TextureAsset
from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.report.perceptual import flip
from engine.report.records import Point, Table
from importers.textures.blocks import encode_blocks
from importers.textures.pixels import level_pixels

Bytes = NDArray[np.uint8]

SIZE = 256
#: problem -> (image, format, channels that count)
PROBLEMS = {
    "color bc7": ("color", "bc7", 3), "color bc1": ("color", "bc1", 3), "data bc7": ("data", "bc7", 3),
    "normal bc5": ("normal", "bc5", 2), "mask bc4": ("mask", "bc4", 1), "leaf bc7": ("leaf", "bc7", 4),
    "leaf bc3": ("leaf", "bc3", 4),
}  # fmt: skip
_BC7 = ("ultrafast", "veryfast", "fast", "basic", "slow")
#: format -> (encoder, effort)
EFFORTS: dict[str, tuple[tuple[str, str], ...]] = {
    "bc7": (*(("ispc", effort) for effort in _BC7), ("etcpak", "default"), ("etcpak", "linear, 16 partitions")),
    "bc1": (("ispc", "only"), ("etcpak", "only"), ("quicktex", "level 5"), ("quicktex", "level 10")),
    "bc3": (("ispc", "only"), ("etcpak", "only"), ("quicktex", "level 5")),
    "bc4": (("ispc", "only"), ("etcpak", "only"), ("quicktex", "only")),
    "bc5": (("ispc", "only"), ("etcpak", "only"), ("quicktex", "only")),
}
#: what the importers' qualities choose, by problem
CHOSEN = {
    "color bc7": {"draft": "ultrafast", "normal": "ultrafast", "high": "basic", "final": "slow"},
    "data bc7": {"draft": "ultrafast", "normal": "ultrafast", "high": "basic", "final": "slow"},
    "leaf bc7": {"draft": "ultrafast", "normal": "ultrafast", "high": "basic", "final": "slow"},
    "normal bc5": dict.fromkeys(("draft", "normal", "high", "final"), "only"),
    "mask bc4": dict.fromkeys(("draft", "normal", "high", "final"), "only"),
}
_MODULES = {"ispc": "ispc_texcomp", "etcpak": "etcpak", "quicktex": "quicktex"}


def knobs(ctx: Context) -> Sequence[Knobs]:
    """Every encoder that is installed at every effort; the others are named as left out."""
    found = []
    for problem, (_, format, _) in PROBLEMS.items():
        for encoder, effort in EFFORTS[format]:
            if importlib.util.find_spec(_MODULES[encoder]) is not None:
                found.append({"problem": problem, "encoder": encoder, "effort": effort})
    ctx.omit("BC6H", "ispc_texcomp alone encodes it, and no independent decoder of it to floats is at hand")
    for encoder, module in _MODULES.items():
        if importlib.util.find_spec(module) is None:
            ctx.omit(f"the encoder {encoder}", f"{module} is not installed: pip install 'lucarna[encoders]'")
    return found


def noise(ctx: Context, name: str, slope: float) -> NDArray[np.float64]:
    """[n,n] in 0..1 with a spectrum of 1/f^slope, as natural images have with 1."""
    rng = ctx.rng(name)
    f = np.fft.fftfreq(SIZE)
    radius = np.maximum(np.hypot(f[:, None], f[None, :]), 1.0 / SIZE)
    waves = np.fft.fft2(rng.standard_normal((SIZE, SIZE))) / radius**slope
    image = np.real(np.fft.ifft2(waves))
    low, high = np.percentile(image, (1, 99))
    return np.asarray(np.clip((image - low) / (high - low), 0.0, 1.0), np.float64)


def image(ctx: Context, name: str) -> Bytes:
    """The test image u1[n,n,4]."""
    y, x = (np.mgrid[0:SIZE, 0:SIZE] + 0.5) / SIZE
    out = np.ones((SIZE, SIZE, 4))
    if name == "color":
        light, tint, other = (noise(ctx, f"color {k}", 1.0) for k in range(3))
        out[..., :3] = np.stack([light, 0.7 * light + 0.3 * tint, 0.5 * light + 0.5 * other], -1)
        out[(np.hypot(x - 0.3, y - 0.4) < 0.15), :3] = (0.9, 0.15, 0.1)
        out[((x * 24 + y * 4) % 1 < 0.3) & (y > 0.75), :3] = (0.05, 0.1, 0.35)
    elif name == "data":
        out[..., :3] = np.stack(
            [noise(ctx, "data 0", 1.5), noise(ctx, "data 1", 0.8), noise(ctx, "data 2", 1.2) > 0.6], -1
        )
    elif name == "normal":
        height = noise(ctx, "height", 1.4) * 6.0
        dy, dx = np.gradient(height)
        n = np.stack([-dx, dy, np.ones_like(dx)], -1)
        out[..., :3] = n / np.linalg.norm(n, axis=-1, keepdims=True) * 0.5 + 0.5
    elif name == "mask":
        out[..., :3] = np.clip(0.5 + 8.0 * (noise(ctx, "mask", 1.5) - 0.5), 0.0, 1.0)[..., None]
    else:
        out[..., :3] = np.stack(
            [0.2 + 0.2 * noise(ctx, "leaf 0", 1.0), 0.3 + 0.5 * noise(ctx, "leaf 1", 1.0), 0.1 + 0 * x], -1
        )
        out[..., 3] = np.clip(0.5 + 20.0 * (noise(ctx, "leaf 2", 1.3) - 0.55), 0.0, 1.0)
    return np.rint(out * 255.0).astype(np.uint8)


def encoder(knobs: Knobs, pixels: Bytes) -> Callable[[], bytes]:
    """The call that is timed: one image to blocks, on one thread."""
    format = PROBLEMS[str(knobs["problem"])][1]
    effort, name = str(knobs["effort"]), str(knobs["encoder"])
    if name == "ispc":
        channels = {"bc4": 1, "bc5": 2}.get(format, 4)
        packed = np.ascontiguousarray(pixels[..., :channels])
        if format in ("bc1", "bc3"):
            return _ispc_old(format, packed)
        alpha = format == "bc7" and bool((pixels[..., 3] != 255).any())
        profile = f"alpha_{effort}" if alpha else effort
        return lambda: encode_blocks(packed, format, profile if format == "bc7" else "basic", 1)
    if name == "etcpak":
        import etcpak

        if format == "bc7":
            params = etcpak.BC7CompressBlockParams()
            if effort != "default":
                params.init_linear_weights()
                params.m_max_partitions = 16
                params.m_uber_level = 0
            return lambda: bytes(etcpak.compress_bc7(pixels.tobytes(), SIZE, SIZE, params))
        compress = getattr(etcpak, f"compress_{format}")
        return lambda: bytes(compress(pixels.tobytes(), SIZE, SIZE))
    return _quicktex(format, effort, pixels)


def _ispc_old(format: str, packed: Bytes) -> Callable[[], bytes]:
    import ispc_texcomp

    compress: Any = getattr(ispc_texcomp, f"compress_blocks_{format}")
    surface = ispc_texcomp.RGBASurface(packed.tobytes(), SIZE, SIZE, SIZE * 4)
    return lambda: bytes(compress(surface))


def _quicktex(format: str, effort: str, pixels: Bytes) -> Callable[[], bytes]:
    import quicktex
    from quicktex.s3tc import bc1, bc3, bc4, bc5

    level = int(effort.split()[1]) if effort.startswith("level") else 5
    make: dict[str, Callable[[], Any]] = {
        "bc1": lambda: bc1.BC1Encoder(level), "bc3": lambda: bc3.BC3Encoder(level), "bc4": lambda: bc4.BC4Encoder(0),
        "bc5": lambda: bc5.BC5Encoder(0, 1),
    }  # fmt: skip
    chosen, raw = make[format](), quicktex.RawTexture.frombytes(pixels.tobytes(), SIZE, SIZE)
    return lambda: bytes(chosen.encode(raw).tobytes())


def run(ctx: Context, knobs: Knobs) -> Trial:
    name, format, channels = PROBLEMS[str(knobs["problem"])]
    pixels: Bytes = ctx.once(f"image {name}", lambda: image(ctx, name))

    def judge(blocks: bytes) -> Outcome:
        got = level_pixels(TextureAsset(format, SIZE, SIZE, [[blocks]]))[..., :channels].astype(np.float64)
        off = got - pixels[..., :channels]
        rmse = float(np.sqrt(np.mean(off**2))) / 255.0
        extra: dict[str, Any] = {
            "PSNR, dB": round(-20.0 * float(np.log10(max(rmse, 1e-9))), 2), "bytes per texel": len(blocks) / SIZE**2,
        }  # fmt: skip
        errors = {"rmse": rmse, "max_error": float(np.abs(off).max()) / 255.0}
        if name == "normal":
            angles = _angles(got, pixels[..., :2].astype(np.float64))
            extra["mean angle, degrees"] = round(angles, 4)
        pictures = []
        if name == "color":
            shown = got.astype(np.uint8)
            try:
                errors["flip"] = flip(shown, pixels[..., :3])[0]
            except LucarnaError as error:
                ctx.omit("FLIP", str(error))
            if knobs["encoder"] == "ispc":
                pictures = beside_truth(ctx, f"{format} {knobs['effort']}", shown, "source", pixels[..., :3])
        return Outcome(errors, extra=extra, pictures=pictures)

    return Trial(encoder(knobs, pixels), judge)


def _angles(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Mean angle in degrees between normals given by x and y as bytes."""

    def vectors(xy: NDArray[np.float64]) -> NDArray[np.float64]:
        v = xy / 127.5 - 1.0
        return np.concatenate([v, np.sqrt(np.maximum(1.0 - (v * v).sum(-1, keepdims=True), 0.0))], -1)

    one, two = vectors(a), vectors(b)
    across = np.linalg.norm(np.cross(one, two), axis=-1)
    return float(np.degrees(np.arctan2(across, (one * two).sum(-1))).mean())


def tables(ctx: Context, points: Sequence[Point]) -> list[Table]:
    """MPix/s and PSNR of every setting, and which of them the qualities use."""
    rows = []
    for point in points:
        if point.ms is None:
            continue
        problem, effort = str(point.knobs["problem"]), str(point.knobs["effort"])
        ours = [
            quality for quality, chosen in CHOSEN.get(problem, {}).items()
            if point.knobs["encoder"] == "ispc" and chosen == effort
        ]  # fmt: skip
        eye = point.error.get("flip")
        rows.append([
            problem, f"{point.knobs['encoder']} {effort}", f"{SIZE * SIZE / point.ms.median / 1000.0:.1f}",
            f"{point.extra['PSNR, dB']:.1f}", "" if eye is None else f"{eye:.4f}", "yes" if point.front else "",
            ", ".join(ours),
        ])  # fmt: skip
    head = ["image and format", "encoder", "MPix/s", "PSNR, dB", "FLIP", "on the front", "used by --quality"]
    return [Table("Encoders", head, rows, "One thread; blocks decoded by Pillow, which shares no code with them.")]


EXPERIMENT = Experiment(
    title="Texture encoders",
    method="block compression of one image by each library at each effort, as the importers call it",
    truth="the image itself, 8 bits; blocks are decoded independently",
    metric="rmse",
    unit="of full scale",
    knobs=knobs,
    default={"problem": "color bc7", "encoder": "ispc", "effort": "ultrafast"},
    run=run,
    curve="encoder",
    problem="problem",
    also=("bytes per texel",),
    tables=tables,
    quick=lambda k: k["effort"] in ("ultrafast", "only", "default", "level 5"),
    note="Points of one image and format compete. The importers use ispc_texcomp, beside which other threads run.",
)
