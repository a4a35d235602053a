"""A lone image as a source: `lucarna convert picture.psd --out DIR` writes picture.dds, and a scene that shows it.

A picture hangs on a card of its own shape, one metre high, without light; a panorama of radiance is the environment.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.mesh import MeshAsset, Submesh
from engine.assets.scene import EnvironmentAsset, MeshRef, NodeAsset
from engine.assets.texture import TextureAsset
from engine.core.findings import Findings
from importers.gltf.uris import read_regular_file, storable_text
from importers.images.grouping import Group, group_of, role_of
from importers.model import ImportedMaterial, ImportedModel, LoneTexture
from importers.settings import ImportSettings


def load(path: Path, settings: ImportSettings) -> ImportedModel:
    """Read an image, or the images that belong to it. Raises InputError, FormatError."""
    from importers.textures.image import probe

    findings = Findings(str(path))
    data = read_regular_file(path, settings.max_file_bytes)
    info = probe(data, str(path))
    floats = info.mode == "float" or info.mode.startswith("float")
    group = group_of(path, (info.width, info.height), floats, settings)
    if group.why:
        findings.info("image.kind", f"{group.kind}: {group.why}", hint="override it with --image-as")
    model = ImportedModel(storable_text(path.stem), findings)
    model.dependencies = [file for file in group.files if file != path]
    model.summary = {"format": info.format, "size": [info.width, info.height], "kind": group.kind}
    if group.kind == "environment":
        model.lone = LoneTexture(lambda: _environment(group, settings), environment=True)
        model.environment = EnvironmentAsset("image", background_blur=0.0)
        return model
    role, flip, why = role_of(path, settings)
    if why and not floats:
        findings.info("image.role", why, hint="override it with --role")
    model.lone = LoneTexture(lambda: _texture(group, role, flip, settings))
    if group.kind == "2d" and _is_flat(data, path.name):
        _card(model, info.width / max(info.height, 1))
    return model


def dependencies(path: Path, settings: ImportSettings) -> list[tuple[str, Path]]:
    """The other files of a cube or an array."""
    from importers.textures.image import probe

    info = probe(read_regular_file(path, settings.max_file_bytes), str(path))
    group = group_of(path, (info.width, info.height), info.mode.startswith("float"), settings)
    return [(file.name, file) for file in group.files if file != path]


def _is_flat(data: bytes, place: str) -> bool:
    """Whether it holds one picture: no cube, array or volume."""
    from engine.assets.dds import MAGIC, parse_dds
    from importers.textures import ktx2

    if ktx2.is_ktx2(data):
        header = ktx2.read_header(data, place)
        return header.faces * header.layers * header.depth == 1
    if data[:4] == MAGIC:
        texture = parse_dds(memoryview(data), place)
        return texture.layers * texture.depth == 1
    return True


def _texture(group: Group, role: str, flip: bool, settings: ImportSettings) -> TextureAsset:
    from importers.images.lone import build

    return build(group, role, flip, settings)


def _environment(group: Group, settings: ImportSettings) -> TextureAsset:
    """A prefiltered cube, as the renderer wants environments; its SH9 in the extras."""
    from engine.assets.environment_dds import with_sh9
    from engine.math.color import srgb_to_linear
    from importers.images.lone import read_pixels
    from importers.textures.environment import SIZE, bake_environment

    pixels = read_pixels(group.files[0], settings)
    if pixels.dtype.kind != "f":
        pixels = srgb_to_linear(pixels[..., :3] / float(np.iinfo(pixels.dtype).max)).astype(np.float32)
    return with_sh9(*bake_environment(pixels, 2 * SIZE))


def _card(model: ImportedModel, aspect: float) -> None:
    x = 0.5 * aspect
    corners = np.array([[-x, 0, 0], [x, 0, 0], [x, 1, 0], [-x, 1, 0]], "<f4")
    normal = np.tile(np.array([0, 0, 32767, 0], "<i2"), (4, 1))
    uv = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], "<f4")
    part = Submesh(0, 6, 0, "triangles", (-x, 0.0, 0.0), (x, 1.0, 0.0))
    indices = np.array([0, 1, 2, 0, 2, 3], "<u4")
    model.meshes = [MeshAsset("card", {"position": corners, "normal": normal, "uv0": uv}, indices, [part])]
    model.slots = [[0]]
    features = ["double_sided", "unlit"]
    asset = MaterialAsset("card", features=features)
    asset.textures["base_color_map"] = TextureRef("", "clamp", "clamp")
    model.materials = [ImportedMaterial(asset)]
    model.nodes = [NodeAsset(model.name, mesh=MeshRef("", 0, "card"))]
