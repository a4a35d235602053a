"""Small pictures of asset files, made in a worker process of their own: the window never waits for one.

    make({"path", "root"}) ─► key of all contents that the picture shows ─► <user cache>/thumbnails/<key>.png
        materials, effects   a sphere in the studio, by the renderer itself (engine.app.material_stage)
        models, scenes       imported as for opening, framed, drawn
        textures             decoded, shrunk in linear light
        environments         the panorama, exposed and tone-mapped

What cannot be shown raises a LucarnaError that says why.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import FormatError, InputError
from engine.core.findings import Finding, Severity
from engine.core.paths import shaders_dir, user_cache_dir

#: part of the key: raise it when pictures change
VERSION = "1"
#: width and height, pixels
SIZE = 192
#: a source that is larger is not imported for its picture's sake
MAX_SOURCE = 512 << 20
MODELS, MATERIALS, TEXTURES, ENVIRONMENTS, EFFECTS = "models", "materials", "textures", "environments", "effects"
ANIMATIONS, OTHER = "animations", "other"

_PLAIN = (0.022, 0.024, 0.028)
_IMAGES = (".png", ".jpg", ".jpeg", ".dds", ".ktx2", ".webp", ".tga", ".bmp", ".tif", ".tiff", ".psd", ".avif", ".gif")

_lowered_priority = False
#: (device, shader digest, runtime, stage) that draw materials: programs are compiled once
_bench: tuple[Any, str, Any, Any] | None = None


@lru_cache(maxsize=1 << 16)
def sort_of(name: str) -> str:
    """What a file is, by its name: MODELS, MATERIALS, TEXTURES, ENVIRONMENTS, EFFECTS, ANIMATIONS or OTHER."""
    lowered = name.lower()
    if lowered.endswith(".material.toml"):
        return MATERIALS
    if lowered.endswith(".effect.toml"):
        return EFFECTS
    if lowered.endswith((".lanim", ".animation.toml", ".mask.toml")):
        return ANIMATIONS
    if lowered.endswith((".hdr", ".exr", ".env.dds")):
        return ENVIRONMENTS
    if lowered.endswith(_IMAGES):
        return TEXTURES
    if lowered.endswith((".scene.json", ".lmesh")):
        return MODELS
    from importers.registry import source_extensions

    return MODELS if lowered.endswith(tuple(source_extensions())) else OTHER


def has_picture(name: str) -> bool:
    return sort_of(name) in (MODELS, MATERIALS, TEXTURES, ENVIRONMENTS, EFFECTS)


def make(request: dict[str, Any], progress: Callable[[str, float], None] | None = None) -> dict[str, Any]:
    """The task of the worker: {"path", "root" (of the project)} -> {"file": the PNG}. Raises LucarnaError."""
    global _lowered_priority
    if hasattr(os, "nice") and not _lowered_priority and request.get("background", True):
        os.nice(10)
        _lowered_priority = True
    path, root = Path(request["path"]), Path(request["root"])
    target = user_cache_dir() / "thumbnails" / f"{key_of(path, root)}.png"
    if target.is_file():
        try:
            os.utime(target)  # the least recently used may go first
        except OSError:
            return {"file": str(target)}
        return {"file": str(target)}
    from engine.report.image import save_png

    save_png(target, picture(path, root))
    return {"file": str(target)}


def key_of(path: Path, root: Path) -> str:
    """The digest of all that the picture of `path` shows. Raises InputError, FormatError where it cannot be read."""
    from importers.fingerprint import digest_of

    sort = sort_of(path.name)
    parts = [VERSION, str(SIZE), sort, path.name, *(f"{p.name} {_digest(p)}" for p in _contents(path, sort))]
    if sort in (MATERIALS, EFFECTS):
        parts.append(_shader_digest(root))
    elif sort == MODELS and not path.name.endswith((".scene.json", ".lmesh")):
        from importers.fingerprint import source_key
        from importers.registry import find_importer
        from importers.settings import ImportSettings

        if path.is_file() and path.stat().st_size > MAX_SOURCE:
            raise InputError("is too large for a thumbnail", where=path)
        parts.append(source_key(path, find_importer(path), ImportSettings()))
    return digest_of(*parts)


def picture(path: Path, root: Path) -> NDArray[np.uint8]:
    """u1[SIZE,SIZE,4] of a file, transparent beside what is not square. Raises LucarnaError."""
    sort = sort_of(path.name)
    if sort in (MATERIALS, EFFECTS):
        return _of_material(path, root)
    if sort == MODELS:
        return _of_model(path, root)
    if sort == ENVIRONMENTS:
        return _of_environment(path)
    if sort == TEXTURES:
        return _of_image(path)
    raise FormatError("has no picture", where=path)


# --- what is drawn ---


def _of_material(path: Path, root: Path) -> NDArray[np.uint8]:
    from engine.app.framing import frame_points
    from engine.assets.material import MaterialAsset

    device, runtime, stage = _material_bench(root)
    residency = runtime.residency
    if path.name.endswith(".effect.toml"):
        name = path.name.removesuffix(".effect.toml")
        material = residency.add_material(MaterialAsset(name, name), path.parent)
    else:
        from engine.assets.material_toml import read_material

        asset = read_material(path)  # not load_material: what is wrong is to be told, not drawn in magenta
        material = residency.add_material(asset, path.parent, str(path))
    device.begin_frame()
    sphere = stage.shape("sphere")
    stage.show(sphere, material)
    device.end_frame()
    stage.renderer.programs.errors.clear()
    points = np.asarray(residency.meshes[sphere[0].mesh].asset.streams["position"], np.float64)
    pixels = _drawn(stage.render, frame_points(points, 1.0, azimuth=25.0, elevation=14.0))
    for error in stage.renderer.programs.errors.values():
        raise error
    return pixels


def _material_bench(root: Path) -> tuple[Any, Any, Any]:
    """(device, runtime, stage) for the shaders of the project at `root` as they are now."""
    global _bench
    from engine.app.material_stage import MaterialStage
    from engine.app.project import shader_folders
    from engine.app.runtime import Runtime
    from engine.assets.scene import EnvironmentAsset, LookAsset, SceneAsset

    digest = f"{root} {_shader_digest(root)}"
    if _bench is not None and _bench[1] == digest:
        return _bench[0], _bench[2], _bench[3]
    device = _device()
    if _bench is not None:
        _bench[3].release()
        _bench[2].close()
        _bench = None
    around = EnvironmentAsset("studio", background="color", background_color=_PLAIN)
    runtime = Runtime(device, profile=False)
    runtime.load(SceneAsset("thumbnails", environment=around), root, shaders=shader_folders(root))
    stage = MaterialStage(runtime)
    stage.surround(around, LookAsset())
    _bench = (device, digest, runtime, stage)
    return device, runtime, stage


def _of_model(path: Path, root: Path) -> NDArray[np.uint8]:
    from engine.app.runtime import Runtime
    from importers.cache import scene_for
    from importers.opening import baker_for

    runtime = Runtime(_device(), profile=False)
    found: list[Finding] = []
    try:
        if path.name.endswith(".lmesh"):
            _load_meshes(runtime, path)
        else:
            scene, findings = scene_for(path)
            runtime.open(scene, baker=baker_for(scene.parent), root=root)
            found += [f for f in (*findings, *runtime.findings) if f.severity is Severity.ERROR]
        if not len(runtime.scene.instances.node):
            why = found[0].message if found else "there is no mesh in it"
            raise FormatError(f"shows nothing: {why}", where=path)
        runtime.scene.environment.background = "color"
        runtime.scene.environment.background_color = _PLAIN
        runtime.update(0.0)
        return _drawn(runtime.render, runtime.framing_camera(1.0))
    finally:
        runtime.close()


def _load_meshes(runtime: Any, path: Path) -> None:
    """All meshes of an .lmesh, in the default material."""
    from engine.assets.scene import EnvironmentAsset, SceneAsset

    runtime.load(SceneAsset(path.stem, environment=EnvironmentAsset("studio")), path.parent)
    rows = []
    for mesh in runtime.residency.load_mesh_file(path):
        node = runtime.scene.nodes.add("mesh")
        parts = len(runtime.residency.meshes[mesh].asset.submeshes)
        rows += [(node, mesh, part, runtime.residency.default_material) for part in range(parts)]
    runtime.add_instances(rows)


def _drawn(render: Callable[[Any], Any], camera: Any) -> NDArray[np.uint8]:
    from engine.render.settings import RenderSettings
    from engine.render.view import View

    frame = render(View(camera, SIZE, SIZE, RenderSettings(samples=4)))
    return np.asarray(frame.color.read(), np.uint8)


def _device() -> Any:
    """The device of this process, made once."""
    from engine.gpu import open_device

    if not _DEVICES:
        _DEVICES.append(open_device("gl"))
    return _DEVICES[0]


_DEVICES: list[Any] = []


# --- what is decoded ---


def _of_image(path: Path) -> NDArray[np.uint8]:
    from engine.assets.dds import read_dds
    from importers.textures.image import decode
    from importers.textures.pixels import rgba_pixels

    if path.suffix.lower() == ".dds":
        texture = read_dds(path)
        if texture.format.startswith("bc6h") or (len(texture.levels) == 6 and "f" in texture.format):
            return _of_environment(path)
        level = 0  # the smallest mip that is large enough
        while level + 1 < len(texture.levels[0]) and max(texture.width, texture.height) >> (level + 1) >= SIZE:
            level += 1
        pixels = rgba_pixels(texture, 0, level)
        if texture.format in ("bc5", "rg8") and pixels.dtype == np.uint8:
            xy = pixels[..., :2].astype(np.float64) / 127.5 - 1.0
            pixels[..., 2] = np.rint((np.sqrt(np.maximum(1.0 - (xy**2).sum(axis=2), 0.0)) + 1.0) * 127.5)
    else:
        from importers.settings import ImportSettings

        pixels = decode(path.read_bytes(), str(path), ImportSettings(), upright=True)
    if pixels.dtype == np.float32:
        return _exposed(pixels[..., :3])
    top = float(np.iinfo(pixels.dtype).max)
    return _fitted(pixels.astype(np.float32) / np.float32(top))


def _of_environment(path: Path) -> NDArray[np.uint8]:
    from importers.textures.hdr import load_radiance

    radiance = load_radiance(path)
    if radiance.ndim == 4:  # faces +x -x +y -y +z -z: the four about the horizon, left of the front to behind it
        radiance = np.concatenate([radiance[i] for i in (1, 4, 0, 5)], axis=1)
    return _exposed(radiance)


def _exposed(radiance: NDArray[np.float32]) -> NDArray[np.uint8]:
    """A linear picture with its middle at 18 % grey, under a simple shoulder (Reinhard 2002, equation 3)."""
    radiance = np.nan_to_num(np.maximum(_shrunk(radiance), 0.0), posinf=6e4)
    luminance = radiance @ np.array([0.2126, 0.7152, 0.0722], np.float32)
    middle = float(np.exp(np.log(luminance + 1e-4).mean()))
    value = radiance * (0.18 / max(middle, 1e-6))
    value = value / (1.0 + value)
    encoded = np.where(value <= 0.0031308, 12.92 * value, 1.055 * np.maximum(value, 1e-9) ** (1 / 2.4) - 0.055)
    rgba = np.concatenate([encoded, np.ones((*encoded.shape[:2], 1), np.float32)], axis=2).astype(np.float32)
    return _fitted(rgba, linear=False)


def _fitted(rgba: NDArray[np.float32], *, linear: bool = True) -> NDArray[np.uint8]:
    """sRGB-encoded f4[h,w,4] in 0..1 shrunk (in linear light) into a transparent square."""
    if linear:
        rgb = rgba[..., :3]
        rgba = np.concatenate(
            [np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4), rgba[..., 3:]], axis=2
        ).astype(np.float32)
        rgba = np.clip(_shrunk(rgba), 0.0, 1.0)
        rgb = rgba[..., :3]
        rgba[..., :3] = np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * np.maximum(rgb, 1e-9) ** (1 / 2.4) - 0.055)
    height, width = rgba.shape[:2]
    out = np.zeros((SIZE, SIZE, 4), np.uint8)
    y, x = (SIZE - height) // 2, (SIZE - width) // 2
    out[y : y + height, x : x + width] = np.rint(np.clip(rgba, 0.0, 1.0) * 255.0)
    return out


def _shrunk(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """`image` with its longer side SIZE; small ones are enlarged to whole multiples, texel by texel."""
    from importers.textures.mips import resample

    height, width = image.shape[:2]
    longer = max(height, width)
    if longer <= SIZE:
        times = SIZE // longer
        return np.repeat(np.repeat(image, times, axis=0), times, axis=1)
    skip = max(1, longer // (4 * SIZE))  # averages of so many texels first: cheap, and still four times too fine
    if skip > 1:
        image = image[: height // skip * skip, : width // skip * skip]
        image = image.reshape(height // skip, skip, width // skip, skip, -1).mean(axis=(1, 3))
    return resample(
        np.ascontiguousarray(image, np.float32),
        max(1, round(width * SIZE / longer)),
        max(1, round(height * SIZE / longer)),
    )


# --- keys ---


def _contents(path: Path, sort: str) -> list[Path]:
    """The files whose contents a picture shows: the file itself, and those that it names."""
    if sort == MATERIALS:
        from engine.assets.material_toml import read_material

        material = read_material(path)
        textures = [path.parent / ref.path for ref in material.textures.values() if ref.path]
        return [path, *material.files[1:], *textures]
    if path.name.endswith(".scene.json"):
        from engine.assets.scene_json import read_scene

        asset = read_scene(path)
        names = dict.fromkeys(f for n in asset.nodes if n.mesh for f in (n.mesh.file, *n.mesh.materials) if f)
        files = [path.parent / name for name in names]
        materials = [f for f in files if f.name.endswith(".material.toml") and f.is_file()]
        return [path, *files, *(g for f in materials for g in _contents(f, MATERIALS)[1:])]
    return [path]


def _digest(path: Path) -> str:
    from importers.fingerprint import digest_or_missing

    return digest_or_missing(path)


def _shader_digest(root: Path) -> str:
    """Of all effects and shaders that a material of the project can be drawn with."""
    from engine.app.project import shader_folders
    from importers.fingerprint import digest_of

    parts = []
    for folder in (*shader_folders(root), shaders_dir()):
        for name in ("effects", "lib", "passes"):
            for file in sorted((folder / name).glob("*")) if (folder / name).is_dir() else ():
                if file.suffix in (".glsl", ".vert", ".frag", ".comp", ".geom", ".tesc", ".tese", ".toml"):
                    parts.append(f"{file.name} {_digest(file)}")
    return digest_of(*parts)
