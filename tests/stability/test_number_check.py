"""The check of a frame's numbers: what it counts and where, on textures of every kind; and from the command line."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.framegraph.builder import Builder
from engine.framegraph.graph import FrameGraph
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import ColorAttachment, DepthAttachment, Device
from engine.render.nonfinite import NumberCheck
from engine.report.number_check import NumberReport, NumberRow
from importers.cli.main import main
from tests.editor.support.planted_nan import plant_nan
from tests.editor.support.small_scene import write_small_scene
from tests.stability.rows import covers
from tests.support.stage import Stage, front_camera, surface

pytestmark = pytest.mark.gl
NAN, INF = math.nan, math.inf


class Writer(Pass):
    """Creates `target` of a kind, or writes over it, by a function."""

    name = "writer"

    def __init__(self, fill: Callable[[Device, Any], None], target: str = "t", **create: Any) -> None:
        self.fill, self.target, self.create = fill, target, create
        super().__init__()

    def declare(self, b: Builder) -> None:
        if self.create:
            b.create(self.target, **self.create)
        else:
            b.write(self.target)
        b.side_effect()

    def execute(self, ctx: PassContext) -> None:
        self.fill(ctx.device, ctx.texture(self.target))


def clear(value: float) -> Callable[[Device, Any], None]:
    def fill(device: Device, texture: Any) -> None:
        device.render_pass("clear", [ColorAttachment(texture, clear=(value, 0.5, 0.5, 1.0))]).end()

    return fill


def put(layer: int = 0, level: int = 0, **texels: Any) -> Callable[[Device, Any], None]:
    """Writes 0.25 everywhere but for texels `xX_Y=value` of that image; the other images are 0.25 too."""

    def fill(device: Device, texture: Any) -> None:
        desc = texture.desc
        for index in range(max(desc.layers, desc.depth)):
            for mip in range(desc.mips):
                h, w = max(1, desc.height >> mip), max(1, desc.width >> mip)
                dtype = np.float16 if desc.format.endswith("16f") else np.float32
                channels = {"r": 1, "rg": 2, "rgba": 4}[desc.format.rstrip("0123456789f")]
                image = np.full((h, w, channels), 0.25, dtype)
                if (index, mip) == (layer, level):
                    for name, value in texels.items():
                        x, y = (int(v) for v in name[1:].split("_"))
                        image[y, x, 0] = value
                texture.write(image, level=mip, layer=index)

    return fill


def check(device: Device, passes: list[Pass], size: tuple[int, int] = (20, 12)) -> NumberReport:
    for index, item in enumerate(passes):
        item.name = f"p{index}"  # type: ignore[misc]  # each needs one of its own
    graph = FrameGraph(passes)
    compiled = graph.compile(device, None, size)
    numbers = NumberCheck(device)
    numbers.begin(compiled)

    @contextlib.contextmanager
    def observed(name: str) -> Iterator[None]:
        yield
        numbers.after(compiled, name)

    try:
        compiled.execute(None, observed)
        return numbers.finish()
    finally:
        numbers.release()
        graph.release()


@covers("format.who-made-it")
def test_counts_places_and_values(gl_device: Device) -> None:
    fill = put(x3_1=NAN, x19_11=INF, x4_1=-INF, x0_0=-1.0, x1_0=40000.0)
    report = check(gl_device, [Writer(fill, format="rgba16f"), Writer(clear(0.5), "u", format="rgba16f")])
    row, other = report.rows
    assert (row.nan, row.inf, row.negative, row.over) == (1, 2, 2, 2)  # an infinity is out of range besides
    assert row.first == (3, 1, 0)
    assert math.isnan(row.value[0])
    assert row.value[1:] == (0.25, 0.25, 0.25)
    assert (other.nan, other.inf, other.negative, other.over, other.first) == (0, 0, 0, 0, None)
    assert report.first is row
    assert report.bad_pixels == 3


@covers("format.who-made-it")
@pytest.mark.parametrize(
    ("create", "fill", "first", "level"),
    [
        ({"format": "rgba32f", "kind": "2d-array", "layers": 3}, put(layer=2, x7_5=NAN), (7, 5, 2), 0),
        ({"format": "rg16f", "mips": 3}, put(level=2, x4_2=NAN), (4, 2, 0), 2),
        ({"format": "r32f", "kind": "3d", "layers": 4}, put(layer=1, x19_0=INF), (19, 0, 1), 0),
        ({"format": "rgba16f", "samples": 4}, clear(NAN), (0, 0, 0), 0),
        ({"format": "r16f", "size": (1, 1)}, put(x0_0=NAN), (0, 0, 0), 0),
    ],
    ids=["array", "mip", "3d", "multisampled", "1x1"],
)
def test_textures_of_every_kind(
    gl_device: Device, create: dict[str, Any], fill: Any, first: tuple[int, int, int], level: int
) -> None:
    report = check(gl_device, [Writer(fill, **create)])
    bad = [row for row in report.rows if row.bad]
    assert [(row.first, row.level) for row in bad] == [(first, level)]
    assert bad[0].nan + bad[0].inf == (240 if "samples" in create else 1)


@covers("format.who-made-it")
def test_only_the_pass_that_made_it_is_blamed(gl_device: Device) -> None:
    def nothing(device: Device, texture: Any) -> None:
        pass

    passes: list[Pass] = [
        Writer(put(), format="rgba16f"), Writer(put(x2_2=NAN, x3_2=NAN)), Writer(nothing), Writer(put()),
    ]  # fmt: skip
    rows = check(gl_device, passes).rows
    assert [(row.nan, row.made) for row in rows] == [(0, 0), (2, 2), (2, 0), (0, 0)]


def test_whole_numbers_and_layered_depth_are_not_looked_into(gl_device: Device) -> None:
    def depth(device: Device, texture: Any) -> None:
        device.render_pass("clear", [], DepthAttachment(texture, clear=0.0, layer=0)).end()

    def nothing(device: Device, texture: Any) -> None:
        pass

    passes: list[Pass] = [
        Writer(nothing, "a", format="rgba8"), Writer(nothing, "b", format="r32ui"),
        Writer(depth, "c", format="d32f", kind="2d-array", layers=2), Writer(depth, "d", format="d32f"),
    ]  # fmt: skip
    assert [row.resource for row in check(gl_device, passes).rows] == ["d"]


def test_a_frame_that_does_not_ask_has_nothing_of_it(stage: Stage) -> None:
    """No dispatch, no texture, no program, and the same bits as a frame that asks."""
    stage.look(kind="uniform", color=(0.4, 0.5, 0.6), sun_illuminance=0.0, background="color")
    from engine.assets.primitives import cube

    stage.add(cube(), surface(base_color=(0.6, 0.4, 0.3, 1)))
    camera, renderer = front_camera(0.7), stage.runtime.renderer

    def shoot(**settings: Any) -> Any:
        frame = stage.runtime.render(stage.view((24, 20), camera, **settings))
        return frame, frame.color.read().copy()

    plain, expected = shoot()
    assert plain.numbers is None
    assert renderer._numbers is None
    asked, got = shoot(check_numbers=True)
    assert asked.numbers is not None
    assert asked.numbers.first is None
    assert asked.stats.counters["dispatches"] > plain.stats.counters["dispatches"]
    assert (got == expected).all()
    again, _ = shoot()
    assert again.stats.counters["dispatches"] == plain.stats.counters["dispatches"]
    dimmed = shoot(view="nonfinite")[1]
    assert dimmed[..., :3].astype(int).sum() < expected[..., :3].astype(int).sum()


@covers("format.who-made-it")
def test_the_command_line_names_pass_pixel_and_count(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = write_small_scene(tmp_path)
    words = ["render", str(scene), "--out", str(tmp_path / "a.png"), "--size", "64x48", "--set", "samples=1"]
    assert main([*words, "--check-numbers"]) == 0
    assert "hold no NaN" in capsys.readouterr().out
    plant_nan(tmp_path, 32.0, 24.0)
    assert main([*words, "--check-numbers"]) == 1
    out = capsys.readouterr().out
    assert "pass 'opaque' made the first: 16 NaN in hdr at (30, 22)" in out
    assert main(words) == 0


def test_the_report_in_words() -> None:
    clean = NumberRow("opaque", "hdr", 0, 8, 8, 0, 0, 0, 0, 0)
    bad = NumberRow("blur", "half", 1, 4, 4, 1, 2, 0, 5, 3, (1, 2, 0), (NAN, 1.0, 0.0, 1.0))
    assert NumberReport((clean,)).lines() == ["numbers: 1 textures after their passes hold no NaN and no infinity"]
    lines = NumberReport((clean, bad), ("x: cube (cube)",)).lines()
    assert lines[0] == "numbers: pass 'blur' made the first: 1 NaN and 2 Inf in half (mip 1) at (1, 2): nan 1 0 1"
    assert "  blur: 5 above 32000 in half" in lines
    assert lines[-1] == "  not looked into: x: cube (cube)"
    assert NumberReport((bad,)).to_json()["rows"][0]["value"] == ["nan", 1.0, 0.0, 1.0]
