"""Textures of one conversion: decoded and encoded in threads, each content only once in a lifetime.

    image bytes + role + settings + encoder version -> key -> <user cache>/textures/<key>.dds, or encode and keep it

The encoders release Python's global lock, so threads suffice.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from engine.core.atomic import atomic_path
from engine.core.errors import InputError, LucarnaError, OutputError
from engine.core.findings import Findings
from engine.core.paths import user_cache_dir
from importers.fingerprint import digest_of
from importers.settings import ImportSettings


@dataclass(frozen=True, slots=True)
class TextureJob:
    """Encode image number `image`, whose file holds `data`, as `role` into `target`. `place`: where it is named."""

    image: int
    role: str
    data: bytes
    target: Path
    place: str


def write_textures(
    jobs: list[TextureJob], settings: ImportSettings, findings: Findings,
    progress: Callable[[str, float], None] | None = None,
) -> list[Path | None]:  # fmt: skip
    """The written files, in the order of `jobs`; None (with a finding) where an image cannot be decoded.

    Raises OutputError where a file cannot be written.
    """
    results: list[Path | None] = []
    workers = settings.jobs or min(len(jobs), os.cpu_count() or 1)
    with ThreadPoolExecutor(max(workers, 1)) as pool:
        futures = [pool.submit(_write, job, settings) for job in jobs]
        for number, (job, future) in enumerate(zip(jobs, futures, strict=True)):
            try:
                future.result()
                results.append(job.target)
            except InputError as error:
                findings.error(
                    "texture.image", f"the image cannot be used as {job.role}: {error.message}", job.place,
                    error.hint or "export the image again; it draws as magenta",
                )  # fmt: skip
                results.append(None)
            if progress:
                progress(f"texture {job.target.name}", 0.2 + 0.7 * (number + 1) / len(jobs))
    return results


def texture_key(data: bytes, role: str, settings: ImportSettings) -> str:
    """The content key of an encoded texture."""
    from importers.textures.encode import ENCODER_VERSION

    return digest_of(data, role, settings.key(), str(ENCODER_VERSION))


def _provisional(data: bytes, role: str) -> object:  # TEMPORARY until importers.textures.encode is there
    import io

    from PIL import Image

    from engine.assets.texture import TextureAsset

    im = Image.open(io.BytesIO(data)).convert("RGBA")
    levels = [im.tobytes()]
    w, h = im.size
    while w > 1 or h > 1:
        w, h = max(1, w // 2), max(1, h // 2)
        im = im.resize((w, h), Image.Resampling.BOX)
        levels.append(im.tobytes())
    w, h = Image.open(io.BytesIO(data)).size
    return TextureAsset("rgba8-srgb" if role == "color" else "rgba8", w, h, [levels])


def _write(job: TextureJob, settings: ImportSettings) -> None:
    import importlib.util

    if importlib.util.find_spec("importers.textures.encode") is None:  # TEMPORARY
        from engine.assets.dds import write_dds

        write_dds(job.target, _provisional(job.data, job.role))  # type: ignore[arg-type]  # TEMPORARY
        return
    kept = user_cache_dir() / "textures" / f"{texture_key(job.data, job.role, settings)}.dds"
    if settings.use_texture_cache and kept.is_file():
        try:
            shutil.copyfile(kept, job.target)
        except OSError as error:
            raise OutputError(f"cannot write: {error.strerror or error}", where=job.target) from error
        return
    from engine.assets.dds import write_dds
    from importers.textures.encode import encode
    from importers.textures.image import decode

    texture = encode(decode(job.data, job.place, settings), job.role, settings)
    write_dds(job.target, texture)
    try:
        with atomic_path(kept) as temporary:
            shutil.copyfile(job.target, temporary)
    except LucarnaError:
        return  # the cache saves time only; a full or read-only disk must not stop an import
