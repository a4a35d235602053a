"""Files, folders and globs -> jobs. The output mirrors the tree; no two jobs write the same file, also where letter
case is ignored."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from engine.core.errors import InputError, LucarnaError
from importers.farm.job import Job, Outcome
from importers.naming import safe_name
from importers.presets import Resolved, SettingsResolver
from importers.registry import IMAGES, source_extensions
from importers.settings import ImportSettings

#: folders that hold no sources
SKIPPED = {"__pycache__", "node_modules"}
_MAGIC = "*?["


@dataclass(slots=True)
class Plan:
    """`jobs` in a stable order; `refused`: outcomes of what cannot be tried; `folders`: those that were searched;
    `images`: those in folders with models, which are for the models to ask for."""

    jobs: list[Job] = field(default_factory=list)
    refused: list[Outcome] = field(default_factory=list)
    folders: list[Path] = field(default_factory=list)
    images: list[Path] = field(default_factory=list)


def make_plan(words: Sequence[str], out: Path, resolver: SettingsResolver) -> Plan:
    """Jobs for all sources that `words` name. A folder is searched (not into links to folders, hidden folders or
    `out`), and its inner structure kept; so is what a glob matches below its fixed part. Images of a folder are taken
    for parts of its models, and are sources of their own where it has none. Images that make one texture (the faces of
    a cube, the layers of an array) are one job.

    A word that names nothing, and a source whose sidecar is wrong, are in `refused`. Raises UsageError for an unknown
    preset."""
    plan = Plan()
    taken: dict[str, Path] = {}
    seen: set[str] = set()
    for word in words:
        try:
            found = _sources(word, out, plan)
        except InputError as error:  # the other words may be right
            plan.refused.append(refusal(Job(Path(word), out, ""), error))
            continue
        for root, source in found:
            identity = os.path.abspath(source)  # noqa: PTH100  (links stay what they are)
            if identity in seen:
                continue
            refused: InputError | None = None
            try:
                resolved = resolver.resolve(source)
            except InputError as error:
                resolved, refused = Resolved(ImportSettings(), {}), error
            parts = parts_of(source, resolved.settings)
            seen.update(os.path.abspath(part) for part in parts)  # noqa: PTH100  (as above)
            seen.add(identity)
            folder = out / source.parent.relative_to(root) if root is not None else out
            name = _free_name(source, stem_of(source, parts), folder, taken)
            if refused is not None:
                plan.refused.append(refusal(Job(source, folder, name), refused, "its settings cannot be read"))
                continue
            plan.jobs.append(Job(source, folder, name, resolved.settings, resolved.origins))
    return plan


def unasked_images(plan: Plan, outcomes: Iterable[Outcome]) -> list[Path]:
    """The images beside models that no source read, once all were looked at."""
    if not plan.images:
        return []
    read: set[str] = set()
    for outcome in outcomes:
        base = os.path.abspath(outcome.job.source.parent)  # noqa: PTH100  (texts, for speed)
        read.add(os.path.join(base, outcome.job.source.name))  # noqa: PTH118  (as above)
        read.update(os.path.normpath(os.path.join(base, name)) for name in outcome.inputs)  # noqa: PTH118  (as above)
    return [path for path in plan.images if os.path.abspath(path) not in read]  # noqa: PTH100  (as above)


def refusal(job: Job, error: LucarnaError, reason: str = "") -> Outcome:
    """The outcome of a job that ended with `error`; without a reason, one that nothing can be said to have changed."""
    text = str(error)
    if str(job.source) not in text:
        text = f"{job.source}: {text}"
    return Outcome(job, "failed", [reason] if reason else [], error=text, exit_code=error.exit_code)


def parts_of(source: Path, settings: ImportSettings) -> tuple[Path, ...]:
    """The images that become one texture with `source`, itself among them; none for other sources."""
    if not source.name.lower().endswith(IMAGES):
        return ()
    from importers.images.grouping import siblings_of

    return siblings_of(source, settings)


def _sources(word: str, out: Path, plan: Plan) -> list[tuple[Path | None, Path]]:
    """(root that the output mirrors, source) of one word of the command line."""
    path = Path(word)
    if any(c in word for c in _MAGIC) and not os.path.lexists(path):
        parts = path.parts
        fixed = next(i for i, part in enumerate(parts) if any(c in part for c in _MAGIC))
        root = Path(*parts[:fixed])
        matches = sorted(Path(p) for p in glob.glob(word, recursive=True))  # noqa: PTH207  (absolute patterns)
        found = [p for p in matches if p.is_file()]
        plan.folders.append(root)
        if not found:
            raise InputError("no file matches this pattern", where=word, hint="** stands for any number of folders")
        return [(root, p) for p in found if not _below(p, out)]
    # os.path: a name that no file can have, or that may not be looked at, is no file
    if os.path.isfile(path):  # noqa: PTH113  (as above)
        return [(None, path)]
    if not os.path.isdir(path):  # noqa: PTH112  (as above)
        if os.path.exists(path):  # noqa: PTH110  (as above)
            raise InputError("is not a regular file", where=path, hint="pipes and devices are not read")
        from importers.gltf.uris import similar_name_hint

        raise InputError("there is no such file or folder", where=path, hint=similar_name_hint(path))
    # images of a folder are parts of its models; where there is none, they are what it holds
    closed: dict[str, OSError] = {}
    models = source_extensions(in_folders=True)
    everything = sorted(_walk(path, out, (*models, *IMAGES), plan.folders, closed))
    images = [p for p in everything if not p.name.lower().endswith(models)]
    found = [p for p in everything if p.name.lower().endswith(models)]
    if found:
        plan.images += images
    else:
        found = images
    for place, error in sorted(closed.items()):
        reason = InputError(f"cannot search the folder: {error.strerror}", where=place, hint="check its rights")
        plan.refused.append(refusal(Job(Path(place), out, ""), reason))
    if not found and not closed:
        hint = f"known: {', '.join(source_extensions())}"
        raise InputError("the folder holds no file that can be imported", where=path, hint=hint)
    return [(path, p) for p in found]


def _walk(
    root: Path, out: Path, known: tuple[str, ...], folders: list[Path], closed: dict[str, OSError]
) -> Iterable[Path]:
    skipped = os.path.abspath(out)  # noqa: PTH100  (compared as text below)
    for base, inner, files in os.walk(root, onerror=lambda error: closed.update({str(error.filename): error})):
        folders.append(Path(base))
        # links to folders are not followed by os.walk: loops cannot happen
        inner[:] = sorted(
            n for n in inner
            if not n.startswith(".") and n not in SKIPPED and os.path.abspath(os.path.join(base, n)) != skipped  # noqa: PTH100, PTH118  (texts, for speed)
        )  # fmt: skip
        for name in files:
            if name.lower().endswith(known) and not name.startswith("."):
                path = Path(base, name)
                if path.is_file() or path.is_symlink():  # a dangling link is a source that cannot be read: say so
                    yield path


def _below(path: Path, folder: Path) -> bool:
    return path.absolute().is_relative_to(folder.absolute())


def stem_of(source: Path, parts: tuple[Path, ...]) -> str:
    """What the source's files are to be called: after the source, or what the images of one texture share."""
    if len(parts) > 1:
        from importers.images.grouping import common_name

        return common_name(source, parts)
    return source.name[: -len(source.suffix)] if source.suffix else source.name


def _free_name(source: Path, stem: str, folder: Path, taken: dict[str, Path]) -> str:
    """The name of the source's files: its stem, with the extension where that is taken, with a number at last.

    A name is taken too where the one is the other's beginning up to a dot: their files would have the same names."""
    base = safe_name(stem)
    extension = safe_name(source.suffix[1:].lower(), "file")
    place = os.path.abspath(folder).casefold() + os.sep  # noqa: PTH100  (only to tell folders apart)

    def clashes(name: str) -> bool:
        text = name.casefold()
        pieces = text.split(".")
        heads = [".".join(pieces[: i + 1]) for i in range(len(pieces))]
        return any(place + head in taken for head in heads) or place + text + "." in taken

    name, number = base, 1
    if clashes(name):
        name = base = f"{base.replace('.', '_')[:50]}_{extension}"
    while clashes(name):
        number += 1
        name = f"{base}_{number}"
    pieces = name.casefold().split(".")
    taken[place + name.casefold()] = source
    for i in range(1, len(pieces)):
        taken[place + ".".join(pieces[:i]) + "."] = source
    return name
