"""Light from all around, baked: a cube prefiltered for GGX in its mips, and SH9 for diffuse light.

    EnvironmentAsset -> source cube (procedural | .hdr, .exr equirect | DDS cube) -> CubeChain
        mip 0     the source itself
        mip m > 0 GGX of perceptual roughness m / (mips - 1), head-on (n = v), samples filtered by their solid angle
        SH9       projected from the source, times the cosine, over pi
      -> engine.assets.environment_dds, in the user's cache under a hash of all that goes in

Sources: Karis 2013 (split sum), Krivanek and Colbert 2008 (filtered importance sampling), Ramamoorthi and
Hanrahan 2001 (SH9).
"""

from __future__ import annotations

import hashlib
import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.assets.container import compact_json
from engine.assets.environment_dds import read_environment, write_environment
from engine.assets.scene import EnvironmentAsset
from engine.assets.texture import TextureAsset
from engine.core.errors import InputError
from engine.core.paths import shaders_dir, user_cache_dir
from engine.math import sh
from engine.math.sphere import basis, cube_solid_angles
from importers.textures import procedural
from importers.textures.cube import CubeChain, directions, from_equirect
from importers.textures.ggx_tables import lobe

Floats = NDArray[np.float32]

#: part of the cache key: raise it when the result changes
VERSION = 1
SIZE = 128
SMALLEST = 4
MAX_SIZE = 2048

#: samples per mip: wide lobes need more, and their mips have fewer texels
_SAMPLES = (0, 96, 192, 384, 768, 1024, 1024)
#: the largest half float, with room for filtering
_MAX_HALF = 65000.0


def bake_environment(
    radiance: Floats | EnvironmentAsset, size: int = SIZE, *, base: Path | None = None, smallest: int = SMALLEST
) -> tuple[TextureAsset, Floats]:
    """Bake f4[h,w,3] (equirectangular), f4[6,n,n,3] (cube faces) or an EnvironmentAsset.

    Returns an rgba16f cube of `size` with mips down to `smallest` texels (both powers of two), and SH9 of
    irradiance / pi, f4[9,3]. `base` is the folder that an image's path counts from. Raises InputError, FormatError.
    """
    if not 1 <= smallest <= size <= MAX_SIZE or size & (size - 1) or smallest & (smallest - 1):
        raise InputError(f"environment sizes {size} and {smallest} are no powers of two up to {MAX_SIZE}")
    if isinstance(radiance, EnvironmentAsset):
        radiance = source_faces(radiance, 2 * size, base or Path())
    if radiance.ndim == 3:
        radiance = from_equirect(radiance, 2 * size)
    if radiance.ndim != 4 or radiance.shape[0] != 6 or radiance.shape[3] != 3:
        raise InputError(f"radiance has shape {radiance.shape}, expected (h, w, 3) or (6, n, n, 3)")
    faces = _fit(np.maximum(np.nan_to_num(radiance, nan=0.0, posinf=_MAX_HALF), 0.0).astype(np.float32), 2 * size)
    sh9 = project_sh9(faces)
    source = CubeChain.build(np.minimum(faces, np.float32(_MAX_HALF)))
    mips = size.bit_length() - smallest.bit_length() + 1
    levels: list[list[bytes]] = [[] for _ in range(6)]
    for mip in range(mips):
        n = size >> mip
        rough = mip / (mips - 1) if mips > 1 else 0.0
        image = source.levels[1][:, 1:-1, 1:-1, :3] if mip == 0 else _prefilter(source, n, rough, _SAMPLES[min(mip, 6)])
        rgba = np.ones((6, n, n, 4), "<f2")
        rgba[..., :3] = np.minimum(image, np.float32(_MAX_HALF))
        for face in range(6):
            levels[face].append(rgba[face].tobytes())
    return TextureAsset("rgba16f", size, size, list(levels), cube=True), sh9


def _prefilter(source: CubeChain, size: int, roughness: float, samples: int) -> Floats:
    """f4[6,size,size,3]: the source seen in GGX of `roughness`, head-on."""
    local, weights, solid_angle = lobe(roughness, samples)
    base_texel = 4.0 * math.pi / (6.0 * (source.levels[0].shape[1] - 2) ** 2)
    # Whole levels: a sample's footprint is a guess anyway, and blending two levels takes twice the time.
    lods = np.round(0.5 * np.log2(np.maximum(solid_angle / base_texel, 1.0))).tolist()
    samples32 = list(zip(local.astype(np.float32), weights.astype(np.float32), lods, strict=True))

    def face(n: NDArray[np.float64]) -> Floats:
        tangent, bitangent = (v.astype(np.float32) for v in basis(n))
        normal = n.astype(np.float32)
        out = np.zeros((len(n), 3), np.float32)
        for (x, y, z), weight, lod in samples32:
            out += source.sample(tangent * x + bitangent * y + normal * z, lod) * weight
        return out

    # numpy lets go of the lock in its loops; a face's sum is always in the same order, whoever computes it.
    with ThreadPoolExecutor() as pool:
        return np.stack(list(pool.map(face, directions(size).reshape(6, -1, 3)))).reshape(6, size, size, 3)


