"""Posed geometry as Wavefront OBJ: world space, metres, +Y up; positions, texture coordinates and normals each once.

Format: Wavefront, "Object Files (.obj)" (Advanced Visualizer manual, appendix B1).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.animation.pose import PosedMesh, pose_meshes, pose_nodes
from engine.assets.clip import ClipAsset
from engine.assets.clip_nodes import spread
from engine.assets.lanim import read_lanim
from engine.assets.lmesh import read_lmesh
from engine.assets.mesh import MeshAsset
from engine.assets.scene import NodeAsset
from engine.assets.scene_json import read_scene
from engine.core.atomic import write_bytes
from engine.core.errors import UsageError
from engine.core.findings import Findings
from importers.settings import ImportSettings

#: frames per second where the source has none of its own
DEFAULT_FRAME_RATE = 30.0


@dataclass(slots=True)
class Geometry:
    """What an export needs of a scene. `materials[m][s]`: the name of the material of slot s of mesh m."""

    name: str
    nodes: list[NodeAsset]
    meshes: list[MeshAsset]
    materials: list[list[str]]
    clips: list[ClipAsset]
    findings: Findings = field(default_factory=Findings)


def load_geometry(path: Path, settings: ImportSettings) -> Geometry:
    """The geometry of a *.scene.json or of any source, its textures left alone. Raises InputError, FormatError."""
    if path.name.lower().endswith(".scene.json"):
        return _from_scene(path)
    from importers.registry import find_importer

    model = find_importer(path).load(path, settings)
    names = [m.asset.name for m in model.materials]
    slots = [[names[i] if i >= 0 else "" for i in mesh] for mesh in model.slots]
    return Geometry(model.name, model.nodes, model.meshes, slots, model.clips, model.findings)


def _from_scene(path: Path) -> Geometry:
    scene = read_scene(path)
    geometry = Geometry(
        scene.name, scene.nodes, [], [], [spread(read_lanim(path.parent / clip), scene.nodes) for clip in scene.clips]
    )
    first: dict[str, int] = {}
    for node in scene.nodes:
        if node.mesh is None:
            continue
        if node.mesh.file not in first:
            first[node.mesh.file] = len(geometry.meshes)
            geometry.meshes += read_lmesh(path.parent / node.mesh.file)
            geometry.materials += [[""] * 0 for _ in range(len(geometry.meshes) - len(geometry.materials))]
        node.mesh.index += first[node.mesh.file]
        if 0 <= node.mesh.index < len(geometry.materials):
            geometry.materials[node.mesh.index] = [m.removesuffix(".material.toml") for m in node.mesh.materials]
    return geometry


def find_clip(clips: Sequence[ClipAsset], name: str) -> ClipAsset:
    """The clip of that name; letter case, and what stands before a `|`, may be left out. Raises UsageError."""
    for normal in (str, str.lower, lambda text: text.lower().rsplit("|", 1)[-1]):
        for clip in clips:
            if normal(clip.name) == (name if normal is str else name.lower()):
                return clip
    known = ", ".join(repr(clip.name) for clip in clips) or "none"
    raise UsageError(f"there is no clip {name!r}", hint=f"clips: {known}")


def time_of_frame(clip: ClipAsset, frame: float) -> float:
    """Seconds from the clip's start at which the source shows its frame number `frame`."""
    return frame / (clip.frame_rate or DEFAULT_FRAME_RATE) - clip.start


def obj_bytes(geometry: Geometry, clip: ClipAsset | None = None, time: float = 0.0, *, hidden: bool = False) -> bytes:
    """The scene at `time` seconds of `clip` (as it stands without one) as an OBJ file."""
    pose = pose_nodes(geometry.nodes, clip, time)
    lines = ["# Lucarna", "# metres, +Y up"]
    counts = np.zeros(3, np.int64)  # v, vt, vn written so far
    names: dict[str, int] = {}
    for posed in pose_meshes(geometry.nodes, geometry.meshes, pose, hidden=hidden):
        node = geometry.nodes[posed.node]
        assert node.mesh is not None
        lines.append(f"o {_word(node.name, names)}")
        slots = geometry.materials[node.mesh.index] if node.mesh.index < len(geometry.materials) else []
        counts += _write_mesh(lines, posed, slots, counts)
    return ("\n".join(lines) + "\n").encode("utf-8")


def export_obj(out: Path, geometry: Geometry, clip: ClipAsset | None, time: float, *, hidden: bool = False) -> None:
    """Write `obj_bytes` atomically. Raises OutputError."""
    write_bytes(out, obj_bytes(geometry, clip, time, hidden=hidden))


def _write_mesh(
    lines: list[str], posed: PosedMesh, slots: Sequence[str], counts: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Append one object; returns how many v, vt and vn it wrote."""
    positions, v = _unique(posed.positions, 9)
    normals, vn = _unique(posed.normals, 6)
    lines += _rows("v", positions)
    uv = posed.mesh.streams.get("uv0")
    written = [len(positions), 0, len(normals)]
    if uv is not None:
        flipped = np.asarray(uv, np.float64) * [1.0, -1.0] + [0.0, 1.0]
        texture, vt = _unique(flipped, 7)
        lines += _rows("vt", texture)
        written[1] = len(texture)
    lines += _rows("vn", normals)
    v, vn = v + counts[0] + 1, vn + counts[2] + 1
    for submesh, triangles in zip(posed.mesh.submeshes, posed.triangles, strict=True):
        slot = submesh.material_slot
        if slot < len(slots) and slots[slot]:
            lines.append(f"usemtl {slots[slot].replace(' ', '_')}")
        columns = [v[triangles], vn[triangles]]
        if uv is not None:
            columns.insert(1, (vt + counts[1] + 1)[triangles])
            form = "{}/{}/{}"
        else:
            form = "{}//{}"
        for corners in np.stack(columns, axis=2).tolist():
            lines.append("f " + " ".join(form.format(*corner) for corner in corners))
    return np.array(written, np.int64)


def _unique(values: NDArray[np.float64], digits: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The different rows in the order of their first use, as precise as they are written; and which is where."""
    rounded = np.round(values, digits) + 0.0  # -0 becomes 0
    _, first, inverse = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return rounded[first[order]], place[inverse.reshape(-1)]


def _rows(kind: str, values: NDArray[np.float64]) -> Iterable[str]:
    return (f"{kind} {' '.join(format(x, '.9g') for x in row)}" for row in values.tolist())


def _word(name: str, taken: dict[str, int]) -> str:
    """A name without spaces and line ends, unique in the file."""
    word = "_".join(name.split()) or "unnamed"
    taken[word] = taken.get(word, 0) + 1
    return word if taken[word] == 1 else f"{word}_{taken[word]}"
