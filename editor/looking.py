"""Looking: the part of a session that looks at the document: settings, camera, picking, measuring. No imgui, no GL."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from editor import camera_controls
from editor.baking import surroundings_revision
from editor.selecting import nodes_in_box
from editor.session_state import SessionState
from engine.core.errors import LucarnaError
from engine.core.param import ParamBlock


class Looking(SessionState):
    """Reads the document and selects in it; edits nothing."""

    __slots__ = ()

    @property
    def settings(self) -> ParamBlock:
        """The render settings of the viewport; view state, not part of the document."""
        if self._settings is None:
            self._settings = self._fresh_settings()
        return self._settings

    def reset_settings(self) -> None:
        self._settings = self._fresh_settings()

    def _fresh_settings(self) -> ParamBlock:
        settings = self.host.new_settings()
        if self.software and any(p.name == "samples" for p in settings.PARAMS):
            settings.samples = 1  # a software rasteriser pays for each one in full
            settings.anisotropy = 1.0
        return settings

    def view(self) -> Any:
        return self.host.view(self.camera, self.width, self.height, self.settings)

    def reset_camera(self) -> None:
        """The scene's own camera, or one that frames it."""
        if self.document is None:
            return
        camera = self.document.runtime.default_camera(self.aspect)
        matrix = np.asarray(camera.world_from_camera, dtype=np.float64)
        low, high = self.document.bounds()
        distance = 5.0
        if np.isfinite(low).all() and np.isfinite(high).all():
            ahead = float((matrix[:3, 3] - 0.5 * (low + high)) @ matrix[:3, 2])
            distance = max(ahead, 0.1 * float(np.linalg.norm(high - low)), 1e-3)
        self.camera = camera_controls.from_matrix(matrix, distance, float(camera.yfov))

    def frame_selection(self) -> None:
        """Look at the selected nodes, or at everything."""
        if self.document is None:
            return
        low, high = self.document.bounds(self.document.selection)
        if not self.document.selection or not np.isfinite(low).all():
            self.frame_all()
            return
        if float(np.linalg.norm(high - low)) <= 0.0:  # a light or an empty: something of a metre round it
            low, high = low - 0.5, high + 0.5
        self.camera = camera_controls.frame(self.camera, low, high, self.aspect)

    def frame_all(self) -> None:
        if self.document is not None:
            self.camera = camera_controls.frame(self.camera, *self.document.bounds(), self.aspect)

    def pick(self, u: float, v: float, *, toggle: bool = False) -> int:
        """Select what shows at (u, v) of the viewport, 0..1 from its top left; returns the node row, or -1."""
        if self.document is None or self.image.frame is None:
            return -1
        try:
            row = int(self.document.runtime.pick(self.view(), u * self.width, v * self.height))
        except LucarnaError as error:
            self.messages.error(error)
            return -1
        if row in self.document.locked:
            row = next((r for r, _point in self.hits(u, v) if r not in self.document.locked), -1)
        self.document.select(row, toggle=toggle)
        return row

    def hits(self, u: float, v: float) -> list[tuple[int, NDArray[np.float64]]]:
        """Every node under (u, v) with the point (world) where it is hit, the nearest first."""
        if self.document is None or self.image.frame is None:
            return []
        try:
            return self.document.runtime.pick_hits(self.view(), u * self.width, v * self.height)
        except LucarnaError as error:
            self.messages.error(error)
            return []

    def pick_through(self, u: float, v: float) -> None:
        """Let the user choose among all that lies under (u, v)."""
        self.ui.pick_list = tuple(row for row, _point in self.hits(u, v))

    def measure(self, u: float, v: float) -> None:
        """Take the point under (u, v) as the next end of the measure."""
        found = self.hits(u, v)
        if not found:
            self.ui.notice = "Nothing there to measure"
            return
        self.tools.measure(found[0][1])

    def select_box(self, low: tuple[float, float], high: tuple[float, float], *, add: bool = False) -> None:
        """Select every drawn node whose middle lies in the rectangle (u, v) .. (u, v); lights and cameras too."""
        document = self.document
        if document is None:
            return
        rows = nodes_in_box(document, self.camera, low, high, self.aspect)
        kept = document.selection if add else ()
        document.selection = tuple(dict.fromkeys((*kept, *rows)))

    def visible_state(self) -> tuple[Hashable, ...]:
        """What the viewport's picture depends on, besides its size: equal states give equal pictures."""
        document = self.document
        if document is None:
            return ()
        scene = document.runtime.scene
        return (
            self.camera,
            self.settings.key(),
            document.history.revision,
            int(scene.structure_rev),
            int(scene.transform_rev),
            int(getattr(document.runtime.residency, "structure_rev", 0)),
            surroundings_revision(document.runtime),
            self.playback.time,
            self.playback.elapsed if self.playback.playing else 0.0,
        )
