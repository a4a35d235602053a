"""Procedural textures of the sample scene: u1[h,w,3|4] images, deterministic, tileable unless said otherwise.

noise (2D periodic, 3D on the sphere) -> height -> normal_map (tangent space, +Y up)
                                      -> colour (sRGB bytes)
"""

from __future__ import annotations

import io
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

Array = NDArray[np.float64]
Pixels = NDArray[np.uint8]


# --- noise ---------------------------------------------------------------------------------------------------------


def _fade(t: Array) -> Array:
    return t * t * t * (t * (t * 6 - 15) + 10)


def noise2(x: Array, y: Array, period_x: int, period_y: int, seed: int) -> Array:
    """Gradient noise, about [-1, 1], with whole periods in x and y (Perlin 2002: quintic fade)."""
    random = np.random.default_rng(seed)
    angle = random.uniform(0, math.tau, (period_y, period_x))
    gx, gy = np.cos(angle), np.sin(angle)
    xi, yi = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = x - xi, y - yi

    def corner(dx: int, dy: int) -> Array:
        i, j = (yi + dy) % period_y, (xi + dx) % period_x
        return np.asarray(gx[i, j] * (fx - dx) + gy[i, j] * (fy - dy))

    u, v = _fade(fx), _fade(fy)
    low = corner(0, 0) * (1 - u) + corner(1, 0) * u
    high = corner(0, 1) * (1 - u) + corner(1, 1) * u
    return (low * (1 - v) + high * v) * 1.5


def fbm2(x: Array, y: Array, period_x: int, period_y: int, seed: int, octaves: int = 5, gain: float = 0.5) -> Array:
    """Octaves of noise2; x, y in units of the first octave's cells."""
    total, weight = np.zeros(np.broadcast(x, y).shape), 1.0
    for octave in range(octaves):
        scale = 2**octave
        total += weight * noise2(x * scale, y * scale, period_x * scale, period_y * scale, seed + octave)
        weight *= gain
    return total


def fbm3(points: Array, seed: int, octaves: int = 5, gain: float = 0.5) -> Array:
    """Octaves of 3D gradient noise at f8[...,3]: no seam and no pinched pole where the points lie on a sphere."""
    random = np.random.default_rng(seed)
    gradients = random.normal(size=(4096, 3))
    gradients /= np.linalg.norm(gradients, axis=1, keepdims=True)
    total, weight = np.zeros(points.shape[:-1]), 1.0
    for octave in range(octaves):
        p = points * 2.0**octave + 17.3 * octave
        base = np.floor(p).astype(np.int64)
        f = p - base
        fade = _fade(f)
        value = np.zeros(points.shape[:-1])
        for corner in range(8):
            offset = np.array([corner & 1, corner >> 1 & 1, corner >> 2 & 1])
            cell = base + offset
            hashed = (cell[..., 0] * 73856093 ^ cell[..., 1] * 19349663 ^ cell[..., 2] * 83492791) & 4095
            dot = np.sum(gradients[hashed] * (f - offset), axis=-1)
            value += dot * np.prod(np.where(offset, fade, 1 - fade), axis=-1)
        total += weight * value * 1.4
        weight *= gain
    return total


def grid(width: int, height: int) -> tuple[Array, Array]:
    """x, y in [0, 1) at texel centres."""
    return np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)


def sphere_points(width: int, height: int) -> Array:
    """Directions f8[h,w,3] of an equirectangular image, in the layout of sample_shapes.sphere."""
    u, v = grid(width, height)
    longitude, latitude = u * math.tau, (0.5 - v) * math.pi
    return np.stack(
        [np.cos(latitude) * np.sin(longitude), np.sin(latitude), np.cos(latitude) * np.cos(longitude)], axis=-1
    )


# --- pixels --------------------------------------------------------------------------------------------------------


def mix(a: Array | Sequence[float], b: Array | Sequence[float], t: Array) -> Array:
    """Colours a..b by t[h,w], clamped."""
    k = np.clip(t, 0, 1)[..., None]
    return np.asarray(a) * (1 - k) + np.asarray(b) * k


