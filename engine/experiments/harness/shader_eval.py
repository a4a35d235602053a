"""GLSL over arrays: n inputs from storage buffers, n outputs into one, by a compute shader that calls one expression.

    ShaderEval(device).kernel("D_GGX(alpha, c, n, h)", {"alpha": "float", …}, "float", include=["lib/brdf.glsl"])
        .bind(alpha=…, …) -> Dispatch: .run() submits, .read() waits and returns f8[n] or f8[n,k]

So that a function of shaders/lib is compared with its float64 twin, and timed, without a picture.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import InputError
from engine.core.paths import shaders_dir
from engine.gpu.preprocess import flatten
from engine.gpu.types import Bindings, Buffer, ComputePipelineDesc, Device, Pipeline, Sampler, ShaderSource, Texture

#: GLSL type -> (numpy type, components, words from one element to the next in std430)
TYPES: dict[str, tuple[str, int, int]] = {
    "float": ("<f4", 1, 1), "vec2": ("<f4", 2, 2), "vec3": ("<f4", 3, 4), "vec4": ("<f4", 4, 4),
    "int": ("<i4", 1, 1), "uint": ("<u4", 1, 1), "uvec2": ("<u4", 2, 2), "uvec4": ("<u4", 4, 4),
}  # fmt: skip

LOCAL_SIZE = 64
MAX_GROUPS = 65535
#: a compute shader has no neighbours in screen space: where a library function asks for their difference it is zero
NO_DERIVATIVES: dict[str, str | int] = {f"{name}(p)": "((p) - (p))" for name in ("dFdx", "dFdy", "fwidth")}
_OUT_BINDING = 7  # eight storage blocks are the least that a device has


class Dispatch:
    """Inputs on the device and room for the outputs."""

    def __init__(
        self, device: Device, pipeline: Pipeline, inputs: list[Buffer], output: Buffer, kind: str, n: int,
        textures: Sequence[tuple[Texture, Sampler]] = (),
    ) -> None:  # fmt: skip
        self._device, self._pipeline, self._inputs, self._output = device, pipeline, inputs, output
        self._kind, self._n = kind, n
        storage = {**dict(enumerate(inputs)), _OUT_BINDING: output}
        self._bindings = Bindings(storage=storage, textures=dict(enumerate(textures)))

    def run(self) -> None:
        """Submit; does not wait."""
        with self._device.compute_pass("shader eval") as encoder:
            encoder.set_pipeline(self._pipeline)
            encoder.set_bindings(self._bindings)
            encoder.dispatch(-(-self._n // LOCAL_SIZE))

    def read(self) -> NDArray[Any]:
        """The outputs: f8[n] or f8[n,k] (u4, i4 for integers)."""
        dtype, parts, stride = TYPES[self._kind]
        words = np.frombuffer(self._output.read(), dtype).reshape(-1, stride)[: self._n, :parts]
        values = words.astype(np.float64) if dtype == "<f4" else words.copy()
        return values[:, 0] if parts == 1 else values

    def release(self) -> None:
        for buffer in (*self._inputs, self._output):
            buffer.release()
        self._pipeline.release()


class Kernel:
    """A compiled expression."""

    def __init__(
        self, device: Device, source: ShaderSource, inputs: Mapping[str, str], output: str,
        textures: Sequence[tuple[Texture, Sampler]] = (),
    ) -> None:  # fmt: skip
        self._device, self._source, self._inputs, self._output = device, source, dict(inputs), output
        self._textures = textures

    def bind(self, **arrays: ArrayLike) -> Dispatch:
        """Upload one array per input, [n] or [n,k]; all of one length. The caller releases the dispatch."""
        if set(arrays) != set(self._inputs):
            raise InputError(f"inputs {sorted(arrays)} given, {sorted(self._inputs)} expected")
        packed = [_pack(arrays[name], kind, name) for name, kind in self._inputs.items()]
        counts = {len(p) for p in packed}
        if len(counts) != 1 or 0 in counts:
            raise InputError(f"inputs of lengths {sorted(counts)}: give all of one length")
        n = counts.pop()
        if n > MAX_GROUPS * LOCAL_SIZE:
            raise InputError(f"{n:,} inputs are more than one dispatch takes, {MAX_GROUPS * LOCAL_SIZE:,}")
        pipeline = self._device.compute_pipeline(ComputePipelineDesc("shader eval", self._source))
        buffers = [self._device.buffer(p, label=name) for p, name in zip(packed, self._inputs, strict=True)]
        output = self._device.buffer(n * TYPES[self._output][2] * 4, label="outputs")
        return Dispatch(self._device, pipeline, buffers, output, self._output, n, self._textures)

    def __call__(self, **arrays: ArrayLike) -> NDArray[Any]:
        """Evaluate once: upload, run, read, free."""
        dispatch = self.bind(**arrays)
        try:
            dispatch.run()
            return dispatch.read()
        finally:
            dispatch.release()


class ShaderEval:
    """Makes kernels on a device. Integer constants go in as `defines`."""

    def __init__(self, device: Device) -> None:
        self._device = device

    def kernel(
        self, expression: str, inputs: Mapping[str, str], output: str, *, include: Sequence[str] = (),
        functions: str = "", defines: Mapping[str, str | int] | None = None,
        textures: Mapping[str, tuple[Texture, Sampler]] | None = None,
    ) -> Kernel:  # fmt: skip
        """A kernel that writes `expression` (GLSL over the names in `inputs`: name -> GLSL type) as `output` type.

        `include`: files of shaders/. `functions`: GLSL in front. `textures`: sampler2D by name, which stay the
        caller's. At most seven inputs. Raises ShaderError.
        """
        assert len(inputs) <= _OUT_BINDING, "a compute shader has eight storage blocks at least, no more for sure"
        textures = textures or {}
        samplers = [f"layout(binding = {i}) uniform sampler2D {name};" for i, name in enumerate(textures)]
        text = _source(expression, inputs, output, include, "\n".join([*samplers, functions]))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "eval.comp"
            path.write_text(text, "utf-8")
            source = flatten(path, "compute", search=[shaders_dir()], defines={**NO_DERIVATIVES, **(defines or {})})
        return Kernel(self._device, source, inputs, output, tuple(textures.values()))


def _source(expression: str, inputs: Mapping[str, str], output: str, include: Sequence[str], functions: str) -> str:
    lines = [f'#include "{name}"' for name in include]
    lines.append(f"layout(local_size_x = {LOCAL_SIZE}) in;")
    for binding, (name, kind) in enumerate(inputs.items()):
        lines.append(f"layout(std430, binding = {binding}) readonly buffer In_{name} {{ {kind} in_{name}[]; }};")
    lines.append(f"layout(std430, binding = {_OUT_BINDING}) writeonly buffer Out {{ {output} eval_out[]; }};")
    lines += [functions, "void main()", "{", "    uint eval_i = gl_GlobalInvocationID.x;"]
    lines.append("    if (eval_i >= uint(eval_out.length())) return;")
    lines += [f"    {kind} {name} = in_{name}[eval_i];" for name, kind in inputs.items()]
    lines += [f"    eval_out[eval_i] = {expression};", "}", ""]
    return "\n".join(lines)


def _pack(values: ArrayLike, kind: str, name: str) -> NDArray[Any]:
    dtype, parts, stride = TYPES[kind]
    array = np.asarray(values)
    array = array.reshape(len(array), -1) if array.size else np.zeros((0, parts))
    if array.shape[1] != parts:
        raise InputError(f"input {name} has {array.shape[1]} components, {kind} has {parts}")
    out = np.zeros((len(array), stride), dtype)
    out[:, :parts] = array
    return out
