"""Evaluates the shaders' own functions over arrays, in a compute shader: GLSL in, float32 arrays out."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.paths import shaders_dir
from engine.gpu.preprocess import flatten
from engine.gpu.types import Bindings, ComputePipelineDesc, Device
from engine.render.blocks import SCENE_PRELUDE

TYPES = {1: "float", 2: "vec2", 3: "vec3", 4: "vec4"}
SWIZZLES = {1: "x", 2: "xy", 3: "xyz", 4: "xyzw"}
GROUP = 64


class ShaderProbe:
    """`probe(code, "lib/brdf.glsl", x=…, n=…)` runs `code` once per row of the inputs and returns what it assigns to
    `result` (a vec4): f4[n,4].

    Inputs are f4[n] or f4[n,2..4], or one value (one row) for all; in the code each is a variable of its own name.
    `shaders`: the folder whose files are included. `storage`, `textures`: further bindings that these want, and
    `declare`: declarations.
    """

    def __init__(self, device: Device, folder: Path, shaders: Path | None = None) -> None:
        self._device = device
        self._folder = folder
        self._shaders = shaders or shaders_dir()

    def __call__(
        self, code: str, *includes: str, storage: Mapping[int, Any] | None = None,
        textures: Mapping[int, Any] | None = None, declare: str = "", defines: Mapping[str, int] | None = None,
        **inputs: ArrayLike,
    ) -> NDArray[np.float32]:  # fmt: skip
        arrays = {name: _columns(values) for name, values in inputs.items()}
        count = max((len(a) for a in arrays.values()), default=1)
        data = np.zeros((count, max(len(arrays), 1), 4), np.float32)
        lines = []
        for slot, (name, array) in enumerate(arrays.items()):
            width = array.shape[1]
            data[:, slot, :width] = array
            lines.append(f"    {TYPES[width]} {name} = given[i * {data.shape[1]}u + {slot}u].{SWIZZLES[width]};")
        text = "\n".join(
            [
                f"layout(local_size_x = {GROUP}) in;",
                *(f'#include "{name}"' for name in includes),
                declare,
                "layout(std430, binding = 6) readonly buffer Given { vec4 given[]; };",
                "layout(std430, binding = 7) writeonly buffer Made { vec4 made[]; };",
                "void main() {",
                "    uint i = gl_GlobalInvocationID.x;",
                f"    if (i >= {count}u) return;",
                *lines,
                "    vec4 result = vec4(0.0);",
                re.sub(r"^", "    ", code, flags=re.M),
                "    made[i] = result;",
                "}",
            ]
        )
        file = self._folder / "probe.comp"
        file.write_text(text + "\n", encoding="utf-8")
        source = flatten(file, "compute", search=[self._shaders], prelude=SCENE_PRELUDE, defines=defines)
        device = self._device
        pipeline = device.compute_pipeline(ComputePipelineDesc("probe", source))
        given, made = device.buffer(data), device.buffer(count * 16)
        with device.compute_pass("probe") as encoder:
            encoder.set_pipeline(pipeline)
            encoder.set_bindings(Bindings(storage={6: given, 7: made, **(storage or {})}, textures=textures or {}))
            encoder.dispatch(-(-count // GROUP))
        result = np.frombuffer(made.read(), np.float32).reshape(count, 4).copy()
        for thing in (given, made, pipeline):
            thing.release()
        return result


def _columns(values: ArrayLike) -> NDArray[np.float32]:
    array = np.asarray(values, np.float32)
    return array if array.ndim == 2 else array.reshape(-1, 1)