def project_sh9(faces: Floats) -> Floats:
    """SH9 f4[9,3] of irradiance / pi of a cube f4[6,n,n,3]; a uniform cube of 1 gives (sqrt(4 pi), 0, …)."""
    n = faces.shape[1]
    weights = np.tile(cube_solid_angles(n).ravel(), 6)
    radiance = sh.project(faces.reshape(-1, 3), directions(n).reshape(-1, 3), weights)
    return (sh.irradiance_coefficients(radiance) / math.pi).astype(np.float32)


def _fit(faces: Floats, size: int) -> Floats:
    """Cube faces at `size`, by halving, or by repeating texels where they are coarser."""
    while faces.shape[1] > size and faces.shape[1] % 2 == 0:
        n = faces.shape[1] // 2
        faces = faces.reshape(6, n, 2, n, 2, 3).mean(axis=(2, 4), dtype=np.float32)
    n = faces.shape[1]
    if n != size:
        at = np.arange(size) * n // size
        faces = faces[:, at][:, :, at]
    return faces


def source_faces(environment: EnvironmentAsset, size: int, base: Path) -> Floats:
    """The radiance of an environment as cube faces f4[6,n,n,3], n = size where it is procedural."""
    if environment.kind == "image":
        from importers.textures.hdr import load_radiance  # only images need the decoders

        image = load_radiance(_image_path(environment, base))
        return image if image.ndim == 4 else from_equirect(image, size)
    d = directions(size).reshape(-1, 3)
    if environment.kind == "studio":
        light = procedural.studio(d)
    elif environment.kind == "sky":
        light = procedural.sky(d, environment)
    else:
        light = procedural.uniform(d, environment.color if environment.kind == "uniform" else (0.0, 0.0, 0.0))
    return light.astype(np.float32).reshape(6, size, size, 3)


def _image_path(environment: EnvironmentAsset, base: Path) -> Path:
    path = base / environment.path
    if not environment.path or not path.is_file():
        raise InputError("the environment's image is not there", where=path, hint="check environment.path in the scene")
    return path


def environment_file(environment: EnvironmentAsset, base: Path, *, size: int = 0) -> Path:
    """The baked `.dds` of an environment: shipped with us, already baked, or baked now into the user's cache.

    `base`: the folder that `environment.path` counts from. `size` 0 = 128, images 256. Intensity and rotation are
    applied when rendering and do not matter here. Raises InputError, FormatError, OutputError.
    """
    size = size or (2 * SIZE if environment.kind == "image" else SIZE)
    if environment.kind == "studio" and size <= 2 * SIZE:
        shipped = studio_path()
        if shipped.is_file():
            return shipped
    key: dict[str, object] = {"version": VERSION, "kind": environment.kind, "size": size}
    if environment.kind == "image":
        path = _image_path(environment, base)
        if path.suffix.lower() == ".dds" and _is_baked(path):
            return path
        try:
            key["source"] = hashlib.sha256(path.read_bytes()).hexdigest()
        except OSError as error:
            raise InputError(f"cannot read: {error.strerror or error}", where=path) from error
    elif environment.kind == "sky":
        for name in ("sun_elevation", "sun_azimuth", "sun_illuminance", "turbidity"):
            key[name] = float(getattr(environment, name))
    elif environment.kind == "uniform":
        key["color"] = [float(v) for v in environment.color]
    out = user_cache_dir() / "env" / f"{hashlib.sha256(compact_json(key).encode()).hexdigest()[:32]}.dds"
    if not _is_baked(out):
        texture, sh9 = bake_environment(environment, size, base=base)
        write_environment(out, texture, sh9)
    return out


def _is_baked(path: Path) -> bool:
    try:
        read_environment(path)
    except InputError:
        return False
    return True


def studio_path() -> Path:
    """The default studio, shipped pre-baked at 256 texels (BC6H); see shipped.py."""
    return shaders_dir() / "data" / "studio.env.dds"
