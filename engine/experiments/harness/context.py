"""What a run gets: device, seed, truths, shaders over arrays, and the tools that lie above the engine."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from engine.experiments.harness.references import ReferenceCache
from engine.report.records import Omission

if TYPE_CHECKING:
    from engine.experiments.harness.scenes import LiveScene
    from engine.experiments.harness.shader_eval import ShaderEval
    from engine.gpu.types import Device
    from engine.render.camera import Camera
    from engine.render.frame import Frame
    from engine.render.view import View
    from engine.resources.residency import Residency
    from engine.scene.scene import Scene

Floats = NDArray[np.float32]
T = TypeVar("T")


class OpenScene(Protocol):
    """A scene on the device, with its tables for those who look at them without one (ray tracing)."""

    @property
    def name(self) -> str: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def residency(self) -> Residency: ...

    def camera(self, aspect: float) -> Camera: ...
    def render(self, view: View, *, hdr: bool = False) -> Frame: ...
    def explain(self, frame: Frame) -> list[str]: ...
    def environment_faces(self) -> Floats:
        """Radiance of what surrounds it as it is drawn, f4[6,n,n,3], before intensity and rotation."""

    def close(self) -> None: ...


class Tools(Protocol):
    """What the importers and the app lend."""

    def sample_scenes(self) -> Sequence[Path]:
        """Scenes to measure on when the caller names none."""

    def open_scene(self, path: Path, device: Device) -> OpenScene:
        """A fresh renderer with nothing compiled. Raises InputError."""

    def prefilter(self, faces: Floats, size: int, roughness: float, samples: int) -> Floats:
        """f4[6,size,size,3]: cube `faces` f4[6,n,n,3] seen head-on in GGX of that roughness, as environments are."""

    def prefilter_samples(self, size: int, roughness: float) -> int:
        """How many samples the importer takes for a mip of that roughness."""

    def cube_directions(self, size: int) -> NDArray[np.float64]:
        """f8[6,size,size,3], unit: through the texels of the cubes that `prefilter` takes and gives."""

    def source_faces(self, kind: str, size: int) -> Floats:
        """Radiance of a procedural environment f4[6,size,size,3]: studio or sky."""

    def resample(self, image: Floats, width: int, height: int, kind: str) -> Floats:
        """An image f4[h,w,c] made smaller as mips are: box or kaiser. It repeats at the borders."""


@dataclass(slots=True)
class Context:
    """One experiment's run. `scenes`: the user's own (--scene); `live`: the one that is open in an editor."""

    device: Device | None = None
    quick: bool = False
    seed: int = 1
    references: ReferenceCache = field(default_factory=ReferenceCache)
    tools: Tools | None = None
    scenes: tuple[Path, ...] = ()
    live: LiveScene | None = None
    omitted: list[Omission] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    scratch: dict[Any, Any] = field(default_factory=dict)
    #: called when the run ends, however it ends: frees what `once` has made
    closing: list[Callable[[], None]] = field(default_factory=list)

    def rng(self, name: str) -> np.random.Generator:
        """A generator of its own for each purpose: adding one does not change another's numbers."""
        return np.random.default_rng([self.seed, zlib.crc32(name.encode())])

    def omit(self, what: str, why: str) -> None:
        """Record what was not measured."""
        if Omission(what, why) not in self.omitted:
            self.omitted.append(Omission(what, why))

    def shaders(self) -> ShaderEval:
        """GLSL over arrays on the device."""
        from engine.experiments.harness.shader_eval import ShaderEval

        if self.device is None:
            raise LucarnaError("this needs a graphics device", hint="see `lucarna doctor`")
        return ShaderEval(self.device)

    def lent(self) -> Tools:
        """The tools. Raises LucarnaError where the caller lent none."""
        if self.tools is None:
            raise LucarnaError("this needs the importers", hint="run it by `lucarna report`")
        return self.tools

    def once(self, name: str, make: Callable[[], T]) -> T:
        """`make()`, kept for the rest of this experiment's run: inputs and truths that its trials share."""
        if name not in self.scratch:
            self.scratch[name] = make()
        value: T = self.scratch[name]
        return value
