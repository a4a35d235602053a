"""Tools: which handles the viewport shows and what a click in it does. View state, no part of a document. No imgui."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(slots=True)
class Tools:
    """`mode`: select, move, rotate, scale. `local`: handles turned as the node, else as the world.

    `measuring`: clicks set the two points (world, metres) of the measure. `focusing`: the next one sets the focus."""

    mode: str = "move"
    local: bool = False
    measuring: bool = False
    focusing: bool = False
    #: keys and pointer steer the camera with no button held, until a click or Escape
    flying: bool = False
    #: the camera goes round by itself
    turning: bool = False
    points: list[NDArray[np.float64]] = field(default_factory=list)

    def measure(self, point: NDArray[np.float64]) -> None:
        """Set the next point; a third begins anew."""
        if len(self.points) == 2:
            self.points.clear()
        self.points.append(np.asarray(point, np.float64))

    @property
    def distance(self) -> float | None:
        """Metres between the two points, or None without both."""
        return float(np.linalg.norm(self.points[1] - self.points[0])) if len(self.points) == 2 else None

    def forget(self) -> None:
        """Another document: what was measured is gone."""
        self.points.clear()
        self.measuring = self.turning = self.focusing = self.flying = False
