"""std140 and std430: one field list gives the numpy dtype and the GLSL text, so that neither is typed twice.

    fields -> layout() -> BlockLayout -> dtype (explicit offsets)     np.zeros(n, dtype).tobytes() fills a buffer
                                      -> block_glsl / struct_glsl / buffer_glsl

Rules: OpenGL 4.6 core specification, section 7.6.2.2 "Standard Uniform Block Layout", rules 1 to 10.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.core.errors import UsageError

#: type -> (number type, components per column, columns); scalars and vectors have one column
TYPES: dict[str, tuple[str, int, int]] = {
    "float": ("<f4", 1, 1), "vec2": ("<f4", 2, 1), "vec3": ("<f4", 3, 1), "vec4": ("<f4", 4, 1),
    "int": ("<i4", 1, 1), "ivec2": ("<i4", 2, 1), "ivec3": ("<i4", 3, 1), "ivec4": ("<i4", 4, 1),
    "uint": ("<u4", 1, 1), "uvec2": ("<u4", 2, 1), "uvec3": ("<u4", 3, 1), "uvec4": ("<u4", 4, 1),
    "mat3": ("<f4", 3, 3), "mat3x4": ("<f4", 4, 3), "mat4": ("<f4", 4, 4),
}  # fmt: skip

RULES = ("std140", "std430")
_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@dataclass(frozen=True, slots=True)
class Field:
    """A member. `count` > 1 is an array of that many."""

    name: str
    type: str
    count: int = 1


@dataclass(frozen=True, slots=True)
class BlockLayout:
    """Where each field lies. `size` = `dtype.itemsize`: the block, or the stride of an array of this struct.

    A field of `dtype` has the shape of its type: (), (n,) for vectors, (columns, rows) for matrices: column-major, so
    store the transpose of a row-major matrix. Arrays add a leading axis. Columns and array elements that the rule pads
    come padded to 4 components (a std140 `float a[3]` is f4[3, 4]: write `row["a"][:, 0]`).
    """

    fields: tuple[Field, ...]
    rule: str
    dtype: np.dtype[np.void]

    @property
    def size(self) -> int:
        return self.dtype.itemsize

    def offset(self, name: str) -> int:
        """Byte offset of field `name`."""
        assert self.dtype.fields is not None
        return int(self.dtype.fields[name][1])

    def members_glsl(self) -> str:
        """The member declarations, one a line."""
        return "".join(
            f"    {field.type} {field.name}{f'[{field.count}]' if field.count > 1 else ''};\n" for field in self.fields
        )

    def struct_glsl(self, name: str) -> str:
        return f"struct {name} {{\n{self.members_glsl()}}};\n"

    def block_glsl(self, name: str, binding: int, instance: str = "") -> str:
        """A uniform block. std430 is for storage buffers only: UsageError."""
        if self.rule != "std140":
            raise UsageError(f"uniform block {name!r} needs the std140 rule, this layout has {self.rule}")
        return f"layout(std140, binding = {binding}) uniform {name} {{\n{self.members_glsl()}}}{_after(instance)};\n"

    def buffer_glsl(self, name: str, binding: int, struct: str, array: str, access: str = "readonly") -> str:
        """A storage block that holds `struct array[]`; `struct_glsl(struct)` must come before it."""
        return f"layout({self.rule}, binding = {binding}) {access} buffer {name} {{\n    {struct} {array}[];\n}};\n"


def layout(fields: Sequence[Field], rule: str = "std140") -> BlockLayout:
    """Place `fields` in order. Raises UsageError for unknown types or rules, bad or repeated names, no fields."""
    if rule not in RULES:
        raise UsageError(f"unknown layout rule {rule!r}", hint=f"choose one of {', '.join(RULES)}")
    if not fields:
        raise UsageError("a block needs at least one field: GLSL has no empty blocks")
    offset, widest = 0, 16 if rule == "std140" else 4
    names: list[str] = []
    forms: list[object] = []
    offsets: list[int] = []
    for field in fields:
        _check(field, names)
        alignment, shape, size = _measure(field, rule)
        offset = _round_up(offset, alignment)
        names.append(field.name)
        forms.append((TYPES[field.type][0], shape))
        offsets.append(offset)
        offset += size
        widest = max(widest, alignment)
    dtype = np.dtype({"names": names, "formats": forms, "offsets": offsets, "itemsize": _round_up(offset, widest)})
    return BlockLayout(tuple(fields), rule, dtype)


def _measure(field: Field, rule: str) -> tuple[int, tuple[int, ...], int]:
    """Base alignment, numpy shape and size in bytes (rules 1 to 8; matrices are arrays of columns, rules 5 to 8)."""
    _, components, columns = TYPES[field.type]
    alignment = 4 * (4 if components == 3 else components)
    is_array = field.count > 1
    if columns == 1 and not is_array:
        return alignment, (components,) if components > 1 else (), 4 * components
    if rule == "std140":
        alignment = _round_up(alignment, 16)
    stored = alignment // 4  # components of one column or element with its padding
    shape: tuple[int, ...] = (stored,) if stored > 1 else ()
    if columns > 1:
        shape = (columns, *shape)
    if is_array:
        shape = (field.count, *shape)
    return alignment, shape, alignment * columns * field.count


def _round_up(value: int, to: int) -> int:
    return -(-value // to) * to


def _check(field: Field, names: Sequence[str]) -> None:
    if field.type not in TYPES:
        raise UsageError(f"field {field.name!r}: unknown type {field.type!r}", hint=f"known: {', '.join(TYPES)}")
    if not _IDENTIFIER.fullmatch(field.name) or field.name.startswith("gl_") or "__" in field.name:
        raise UsageError(f"{field.name!r} is not a name that GLSL takes")
    if field.name in names:
        raise UsageError(f"two fields are named {field.name!r}")
    if field.count < 1:
        raise UsageError(f"field {field.name!r}: count must be at least 1, got {field.count}")


def _after(instance: str) -> str:
    return f" {instance}" if instance else ""
