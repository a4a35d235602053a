from __future__ import annotations

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.gpu.glsl_layout import RULES, TYPES, BlockLayout, Field, layout
from engine.gpu.types import Bindings, ComputePipelineDesc, Device, ShaderSource

MIXED = (
    Field("a", "float"), Field("b", "vec2"), Field("c", "vec3"), Field("d", "float"), Field("e", "vec3"),
    Field("f", "vec2"), Field("g", "mat4"), Field("h", "float", 3), Field("i", "uint"), Field("j", "vec3", 2),
    Field("k", "ivec2", 2), Field("l", "mat3"), Field("m", "int"), Field("n", "mat3x4"), Field("o", "uvec4"),
    Field("p", "float"),
)  # fmt: skip


def offsets(block: BlockLayout) -> dict[str, int]:
    return {field.name: block.offset(field.name) for field in block.fields}


def test_std140_offsets_by_hand() -> None:
    block = layout(MIXED, "std140")
    assert offsets(block) == {
        "a": 0, "b": 8, "c": 16, "d": 28, "e": 32, "f": 48, "g": 64, "h": 128, "i": 176, "j": 192, "k": 224,
        "l": 256, "m": 304, "n": 320, "o": 368, "p": 384,
    }  # fmt: skip
    assert block.size == 400


def test_std430_offsets_by_hand() -> None:
    block = layout(MIXED, "std430")
    assert offsets(block) == {
        "a": 0, "b": 8, "c": 16, "d": 28, "e": 32, "f": 48, "g": 64, "h": 128, "i": 140, "j": 144, "k": 176,
        "l": 192, "m": 240, "n": 256, "o": 304, "p": 320,
    }  # fmt: skip
    assert block.size == 336


def test_std430_struct_is_not_rounded_to_16() -> None:
    assert layout([Field("a", "float")], "std430").size == 4
    assert layout([Field("a", "vec2"), Field("b", "float")], "std430").size == 16
    assert layout([Field("a", "float")], "std140").size == 16


def test_text() -> None:
    block = layout([Field("view", "mat4"), Field("weights", "float", 4)])
    assert block.block_glsl("View", 3) == (
        "layout(std140, binding = 3) uniform View {\n    mat4 view;\n    float weights[4];\n};\n"
    )
    assert block.block_glsl("View", 3, "view").endswith("} view;\n")
    row = layout([Field("tint", "vec3")], "std430")
    assert row.struct_glsl("Row") == "struct Row {\n    vec3 tint;\n};\n"
    assert row.buffer_glsl("Rows", 2, "Row", "rows") == (
        "layout(std430, binding = 2) readonly buffer Rows {\n    Row rows[];\n};\n"
    )


@pytest.mark.parametrize(
    ("fields", "rule", "says"),
    [
        ([Field("a", "vec5")], "std140", "unknown type 'vec5'"),
        ([Field("a", "float")], "std123", "unknown layout rule"),
        ([Field("a", "float"), Field("a", "int")], "std140", "two fields"),
        ([Field("a b", "float")], "std140", "not a name"),
        ([Field("gl_x", "float")], "std140", "not a name"),
        ([Field("a", "float", 0)], "std140", "at least 1"),
        ([], "std140", "at least one field"),
    ],
)
def test_mistakes(fields: list[Field], rule: str, says: str) -> None:
    with pytest.raises(UsageError, match=says):
        layout(fields, rule)


def test_uniform_blocks_are_std140() -> None:
    with pytest.raises(UsageError, match="std140"):
        layout([Field("a", "float")], "std430").block_glsl("A", 0)


def _write(block: BlockLayout, row: np.ndarray, start: float) -> list[float]:
    """Fill all components of every field with consecutive numbers, in GLSL's order; the numbers."""
    numbers: list[float] = []
    for field in block.fields:
        _, components, columns = TYPES[field.type]
        shape = tuple(n for n in (field.count if field.count > 1 else 0, columns if columns > 1 else 0) if n)
        count = int(np.prod(shape, dtype=int)) * components
        values = start + len(numbers) + np.arange(count)
        target = row[field.name]
        if components == 1 and target.ndim == len(shape):
            row[field.name] = values.reshape(shape) if shape else values[0]
        else:
            target[..., :components] = values.reshape(*shape, components)
        numbers += values.tolist()
    return numbers


def _reads(block: BlockLayout, prefix: str) -> list[str]:
    """GLSL expressions for all components, in the order of `_write`."""
    out = []
    for field in block.fields:
        _, components, columns = TYPES[field.type]
        elements = [f"[{i}]" for i in range(field.count)] if field.count > 1 else [""]
        for element in elements:
            for column in [f"[{c}]" for c in range(columns)] if columns > 1 else [""]:
                for component in [f"[{k}]" for k in range(components)] if components > 1 else [""]:
                    out.append(f"{prefix}{field.name}{element}{column}{component}")
    return out


@pytest.mark.parametrize("rule", RULES)
def test_the_linked_program_reads_what_numpy_wrote(gl_device: Device, rule: str) -> None:
    block = layout(MIXED, rule)
    if rule == "std140":
        declared, prefix = block.block_glsl("Mixed", 0), ""
        rows = np.zeros(1, block.dtype)
    else:
        declared, prefix = block.struct_glsl("Row") + block.buffer_glsl("Mixed", 0, "Row", "rows"), "rows[1]."
        rows = np.zeros(2, block.dtype)  # the second row checks the stride
    reads = _reads(block, prefix)
    body = "\n".join(f"seen[{i}] = float({read});" for i, read in enumerate(reads))
    text = f"""
        layout(local_size_x = 1) in;
        {declared}
        layout(std430, binding = 1) writeonly buffer Seen {{ float seen[]; }};
        void main() {{ {body} }}"""
    pipeline = gl_device.compute_pipeline(ComputePipelineDesc("layout", ShaderSource("compute", text)))
    assert pipeline.block_size("Mixed") == block.size
    assert pipeline.block_size("Absent") == -1
    expected = _write(block, rows[-1], 1.0)
    source = gl_device.buffer(rows)
    seen = gl_device.buffer(4 * len(reads))
    uniforms, storage = ({0: source}, {1: seen}) if rule == "std140" else ({}, {0: source, 1: seen})
    with gl_device.compute_pass("layout") as encoder:
        encoder.set_pipeline(pipeline)
        encoder.set_bindings(Bindings(uniforms=uniforms, storage=storage))
        encoder.dispatch(1)
    np.testing.assert_array_equal(np.frombuffer(seen.read(), np.float32), expected)
    for resource in (source, seen, pipeline):
        resource.release()
