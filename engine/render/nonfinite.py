"""NumberCheck: looks into every texture that a pass wrote, right after that pass: who made the first NaN, and where.

It is no pass: it stands beside the graph and runs only in frames that ask for it (RenderSettings.check_numbers, or the
view `nonfinite`), so a frame that does not ask has nothing of it, no texture, no dispatch, no compiled program.

    begin(graph) -> after(graph, pass) for each pass -> finish() -> NumberReport
                           |                              |
      compute: counts into a buffer, marks into a texture '-- show(color): the marks over the picture
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from engine.core.paths import shaders_dir
from engine.framegraph.compiled import CompiledGraph
from engine.gpu.formats import DEPTH, image_size
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.preprocess import flatten
from engine.gpu.types import (
    Bindings,
    BlendState,
    Buffer,
    ColorAttachment,
    ComputePipelineDesc,
    Device,
    Pipeline,
    RasterState,
    RenderPipelineDesc,
    SamplerDesc,
    Texture,
    TextureDesc,
)
from engine.report.number_check import HIGHEST, NumberReport, NumberRow

#: formats that can hold a NaN; of those with three channels or more, values below 0 and beyond HIGHEST are counted too
FLOATS = frozenset({"r16f", "rg16f", "rgba16f", "r32f", "rg32f", "rgba32f", "rg11b10f", "d32f"})
RADIANCE = frozenset({"rgba16f", "rgba32f", "rg11b10f"})
KINDS = {"2d": 0, "2d-array": 2, "3d": 3}
MULTISAMPLED = 1
GROUP = (8, 8)
NONE = 0xFFFFFFFF
CHECKED_UNIT, MARKS_UNIT = 10, 10

RECORD = layout(
    [
        Field("nan_count", "uint"), Field("inf_count", "uint"), Field("negative", "uint"), Field("over", "uint"),
        Field("first", "uint"), Field("value", "vec4"),
    ],
    rule="std430",
)  # fmt: skip
JOB = layout(
    [
        Field("size", "ivec3"), Field("level", "int"), Field("samples", "int"), Field("record", "uint"),
        Field("radiance", "uint"), Field("marks", "uint"), Field("highest", "float"),
    ],
    rule="std140",
)  # fmt: skip


@dataclass(slots=True)
class _Job:
    """One level of one texture after one pass."""

    pass_name: str
    resource: str
    desc: TextureDesc
    level: int
    #: one that is no resource of the graph
    texture: Texture | None = None

    @property
    def size(self) -> tuple[int, int, int]:
        width, height = image_size(self.desc, self.level)
        deep = max(1, self.desc.depth >> self.level) if self.desc.kind == "3d" else self.desc.layers
        return width, height, deep


@dataclass(slots=True)
class _Running:
    """The check of the frame that is being made."""

    jobs: list[_Job]
    unchecked: list[str]
    records: Buffer
    blocks: Buffer
    stride: int
    marks: Texture
    by_pass: dict[str, list[int]] = field(default_factory=dict)


class NumberCheck:
    """Of one device. Everything is made at the first frame that asks, and kept until `release`."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._pipelines: dict[tuple[int, int], Pipeline] = {}
        self._show: Pipeline | None = None
        self._running: _Running | None = None
        self._marks: Texture | None = None
        self._sampler = device.sampler(SamplerDesc("clamp", "clamp", "clamp", "nearest", "nearest"))

    @property
    def marks(self) -> Texture | None:
        """r32ui of the last checked view's size: bit 0 NaN, 1 infinite, 2 negative, 3 above HIGHEST."""
        return self._marks

    def begin(self, graph: CompiledGraph, place: str = "", also: Sequence[tuple[str, Texture]] = ()) -> None:
        """Before the passes of `graph` run. `also`: textures (by name) that were written before that, at `place`; they
        are looked into here."""
        jobs, unchecked = _jobs(graph)
        before = [
            _Job(place, name, texture.desc, level, texture)
            for name, texture in also
            if texture.desc.format in FLOATS and texture.desc.kind in KINDS
            for level in range(texture.desc.mips)
        ]
        jobs = [*before, *jobs]
        device = self._device
        rows = np.zeros(max(len(jobs), 1), RECORD.dtype)
        rows["first"] = NONE
        align = device.caps.uniform_alignment
        stride = -(-JOB.size // align) * align
        blocks = np.zeros((max(len(jobs), 1), stride), np.uint8)
        by_pass: dict[str, list[int]] = {}
        for index, job in enumerate(jobs):
            row = np.zeros((), JOB.dtype)
            row["size"], row["level"], row["record"] = job.size, job.level, index
            row["samples"], row["highest"] = job.desc.samples, HIGHEST
            row["radiance"] = job.desc.format in RADIANCE and job.texture is None
            row["marks"] = job.desc.kind == "2d"
            blocks[index, : JOB.size] = np.frombuffer(row.tobytes(), np.uint8)
            by_pass.setdefault(job.pass_name, []).append(index)
        self._running = _Running(
            jobs, unchecked, device.buffer(rows, label="number records"), device.buffer(blocks, label="number jobs"),
            stride, self._clean_marks(*graph.size), by_pass,
        )  # fmt: skip
        self.after(graph, place)

    def after(self, graph: CompiledGraph, pass_name: str) -> None:
        """Right after `pass_name` ran, before a later one takes the memory of its textures."""
        running = self._running
        assert running is not None, "begin comes first"
        indices = running.by_pass.get(pass_name, ())
        if not indices:
            return
        with self._device.compute_pass("check numbers") as encoder:
            for index in indices:
                job = running.jobs[index]
                kind = MULTISAMPLED if job.desc.samples > 1 else KINDS[job.desc.kind]
                bindings = Bindings(
                    uniforms={1: (running.blocks, index * running.stride, JOB.size)},
                    storage={0: running.records},
                    textures={CHECKED_UNIT: (job.texture or graph.texture(job.resource), self._sampler)},
                    images={0: (running.marks, 0, "read_write")},
                )
                encoder.set_pipeline(self._pipeline(kind, 0))
                encoder.set_bindings(bindings)
                width, height, deep = job.size
                encoder.dispatch(-(-width // GROUP[0]), -(-height // GROUP[1]), deep)
                encoder.set_pipeline(self._pipeline(kind, 1))
                encoder.dispatch(1)

    def finish(self) -> NumberReport:
        """After the last pass: waits for the device, and reads the counts."""
        running = self._running
        assert running is not None, "begin comes first"
        records = np.frombuffer(running.records.read(), RECORD.dtype)
        left: dict[tuple[str, int], int] = {}
        rows = []
        for job, record in zip(running.jobs, records, strict=False):
            count = int(record["nan_count"]) + int(record["inf_count"])
            made = max(0, count - left.get((job.resource, job.level), 0))
            left[job.resource, job.level] = count
            rows.append(_row(job, record, made))
        running.records.release()
        running.blocks.release()
        self._running = None
        return NumberReport(tuple(rows), tuple(running.unchecked))

    def show(self, color: Texture) -> None:
        """Dim the finished picture and put the marks of the last check over it."""
        assert self._marks is not None, "begin comes first"
        if self._show is None:
            root = shaders_dir()
            over = BlendState("one", "one_minus_src_alpha", "add", "zero", "one", "add")
            self._show = self._device.render_pipeline(
                RenderPipelineDesc(
                    "nonfinite marks",
                    flatten(root / "passes/fullscreen.vert", "vertex", search=[root]),
                    flatten(root / "debug/nonfinite_marks.frag", "fragment", search=[root]),
                    (), "triangles", None, (over,), RasterState("none"),
                )
            )  # fmt: skip
        with self._device.render_pass("nonfinite marks", [ColorAttachment(color)]) as render_pass:
            render_pass.set_pipeline(self._show)
            render_pass.set_bindings(Bindings(textures={MARKS_UNIT: (self._marks, self._sampler)}))
            render_pass.draw(3)

    def release(self) -> None:
        for pipeline in (*self._pipelines.values(), self._show):
            if pipeline is not None:
                pipeline.release()
        self._pipelines.clear()
        self._show = None
        if self._marks is not None:
            self._marks.release()
            self._marks = None

    def _clean_marks(self, width: int, height: int) -> Texture:
        if self._marks is None or (self._marks.desc.width, self._marks.desc.height) != (width, height):
            if self._marks is not None:
                self._marks.release()
            self._marks = self._device.texture(TextureDesc("r32ui", width, height, label="number marks"))
        self._marks.write(np.zeros((height, width), np.uint32))
        return self._marks

    def _pipeline(self, kind: int, fetch: int) -> Pipeline:
        found = self._pipelines.get((kind, fetch))
        if found is None:
            root = shaders_dir()
            prelude = RECORD.struct_glsl("Record") + RECORD.buffer_glsl("Records", 0, "Record", "records", "")
            defines = {"KIND": kind, "FETCH": fetch, "GROUP_X": 1 if fetch else GROUP[0]}
            source = flatten(
                root / "debug/nonfinite.comp", "compute", search=[root],
                prelude=prelude + JOB.block_glsl("JobBlock", 1, "job"),
                defines={**defines, "GROUP_Y": 1 if fetch else GROUP[1]},
            )  # fmt: skip
            found = self._device.compute_pipeline(ComputePipelineDesc("check numbers", source))
            self._pipelines[kind, fetch] = found
        return found


def _jobs(graph: CompiledGraph) -> tuple[list[_Job], list[str]]:
    """What is to be looked into, in the order of the passes, and what cannot be."""
    jobs, unchecked = [], []
    for declaration in graph.plan.declarations:
        for name in declaration.writes:
            desc = graph.plan.descs[name]
            if desc.format not in FLOATS:
                continue
            # the layers of a depth map that no one drew this frame hold anything; depth itself is clipped to 0..1
            if desc.format in DEPTH and (desc.layers > 1 or desc.kind != "2d"):
                continue
            if desc.kind not in KINDS:
                unchecked.append(f"{declaration.name}: {name} ({desc.kind})")
                continue
            jobs += [_Job(declaration.name, name, desc, level) for level in range(desc.mips)]
    return jobs, unchecked


def _row(job: _Job, record: np.void, made: int) -> NumberRow:
    width, height, _deep = job.size
    index = int(record["first"])
    first = None if index == NONE else (index % width, index // width % height, index // (width * height))
    x, y, z, w = (float(v) for v in record["value"])
    return NumberRow(
        job.pass_name, job.resource, job.level, width, height, int(record["nan_count"]), int(record["inf_count"]),
        int(record["negative"]), int(record["over"]), made, first, (x, y, z, w),
    )  # fmt: skip
