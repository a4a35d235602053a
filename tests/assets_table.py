"""What is in every real file: `python -m tests.assets_table [FOLDER] [--only TEXT] [--markdown]`.

Each file is read by our importer and, where there is one, by an independent reader of the same format:

    FBX, glTF, .mesh.xml   Assimp        OBJ, STL, PLY, OFF, DAE   trimesh        .mesh   OgreXMLConverter's XML

Where the two disagree, the line says why, as far as a rule below knows; `?` where none does. Exit code 1 where a file
fails without saying why, or a difference has no explanation.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from engine.core.errors import LucarnaError
from importers.fallback import formats, library
from importers.model import ImportedModel
from importers.registry import find_importer, source_extensions
from importers.settings import ImportSettings
from importers.workers.process import WorkerLimits
from importers.workers.runner import run_in_worker

SETTINGS = ImportSettings(max_worker_seconds=60.0)


@dataclass(slots=True)
class Counts:
    """What one reader found; -1 where it cannot say."""

    vertices: int = -1
    triangles: int = -1
    joints: int = -1
    clips: int = -1
    durations: list[float] = field(default_factory=list)
    materials: int = -1
    textures: int = -1
    ms: float = 0.0
    error: str = ""


@dataclass(slots=True)
class Line:
    """One file: ours, the other's (None: there is no other reader), and what is said of their differences."""

    path: Path
    ours: Counts
    other: Counts | None
    notes: list[str]


def rows(folder: Path, only: str = "") -> Iterator[Line]:
    """All sources below `folder`, sorted."""
    known = source_extensions(in_folders=True)
    for path in sorted(p for p in folder.rglob("*") if p.name.lower().endswith(known) and p.is_file()):
        if only in str(path):
            yield row(path)


def row(path: Path) -> Line:
    model: ImportedModel | None = None
    clock = time.perf_counter()
    try:
        model = find_importer(path).load(path, SETTINGS)
        ours = _ours(model)
    except LucarnaError as error:
        ours = Counts(error=error.message)
    ours.ms = 1000.0 * (time.perf_counter() - clock)
    other = _other(path)
    return Line(path, ours, other, _notes(path, ours, other, model))


def _ours(model: ImportedModel) -> Counts:
    triangles = sum(
        part.index_count // 3 for mesh in model.meshes for part in mesh.submeshes if part.topology == "triangles"
    )
    joints = {joint for node in model.nodes for joint in node.joints}
    lengths = [max((float(c.times[-1]) for c in clip.channels if len(c.times)), default=0.0) for clip in model.clips]
    return Counts(
        sum(mesh.vertex_count for mesh in model.meshes), triangles, len(joints), len(model.clips), lengths,
        len(model.materials), len(model.images),
    )  # fmt: skip


def _other(path: Path) -> Counts | None:
    name = path.name.lower()
    if name.endswith(".mesh"):
        return _converter(path) if shutil.which("OgreXMLConverter") else None
    task = "assimp"
    if name.endswith(formats.TRIMESH):
        task = "trimesh"
    elif not library.available():
        return None
    request: dict[str, Any] = {
        "path": str(path.resolve()), "library": library.find_library(), "crease": 0.0, "srgb_colors": False,
        "outside": False, "max_bytes": SETTINGS.max_file_bytes,
    }  # fmt: skip
    try:
        result = run_in_worker(
            f"importers.fallback.{task}_extract:extract", request, path, WorkerLimits(60.0, 4 << 30), task
        )
    except LucarnaError as error:
        return Counts(error=error.message)
    data = result.data
    triangles = sum(len(result.arrays[mesh["triangles"]]) for mesh in data["meshes"])
    joints = {bone for mesh in data["meshes"] for skin in mesh["skins"] for bone in skin["bones"]}
    clips = [stack["end"] - stack["begin"] for stack in data["stacks"]]
    points = sum(len(result.arrays[mesh["positions"]]) for mesh in data["meshes"])
    return Counts(points, triangles, len(joints), len(clips), clips, len(data["materials"]), len(data["textures"]))


