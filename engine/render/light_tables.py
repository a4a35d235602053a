"""What light shading looks up: fitted lobes of area lights and IES profiles, on the device once a scene has any.

A profile whose file changes is read again; while that fails its last good shape stays.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.dds import read_dds
from engine.assets.ies import read_ies
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.core.paths import shaders_dir
from engine.core.watched import Watched
from engine.gpu.types import Device, Sampler, SamplerDesc, Texture, TextureDesc
from engine.scene.lights import FIRST_AREA
from engine.scene.scene import Scene

LTC_UNIT = 13
PROFILE_UNIT = 14
#: texels of a profile: around and from straight ahead to straight back
PROFILE_SIZE = (128, 256)
#: every device has so many texture layers (OpenGL 4.3)
MOST_PROFILES = 2048
LTC_FILE = "ltc.dds"


class LightTables:
    """`area`, `profiles`: whether the scene's shining lights need each; `layers` i4[p]: the texture layer of each path
    in LightTable.profiles, -1 = none or unreadable (then the light shines evenly, and `findings` says why).
    `errors`: files that changed and could not be read again."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self.area = False
        self.profiles = False
        self.layers: NDArray[np.int32] = np.zeros(0, np.int32)
        self.findings = Findings()
        self.errors: dict[Path, InputError] = {}
        self._files = Watched()
        #: the shape last read from each file
        self._shapes: dict[Path, NDArray[np.float16]] = {}
        self._sampler: Sampler = device.sampler(SamplerDesc("clamp", "clamp", "clamp", "linear", "linear"))
        self._ltc: Texture | None = None
        self._profiles: Texture | None = None
        self._key: tuple[object, ...] = ()
        self._world: NDArray[np.void] | None = None

    def update(self, scene: Scene, *, everything: bool = False) -> None:
        """Look at what shines, load what it needs. `everything`: also what it does not (a forced frame)."""
        world = scene.lights.world()
        if world is not self._world:
            self._world = world
            self.area = bool((world["type"] >= FIRST_AREA).any())
            self.profiles = bool((world["profile"] >= 0).any())
        if (self.area or everything) and self._ltc is None:
            asset = read_dds(shaders_dir() / "data" / LTC_FILE)
            self._ltc = self._device.texture(TextureDesc(asset.format, asset.width, asset.height, label="ltc table"))
            self._ltc.write(asset.levels[0][0])
        key = (tuple(scene.lights.profiles), scene.folder)
        if (self.profiles or everything) and (key != self._key or self._profiles is None):
            self._key = key
            self._load(scene.lights.profiles, scene.folder)

    def changed(self) -> bool:
        """Whether the file of a profile changed since it was read. Any thread may ask."""
        return bool(self._files.changed())

    def invalidate(self) -> None:
        """Take all files for changed."""
        self._files.invalidate()

    def reread(self) -> list[Path]:
        """Read what changed; returns the files whose lights have another shape in the next frame."""
        taken = []
        for path in sorted(self._files.take()):
            try:
                self._shapes[path] = _shape(path)
            except InputError as error:
                self.errors[path] = error
                continue
            self.errors.pop(path, None)
            taken.append(path)
        if taken:
            self._key = ()
        return taken

    def kept(self, path: Path) -> bool:
        """Whether a file that cannot be read again was good before."""
        return path in self._shapes

    def bindings(self) -> dict[int, Any]:
        """By texture unit; nothing for what was never needed."""
        bound: dict[int, Any] = {}
        if self._ltc is not None:
            bound[LTC_UNIT] = (self._ltc, self._sampler)
        if self._profiles is not None:
            bound[PROFILE_UNIT] = (self._profiles, self._sampler)
        return bound

    def _load(self, paths: list[str], folder: Path) -> None:
        self.findings = Findings()
        self.layers = np.full(len(paths), -1, np.int32)
        pictures: list[NDArray[np.float16]] = []
        for index, path in enumerate(paths):
            if len(pictures) == MOST_PROFILES:
                self.findings.error("light.profile", f"{path}: more than {MOST_PROFILES} profiles")
                continue
            file = folder / path
            self._files.add([file])
            if file not in self._shapes:
                try:
                    self._shapes[file] = _shape(file, self.findings)
                except InputError as error:
                    self.findings.error("light.profile", str(error), hint="the light shines evenly without it")
                    continue
            self.layers[index] = len(pictures)
            pictures.append(self._shapes[file])
        if self._profiles is not None:
            self._profiles.release()
        width, height = PROFILE_SIZE if pictures else (1, 1)
        pictures = pictures or [np.ones((1, 1), np.float16)]
        self._profiles = self._device.texture(
            TextureDesc("r16f", width, height, "2d-array", layers=len(pictures), label="light profiles")
        )
        for layer, picture in enumerate(pictures):
            self._profiles.write(picture, layer=layer)

    def release(self) -> None:
        for texture in (self._ltc, self._profiles):
            if texture is not None:
                texture.release()


def _shape(path: Path, findings: Findings | None = None) -> NDArray[np.float16]:
    return read_ies(path, findings).relative(*PROFILE_SIZE).astype(np.float16)
