"""One source becomes our files: all of them appear in the output folder at the end, or none.

importer.load -> ImportedModel -> stage: textures (threads, cached by content) + .lmesh + .lanim + materials + scene
                                  -> each file is renamed into place
"""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from engine.assets.lanim import write_lanim
from engine.assets.lmesh import write_lmesh
from engine.assets.material_toml import write_material
from engine.assets.scene import SceneAsset
from engine.assets.scene_json import write_scene
from engine.core.errors import InputError, OutputError
from engine.core.findings import Findings
from importers.fingerprint import source_key
from importers.model import ImportedModel, TextureUse
from importers.naming import UniqueNames, safe_name
from importers.registry import Importer, find_importer
from importers.settings import ImportSettings
from importers.texture_cache import TextureJob, write_textures

Progress = Callable[[str, float], None]


@dataclass(slots=True)
class ConvertResult:
    """`scene`: the .scene.json (None where only a check was made); `outputs`: every file, sorted; `timings`: seconds
    by step."""

    scene: Path | None
    outputs: list[Path]
    findings: Findings
    timings: dict[str, float] = field(default_factory=dict)


def convert(
    source: Path, out: Path, settings: ImportSettings, progress: Progress | None = None, name: str = ""
) -> ConvertResult:
    """Write `source` as .scene.json, .lmesh, .lanim, .material.toml and .dds into the folder `out`.

    `name` begins every file's name (the source's stem unless given). The same source and settings give the same bytes.
    Raises InputError or FormatError where nothing can be imported and OutputError where the folder cannot be
    written: then no file is touched. `progress` gets (what is done, share from 0 to 1).
    """
    timings: dict[str, float] = {}
    clock = time.perf_counter()
    importer = find_importer(source)
    model = importer.load(source, settings)
    timings["read"] = time.perf_counter() - clock
    if progress:
        progress(f"read {source.name}", 0.2)
    out = Path(out)
    staging = _staging_folder(out)
    try:
        scene = stage(model, importer, source, staging, settings, timings, progress, name)
        clock = time.perf_counter()
        outputs = _publish(staging, out)
        timings["publish"] = time.perf_counter() - clock
    finally:
        shutil.rmtree(staging, ignore_errors=True)
    return ConvertResult(out / scene.name, outputs, model.findings, timings)


def stage(
    model: ImportedModel, importer: Importer, source: Path, folder: Path, settings: ImportSettings,
    timings: dict[str, float], progress: Progress | None = None, name: str = "", key: str = "",
) -> Path:  # fmt: skip
    """Write all files of `model` into `folder`; returns the scene's path there. `key`: the source's key, where known.

    Raises OutputError."""
    base = safe_name(name or source.stem)
    provenance = {
        "source": source.name.encode("utf-8", "replace").decode("utf-8"),
        "source_hash": key or source_key(source, importer, settings),
        "importer": f"{importer.name} {importer.version}",
    }
    clock = time.perf_counter()
    _write_textures(model, folder, base, settings, progress)
    timings["textures"] = time.perf_counter() - clock
    clock = time.perf_counter()
    files, names = [], UniqueNames()
    for material in model.materials:
        files.append(f"{names.take(f'{base}.{safe_name(material.asset.name)}')}.material.toml")
        write_material(folder / files[-1], material.asset)
    scene = SceneAsset(
        model.name, model.nodes, environment=model.environment, look=model.look,
        active_camera=model.active_camera, provenance=provenance,
    )  # fmt: skip
    if model.meshes:
        write_lmesh(folder / f"{base}.lmesh", model.meshes, provenance)
    for node in model.nodes:
        if node.mesh is not None:
            node.mesh.file = f"{base}.lmesh"
            node.mesh.materials = [files[i] if i >= 0 else "" for i in model.slots[node.mesh.index]]
    clip_names = UniqueNames()
    for clip in model.clips:
        file = f"{clip_names.take(f'{base}.{safe_name(clip.name)}')}.lanim"
        write_lanim(folder / file, clip, provenance)
        scene.clips.append(file)
    path = folder / f"{base}.scene.json"
    write_scene(path, scene)
    timings["write"] = time.perf_counter() - clock
    return path


