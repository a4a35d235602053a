"""The engine's side of the editor, behind one small interface, so that panels and tests need no GPU and no importer."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from editor.camera_controls import OrbitCamera
from editor.waking import wake
from engine.core.findings import Findings
from engine.core.param import ParamBlock

#: (what is being done, 0..1 or -1 where unknown); may raise Cancelled
Progress = Callable[[str, float], None]


class Cancelled(Exception):
    """The user called the work off."""


@dataclass(slots=True)
class Resolved:
    """A path the user opened, resolved to a scene file. `project_root`: its project's folder; None for loose files."""

    source: Path
    scene: Path
    project_root: Path | None = None
    project_name: str = ""
    findings: Findings = field(default_factory=Findings)
    #: the source that the scene was made from, where there is one
    imported_from: Path | None = None


class Runtime(Protocol):
    """What the editor asks of engine.app.runtime.Runtime."""

    scene: Any
    asset: Any
    residency: Any

    @property
    def duration(self) -> float: ...
    def update(self, time_s: float) -> Any: ...
    def default_camera(self, aspect: float) -> Any: ...
    def add_nodes(self, nodes: list[Any], base: Path, parent: int = -1) -> Any: ...
    def render(self, view: Any) -> Any: ...
    def pick(self, view: Any, x: float, y: float) -> int: ...
    def pick_hits(self, view: Any, x: float, y: float) -> list[tuple[int, NDArray[np.float64]]]: ...
    def close(self) -> None: ...


class Host(Protocol):
    """Makes runtimes and views. `resolve` runs in a worker thread and touches no GPU; all else on the window's."""

    def open_device(self, attach: bool) -> Any: ...
    def resolve(self, path: Path, progress: Progress) -> Resolved: ...
    def open_runtime(self, device: Any, scene: Path, root: Path | None = None, base: Path | None = None) -> Runtime: ...
    def new_settings(self) -> ParamBlock: ...
    def view(self, camera: OrbitCamera, width: int, height: int, settings: ParamBlock) -> Any: ...
    def source_extensions(self) -> Sequence[str]: ...


class EngineHost:
    """The real one. Engine and importers are imported when first needed, so that the window opens sooner."""

    def open_device(self, attach: bool) -> Any:
        from engine.gpu import open_device

        return open_device("gl", attach=attach)

    def resolve(self, path: Path, progress: Progress) -> Resolved:
        from editor.opening import resolve_path

        resolved = resolve_path(path, progress, self.source_extensions())
        importlib.import_module("engine.app.runtime")  # here, so that the window's thread need not wait for it
        importlib.import_module("importers.opening")
        return resolved

    def open_runtime(self, device: Any, scene: Path, root: Path | None = None, base: Path | None = None) -> Runtime:
        """`base`: the scene file's content as it once was, for a recovery."""
        from engine.app.runtime import MANY_PICTURES
        from engine.app.runtime import Runtime as EngineRuntime
        from importers.opening import baker_for

        runtime = EngineRuntime(device, pixels=MANY_PICTURES)
        runtime.sleepy = True
        try:
            runtime.open(scene, baker=baker_for(scene.parent), root=root, base=base)
            runtime.renderer.environments.told = wake
        except BaseException:  # an interrupt, too, leaves nothing behind
            runtime.close()
            raise
        return runtime

    def new_settings(self) -> ParamBlock:
        from engine.render.settings import RenderSettings

        make: Callable[..., ParamBlock] = RenderSettings  # every parameter has a default
        return make()

    def view(self, camera: OrbitCamera, width: int, height: int, settings: ParamBlock) -> Any:
        from engine.render.camera import Camera
        from engine.render.settings import RenderSettings
        from engine.render.view import View

        assert isinstance(settings, RenderSettings)
        eye = Camera(camera.world_from_camera(), camera.yfov, camera.znear)
        if camera.orthographic:
            eye = Camera(eye.world_from_camera, camera.yfov, camera.znear, 200.0 * camera.distance, camera.ymag)
        return View(camera=eye, width=width, height=height, settings=settings)

    def source_extensions(self) -> Sequence[str]:
        from importers.registry import source_extensions

        return source_extensions()


def box_corners(low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
    """The 8 corners f8[8,3] of a box; corner i has bit 0, 1, 2 of i set where x, y, z is high."""
    bits = (np.arange(8)[:, None] >> np.arange(3)) & 1
    return np.where(bits == 1, np.asarray(high, dtype=np.float64), np.asarray(low, dtype=np.float64))
