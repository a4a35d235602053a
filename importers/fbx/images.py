"""The images that materials show: embedded or found, and those that must be put together from several."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Callable, Hashable
from pathlib import Path, PurePosixPath

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from importers.fbx.document import FbxDocument
from importers.fbx.texture_files import Search, TextureFinder
from importers.gltf.uris import read_regular_file
from importers.model import SourceImage
from importers.settings import ImportSettings

Pixels = NDArray[np.uint8]


class Images:
    """Collects the images of one source, each once; `files`: what was found, for `dependencies`."""

    def __init__(self, doc: FbxDocument, source: Path, settings: ImportSettings) -> None:
        self.images: list[SourceImage] = []
        self.files: list[Path] = []
        self._doc = doc
        self._settings = settings
        self._finder = TextureFinder(source, settings.allow_outside)
        self._known: dict[Hashable, int] = {}

    def plain(self, texture: int) -> int:
        """The image of a file texture as it is; -1 (with a finding, once) where there is none."""
        entry = self._doc.textures[texture]
        content = str(entry["content"])
        names = [str(name) for name in entry["files"]]
        key: Hashable = ("file", *names)
        if content:
            key = ("content", hashlib.blake2b(self._doc.bytes_of(content), digest_size=16).digest())
        if key not in self._known:
            data = self._source(texture)
            if data is None:
                self._known[key] = -1
            else:
                name = PurePosixPath(next((n for n in names if n), "").replace("\\", "/")).stem or str(entry["name"])
                self._known[key] = self._add(name, data, f"textures[{entry['name'] or texture}]")
        return self._known[key]

    def find(self, names: list[str]) -> Search:
        """A file beside the source, by the names it goes by in there."""
        return self._finder.find(names)

    def packed(self, kind: str, inputs: tuple[int, ...], pack: Callable[..., Pixels]) -> int:
        """An image made by `pack` from the pixels u1[h,w,4] of `inputs` (image numbers, -1: None is given)."""
        key = (kind, *inputs)
        if key not in self._known:
            sources = [self.images[i] if i >= 0 else None for i in inputs]
            title = "_".join(dict.fromkeys(s.name for s in sources if s is not None))

            def fetch() -> bytes | None:
                return self._packed(sources, pack)

            self._known[key] = self._add(title, fetch, f"{kind} of {title}")
        return self._known[key]

    def _add(self, name: str, data: Callable[[], bytes | None], path: str) -> int:
        self.images.append(SourceImage(name, data, path))
        return len(self.images) - 1

    def _source(self, texture: int) -> Callable[[], bytes | None] | None:
        entry, doc = self._doc.textures[texture], self._doc
        where = f"textures[{entry['name'] or texture}]"
        if entry["content"]:
            content = str(entry["content"])
            return lambda: doc.bytes_of(content)
        search = self._finder.find([str(name) for name in entry["files"]])
        if search.path is None:
            given = next((str(name) for name in entry["files"] if name), "")
            _report(doc, given, search, where)
            return None
        path = search.path
        self.files.append(path)

        def read() -> bytes | None:
            try:
                return read_regular_file(path, self._settings.max_file_bytes)
            except InputError as error:
                doc.findings.error("fbx.texture", f"{path.name}: {error.message}", where, error.hint)
                return None

        return read

    def _packed(self, sources: list[SourceImage | None], pack: Callable[..., Pixels]) -> bytes | None:
        from PIL import Image

        from importers.textures.image import decode

        pixels: list[Pixels | None] = []
        for source in sources:
            data = source.data() if source is not None else None
            if source is None or data is None:
                pixels.append(None)
                continue
            try:
                pixels.append(_bytes(decode(data, source.path, self._settings)))
            except InputError as error:
                self._doc.findings.error("fbx.texture", f"cannot be used: {error.message}", source.path, error.hint)
                pixels.append(None)
        if all(p is None for p in pixels):
            return None
        size = max((p.shape[1], p.shape[0]) for p in pixels if p is not None)
        fitted = [None if p is None else _resized(p, size) for p in pixels]
        out = io.BytesIO()
        Image.fromarray(pack(*fitted)).save(out, "PNG", compress_level=1)
        return out.getvalue()


def metal_rough(roughness: Pixels | None, metallic: Pixels | None) -> Pixels:
    """G roughness, B metallic, from grey maps; a missing one is white, for the parameter to scale."""
    return _join(1.0, roughness, metallic)


def metal_gloss(glossiness: Pixels | None, metallic: Pixels | None) -> Pixels:
    """As `metal_rough`, from glossiness = 1 - roughness."""
    return _join(-1.0, glossiness, metallic)


def color_with_alpha(color: Pixels | None, opacity: Pixels | None) -> Pixels:
    """The colour with the opacity map's brightness as its alpha."""
    return _with_alpha(color, opacity, False)


def color_without(color: Pixels | None, transparency: Pixels | None) -> Pixels:
    """The colour with the transparency map's darkness as its alpha."""
    return _with_alpha(color, transparency, True)


def _join(sign: float, first: Pixels | None, metallic: Pixels | None) -> Pixels:
    known = first if first is not None else metallic
    assert known is not None
    out = np.full((*known.shape[:2], 4), 255, np.uint8)
    if first is not None:
        out[..., 1] = first[..., 0] if sign > 0 else 255 - first[..., 0]
    if metallic is not None:
        out[..., 2] = metallic[..., 0]
    return out


def _with_alpha(color: Pixels | None, mask: Pixels | None, inverted: bool) -> Pixels:
    known = color if color is not None else mask
    assert known is not None
    out = np.full((*known.shape[:2], 4), 255, np.uint8)
    if color is not None:
        out[..., :3] = color[..., :3]
    if mask is not None:
        # a mask with alpha of its own holds it there
        grey = mask[..., 3] if (mask[..., 3] < 255).any() else mask[..., :3].astype(np.uint16).mean(axis=2)
        out[..., 3] = 255 - grey if inverted else grey
    return out


def _bytes(pixels: NDArray[np.generic]) -> Pixels:
    if pixels.dtype == np.uint16:
        return (pixels.astype(np.uint32) // 257).astype(np.uint8)
    if pixels.dtype == np.uint8:
        return np.asarray(pixels, np.uint8)
    out = np.full((*pixels.shape[:2], 4), 255, np.uint8)
    out[..., :3] = np.clip(np.asarray(pixels, np.float32)[..., :3] * 255.0 + 0.5, 0, 255).astype(np.uint8)
    return out


def _resized(pixels: Pixels, size: tuple[int, int]) -> Pixels:
    from PIL import Image

    if (pixels.shape[1], pixels.shape[0]) == size:
        return pixels
    return np.asarray(Image.fromarray(pixels).resize(size, Image.Resampling.BILINEAR), np.uint8)


def _report(doc: FbxDocument, given: str, search: Search, where: str) -> None:
    tried = ", ".join(repr(name) for name in search.tried[:4]) or "no name"
    hint = f"did you mean {search.similar[0]!r}?" if search.similar else "put the file beside the source"
    if len(search.similar) > 1:
        hint = f"did you mean one of {', '.join(map(repr, search.similar))}?"
    doc.findings.error(
        "fbx.texture", f"the image {given!r} is not found; tried {tried}; drawn as magenta", where, hint
    )  # fmt: skip