def _write_textures(
    model: ImportedModel, folder: Path, base: str, settings: ImportSettings, progress: Progress | None
) -> None:
    """Encode every use of an image once and point the materials at the files; failures leave the path empty."""
    users: dict[TextureUse, list[tuple[int, str]]] = {}
    for m, material in enumerate(model.materials):
        for slot, use in sorted(material.images.items()):
            users.setdefault(use, []).append((m, slot))
    roles: dict[int, set[str]] = {}
    for use in users:
        roles.setdefault(use.image, set()).add(use.role)
    names = UniqueNames()
    jobs = []
    for use, slots in sorted(users.items(), key=lambda item: (item[0].image, item[0].role, item[1])):
        source = model.images[use.image]
        data = source.data()
        if data is None:
            continue
        if source.name:
            title = f"{source.name}.{use.role}" if len(roles[use.image]) > 1 else source.name
        else:
            first, slot = slots[0]
            title = f"{model.materials[first].asset.name}.{slot.removesuffix('_map')}"
        file = f"{names.take(f'{base}.{safe_name(title)}')}.dds"
        references = [model.materials[m].asset.textures[slot] for m, slot in slots]
        wrap = all(r.wrap_u == r.wrap_v == "repeat" for r in references)
        jobs.append(TextureJob(use, data, folder / file, source.path, wrap))
    written = write_textures(jobs, settings, model.findings, progress)
    for job, path in zip(jobs, written, strict=True):
        for m, slot in users[job.use]:
            model.materials[m].asset.textures[slot].path = path.name if path is not None else ""


def _staging_folder(out: Path) -> Path:
    """A new folder beside `out`, on the same file system. Raises OutputError."""
    try:
        if out.exists() and not out.is_dir():
            raise OutputError(
                "the output must be a folder; a file has that name", where=out, hint="choose another --out"
            )
        parent = out.resolve().parent
        parent.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(prefix=f".{out.name}.", suffix=".tmp", dir=parent))
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        hint = "choose a folder that you may write to"
        raise OutputError(f"cannot write there: {reason}", where=out, hint=hint) from error


def _publish(staging: Path, out: Path) -> list[Path]:
    """Move every staged file into `out`. All targets are checked first, so that a refusal leaves `out` as it was."""
    files = sorted(p for p in staging.rglob("*") if p.is_file())
    targets = [out / p.relative_to(staging) for p in files]
    try:
        out.mkdir(parents=True, exist_ok=True)
        if not os.access(out, os.W_OK | os.X_OK):
            raise OutputError("the folder cannot be written to", where=out, hint="choose another --out")
        for target in targets:
            if target.is_dir():
                raise OutputError("a folder has the name of an output file", where=target, hint="move it away")
        for file, target in zip(files, targets, strict=True):
            file.replace(target)
    except OSError as error:
        raise OutputError(
            f"cannot write: {error.strerror or error}", where=out, hint="check the free space and the rights"
        ) from error
    return targets


def sources_in(path: Path) -> list[Path]:
    """The importable files at `path`: itself, or all below it, sorted. Raises InputError where there are none."""
    from importers.registry import source_extensions

    if path.is_file():
        return [path]
    if not path.is_dir():
        if path.exists():
            raise InputError("is not a regular file", where=path, hint="pipes and devices are not read")
        from importers.gltf.uris import similar_name_hint

        raise InputError("there is no such file or folder", where=path, hint=similar_name_hint(path))
    known = source_extensions()
    found = sorted(p for p in path.rglob("*") if p.name.lower().endswith(known) and p.is_file())
    if not found:
        raise InputError("the folder holds no file that can be imported", where=path, hint=f"known: {', '.join(known)}")
    return found
