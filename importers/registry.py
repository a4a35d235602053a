"""Which importer reads a file: by its extension, and where that says nothing, by its first bytes.

Adding a format is one `Importer` row here and a package of its own beside `gltf`; its module is imported when used.
Its settings are fields in importers/settings.py. What it must keep to:

    load(path, settings) -> ImportedModel            may run in a worker process: no state kept between files, no
                                                     writes outside user_cache_dir(), InputError or FormatError only
    dependencies(path, settings) -> [(name, path)]   every further file that the bytes depend on, also where it is
                                                     missing; without the work of loading

Files that are opened and folders that are listed meanwhile are noticed by the farm by itself (importers.farm.trace).
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from engine.core.errors import FormatError
from importers.fallback.formats import EXTENSIONS as OTHER_FORMATS
from importers.ogre.sniff import is_ogre

if TYPE_CHECKING:
    from importers.model import ImportedModel
    from importers.settings import ImportSettings


@dataclass(frozen=True, slots=True)
class Importer:
    """`module` has `load(path, settings) -> ImportedModel` and `dependencies(path, settings) -> [(uri, path)]`.

    `version` is part of every cache key: raise it whenever the same source would give other bytes. `in_folders`:
    whether folders are searched for such files; False for what is mostly a part of other sources (images), which is
    converted when it is named, or where a folder holds nothing else. `extra`: the optional extra whose absence the
    module reports.
    """

    name: str
    module: str
    extensions: tuple[str, ...]
    version: int
    sniff: Callable[[bytes], bool]
    in_folders: bool = True
    extra: str = ""

    def load(self, path: Path, settings: ImportSettings) -> ImportedModel:
        """Read the source. Raises InputError, FormatError; lesser faults are findings of the model."""
        model: ImportedModel = importlib.import_module(self.module).load(path, settings)
        if model.meshes and settings.clean_triangles:
            from importers.processing import clean

            clean(model, settings)
        from importers.adjusting import adjust, wanted

        if wanted(settings):
            adjust(model, settings)
        if model.materials and (settings.loose_textures or settings.materials or settings.textures):
            from importers.loose_textures import complete

            complete(model, path, settings)
        return model

    def dependencies(self, path: Path, settings: ImportSettings) -> list[tuple[str, Path]]:
        """(name in the source, file) of the files that the source reads besides itself."""
        found: list[tuple[str, Path]] = importlib.import_module(self.module).dependencies(path, settings)
        return found


def _is_gltf(head: bytes) -> bool:
    return head.startswith(b"glTF") or (head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{") and b'"asset"' in head)


def _is_fbx(head: bytes) -> bool:
    return head.startswith(b"Kaydara FBX Binary") or (head.lstrip().startswith(b";") and b"FBX" in head[:200])


IMAGES = (
    ".png", ".jpg", ".jpeg", ".tga", ".bmp", ".tif", ".tiff", ".webp", ".psd", ".psb", ".dds", ".ktx2", ".exr", ".hdr",
    ".avif", ".gif",
)  # fmt: skip


def _is_image(head: bytes) -> bool:
    starts = (b"\x89PNG", b"\xff\xd8\xff", b"8BPS", b"DDS ", b"\xabKTX 20", b"#?RADIANCE", b"\x76\x2f\x31\x01", b"BM")
    return head.startswith(starts) or (head.startswith(b"RIFF") and head[8:12] == b"WEBP")


IMPORTERS = (
    Importer("glTF", "importers.gltf.reader", (".gltf", ".glb"), 5, _is_gltf),
    Importer("FBX", "importers.fbx.reader", (".fbx",), 3, _is_fbx),
    Importer("image", "importers.images.reader", IMAGES, 1, _is_image, in_folders=False),
    Importer("Ogre", "importers.ogre.reader", (".mesh", ".mesh.xml"), 1, is_ogre),
    Importer("other", "importers.fallback.reader", OTHER_FORMATS, 1, lambda head: False),
)


#: what is read with something else, or was imported before
_PARTS = {
    ".skeleton": "a skeleton is read with the .mesh that names it", ".material": "it is read with a .mesh",
    ".skeleton.xml": "a skeleton is read with the .mesh.xml that names it", ".mtl": "it is read with its .obj",
    ".bin": "it is read with its .gltf", ".import": "these are the settings of the source beside it",
} | dict.fromkeys(
    (".scene.json", ".lmesh", ".lanim", ".material.toml", ".animation.toml", ".effect.toml"),
    "it is an engine file already: nothing to import",
)  # fmt: skip


def all_importers() -> tuple[Importer, ...]:
    """Our own, then those of plug-ins: theirs never read what ours do."""
    from importers.plugin_importers import plugin_importers

    return (*IMPORTERS, *plugin_importers())


def source_extensions(*, in_folders: bool = False) -> tuple[str, ...]:
    """All extensions that some importer reads, lower case; `in_folders`: those that folders are searched for."""
    return tuple(
        e for importer in all_importers() if importer.in_folders or not in_folders for e in importer.extensions
    )


def find_importer(path: Path) -> Importer:
    """The importer for `path`. Raises FormatError, naming what can be read, where there is none."""
    extension, name = path.suffix.lower(), path.name.lower()
    for importer in all_importers():
        if name.endswith(importer.extensions):
            return importer
    if path.is_file():
        with path.open("rb") as file:
            head = file.read(4096)
        for importer in all_importers():
            if importer.sniff(head):
                return importer
    what = extension or "files without an extension"
    hint = next((why for ending, why in _PARTS.items() if name.endswith(ending)), "")
    raise FormatError(f"no importer reads {what}", where=path, hint=hint or f"known: {', '.join(source_extensions())}")