def smoothstep(low: float, high: float, x: Array) -> Array:
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def rgb(code: str) -> Array:
    """'#rrggbb' as f8[3] in 0..1 (sRGB)."""
    return np.array([int(code[i : i + 2], 16) for i in (1, 3, 5)]) / 255


def to_bytes(image: Array) -> Pixels:
    return np.round(np.clip(image, 0, 1) * 255).astype(np.uint8)


def normal_map(height: Array, strength: float, *, aspect: float = 1.0) -> Pixels:
    """Tangent-space normals (+X right, +Y up, +Z out) of a tileable height; `aspect` = texel width / texel height."""
    dx = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) * strength / aspect
    down = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) * strength
    normal = np.stack([-dx, down, np.ones_like(height)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return to_bytes(normal * 0.5 + 0.5)


def metal_rough(occlusion: Array | float, roughness: Array, metallic: Array | float) -> Pixels:
    """Occlusion, roughness, metallic in R, G, B."""
    return to_bytes(np.stack(np.broadcast_arrays(occlusion, roughness, metallic), -1).astype(np.float64))


def png(image: Pixels) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def jpeg(image: Pixels, quality: int = 90) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, "JPEG", quality=quality, subsampling=0, optimize=True)
    return buffer.getvalue()


# --- materials -----------------------------------------------------------------------------------------------------


def brushed(size: int = 256) -> tuple[Pixels, Pixels]:
    """Fine scratches along u: normal map, and roughness with its grain."""
    x, y = grid(size, size)
    scratches = np.zeros((size, size))
    for octave, (cells_x, cells_y) in enumerate(((2, 48), (3, 96), (4, 128))):
        scratches += noise2(x * cells_x, y * cells_y, cells_x, cells_y, 11 + octave) * 0.6**octave
    smudges = fbm2(x * 3, y * 3, 3, 3, 29, 4)
    rough = 0.26 + 0.05 * scratches + 0.06 * smudges
    return normal_map(scratches, 0.055), metal_rough(1.0, rough, 1.0)


def marble(size: int = 1024) -> Pixels:
    """White marble with folded grey veins and a few thin golden ones."""
    x, y = grid(size, size)
    warp_x = fbm2(x * 3, y * 3, 3, 3, 41, 5, 0.42)
    warp_y = fbm2(x * 3, y * 3, 3, 3, 47, 5, 0.42)
    u, v = x * 3 + warp_x * 0.75, y * 3 + warp_y * 0.75
    broad = 1 - np.abs(noise2(u, v, 3, 3, 53))
    fine = 1 - np.abs(noise2(u * 2 + 0.37, v * 2 + 0.11, 6, 6, 59))
    gold = 1 - np.abs(noise2(u + 1.3, v + 2.6, 3, 3, 67))
    clouds = fbm2(x * 4, y * 4, 4, 4, 61, 5)
    colour = mix(rgb("#efece6"), rgb("#cfcbc6"), smoothstep(-0.3, 1.0, clouds))
    colour = mix(colour, rgb("#8d8c90"), 0.75 * smoothstep(0.80, 1.0, broad) ** 2)
    colour = mix(colour, rgb("#5d5c63"), 0.85 * smoothstep(0.965, 1.0, broad))
    colour = mix(colour, rgb("#77767c"), 0.6 * smoothstep(0.95, 1.0, fine) * smoothstep(-0.2, 0.6, clouds))
    colour = mix(colour, rgb("#a98245"), 0.7 * smoothstep(0.982, 1.0, gold) * smoothstep(-0.4, 0.3, -clouds))
    return to_bytes(colour)


def walnut(size: int = 512) -> tuple[Pixels, Pixels]:
    """Walnut along u: colour, and roughness of a satin varnish over its pores."""
    x, y = grid(size, size)
    bend = fbm2(x * 2, y * 2, 2, 2, 71, 3)
    rings = np.sin((y * 14 + bend * 1.3) * math.tau) * 0.5 + 0.5
    fibre = noise2(x * 6, y * 128, 6, 128, 73) + 0.6 * noise2(x * 12, y * 256, 12, 256, 79)
    pores = smoothstep(0.45, 0.9, noise2(x * 24, y * 192, 24, 192, 83))
    colour = mix(rgb("#4a2a18"), rgb("#7d4d2c"), 0.3 + 0.36 * rings + 0.22 * fibre)
    colour = mix(colour, rgb("#2a160c"), 0.55 * pores)
    return to_bytes(colour), metal_rough(1.0, 0.34 + 0.12 * pores + 0.04 * fibre, 0.0)


def stone_floor(size: int = 1024, tiles: int = 4) -> tuple[Pixels, Pixels, Pixels]:
    """A checker of pale limestone and dark slate with worn edges: colour, normals (half size), roughness (half)."""
    x, y = grid(size, size)
    column, row = np.floor(x * tiles), np.floor(y * tiles)
    dark = (column + row) % 2
    fx, fy = x * tiles - column - 0.5, y * tiles - row - 0.5
    wobble = fbm2(x * 24, y * 24, 24, 24, 91, 3) * 0.006
    # distance from the tile's rounded edge, in tiles; positive inside
    corner = 0.04
    qx, qy = np.abs(fx) - (0.488 - corner), np.abs(fy) - (0.488 - corner)
    outside = np.hypot(np.maximum(qx, 0), np.maximum(qy, 0)) + np.minimum(np.maximum(qx, qy), 0)
    inside = corner - outside + wobble
    grout = 1 - smoothstep(-0.004, 0.006, inside)
    shade = np.random.default_rng(97).uniform(-0.09, 0.09, (tiles, tiles))[row.astype(int), column.astype(int)]
    clouds = fbm2(x * 8 + column * 0.31, y * 8 + row * 0.17, 8, 8, 101, 5)
    veins = smoothstep(0.90, 1.0, 1 - np.abs(fbm2(x * 4, y * 4, 4, 4, 103, 4)))
    specks = noise2(x * 256, y * 256, 256, 256, 107)
    pale = mix(rgb("#b3a58c"), rgb("#d3c8b2"), 0.5 + 0.5 * clouds + shade * 3)
    pale = mix(pale, rgb("#8d7c62"), 0.30 * smoothstep(0.5, 1.0, specks))
    slate = mix(rgb("#20262d"), rgb("#39414a"), 0.45 + 0.45 * clouds + shade * 3)
    slate = mix(slate, rgb("#8a9096"), 0.22 * veins)
    colour = pale * (1 - dark[..., None]) + slate * dark[..., None]
    colour = mix(colour, rgb("#17140f"), grout * 0.9)
    height = smoothstep(-0.01, 0.035, inside) * 1.6 + clouds * 0.12
    half = height.reshape(size // 2, 2, size // 2, 2).mean((1, 3))
    rough = np.where(dark > 0, 0.30 + 0.10 * clouds, 0.42 + 0.10 * clouds) + 0.02 * specks
    rough = rough * (1 - grout) + 0.9 * grout
    rough = rough.reshape(size // 2, 2, size // 2, 2).mean((1, 3))
    return to_bytes(colour), normal_map(half, 1.4), metal_rough(1.0, rough, 0.0)


def floor_occlusion(size: int, radius: float, pedestal: float, height: float) -> Pixels:
    """What the pedestal (a cylinder) hides of the sky, for the floor's second uv set; not tileable.

    Above a point at distance d from the axis it fills an azimuth of 2 asin(p/d) up to the elevation atan(h/(d-p));
    cosine-weighted, that sector takes (azimuth / 2π) sin²(elevation) of the sky."""
    x, y = grid(size, size)
    distance = np.maximum(np.hypot(x - 0.5, y - 0.5) * 2 * radius, 1e-6)
    outside = np.maximum(distance, pedestal * 1.0001)
    azimuth = 2 * np.arcsin(np.clip(pedestal / outside, 0, 1)) / math.tau
    elevation = np.arctan2(height, outside - pedestal)
    hidden = azimuth * np.sin(elevation) ** 2
    # a second, narrow term for the gap under the foot's moulding
    gap = 0.45 * np.exp(-np.maximum(distance - pedestal, 0) / 0.012)
    open_sky = np.clip(1 - 1.25 * hidden - gap, 0, 1)
    open_sky = np.where(distance < pedestal, 0.05, open_sky)
    return to_bytes(np.repeat(open_sky[..., None], 3, -1))


def clay(width: int = 512) -> tuple[Pixels, Pixels, Pixels]:
    """Unglazed terracotta, modelled by hand: colour, normals, roughness (equirectangular)."""
    points = sphere_points(width, width // 2)
    dents = fbm3(points * 2.6, 113, 4)
    grain = fbm3(points * 12, 127, 2)
    grooves = np.sin(points[..., 1] * 46 + fbm3(points * 2, 131, 3) * 3.0)
    height = dents * 1.0 + grain * 0.22 + grooves * 0.10
    colour = mix(rgb("#8f452a"), rgb("#c9774c"), 0.5 + 0.45 * dents + 0.15 * grain)
    colour = mix(colour, rgb("#e0a27b"), 0.35 * smoothstep(0.25, 0.8, grain))
    rough = 0.88 + 0.08 * grain
    return to_bytes(colour), normal_map(height, 2.4), metal_rough(1.0, rough, 0.0)


def porcelain(width: int = 1024) -> Pixels:
    """White porcelain with cobalt continents, brushed, and fine meridians (equirectangular)."""
    points = sphere_points(width, width // 2)
    u, v = grid(width, width // 2)
    land = fbm3(points * 1.55 + 4.7, 137, 6, 0.55)
    brush = fbm3(points * 9, 139, 3)
    inside = smoothstep(0.02, 0.06, land + brush * 0.02)
    rim = smoothstep(0.0, 0.03, land) - smoothstep(0.035, 0.075, land)
    wash = np.clip(0.55 + 0.9 * land + 0.25 * brush, 0, 1)
    colour = np.broadcast_to(rgb("#f1f1ec"), (*land.shape, 3))
    colour = mix(colour, mix(rgb("#5f86c9"), rgb("#12307a"), wash), inside)
    colour = mix(colour, rgb("#0b1f57"), rim * 0.8)
    latitude = (0.5 - v) * 180

    def line(distance: Array, half: float) -> Array:
        return 1 - smoothstep(half * 0.6, half * 1.4, distance)

    meridian = np.abs((u * 12 + 0.5) % 1 - 0.5) * 30 * np.cos(np.radians(latitude))
    parallel = np.abs((latitude / 30 + 0.5) % 1 - 0.5) * 30
    graticule = np.maximum(line(meridian, 0.45), line(parallel, 0.45))
    return to_bytes(mix(colour, rgb("#3d5fae"), 0.55 * graticule))


def hammered(size: int = 256) -> tuple[Pixels, Pixels]:
    """Forged iron: overlapping round dents; normals and roughness."""
    random = np.random.default_rng(149)
    x, y = grid(size, size)
    height = np.ones((size, size))
    for cx, cy, r in zip(
        random.uniform(size=150), random.uniform(size=150), random.uniform(0.05, 0.1, 150), strict=True
    ):
        dx, dy = np.abs(x - cx), np.abs(y - cy)
        d = np.hypot(np.minimum(dx, 1 - dx), np.minimum(dy, 1 - dy)) / r
        height = np.minimum(height, 0.55 + 0.45 * d**2)
    grain = fbm2(x * 32, y * 32, 32, 32, 151, 3)
    return normal_map(height + grain * 0.02, 2.2), metal_rough(1.0, 0.46 + 0.08 * grain + 0.1 * (1 - height), 1.0)


def sun_surface(width: int = 512) -> Pixels:
    """Glowing granules, darker at their seams (equirectangular)."""
    points = sphere_points(width, width // 2)
    cells = 1 - np.abs(fbm3(points * 5, 157, 4))
    flow = fbm3(points * 2, 163, 4)
    colour = mix(rgb("#f0892c"), rgb("#ffe2a0"), smoothstep(0.35, 1.0, cells + 0.25 * flow))
    return to_bytes(colour)


# --- ornaments -----------------------------------------------------------------------------------------------------


def filigree(width: int = 512, height: int = 256) -> Pixels:
    """A band of leaves and scrolls cut out of sheet brass, tileable in u: colour with alpha."""
    scale = 4
    canvas = Image.new("L", (width * scale, height * scale), 0)
    draw = ImageDraw.Draw(canvas)
    w, h = width * scale, height * scale
    bar = int(h * 0.055)
    draw.rectangle((0, 0, w, bar), fill=255)
    draw.rectangle((0, h - bar, w, h), fill=255)

    def curve(points: Array, half: Array | float) -> None:
        """A stroke of varying half width, drawn as discs; repeated over the seam."""
        halves = np.broadcast_to(half, (len(points),))
        for (px, py), r in zip(points, halves, strict=True):
            for shift in (-1, 0, 1):
                cx, cy, d = (px + shift) * w, py * h, r * h
                draw.ellipse((cx - d, cy - d, cx + d, cy + d), fill=255)

    def leaf(x0: float, y0: float, x1: float, y1: float, half: float) -> None:
        t = np.linspace(0, 1, 90)
        spine = np.stack([x0 + (x1 - x0) * t, y0 + (y1 - y0) * t], 1)
        curve(spine, half * np.sin(np.pi * t) ** 0.8 * (1 - 0.35 * t) + 0.004)

    t = np.linspace(0, 1, 400)
    for mirror in (0, 1):
        x0 = mirror * 0.5
        # a rising vine between the bars, with a scroll, leaves on both sides
        sign = 1 - 2 * mirror
        vine = np.stack([x0 + 0.5 * t, 0.5 + sign * 0.30 * np.sin(np.pi * t)], 1)
        curve(vine, 0.022)
        a = np.linspace(0, 3.4 * np.pi, 300)
        radius = 0.085 * (1 - a / (4.6 * np.pi))
        centre = (x0 + 0.25, 0.5 + sign * 0.08)
        scroll = np.stack([centre[0] + radius * 0.5 * np.sin(a), centre[1] + sign * radius * np.cos(a) * 1.9], 1)
        curve(scroll, np.linspace(0.024, 0.016, 300))
        for offset, reach, size in ((0.10, 0.075, 0.055), (0.40, -0.075, 0.055)):
            base = 0.5 + sign * 0.30 * math.sin(math.pi * offset / 0.5)
            leaf(x0 + offset, base, x0 + offset + reach, base - sign * 0.26, size)
            leaf(x0 + offset, base, x0 + offset - reach * 0.55, base + sign * 0.17, size * 0.8)
        leaf(x0 + 0.25, 0.5 + sign * 0.28, x0 + 0.25, 0.5 + sign * 0.45, 0.06)
    for centre_x in (0.0, 0.5):
        curve(np.array([[centre_x, 0.5]]), 0.075)
        for angle in range(0, 360, 60):
            turn = math.radians(angle + 30)
            curve(np.array([[centre_x + 0.055 * math.cos(turn), 0.5 + 0.11 * math.sin(turn)]]), 0.04)
    alpha = np.asarray(canvas.resize((width, height), Image.Resampling.BOX), np.float64) / 255
    shade = rgb("#d9ab57") * np.ones((height, width, 1))
    return to_bytes(np.concatenate([shade, alpha[..., None]], -1))


def planet_ring(width: int = 512, height: int = 128) -> Pixels:
    """Saturn's ring as pierced gold: u around, v outer to inner edge; gaps, a row of slits and a row of stars."""
    scale = 4
    canvas = Image.new("L", (width * scale, height * scale), 255)
    draw = ImageDraw.Draw(canvas)
    w, h = width * scale, height * scale
    draw.rectangle((0, h * 0.30, w, h * 0.36), fill=0)
    draw.rectangle((0, h * 0.80, w, h * 0.83), fill=0)
    count = 12
    for i in range(count):
        x = (i + 0.5) / count * w
        draw.rounded_rectangle((x - w * 0.028, h * 0.09, x + w * 0.028, h * 0.21), radius=h * 0.06, fill=0)
        points = []
        for k in range(8):
            r = h * (0.155 if k % 2 == 0 else 0.055)
            a = math.pi * k / 4
            points.append((x + r * 0.9 * math.sin(a), h * 0.58 - r * math.cos(a)))
        draw.polygon(points, fill=0)
        # bridges hold the parts together
        x = i / count * w
        for shift in (0, w):
            draw.rectangle((x + shift - w * 0.005, h * 0.29, x + shift + w * 0.005, h * 0.84), fill=255)
    alpha = np.asarray(canvas.resize((width, height), Image.Resampling.BOX), np.float64) / 255
    shade = rgb("#f2cf7c") * np.ones((height, width, 1))
    return to_bytes(np.concatenate([shade, alpha[..., None]], -1))


def engraved_scale(width: int = 1024, height: int = 128) -> tuple[Pixels, Pixels, Pixels]:
    """A quarter of the horizon ring: a degree scale and three signs, cut into brass and filled with black; colour,
    normals, roughness. Tileable in u, v outer to inner edge."""
    scale = 3
    canvas = Image.new("L", (width * scale, height * scale), 0)
    draw = ImageDraw.Draw(canvas)
    w, h = width * scale, height * scale

    def line(x0: float, y0: float, x1: float, y1: float, thick: float = 0.022) -> None:
        draw.line((x0 * w, y0 * h, x1 * w, y1 * h), fill=255, width=max(1, round(thick * h)))

    for y in (0.05, 0.34, 0.40, 0.95):
        line(-0.01, y, 1.01, y)
    for degree in range(91):
        length = 0.27 if degree % 10 == 0 else 0.18 if degree % 5 == 0 else 0.11
        line(degree / 90, 0.06, degree / 90, 0.06 + length, 0.026 if degree % 5 == 0 else 0.018)
    for sector in range(4):
        line(sector / 3, 0.40, sector / 3, 0.95, 0.03)
    aspect = h / w

    def circle(x: float, y: float, r: float, start: float = 0, end: float = 360) -> None:
        box = ((x - r * aspect) * w, (y - r) * h, (x + r * aspect) * w, (y + r) * h)
        draw.arc(box, start, end, fill=255, width=round(0.035 * h))

    middle = 0.675
    for sector, kind in enumerate(("sun", "moon", "star")):
        x = (sector + 0.5) / 3
        for side in (-1, 1):
            for k in (1, 2, 3):
                dot = x + side * (0.035 + 0.03 * k)
                r = 0.05 - 0.01 * k
                draw.ellipse(
                    ((dot - r * aspect) * w, (middle - r) * h, (dot + r * aspect) * w, (middle + r) * h), fill=255
                )
        if kind == "sun":
            circle(x, middle, 0.11)
            for k in range(12):
                a = k * math.tau / 12
                dx, dy = math.cos(a) * aspect, math.sin(a)
                line(x + dx * 0.14, middle + dy * 0.14, x + dx * 0.21, middle + dy * 0.21, 0.03)
        elif kind == "moon":
            circle(x, middle, 0.19, 40, 320)
            circle(x + 0.07 * aspect, middle, 0.14, 55, 305)
        else:
            tips = [
                (x + math.sin(k * math.tau / 10) * aspect * r, middle - math.cos(k * math.tau / 10) * r)
                for k, r in ((k, 0.21 if k % 2 == 0 else 0.085) for k in range(10))
            ]
            for (ax, ay), (bx, by) in zip(tips, [*tips[1:], tips[0]], strict=True):
                line(ax, ay, bx, by, 0.03)
    cut = np.asarray(canvas.resize((width, height), Image.Resampling.BOX), np.float64) / 255
    u, v = grid(width, height)
    grain = noise2(u * 8, v * 64, 8, 64, 167) + 0.5 * noise2(u * 16, v * 96, 16, 96, 173)
    colour = mix(rgb("#f0c56b"), rgb("#1b130a"), cut * 0.93)
    height_map = -cut * 1.2 + grain * 0.03
    return (
        to_bytes(colour),
        normal_map(height_map, 0.9),
        metal_rough(1.0, 0.24 + 0.04 * grain + 0.5 * cut, 1 - 0.85 * cut),
    )
