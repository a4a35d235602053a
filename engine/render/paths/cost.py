"""What each path costs for local lights: a linear model in pixels and lights, built in or fitted on the device.

A fit is kept per device in the user's cache folder (`light_costs`); `lucarna report lights` measures and writes it.
Until then, or where the file is not to be read, the built-in numbers count. Only their order decides: `auto` takes the
cheapest path.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from engine.core.atomic import write_text
from engine.core.paths import user_cache_dir
from engine.gpu.types import Caps
from engine.render.lighting import PATHS


@dataclass(frozen=True, slots=True)
class PathCost:
    """Milliseconds of a frame: `fixed` + `pixel` per million pixels + `light` per 1,000 lights + `both` per million
    pixels and 1,000 lights."""

    fixed: float
    pixel: float
    light: float
    both: float

    def ms(self, lights: int, pixels: int) -> float:
        m, k = pixels * 1e-6, lights * 1e-3
        return self.fixed + self.pixel * m + self.light * k + self.both * m * k


#: measured on the sample scenes at 640x360 with a software rasteriser on two cores, up to 1,024 lights
BUILT_IN: dict[str, PathCost] = {
    "forward": PathCost(1.0, 90.0, 0.0, 25_000.0),
    "deferred": PathCost(1.5, 120.0, 12.0, 740.0),
    "tiled-deferred": PathCost(2.0, 135.0, 2.0, 160.0),
    "forward-plus": PathCost(2.0, 140.0, 2.0, 220.0),
}


@dataclass(frozen=True, slots=True)
class CostModel:
    """`source`: where the numbers are from, for people."""

    costs: Mapping[str, PathCost] = field(default_factory=lambda: dict(BUILT_IN))
    source: str = "built-in model"

    def cheapest(self, lights: int, pixels: int, samples: int) -> tuple[str, str]:
        """(path, why). With several samples a pixel only the forward paths come into question."""
        found = {
            path: cost.ms(lights, pixels)
            for path, cost in self.costs.items()
            if samples == 1 or path in ("forward", "forward-plus")
        }
        best, *rest = sorted(found, key=lambda path: found[path])
        others = ", ".join(f"{path} {found[path]:.3g}" for path in rest)
        limit = f"; {samples} samples a pixel leave out the deferred ones" if samples > 1 else ""
        what = f"{lights} local lights on {pixels} pixels"
        return best, f"{what} take {found[best]:.3g} ms by the {self.source}, {others}{limit}"


def fit(measured: Iterable[tuple[str, int, int, float]], source: str) -> CostModel:
    """Fit (path, lights, pixels, ms) points: least squares of the relative error, with no negative cost.

    A path with fewer than four points keeps its built-in numbers.
    """
    points = list(measured)
    costs = dict(BUILT_IN)
    for path in PATHS:
        rows = [(lights, pixels, ms) for name, lights, pixels, ms in points if name == path and ms > 0.0]
        if len(rows) >= 4:
            costs[path] = _fit_path(rows)
    return CostModel(costs, source)


def _fit_path(rows: list[tuple[int, int, float]]) -> PathCost:
    k = np.array([lights for lights, _, _ in rows]) * 1e-3
    m = np.array([pixels for _, pixels, _ in rows]) * 1e-6
    ms = np.array([ms for _, _, ms in rows])
    terms = np.stack([np.ones_like(m), m, k, m * k], axis=1) / ms[:, None]
    used = [0, 1, 2, 3]
    while used:
        values = np.linalg.lstsq(terms[:, used], np.ones(len(ms)), rcond=None)[0]
        if (values >= 0.0).all():
            break
        used.pop(int(np.argmin(values)))
    full = np.zeros(4)
    full[used] = values
    return PathCost(*(float(v) for v in full))


def cost_file(caps: Caps) -> Path:
    """Where the fit of a device lies."""
    name = hashlib.sha256(f"{caps.device}\n{caps.version}".encode()).hexdigest()[:16]
    return user_cache_dir() / "light_costs" / f"{name}.json"


def save(model: CostModel, caps: Caps) -> Path:
    """Keep a fit for this device. Raises OutputError."""
    path = cost_file(caps)
    path.parent.mkdir(parents=True, exist_ok=True)
    data = {"device": caps.device, "version": caps.version, "source": model.source,
            "costs": {name: asdict(cost) for name, cost in model.costs.items()}}  # fmt: skip
    write_text(path, json.dumps(data, indent=2, sort_keys=True) + "\n")
    return path


def load(caps: Caps) -> CostModel:
    """The fit of this device, else the built-in model; a file that makes no sense counts as none."""
    try:
        data = json.loads(cost_file(caps).read_text(encoding="utf-8"))
        costs = {path: PathCost(**data["costs"][path]) for path in PATHS}
        numbers = [value for cost in costs.values() for value in asdict(cost).values()]
        if not all(isinstance(v, int | float) and math.isfinite(v) and v >= 0.0 for v in numbers):
            return CostModel()
        return CostModel(costs, str(data["source"]))
    except (OSError, ValueError, KeyError, TypeError):
        return CostModel()
