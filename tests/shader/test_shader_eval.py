"""The harness itself: every type goes in and comes out, in order, whatever the count."""

from __future__ import annotations

import numpy as np
import pytest

from engine.core.errors import InputError, ShaderError
from engine.experiments.harness.shader_eval import TYPES, ShaderEval
from engine.gpu.types import Device


@pytest.fixture
def shaders(gl_device: Device) -> ShaderEval:
    return ShaderEval(gl_device)


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.parametrize("n", [1, 63, 64, 1000])
def test_identity(shaders: ShaderEval, kind: str, n: int) -> None:
    dtype, parts, _ = TYPES[kind]
    values = np.arange(n * parts).reshape(n, parts).astype(dtype)
    got = shaders.kernel("x", {"x": kind}, kind)(x=values)
    np.testing.assert_array_equal(got.reshape(n, parts), values)


def test_several_inputs_includes_functions_and_defines(shaders: ShaderEval) -> None:
    kernel = shaders.kernel(
        "combine(sat(a), b) + float(OFFSET)", {"a": "float", "b": "vec3"}, "float", include=["lib/math.glsl"],
        functions="float combine(float a, vec3 b) { return a * b.x + b.y * b.z; }", defines={"OFFSET": 3},
    )  # fmt: skip
    got = kernel(a=[2.0, 0.5], b=[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    np.testing.assert_allclose(got, [1.0 + 6.0 + 3.0, 2.0 + 30.0 + 3.0])


def test_run_again_gives_the_same(shaders: ShaderEval) -> None:
    dispatch = shaders.kernel("x * x", {"x": "float"}, "float").bind(x=np.arange(100.0))
    for _ in range(3):
        dispatch.run()
        np.testing.assert_array_equal(dispatch.read(), np.arange(100.0) ** 2)
    dispatch.release()


def test_mistakes(shaders: ShaderEval) -> None:
    kernel = shaders.kernel("x + y", {"x": "float", "y": "float"}, "float")
    for arrays in ({"x": [1.0]}, {"x": [1.0], "y": [1.0, 2.0]}, {"x": [], "y": []}, {"x": [[1.0, 2.0]], "y": [1.0]}):
        with pytest.raises(InputError):
            kernel(**arrays)
    with pytest.raises(ShaderError, match="undefined_thing"):
        shaders.kernel("undefined_thing(x)", {"x": "float"}, "float")(x=[1.0])
