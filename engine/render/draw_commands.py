"""Indirect draw commands: templates in batch order, and those of them that a set of instances needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.gpu.types import Buffer, Device
from engine.render.draw_states import Batch, DrawState

COMMAND_DTYPE = np.dtype(
    [
        ("index_count", "<u4"), ("instance_count", "<u4"), ("first_index", "<u4"),
        ("base_vertex", "<i4"), ("base_instance", "<u4"),
    ]
)  # fmt: skip


@dataclass(slots=True)
class Template:
    """Commands before visibility, in batch order, and which command each instance row belongs to."""

    states: list[DrawState]  # per command
    commands: NDArray[np.void]  # COMMAND_DTYPE, instance counts 0
    row_order: NDArray[np.intp]  # instance rows sorted by command
    row_command: NDArray[np.intp]  # command of each of row_order


def empty_template() -> Template:
    return Template([], np.zeros(0, COMMAND_DTYPE), np.zeros(0, np.intp), np.zeros(0, np.intp))


def chosen(
    template: Template, runs: list[tuple[int, int]], mask: NDArray[np.bool_], first_command: int, first_id: int
) -> tuple[NDArray[np.void], NDArray[np.intp], list[Batch]]:
    """The commands of a template for the instances in `mask`, their ids, and the batches that draw something."""
    drawn = mask[template.row_order]
    ids = template.row_order[drawn]
    counts = np.bincount(template.row_command[drawn], minlength=len(template.commands))
    commands = template.commands.copy()
    commands["instance_count"] = counts
    commands["base_instance"] = first_id + np.cumsum(counts) - counts
    totals = np.add.reduceat(counts, [first for first, _ in runs]).tolist() if runs else []
    batches = [
        Batch(template.states[first], first_command + first, count)
        for (first, count), total in zip(runs, totals, strict=True)
        if total
    ]
    return commands, ids, batches


def runs_of(states: list[DrawState]) -> list[tuple[int, int]]:
    """(first, count) of runs of equal neighbours."""
    runs: list[tuple[int, int]] = []
    for i, state in enumerate(states):
        if runs and states[runs[-1][0]] == state:
            runs[-1] = (runs[-1][0], runs[-1][1] + 1)
        else:
            runs.append((i, 1))
    return runs


def fit_buffer(device: Device, buffer: Buffer, data: NDArray[np.generic]) -> Buffer:
    """Write `data` into `buffer`, in a bigger one if it is too small."""
    if buffer.size < data.nbytes:
        label = buffer.label
        buffer.release()
        buffer = device.buffer(max(data.nbytes, 16), label=label)
    buffer.write(np.ascontiguousarray(data))
    return buffer
