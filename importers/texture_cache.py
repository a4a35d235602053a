"""Textures of one conversion: decoded and encoded in threads, each content only once in a lifetime.

    image bytes + role + settings + encoder version -> key -> <user cache>/textures/<key>.dds, or encode and keep it

The encoders release Python's global lock, so threads suffice.
"""

from __future__ import annotations

import os
import shutil
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from engine.core.atomic import atomic_path
from engine.core.errors import InputError, LucarnaError, OutputError
from engine.core.findings import Findings
from engine.core.paths import user_cache_dir
from importers.fingerprint import digest_of
from importers.model import TextureUse
from importers.settings import ImportSettings
from importers.versions import ENCODER_VERSION

_DECODING = threading.Lock()


@dataclass(frozen=True, slots=True)
class TextureJob:
    """Encode the image file `data`, named at `place` in the source, for `use` into `target`.

    `wrap`: it repeats in both directions wherever it is used. `normal`: the image file of the normal map over it, where
    its bumps are to count. `settings`: where they differ from those of the other textures."""

    use: TextureUse
    data: bytes
    target: Path
    place: str
    wrap: bool = True
    normal: bytes | None = None
    settings: ImportSettings | None = None


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
        futures = [pool.submit(_write, job, job.settings or settings) for job in jobs]
        for number, (job, future) in enumerate(zip(jobs, futures, strict=True)):
            try:
                future.result()
                results.append(job.target)
            except InputError as error:
                findings.error(
                    "texture.image", f"the image cannot be used as {job.use.role}: {error.message}", job.place,
                    error.hint or "export the image again; it draws as magenta",
                )  # fmt: skip
                results.append(None)
            if progress:
                progress(f"texture {job.target.name}", 0.2 + 0.7 * (number + 1) / len(jobs))
    return results


def texture_key(job: TextureJob, settings: ImportSettings) -> str:
    """The content key of an encoded texture: the image's bytes, and all that changes how they are encoded."""
    use = f"{job.use.role} {job.use.alpha_cutoff} {job.wrap}"
    return digest_of(job.data, use, settings.key("textures"), ENCODER_VERSION, job.normal or b"")


def _write(job: TextureJob, settings: ImportSettings) -> None:
    kept = user_cache_dir() / "textures" / f"{texture_key(job, settings)}.dds"
    if settings.use_texture_cache and kept.is_file():
        try:
            shutil.copyfile(kept, job.target)
        except OSError as error:
            raise OutputError(f"cannot write: {error.strerror or error}", where=job.target) from error
        return
    from engine.assets.dds import write_dds
    from importers.textures.encode import encode
    from importers.textures.image import decode

    # Pillow's limits and warning filters are globals; and decoding holds Python's lock anyway
    with _DECODING:
        pixels = decode(job.data, job.place, settings)
        bumps = None if job.normal is None else decode(job.normal, job.place, settings)
    texture = encode(
        pixels,
        job.use.role,
        settings,
        alpha_cutoff=job.use.alpha_cutoff,
        wrap=job.wrap,
        threads=settings.jobs,
        bumps=bumps,
    )
    write_dds(job.target, texture)
    try:
        with atomic_path(kept) as temporary:
            shutil.copyfile(job.target, temporary)
    except LucarnaError:
        return  # the cache saves time only; a full or read-only disk must not stop an import
