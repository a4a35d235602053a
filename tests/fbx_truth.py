"""FBX against OBJ truth: `python -m tests.fbx_truth [FOLDER]` prints how far our posed geometry is from it.

Beside many test files lie OBJ files that the authoring tool wrote: `NAME[_CLIP]_FRAME.obj` for NAME_VERSION_FORMAT.fbx,
or NAME.obj for the static pose. They are in the tool's own units and axes, so the truth is brought to metres and +Y up
by what the FBX file declares; where the tool's OBJ exporter did not keep to that, by the first of a few conventions
that fits, and the table says which.
"""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from importers.export.obj import Geometry, find_clip, obj_bytes, time_of_frame
from importers.fbx.reader import load
from importers.model import ImportedModel
from importers.settings import ImportSettings

F8 = NDArray[np.float64]
#: largest vertex error allowed, as a share of the model's size
TOLERANCE = 1e-3
_VERSIONED = re.compile(r"_\d{4}_(ascii|binary)$")
_Y_FROM_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True, slots=True)
class Truth:
    """One OBJ file and the clip and frame of `fbx` that it shows (frame None: as the scene stands)."""

    fbx: Path
    obj: Path
    clip: str
    frame: int | None


@dataclass(frozen=True, slots=True)
class Outcome:
    """`error`: the largest distance to the nearest vertex, both ways, by the model's size; `note` where it failed."""

    truth: Truth
    vertices: int
    error: float
    convention: str
    note: str = ""

    @property
    def ok(self) -> bool:
        return not self.note and self.error <= TOLERANCE


def find_truths(folder: Path) -> list[Truth]:
    """All pairs below `folder`, the ones called lefthanded aside."""
    found = []
    files = sorted(p for p in folder.rglob("*") if p.suffix.lower() == ".fbx")
    bases = {(p.parent, _VERSIONED.sub("", p.stem)) for p in files}
    for fbx in files:
        base = _VERSIONED.sub("", fbx.stem)
        longer = [b for place, b in bases if place == fbx.parent and b.startswith(f"{base}_")]
        pattern = re.compile(re.escape(base) + r"(?:_(?:(?P<clip>[a-z]+)_)?(?P<frame>\d+))?$")
        for obj in sorted(fbx.parent.glob(f"{base}*.obj")):
            match = pattern.match(obj.stem)
            if any(obj.stem == b or obj.stem.startswith(f"{b}_") for b in longer):
                continue  # the truth of another file whose name goes on
            if match and "lefthanded" not in obj.stem:
                frame = match["frame"]
                found.append(Truth(fbx, obj, match["clip"] or "", None if frame is None else int(frame)))
    return found


def measure(folder: Path, prepare: Callable[[ImportedModel], None] = lambda model: None) -> Iterator[Outcome]:
    """The outcomes of all truths below `folder`; each FBX file is read once, and then `prepare` is called with it."""
    last: Path | None = None
    geometry: Geometry | None = None
    unit, up, failure = 1.0, "", ""
    for truth in find_truths(folder):
        if truth.fbx != last:
            last, geometry, failure = truth.fbx, None, ""
            try:
                model = load(truth.fbx, ImportSettings())
                prepare(model)
                unit, up = float(str(model.summary["unit_meters"])), str(model.summary["up_axis"])
                slots = [["" for _ in mesh] for mesh in model.slots]
                geometry = Geometry(model.name, model.nodes, model.meshes, slots, model.clips)
            except LucarnaError as error:
                failure = error.message
        if geometry is None:
            yield Outcome(truth, 0, np.inf, "", failure)
        else:
            yield _compare(truth, geometry, unit, up)