def _converter(path: Path) -> Counts:
    """Counts of the XML that OgreXMLConverter writes."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.mesh.xml"
        command = ["OgreXMLConverter", "-q", "-log", str(Path(folder) / "log"), str(path), str(out)]
        try:
            done = subprocess.run(command, capture_output=True, timeout=60, check=False, cwd=folder)
        except subprocess.TimeoutExpired:
            return Counts(error="OgreXMLConverter did not finish")
        if not out.is_file():
            return Counts(error=f"OgreXMLConverter ended with {done.returncode}")
        root = ElementTree.parse(out).getroot()
    triangles = 0
    for part in root.iter("submesh"):
        kind, faces = part.get("operationtype", "triangle_list"), part.find("faces")
        listed = [] if faces is None else list(faces)
        if kind == "triangle_list":
            triangles += len(listed)
        elif kind in ("triangle_strip", "triangle_fan") and listed:
            # the first face has three corners, each further one adds one
            triangles += len(listed)
    vertices = sum(int(g.get("vertexcount", "0")) for g in (*root.iter("geometry"), *root.iter("sharedgeometry")))
    return Counts(vertices, triangles)


def _notes(path: Path, ours: Counts, other: Counts | None, model: ImportedModel | None) -> list[str]:
    """Why the two differ; `?` where no rule knows."""
    if ours.error:
        return [f"refused: {ours.error}"] + ([f"the other: {other.error}"] if other and other.error else [])
    if other is None:
        return ["no independent reader"]
    if other.error:
        return [f"other refused: {other.error[:110]}"]
    assert model is not None
    notes = []
    if ours.triangles != other.triangles:
        notes.append(_triangles(ours, other, model))
    if path.suffix.lower() == ".mesh":
        if ours.vertices < other.vertices:
            notes.append(
                f"vertices {ours.vertices} to {other.vertices}: shared ones that no submesh uses, or none drawn"
            )
        return notes
    if other.joints >= 0 and ours.joints != other.joints:
        notes.append(_joints(path, ours, other, model))
    if ours.clips != other.clips:
        lost = [f for f in model.findings if "moves nothing" in f.message or "no key" in f.message]
        why = (
            f"{len(lost)} of them move nothing"
            if lost
            else "the other drops takes without keys"
            if ours.clips > other.clips
            else ""
        )
        if not why and path.suffix.lower() not in (".fbx", ".gltf", ".glb"):
            why = "the other reads no animation"
        if not why and other.clips > ours.clips and not ours.clips:
            why = "nothing that it moves is in the scene, or only what we do not animate"
        notes.append(f"clips {ours.clips} to {other.clips}: {why or '?'}")
    elif any(
        abs(a - b) > 0.02 * max(a, b, 0.1) for a, b in zip(sorted(ours.durations), sorted(other.durations), strict=True)
    ):
        notes.append("durations differ: ours run from the stack's begin to its end, the other's to the last key from 0")
    return notes


def _triangles(ours: Counts, other: Counts, model: ImportedModel) -> str:
    text = f"triangles {ours.triangles} to {other.triangles}: "
    codes = {f.code.partition(".")[2] for f in model.findings}
    left_out = {
        "zero-area": "we leave out faces that name a point twice", "collapsed": "we leave out collapsed triangles",
        "doubled": "we leave out triangles that are there twice", "index-range": "we leave out faces out of range",
        "index": "we leave out faces out of range", "faces": "we leave out holes and loose edges",
        "not-finite": "we leave out what is no number", "topology": "strips and fans are counted otherwise",
        "empty-mesh": "we leave out what cannot be drawn",
    }  # fmt: skip
    reasons = [why for code, why in left_out.items() if code in codes]
    if any("Duplicate object" in f.message for f in model.findings):
        return text + "two objects have one number, and ufbx keeps one of them"
    if ours.triangles < other.triangles and reasons:
        return text + "; ".join(reasons)
    if ours.triangles > other.triangles:
        return text + "the other cuts concave and holed polygons wrongly, or skips some"
    if len(model.nodes) and sum(node.mesh is not None for node in model.nodes) > len(model.meshes):
        return text + "instances: the other copies meshes"
    return text + "?"


def _joints(path: Path, ours: Counts, other: Counts, model: ImportedModel) -> str:
    text = f"joints {ours.joints} to {other.joints}: "
    if other.joints < ours.joints:
        return text + "the other drops bones without weights"
    if path.suffix.lower() in (".gltf", ".glb"):
        return text + "the other counts skins that no mesh uses"
    return text + ("bones that hold the mesh's own node" if other.joints - ours.joints <= 1 else "?")


def table(lines: list[Line], folder: Path) -> str:
    """Fixed columns, and a summary."""
    width = max((len(str(line.path.relative_to(folder))) for line in lines), default=10)
    out = [
        f"{'file':<{width}} {'vertices':>8} {'triangles':>9} {'joints':>6} {'clips':>5} {'seconds':>8} {'mats':>5}"
        f" {'imgs':>5} {'ms':>6}  the other reader"
    ]
    for line in lines:
        o, name = line.ours, str(line.path.relative_to(folder))
        if o.error:
            out.append(
                f"{name:<{width}} {'-':>8} {'-':>9} {'-':>6} {'-':>5} {'-':>8} {'-':>5} {'-':>5} {o.ms:>6.0f}  "
                + "; ".join(line.notes)
            )
            continue
        same = "the same" if line.other is not None and not line.notes else ""
        out.append(
            f"{name:<{width}} {o.vertices:>8} {o.triangles:>9} {o.joints:>6} {o.clips:>5} {sum(o.durations):>8.2f}"
            f" {o.materials:>5} {o.textures:>5} {o.ms:>6.0f}  " + (same or "; ".join(line.notes))
        )  # fmt: skip
    kinds = Counter("refused" if line.ours.error else "read" for line in lines)
    against = Counter(
        "no other reader" if line.other is None else "the other refuses" if line.other.error
        else "the same" if not line.notes else "explained" if not any("?" in n for n in line.notes) else "unexplained"
        for line in lines if not line.ours.error
    )  # fmt: skip
    out += ["", f"{len(lines)} files: " + ", ".join(f"{n} {k}" for k, n in sorted(kinds.items()))]
    out.append("against the other reader: " + ", ".join(f"{n} {k}" for k, n in sorted(against.items())))
    return "\n".join(out)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.assets_table", description=__doc__.splitlines()[0])
    root = Path(__file__).resolve().parent.parent
    parser.add_argument("folder", nargs="?", type=Path, default=root.parent / "shared" / "assets")
    parser.add_argument("--only", default="", metavar="TEXT", help="only files whose path holds this")
    args = parser.parse_args()
    lines = list(rows(args.folder, args.only))
    print(table(lines, args.folder))
    return 1 if any("?" in note for line in lines for note in line.notes) else 0


if __name__ == "__main__":
    sys.exit(main())
