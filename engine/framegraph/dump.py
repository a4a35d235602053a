"""Text drawing of a compiled graph. It names no device, time or address, so it can be a golden file.

    textures                        0 1 2
      depth  d32f     640x480  #0   C R .
      hdr    rgba16f  640x480  #1   . C R

C creates, W writes, R reads, H reads the history, P presents, - alive between. `#n` is the shared texture it lies in.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from engine.framegraph.builder import Declaration
from engine.framegraph.resources import human_bytes, texture_bytes
from engine.gpu.types import TextureDesc

if TYPE_CHECKING:
    from engine.framegraph.compiled import CompiledGraph


def dump(graph: CompiledGraph) -> str:
    """Passes, textures with lifetimes and aliases, and what was left out. Ends with a line break."""
    plan = graph.plan
    total = len(plan.passes) + len(plan.left_out)
    lines = [
        f"frame graph {graph.size[0]}x{graph.size[1]}: {len(plan.passes)} of {total} passes,"
        f" {len(plan.slots)} transient textures in {len(plan.slot_descs)}:"
        f" {human_bytes(graph.transient_bytes)} of {human_bytes(graph.unaliased_bytes)}",
        "",
        "passes",
    ]
    number = len(str(max(0, len(plan.passes) - 1)))
    rows = [(f"{i:>{number}}", d.name, _clauses(d)) for i, d in enumerate(plan.declarations)]
    lines += _table(rows)
    lines += ["", "textures"]
    header = " ".join(f"{i:>{number}}" for i in range(len(plan.declarations)))
    names = [
        (name, plan.descs[name].format, extent(plan.descs[name]), human_bytes(texture_bytes(plan.descs[name])),
         _home(graph, name), _timeline(plan.declarations, name, number))
        for name in plan.spans
    ]  # fmt: skip
    lines += _table([("", "", "", "", "", header), *names])
    if plan.left_out:
        lines += ["", "left out"]
        lines += _table([(left.name, left.reason, f"saves {human_bytes(left.saved)}") for left in plan.left_out])
    return "\n".join(lines) + "\n"


def extent(desc: TextureDesc) -> str:
    """`1280x720`, `512x512x6 cube`, with the mips when there are several."""
    text = f"{desc.width}x{desc.height}"
    if desc.kind != "2d":
        text += f"x{max(desc.layers, desc.depth)} {desc.kind}"
    return f"{text} {desc.mips} mips" if desc.mips > 1 else text


def _clauses(d: Declaration) -> str:
    writes = [name for name in d.writes if name not in d.creates]
    reads = [name for name in d.reads if name not in d.creates]
    parts = [
        f"{verb} {', '.join(names)}"
        for verb, names in (
            ("imports", d.imports), ("reads", reads), ("reads the history of", d.histories), ("creates", d.creates),
            ("writes", writes), ("keeps", d.keeps), ("presents", d.presents), ("does without", d.optional),
        )
        if names
    ]  # fmt: skip
    return "; ".join([*parts, "has a side effect"] if d.side_effect else parts)


def _home(graph: CompiledGraph, name: str) -> str:
    plan = graph.plan
    if name in plan.slots:
        return f"#{plan.slots[name]}"
    if name in plan.imported:
        return "imported"
    return "history" if name in plan.histories else "kept"


def _timeline(declarations: Sequence[Declaration], name: str, width: int) -> str:
    marks = [_mark(d, name) for d in declarations]
    used = [i for i, mark in enumerate(marks) if mark]
    return " ".join(f"{mark or ('-' if used[0] < i < used[-1] else '.'):>{width}}" for i, mark in enumerate(marks))


def _mark(d: Declaration, name: str) -> str:
    for letter, names in (("C", d.creates), ("W", d.writes), ("H", d.histories), ("R", d.reads), ("P", d.presents)):
        if name in names:
            return letter
    return "I" if name in d.imports else ""


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))] if rows else []
    return ["  " + "  ".join(f"{cell:<{w}}" for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows]
