"""What the texture viewer can look at, and its numbers: targets of the frame, textures of the materials, the tables and
surroundings that the renderer keeps, image files. No imgui."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from editor.picture_files import PictureFile, PictureFiles
from editor.texture_view import as_float, cross, linear
from engine.assets.texture import mip_extent
from engine.core.errors import InputError
from engine.framegraph.resources import texture_bytes
from engine.gpu.types import TextureDesc
from engine.render.peek import Peek

#: layer that stands for all faces of a cube
ALL_FACES = -1
FACES = ("+X", "-X", "+Y", "-Y", "+Z", "-Z")
KINDS = {"target": "Targets of the frame", "renderer": "Of the renderer", "material": "Materials", "file": "File"}


@dataclass(frozen=True, slots=True)
class Source:
    """Something to look at. `kind`: of KINDS; `name`: of a target or a renderer's texture, a slot, a file's path."""

    kind: str
    name: str
    material: int = -1
    label: str = ""
    note: str = ""
    samples: int = 1


@dataclass(frozen=True, slots=True)
class Level:
    """One image: `values` f4[h,w,c], scene-linear where `srgb` says that it is stored with a curve. `desc`: of the
    whole texture. `floating`: stored as floating point numbers; `depth`: a depth buffer."""

    values: NDArray[np.float32]
    desc: TextureDesc
    srgb: bool = False
    floating: bool = False
    depth: bool = False
    bytes: int = 0

    @property
    def layers(self) -> int:
        return 6 if self.desc.kind == "cube" else max(self.desc.layers, self.desc.depth)


def list_sources(session: Any, file: Path | None = None) -> list[Source]:
    """Everything that can be looked at now, kind by kind in the order of KINDS."""
    found: list[Source] = []
    frame = session.image.frame
    plan = getattr(getattr(frame, "graph", None), "plan", None)
    if plan is not None:
        for name, desc in plan.descs.items():
            note = f"{desc.format}, {desc.samples} samples" if desc.samples > 1 else desc.format
            found.append(Source("target", name, -1, name, note, desc.samples))
    document = session.document
    if document is None:
        return [*found, *([_file(file)] if file is not None else [])]
    renderer = getattr(document.runtime, "renderer", None)
    tables = renderer.tables() if renderer is not None and hasattr(renderer, "tables") else {}
    for name, texture in tables.items():
        found.append(Source("renderer", name, -1, name, texture.desc.format))
    materials = document.runtime.scene.instances.material
    for material in dict.fromkeys(int(m) for m in materials if m >= 0):
        record = document.runtime.residency.material(material)
        for slot in record.effect.textures:
            ref = record.asset.textures.get(slot.name)
            if ref is not None and ref.path:
                label = f"{record.asset.name or 'material'}: {slot.name.removesuffix('_map').replace('_', ' ')}"
                found.append(Source("material", slot.name, material, label, Path(ref.path).name))
    if file is not None:
        found.append(_file(file))
    return found


def _file(path: Path) -> Source:
    return Source("file", str(path), -1, path.name, str(path))


def read(session: Any, source: Source, level: int, layer: int, files: PictureFiles) -> Level | None:
    """The numbers of one image; None while they are on their way. `level` and `layer` are kept in range. Raises
    LucarnaError, KeyError, ValueError where they cannot be had. Between device frames."""
    if source.kind == "file":
        found = files.get(Path(source.name))
        return None if found is None else _level_of_file(session, found, level, layer)
    if source.samples > 1:
        raise InputError(
            f"{source.name} has {source.samples} samples a pixel",
            hint="set Samples to 1 in the render settings to see it",
        )
    if source.kind == "target":
        return _target(session, source, level, layer)
    if source.kind == "renderer":
        texture = session.document.runtime.renderer.tables()[source.name]
    else:
        texture, layer = session.document.runtime.residency.materials.slot_texture(source.material, source.name)
    with session.device_frame():
        return _of_texture(texture, level, int(layer))


def _target(session: Any, source: Source, level: int, layer: int) -> Level | None:
    """What a graph keeps is there after its frame; all else is read in the middle of the next one."""
    graph = session.image.frame.graph
    renderer = getattr(session.document.runtime, "renderer", None)
    if source.name not in graph.plan.slots or renderer is None:
        with session.device_frame():
            return _of_texture(graph.texture(source.name), level, layer)
    desc = graph.plan.descs[source.name]
    level, layer = min(level, desc.mips - 1), max(layer, 0)
    peek = renderer.peek
    if peek is None or (peek.resource, peek.level, peek.layer) != (source.name, level, layer):
        peek = renderer.peek = Peek(source.name, level, layer)
    pixels = peek.take()
    if pixels is None:
        session.image.invalidate()
        return None
    return _level(pixels, desc, level)


def _of_texture(texture: Any, level: int, layer: int) -> Level:
    desc = texture.desc
    level = min(level, desc.mips - 1)
    if desc.kind == "cube" and layer == ALL_FACES:
        faces = [_level(np.asarray(texture.read(level=level, layer=face)), desc, level) for face in range(6)]
        return Level(
            cross([f.values for f in faces]), desc, faces[0].srgb, faces[0].floating, faces[0].depth, faces[0].bytes
        )
    return _level(np.asarray(texture.read(level=level, layer=max(layer, 0))), desc, level)


def _level(pixels: NDArray[Any], desc: TextureDesc, level: int) -> Level:
    srgb, depth = desc.format.endswith("-srgb"), desc.format.startswith("d")
    values = as_float(pixels)
    floating = pixels.dtype.kind == "f" and not depth
    return Level(linear(values) if srgb else values, desc, srgb, floating, depth, texture_bytes(desc))


def _level_of_file(session: Any, found: PictureFile, level: int, layer: int) -> Level:
    if found.problem:
        raise InputError(found.problem)
    if found.asset is None:
        height, width, count = found.pixels.shape
        kind = "" if found.bits == 8 else f"{found.bits}"
        format = f"{'rgba'[:count]}{kind or 8}{'-srgb' if found.srgb else ''}" if found.bits < 32 else "rgb32f"
        desc = TextureDesc(format, width, height)
        values = linear(found.pixels) if found.srgb else found.pixels
        return Level(values, desc, found.srgb, found.bits == 32, False, height * width * count * found.bits // 8)
    asset = found.asset
    kind = "cube" if asset.cube else "3d" if asset.depth > 1 else "2d-array" if asset.layers > 1 else "2d"
    desc = TextureDesc(
        asset.format, asset.width, asset.height, kind, 1 if kind == "3d" else asset.layers, asset.depth, asset.mip_count
    )
    level = min(level, desc.mips - 1)
    images = range(6) if kind == "cube" and layer == ALL_FACES else [min(max(layer, 0), asset.layers - 1)]
    levels = [_level(_decoded(session, asset, image, level), desc, level) for image in images]
    values = cross([one.values for one in levels]) if len(levels) == 6 else levels[0].values
    return Level(values, desc, levels[0].srgb, levels[0].floating, False, asset.byte_size)


def _decoded(session: Any, asset: Any, image: int, level: int) -> NDArray[Any]:
    """Texels of a stored image (the first slice of a volume): the device unpacks blocks."""
    width, height = mip_extent(asset.width, level), mip_extent(asset.height, level)
    data = asset.levels[image][level]
    with session.device_frame():
        texture = session.device.texture(TextureDesc(asset.format, width, height, label="picture of a file"))
        try:
            texture.write(bytes(data)[: texture_bytes(texture.desc)])
            return np.array(texture.read())
        finally:
            texture.release()
