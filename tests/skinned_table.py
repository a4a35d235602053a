"""How far skinned vertices are from what their files say, in millimetres: `python -m tests.skinned_table [ASSETS]`.

glTF and Ogre files are evaluated in float64 straight from the file; FBX files are compared with the OBJ files that
another program wrote of their poses. Importers, clips, sampler and palette are in it. Each file twice: with its keys as
they are, and with fewer keys in 16 bits, as files are converted unless told otherwise: then a vertex may be off by
importers.key_reduction.SHARE of the model's size more. Exit code 1 where one is off by more.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from engine.app.posed import posed_positions
from engine.app.runtime import Runtime
from engine.gpu import open_device
from importers.convert import convert
from importers.key_reduction import SHARE, reduce_model
from importers.model import ImportedModel
from importers.settings import ImportSettings
from tests.animation.gltf_truth import Gltf
from tests.ogre_truth import OgreTruth, read_binary, read_xml

GLTF = ("CesiumMan", "BrainStem", "RiggedFigure", "RiggedSimple")
OGRE = ("ogre/models/ninja.mesh", "ogre/models/robot.mesh", "ogre/models/fish.mesh", "ogre_xml/ninja.mesh.xml",
        "ogre_xml/fish.mesh.xml")  # fmt: skip
#: a vertex may be off by so much of its model's size: float32 keys' times and palette, 16-bit weights
LIMIT = 5e-5


@dataclass(frozen=True, slots=True)
class Row:
    """`error`, `size` in metres of the file; `poses`: moments looked at."""

    file: str
    vertices: int
    poses: int
    size: float
    error: float
    coded: bool = False
    limit: float = LIMIT

    @property
    def allowed(self) -> float:
        """Metres."""
        return (self.limit + (SHARE if self.coded else 0.0)) * self.size

    @property
    def ok(self) -> bool:
        return self.error <= self.allowed


def main(folder: Path) -> int:
    """Print the table; 1 where something is off."""
    print(
        f"{'file':<40} {'keys':<6} {'vertices':>8} {'poses':>6} {'size, m':>8} "
        f"{'max error, mm':>14} {'allowed, mm':>12} {'of its size':>12}"
    )
    bad = 0
    for row in rows(folder):
        bad += not row.ok
        share = row.error / max(row.size, 1e-12)
        print(
            f"{row.file:<40} {'coded' if row.coded else 'all':<6} {row.vertices:>8,} {row.poses:>6} {row.size:>8.4g} "
            f"{row.error * 1e3:>14.5f} {row.allowed * 1e3:>12.5f} {share:>12.1e}"
            f"{'' if row.ok else '  <-- too far'}",
            flush=True,
        )
    return 1 if bad else 0


def rows(folder: Path) -> Iterator[Row]:
    runtime = Runtime(open_device("null"))
    try:
        with tempfile.TemporaryDirectory() as scratch:
            for name in GLTF:
                path = folder / "gltf" / name / "glTF-Binary" / f"{name}.glb"
                if path.is_file():
                    yield from (gltf_row(runtime, path, Path(scratch) / name, coded=coded) for coded in (False, True))
            for name in OGRE:
                out = Path(scratch) / name.replace("/", "-")
                if (folder / name).is_file():
                    yield from (ogre_row(runtime, folder / name, out, coded=coded) for coded in (False, True))
    finally:
        runtime.close()
    yield from fbx_rows(folder)


def gltf_row(runtime: Runtime, path: Path, out: Path, *, coded: bool = False) -> Row:
    truth = Gltf(path)
    _open(runtime, path, out, coded)
    length = runtime.clips[0].duration
    times = [0.0, 0.1, 0.337, length * 0.5, length * 0.93, length]
    pairs = [(truth.skinned(t), _posed(runtime, 0, t)) for t in times]
    size = float(np.ptp(pairs[0][0][1], axis=0).max())
    return Row(path.name, len(pairs[0][1][0]), len(times), size, max(farthest(a, b) for a, b in pairs), coded)


def ogre_row(runtime: Runtime, path: Path, out: Path, *, coded: bool = False) -> Row:
    truth = read_xml(path) if path.suffix == ".xml" else read_binary(path)
    _open(runtime, path, out, coded)
    unit = _unit(runtime, truth)
    worst, poses, count = 0.0, 0, 0
    for number, clip in enumerate(runtime.clips):
        if clip.name not in truth.clips:
            continue
        for time in truth.shared_times(clip.name)[:6]:
            theirs = truth.skinned(clip.name, time) * unit
            ours = _posed(runtime, number, time)
            worst = max(worst, farthest((truth.points * unit, theirs), ours))
            poses, count = poses + 1, len(ours[0])
    size = float(np.ptp(truth.points * unit, axis=0).max())
    return Row("/".join(path.parts[-2:]), count, poses, size, worst, coded)


def fbx_rows(folder: Path) -> Iterator[Row]:
    """Poses of FBX files, of which another program wrote the vertices: those with a skin in their name."""
    from tests import fbx_truth

    found: dict[tuple[Path, bool], list[fbx_truth.Outcome]] = {}
    for coded in (False, True):
        for outcome in fbx_truth.measure(folder, _code if coded else lambda model: None):
            if "skin" in outcome.truth.fbx.name or "sausage" in outcome.truth.fbx.name:
                found.setdefault((outcome.truth.fbx, coded), []).append(outcome)
    for (path, coded), outcomes in sorted(found.items()):
        good = [o for o in outcomes if not o.note]
        if good:
            # the error there is relative; sizes differ by pose, so it is told for a model of one metre
            yield Row(
                path.name,
                max(o.vertices for o in good),
                len(good),
                1.0,
                max(o.error for o in good),
                coded,
                fbx_truth.TOLERANCE,
            )


def _code(model: ImportedModel) -> None:
    reduce_model(model, -1.0)


def farthest(truth: tuple[np.ndarray, np.ndarray], got: tuple[np.ndarray, np.ndarray]) -> float:
    """The greatest distance of a vertex from the nearest posed vertex with the same place at bind."""
    at: dict[bytes, list[int]] = {}
    for i, place in enumerate(truth[0].astype(np.float32)):
        at.setdefault((place + np.float32(0.0)).tobytes(), []).append(i)
    worst = 0.0
    for place, point in zip(got[0].astype(np.float32), got[1], strict=True):
        same = at.get((place + np.float32(0.0)).tobytes())
        if same is None:  # the importer's own rounding of the place
            near = np.linalg.norm(truth[0] - place, axis=1)
            same = np.flatnonzero(near <= near.min() * (1.0 + 1e-6) + 1e-9).tolist()
        worst = max(worst, float(np.linalg.norm(truth[1][same] - point, axis=1).min()))
    return worst


def _open(runtime: Runtime, path: Path, out: Path, coded: bool) -> None:
    settings = ImportSettings(quality="draft", key_error_mm=-1.0 if coded else 0.0)
    scene = convert(path, out, settings).scene
    assert scene is not None
    runtime.open(scene)


def _posed(runtime: Runtime, clip: int, time: float) -> tuple[np.ndarray, np.ndarray]:
    """(bind, posed) of all skinned vertices, as they are drawn."""
    runtime.play(clip, mode="once")
    runtime.update(time)
    table = runtime.scene.instances
    bind, posed, seen = [], [], set()
    for instance in range(len(table)):
        mesh = int(table.mesh[instance])
        if mesh in seen or int(runtime.scene.skins.of_nodes(table.node[instance : instance + 1])[0]) < 0:
            continue
        seen.add(mesh)
        bind.append(runtime.residency.meshes[mesh].asset.streams["position"].astype(np.float64))
        posed.append(posed_positions(runtime.scene, runtime.residency, instance))
    return np.concatenate(bind), np.concatenate(posed)


def _unit(runtime: Runtime, truth: OgreTruth) -> float:
    """Metres of ours in a unit of theirs."""
    asset = next(m.asset for m in runtime.residency.meshes[-len(runtime.residency.meshes) :])
    ours = np.ptp(np.concatenate([m.asset.streams["position"] for m in runtime.residency.meshes]), axis=0).max()
    del asset
    return float(round(ours / np.ptp(truth.points, axis=0).max(), 6))


if __name__ == "__main__":
    root = Path(__file__).resolve().parent.parent
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else root.parent / "shared" / "assets"))
