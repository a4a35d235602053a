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
from dataclasses import dataclass, field, replace
from pathlib import Path

from engine.assets.lanim import write_lanim
from engine.assets.lmesh import write_lmesh
from engine.assets.material_toml import write_material
from engine.assets.scene import SceneAsset
from engine.assets.scene_json import write_scene
from engine.core.atomic import atomic_path
from engine.core.errors import OutputError
from engine.core.findings import Findings
from importers.fingerprint import digest_file
from importers.gltf.variants import name_variants
from importers.model import ImportedModel, TextureUse
from importers.naming import UniqueNames, safe_name
from importers.processing import finish
from importers.registry import Importer, find_importer
from importers.settings import ImportSettings
from importers.texture_cache import TextureJob, write_textures
from importers.texture_settings import texture_settings

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
    timings: dict[str, float], progress: Progress | None = None, name: str = "",
) -> Path:  # fmt: skip
    """Write all files of `model` into `folder`; returns the scene's path there.

    Raises InputError where the source is gone, OutputError."""
    base = safe_name(name or source.stem)
    provenance = {
        "source": source.name.encode("utf-8", "replace").decode("utf-8"),
        # of the source alone: another texture leaves meshes and clips as they are
        "source_hash": digest_file(source),
        "importer": f"{importer.name} {importer.version}",
    }
    clock = time.perf_counter()
    finish(model, settings)
    timings["process"] = time.perf_counter() - clock
    clock = time.perf_counter()
    _write_lone(model, folder / f"{base}.dds")
    _write_textures(model, folder, base, settings, progress)
    timings["textures"] = time.perf_counter() - clock
    clock = time.perf_counter()
    files, names = [], UniqueNames()
    for material in model.materials:
        files.append(f"{names.take(f'{base}.{safe_name(material.asset.name)}')}.material.toml")
        write_material(folder / files[-1], material.asset)
    _write_profiles(model, folder, base)
    scene = SceneAsset(
        model.name, model.nodes, environment=model.environment, look=model.look,
        active_camera=model.active_camera, provenance=provenance,
    )  # fmt: skip
    for mesh in model.meshes:
        name_variants(mesh, files)
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
    jobs: list[TextureJob] = []
    shown: list[list[tuple[int, str]]] = []
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
        own, role = texture_settings(source, use.role, settings)
        job = TextureJob(replace(use, role=role), data, folder / file, source.path, wrap, settings=own)
        if own.roughness_from_normals and role == "metal_rough":
            job = replace(job, normal=_normal_map_over(model, slots[0][0]))
        jobs.append(job)
        shown.append(slots)
    written = write_textures(jobs, settings, model.findings, progress)
    for slots, path in zip(shown, written, strict=True):
        for m, slot in slots:
            model.materials[m].asset.textures[slot].path = path.name if path is not None else ""


def _write_lone(model: ImportedModel, path: Path) -> None:
    """The texture of a source that is an image, and who shows it."""
    if model.lone is None:
        return
    from engine.assets.dds import write_dds

    write_dds(path, model.lone.build())
    if model.lone.environment:
        model.environment.path = path.name
    for material in model.materials:
        material.asset.textures["base_color_map"].path = path.name


def _write_profiles(model: ImportedModel, folder: Path, base: str) -> None:
    """The light profiles, and the lights that name them."""
    names, files = UniqueNames(), {}
    for name, data in model.profiles.items():
        title = safe_name(name.removesuffix(".ies"))
        files[name] = f"{names.take(f'{base}.{title}')}.ies"
        with atomic_path(folder / files[name]) as temporary:
            temporary.write_bytes(data)
    for node in model.nodes:
        if node.light is not None and node.light.profile:
            node.light = replace(node.light, profile=files.get(node.light.profile, node.light.profile))


def _normal_map_over(model: ImportedModel, material: int) -> bytes | None:
    """The file of the material's normal map, where it lies on the mesh as its metal_rough map does."""
    asset, use = model.materials[material].asset, model.materials[material].images.get("normal_map")
    one, two = asset.textures.get("normal_map"), asset.textures.get("metal_rough_map")
    if use is None or one is None or two is None:
        return None
    same = (one.uv_set, one.offset, one.scale, one.rotation) == (two.uv_set, two.offset, two.scale, two.rotation)
    return model.images[use.image].data() if same else None


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