def _compare(truth: Truth, geometry: Geometry, unit: float, up: str) -> Outcome:
    clip, moment = None, 0.0
    if truth.frame is not None and geometry.clips:
        try:
            clip = find_clip(geometry.clips, truth.clip) if truth.clip else geometry.clips[0]
        except LucarnaError as error:
            return Outcome(truth, 0, np.inf, "", error.message)
        moment = time_of_frame(clip, truth.frame)
    text = truth.obj.read_text(encoding="utf-8", errors="replace")
    theirs = read_vertices(text)
    ours = read_vertices(obj_bytes(_part(geometry, text), clip, moment).decode())
    if not len(ours):
        return Outcome(truth, 0, np.inf, "", "nothing to export")
    best: Outcome | None = None
    for name, matrix in _conventions(unit, up):
        moved = theirs @ matrix.T
        size = float(np.linalg.norm(np.ptp(moved, axis=0)))
        error = max(_farthest(moved, ours), _farthest(ours, moved)) / max(size, 1e-12)
        if best is None or error < best.error * 0.5:
            best = Outcome(truth, len(theirs), error, name)
        if best.ok:
            break
    assert best is not None
    return best


def _part(geometry: Geometry, text: str) -> Geometry:
    """The geometry without the nodes that the truth leaves out, where it names all that it has as we do."""
    names = {line[2:].strip() for line in text.splitlines() if line.startswith("o ")}
    ours = {node.name for node in geometry.nodes if node.mesh is not None}
    if not names or not names < ours:
        return geometry
    nodes = [node if node.name in names else replace(node, mesh=None) for node in geometry.nodes]
    return replace(geometry, nodes=nodes)


def _conventions(unit: float, up: str) -> list[tuple[str, F8]]:
    """What may bring a truth file to metres and +Y up; first what the FBX file declares."""
    turn = _Y_FROM_Z if up == "+z" else np.eye(3)
    listed = [("as declared", unit * turn)]
    for scale_name, scale in (("file units", unit), ("metres", 1.0), ("centimetres", 0.01), ("inches", 0.0254)):
        listed += [(f"{scale_name}, +Y up", scale * np.eye(3)), (f"{scale_name}, +Z up", scale * _Y_FROM_Z)]
    return listed


def read_vertices(text: str) -> F8:
    """The vertices f8[n,3] of an OBJ file that its faces use (all, where it has none)."""
    points = [line.split()[1:4] for line in text.splitlines() if line.startswith("v ")]
    values = np.array(points, np.float64).reshape(-1, 3)
    used: set[int] = set()
    for line in text.splitlines():
        if line.startswith("f "):
            used |= {int(word.split("/")[0]) for word in line.split()[1:]}
    rows = sorted({i - 1 if i > 0 else len(values) + i for i in used})
    return values[rows] if rows else values


def _farthest(a: F8, b: F8) -> float:
    """The largest distance from a point of `a` to its nearest in `b`."""
    worst = 0.0
    for start in range(0, len(a), 512):
        part = a[start : start + 512]
        square = ((part[:, None, :] - b[None]) ** 2).sum(axis=2)
        worst = max(worst, float(square.min(axis=1).max()))
    return worst**0.5


def main(folder: Path) -> int:
    """Print the table; 1 where something is off."""
    started = time.perf_counter()
    outcomes = list(measure(folder))
    width = max((len(o.truth.fbx.name) for o in outcomes), default=10)
    print(f"{'file':<{width}}  {'truth':<38} {'vertices':>8}  {'error':>9}  convention")
    for o in outcomes:
        error = f"{o.error:9.2e}" if np.isfinite(o.error) else "        -"
        mark = "" if o.ok else "  <-- " + (o.note or "too far")
        print(f"{o.truth.fbx.name:<{width}}  {o.truth.obj.name:<38} {o.vertices:>8}  {error}  {o.convention}{mark}")
    good = sum(o.ok for o in outcomes)
    worst = max((o.error for o in outcomes if o.ok), default=0.0)
    files = len({o.truth.fbx for o in outcomes})
    print(
        f"{good} of {len(outcomes)} poses of {files} files within {TOLERANCE:g}; "
        f"worst of those {worst:.2e}; {time.perf_counter() - started:.1f} s"
    )
    return 0 if good == len(outcomes) else 1


if __name__ == "__main__":
    root = Path(__file__).resolve().parent.parent
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else root.parent / "shared" / "assets"))
