"""Any other format -> ImportedModel: a worker reads it by Assimp or trimesh, the rest is the same as for FBX."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import importlib.metadata
import importlib.util
import json
import math
from pathlib import Path
from typing import Any

from engine.assets.scene import NodeAsset
from engine.core.atomic import write_text
from engine.core.errors import FormatError, InputError, LucarnaError, Place
from engine.core.findings import Findings
from engine.core.paths import user_cache_dir
from importers.fallback import formats, library
from importers.fbx.document import FbxDocument
from importers.fbx.reader import ModelBuilder, content_digest
from importers.fbx.texture_files import TextureFinder
from importers.model import ImportedModel
from importers.settings import ImportSettings
from importers.workers.process import WorkerLimits
from importers.workers.runner import WorkerResult, run_in_worker

_SECOND_OPINION = 20.0
#: the digest, reader and result of the file read last, while nothing has used it
_recent: list[tuple[str, WorkerResult]] = []


def load(path: Path, settings: ImportSettings) -> ImportedModel:
    """Read the file whole. Raises InputError or FormatError where nothing can be had from it; everything less is a
    finding of the model, and the rest is imported."""
    findings = Findings(str(path))
    result, reader, refusal = _read(path, settings)
    if refusal:
        findings.warn("assimp.refused", f"{refusal}; read by trimesh instead", hint="skins and clips are left out")
    try:
        doc = FbxDocument(result, findings)
        model = ModelBuilder(doc, path, settings).build()
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise FormatError(
            f"the scene that was read makes no sense ({type(error).__name__}: {error})", where=path,
            hint="export it again; please report this file",
        ) from error  # fmt: skip
    except LucarnaError as error:
        if not error.where.file:
            error.where = Place(str(path), path=error.where.path)
        raise
    # the builder is FBX's, its findings are this reader's
    findings.items[:] = [dataclasses.replace(f, code=f.code.replace("fbx.", f"{reader}.", 1)) for f in findings.items]
    _orient(model, path, settings)
    counts = model.summary["counts"]
    model.summary = {"format": path.suffix[1:].upper(), "generator": result.data["creator"], "counts": counts}
    return model


def dependencies(path: Path, settings: ImportSettings) -> list[tuple[str, Path]]:
    """(name, file) of every texture and side file that the source names, found or not, and of Assimp's own library:
    another build may read the same file differently."""
    names = _names(path, settings)
    finder = TextureFinder(path, settings.allow_outside)
    found: list[tuple[str, Path]] = []
    for name in names["textures"]:
        search = finder.find([name])
        found.append((name, search.path or path.parent / Path(name.replace("\\", "/")).name))
    found += [(name, path.parent / name) for name in names["side_files"]]
    if names["reader"] == "assimp":
        found.append(("(Assimp's library)", Path(library.find_library())))
    else:
        # a name that no file has: only the text of it counts
        found.append((f"(trimesh {importlib.metadata.version('trimesh')})", path.parent / "."))
    return found


def _orient(model: ImportedModel, path: Path, settings: ImportSettings) -> None:
    """Unit and up axis, where the settings give them: a node above all others."""
    unit, up = settings.source_unit or 1.0, settings.source_up
    if path.suffix.lower() in formats.COMPLETE:
        return
    if unit == 1.0 and up in ("auto", "y"):
        if path.suffix.lower() in formats.UNITLESS:
            model.findings.info(
                "source.units", "the format has no unit and no up axis: taken as metres and +Y up", "",
                "set source_unit and source_up where they are others",
            )  # fmt: skip
        return
    half = math.sqrt(0.5)
    rotation = (-half, 0.0, 0.0, half) if up == "z" else (0.0, 0.0, 0.0, 1.0)
    for node in model.nodes:
        node.parent += 1
        node.joints = [joint + 1 for joint in node.joints]
    for clip in model.clips:
        for channel in clip.channels:
            channel.node += 1
    if model.active_camera >= 0:
        model.active_camera += 1
    model.nodes.insert(0, NodeAsset("source_axes", -1, (0.0, 0.0, 0.0), rotation, (unit, unit, unit)))


# --- the worker, asked once for both questions ---


def _read(path: Path, settings: ImportSettings) -> tuple[WorkerResult, str, str]:
    """What the worker makes of the file, who read it, and why Assimp did not, where it was asked first."""
    digest = content_digest(path, settings)
    kept = [
        result for known, result in _recent
        if known == f"{digest} {path}" and _unchanged(path, result.data["side_files"])
    ]  # fmt: skip
    _recent.clear()
    if kept:
        return kept[0], str(kept[0].data["reader"]), str(kept[0].data["refusal"])
    suffix = path.suffix.lower()
    with_trimesh = suffix in formats.TRIMESH and importlib.util.find_spec("trimesh") is not None
    if suffix == ".dae" and importlib.util.find_spec("collada") is None:
        with_trimesh = False
    request: dict[str, Any] = {
        "path": str(path.resolve()),
        "crease": math.radians(formats.CREASE_DEGREES),
        "srgb_colors": suffix in formats.SRGB_COLORS,
        "outside": settings.allow_outside,
        "max_bytes": settings.max_file_bytes,
    }
    limits = WorkerLimits(settings.max_worker_seconds, settings.max_worker_bytes)
    refusal = ""
    if library.available():
        request["library"] = library.find_library()
        try:
            result = run_in_worker("importers.fallback.assimp_extract:extract", request, path, limits, "Assimp")
            return _noted(result, "assimp", "", digest, path), "assimp", ""
        except FormatError as error:
            if not with_trimesh:
                raise
            refusal = error.message
    elif not with_trimesh:
        hint = library.HINT if suffix != ".dae" else f"pip install lucarna[collada], or {library.HINT}"
        raise InputError(f"{suffix} files are read by Assimp, which is not installed", where=path, hint=hint)
    if refusal:  # a second opinion must not take long: trimesh waits for the end of some damaged files for ever
        limits = WorkerLimits(min(limits.seconds, _SECOND_OPINION), limits.memory_bytes)
    try:
        result = run_in_worker("importers.fallback.trimesh_extract:extract", request, path, limits, "trimesh")
    except FormatError:
        if not refusal:
            raise
        result = WorkerResult({"meshes": []}, {})
    # nothing is no second opinion
    if refusal and not any(len(result.arrays[mesh["triangles"]]) for mesh in result.data["meshes"]):
        raise FormatError(refusal, where=path, hint="export it again")
    return _noted(result, "trimesh", refusal, digest, path), "trimesh", refusal


def _noted(result: WorkerResult, reader: str, refusal: str, digest: str, path: Path) -> WorkerResult:
    """The result, with what `dependencies` asks for written down; only saves time."""
    result.data["reader"], result.data["refusal"] = reader, refusal
    names = [str(t["files"][0]) for t in result.data["textures"] if t["files"][0]]
    memo = {"reader": reader, "textures": sorted(set(names)), "side_files": result.data["side_files"]}
    with contextlib.suppress(LucarnaError):
        write_text(_memo(digest), json.dumps(memo, sort_keys=True))
    return result


def _names(path: Path, settings: ImportSettings) -> dict[str, Any]:
    """{"reader", "textures": [names], "side_files": {name: digest}}; remembered by the bytes of all files read."""
    digest = content_digest(path, settings)
    try:
        known: dict[str, Any] = json.loads(_memo(digest).read_text(encoding="utf-8"))
        same_reader = known["reader"] == "assimp" or not library.available()
        if same_reader and _unchanged(path, known["side_files"]):
            return known
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass
    result, _, _ = _read(path, settings)
    # whoever asks for the dependencies mostly loads the file next
    _recent[:] = [(f"{digest} {path}", result)]
    names = [str(t["files"][0]) for t in result.data["textures"] if t["files"][0]]
    reader, side_files = result.data["reader"], result.data["side_files"]
    return {"reader": reader, "textures": sorted(set(names)), "side_files": side_files}


def _unchanged(path: Path, side_files: dict[str, str]) -> bool:
    return all(_digest(path.parent / name) == digest for name, digest in side_files.items())


def _digest(path: Path) -> str:
    try:
        # a pipe would be waited for
        return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest() if path.is_file() else ""
    except (OSError, ValueError):
        return ""


def _memo(digest: str) -> Path:
    return user_cache_dir() / "other_names" / f"{digest}.json"
