"""LookCard: a grey ball, a chrome ball and a colour chart under a scene's surroundings, to judge light and curve by.

open runtime's surroundings ──shared──► LookCard: a Runtime of its own ──► a strip of three squares
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.app.runtime import Runtime
from engine.assets.material import MaterialAsset
from engine.assets.mesh import MeshAsset
from engine.assets.primitives import card, uv_sphere
from engine.assets.scene import SceneAsset
from engine.math.color import srgb_to_linear
from engine.render.camera import Camera
from engine.render.environments import Environments
from engine.render.frame import Frame
from engine.render.settings import RenderSettings
from engine.render.view import View

#: squares side by side: grey, chrome, and the chart, which is half as wide again
ASPECT = 3.5
#: the 24 patches of the ColorChecker Classic, sRGB as X-Rite publishes them (data before November 2014), row by row
PATCHES = (
    "735244", "c29682", "627a9d", "576c43", "8580b1", "67bdaa",
    "d67e2c", "505ba6", "c15a63", "5e3c6c", "9dbc40", "e0a32e",
    "383d96", "469449", "af363c", "e7c71f", "bb5695", "0885a1",
    "f3f3f2", "c8c8c8", "a0a0a0", "7a7a79", "555555", "343434",
)  # fmt: skip
COLUMNS, ROWS = 6, 4
GREY, CHROME = 0.18, 0.95
#: a Lambertian surface: what it sends back is its colour times the light that arrives
MATT = {"metallic": 0.0, "roughness": 1.0, "specular": 0.0}
#: what is behind, scene-linear
GROUND = (0.02, 0.02, 0.022)
_RADIUS, _PATCH, _STEP = 0.44, 0.2, 0.23
#: the card is seen plainly, whatever of the scene is shown just now
_SIMPLE: dict[str, Any] = {
    "view": "lit",
    "path": "forward",
    "background": "scene",
    "shadows": False,
    "local_shadows": "off",
    "ambient_occlusion": "off",
    "auto_exposure": False,
    "bloom": 0.0,
    "force_all": False,
    "check_numbers": False,
}


class LookCard:
    """Make it inside a device frame; `release` it before the runtime of `owner` closes."""

    def __init__(self, owner: Runtime) -> None:
        self.owner = owner
        self.runtime = Runtime(owner.device, profile=False)
        self.runtime.load(SceneAsset("look card"), Path())
        self.runtime.renderer.environments.release()
        self.runtime.renderer.environments = owner.renderer.environments  # baked once for both
        self._meshes: dict[int, int] = {}
        self._top = self.runtime.scene.nodes.add("card")
        ball = uv_sphere(_RADIUS)
        self._add(ball, "grey", (-1.25, 0.0), base_color=(GREY,) * 3 + (1.0,), **MATT)
        self._add(ball, "chrome", (-0.25, 0.0), base_color=(CHROME,) * 3 + (1.0,), roughness=0.0, metallic=1.0)
        patch = card(_PATCH)
        for i, text in enumerate(PATCHES):
            row, column = divmod(i, COLUMNS)
            at = 1.0 + (column - 0.5 * (COLUMNS - 1)) * _STEP, (0.5 * (ROWS - 1) - row) * _STEP
            encoded = np.array([int(text[k : k + 2], 16) for k in (0, 2, 4)]) / 255.0
            color = tuple(float(v) for v in srgb_to_linear(encoded))
            self._add(patch, f"patch {i + 1}", at, base_color=(*color, 1.0), **MATT)

    def render(
        self, rotation: NDArray[np.float64], settings: RenderSettings, width: int, height: int,
        patience: float | None = None,
    ) -> Frame | None:  # fmt: skip
        """As a camera turned by `rotation` (f8[3,3], world from camera) sees it; all face it, so that what they mirror
        and where they are lit from is as it is for the scene's things that face it.

        With `patience` (seconds) None while shader programs are made (see Runtime.follow)."""
        scene = self.runtime.scene
        scene.environment = replace(self.owner.scene.environment, background="color", background_color=GROUND)
        scene.look = replace(self.owner.scene.look)
        turned = np.eye(4)
        turned[:3, :3] = rotation
        scene.nodes.set_matrix(self._top, turned)
        scene.update()
        eye = turned.copy()
        eye[:3, 3] = rotation[:, 2] * 5.0
        shown = RenderSettings(**{**settings.values(), **_SIMPLE})
        view = View(Camera(eye, 0.7, 0.1, 20.0, 0.5), width, height, shown)
        return self.runtime.render(view) if patience is None else self.runtime.follow(view, patience)

    def release(self) -> None:
        self.runtime.renderer.environments = Environments(self.runtime.device)  # the owner's stay
        self.runtime.close()

    def _add(self, mesh: MeshAsset, name: str, at: tuple[float, float], **params: Any) -> None:
        residency = self.runtime.residency
        key = id(mesh)
        if key not in self._meshes:
            self._meshes[key] = residency.add_meshes([mesh])[0]
        material = residency.add_material(MaterialAsset(name, params=params), Path())
        node = self.runtime.scene.nodes.add(name, self._top, (*at, 0.0))
        self.runtime.add_instances([(node, self._meshes[key], 0, material)])
