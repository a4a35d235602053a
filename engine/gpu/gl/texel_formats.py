"""Our texture formats in OpenGL's words."""

from __future__ import annotations

from typing import NamedTuple


class TexelFormat(NamedTuple):
    """`internal` as stored; `layout` and `number` as uploaded; `read_number` as read back (packed types unpacked)."""

    internal: int
    layout: int
    number: int
    read_number: int


RED, RG, RGB, RGBA, RED_INTEGER, RG_INTEGER, DEPTH = 0x1903, 0x8227, 0x1907, 0x1908, 0x8D94, 0x8228, 0x1902
U1, U4, F4, F2 = 0x1401, 0x1405, 0x1406, 0x140B
PACKED_11_11_10F, PACKED_10_10_10_2 = 0x8C3B, 0x8368  # the _REV forms: red in the lowest bits

TEXELS: dict[str, TexelFormat] = {
    "r8": TexelFormat(0x8229, RED, U1, U1),
    "rg8": TexelFormat(0x822B, RG, U1, U1),
    "rgba8": TexelFormat(0x8058, RGBA, U1, U1),
    "rgba8-srgb": TexelFormat(0x8C43, RGBA, U1, U1),
    "r16f": TexelFormat(0x822D, RED, F2, F2),
    "rg16f": TexelFormat(0x822F, RG, F2, F2),
    "rgba16f": TexelFormat(0x881A, RGBA, F2, F2),
    "r32f": TexelFormat(0x822E, RED, F4, F4),
    "rg32f": TexelFormat(0x8230, RG, F4, F4),
    "rgba32f": TexelFormat(0x8814, RGBA, F4, F4),
    "rg11b10f": TexelFormat(0x8C3A, RGB, PACKED_11_11_10F, F4),
    "rgb10a2": TexelFormat(0x8059, RGBA, PACKED_10_10_10_2, F4),
    "r32ui": TexelFormat(0x8236, RED_INTEGER, U4, U4),
    "rg32ui": TexelFormat(0x823C, RG_INTEGER, U4, U4),
    "d32f": TexelFormat(0x8CAC, DEPTH, F4, F4),
    "d32f-s8": TexelFormat(0x8CAD, DEPTH, F4, F4),  # what is read is its depth
}

COMPRESSED: dict[str, int] = {
    "bc1": 0x83F1, "bc1-srgb": 0x8C4D, "bc3": 0x83F3, "bc3-srgb": 0x8C4F, "bc4": 0x8DBB, "bc5": 0x8DBD,
    "bc6h": 0x8E8F, "bc7": 0x8E8C, "bc7-srgb": 0x8E8D,
}  # fmt: skip

#: what a compressed format is read back as: the driver decodes it
DECODED: dict[str, str] = {
    "bc1": "rgba8", "bc1-srgb": "rgba8-srgb", "bc3": "rgba8", "bc3-srgb": "rgba8-srgb", "bc4": "r8", "bc5": "rg8",
    "bc6h": "rgba16f", "bc7": "rgba8", "bc7-srgb": "rgba8-srgb",
}  # fmt: skip


def internal_format(name: str) -> int:
    return COMPRESSED[name] if name in COMPRESSED else TEXELS[name].internal
