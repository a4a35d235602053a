"""FrameGraph: culling with reasons, versions, caching, collected errors, the dump. No GPU."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from engine.core.errors import LucarnaError, UsageError
from engine.framegraph.builder import Builder
from engine.framegraph.explain import explain
from engine.framegraph.graph import FrameGraph
from engine.framegraph.passes import Pass, PassContext
from engine.framegraph.resources import human_bytes
from engine.gpu import open_device
from engine.gpu.types import Device, TextureDesc

SIZE = (64, 48)


def make(
    name: str,
    declare: Callable[[Builder], Any],
    needs: Callable[[Any], bool | str] = lambda facts: True,
    execute: Callable[[PassContext], Any] = lambda ctx: None,
) -> Pass:
    """A pass of functions."""

    class Made(Pass):
        def needs(self, facts: Any) -> bool | str:
            return needs(facts)

        def declare(self, b: Builder) -> None:
            declare(b)

        def execute(self, ctx: PassContext) -> None:
            execute(ctx)

    Made.name = name
    return Made()


@pytest.fixture
def device() -> Iterator[Device]:
    device = open_device("null")
    yield device
    device.release()


def forward(b: Builder) -> None:
    b.create("depth", "d32f")
    b.create("hdr", "rgba16f")


def ssao(b: Builder) -> None:
    b.read("depth")
    b.create("ao", "r8", scale=0.5)


def composite(b: Builder) -> None:
    b.read("ao", optional=True)
    b.write("hdr")


def tone_map(b: Builder) -> None:
    b.read("hdr")
    b.create("color", "rgba8")
    b.present("color")


def frame(trace: list[str] | None = None) -> FrameGraph:
    def note(ctx: PassContext) -> None:
        if trace is not None:
            trace.append(ctx.pass_name)

    return FrameGraph(
        [
            make("forward", forward, execute=note),
            make("ssao", ssao, lambda facts: "ao" in facts or "the look has no ambient occlusion", note),
            make("histogram", lambda b: (b.read("hdr"), b.create("bins", "r32ui", size=(256, 1))), execute=note),
            make("composite", composite, execute=note),
            make("tone_map", tone_map, execute=note),
        ]
    )


def test_left_out_by_need_and_by_reachability(device: Device) -> None:
    trace: list[str] = []
    graph = frame(trace).compile(device, frozenset(), SIZE)
    graph.execute()
    assert trace == ["forward", "composite", "tone_map"]
    assert [(left.name, left.reason, left.saved) for left in graph.left_out] == [
        ("ssao", "the look has no ambient occlusion", 32 * 24),
        ("histogram", "nothing reads its outputs: bins", 256 * 4),
    ]


def test_force_all_runs_everything(device: Device) -> None:
    trace: list[str] = []
    graph = frame(trace).compile(device, frozenset(), SIZE, force_all=True)
    graph.execute()
    assert trace == ["forward", "ssao", "histogram", "composite", "tone_map"]
    assert graph.left_out == []


def test_compiles_once_per_key(device: Device) -> None:
    graph = frame()
    first = graph.compile(device, frozenset(), SIZE)
    assert graph.compile(device, frozenset(), SIZE) is first
    assert graph.compiles == 1
    others = [
        graph.compile(device, frozenset({"ao"}), SIZE),
        graph.compile(device, frozenset(), (65, 48)),
        graph.compile(device, frozenset(), SIZE, force_all=True),
        graph.compile(device, frozenset(), SIZE, key="second view"),
    ]
    assert len({id(g) for g in (first, *others)}) == 5
    assert graph.compiles == 5


def test_structure_key_recompiles(device: Device) -> None:
    class Chain(Pass):
        name = "chain"
        levels = 2

        def structure_key(self) -> int:
            return self.levels

        def declare(self, b: Builder) -> None:
            b.create("bloom", "rgba16f", mips=self.levels)
            b.present("bloom")

        def execute(self, ctx: PassContext) -> None: ...

    chain = Chain()
    graph = FrameGraph([chain])
    assert graph.compile(device, None, SIZE).plan.descs["bloom"].mips == 2
    chain.levels = 3
    assert graph.compile(device, None, SIZE).plan.descs["bloom"].mips == 3


def test_a_write_needs_the_version_before_it(device: Device) -> None:
    graph = FrameGraph(
        [
            make("base", lambda b: b.create("x", "rgba8")),
            make("blend", lambda b: b.write("x")),
            make("late", lambda b: b.write("x")),
            make("unread", lambda b: (b.read("x"), b.create("y", "rgba8"))),
            make("show", lambda b: b.present("x")),
        ]
    ).compile(device, None, SIZE)
    assert [p.name for p in graph.passes] == ["base", "blend", "late", "show"]


def test_a_version_nobody_reads_is_left_out(device: Device) -> None:
    graph = FrameGraph(
        [
            make("base", lambda b: b.create("x", "rgba8")),
            make("use", lambda b: (b.read("x"), b.create("y", "rgba8"), b.present("y"))),
            make("overpaint", lambda b: b.write("x")),
        ]
    ).compile(device, None, SIZE)
    assert [p.name for p in graph.passes] == ["base", "use"]
    assert graph.left_out[0].reason == "nothing reads its outputs: x"


def test_side_effects_and_imported_targets_stay(device: Device) -> None:
    atlas = device.texture(TextureDesc("d32f", 8, 8))
    graph = FrameGraph(
        [
            make("simulate", lambda b: b.side_effect()),
            make("shadows", lambda b: (b.import_texture("atlas", atlas), b.write("atlas"))),
            make("idle", lambda b: None),
        ]
    ).compile(device, None, SIZE)
    assert [p.name for p in graph.passes] == ["simulate", "shadows"]
    assert graph.left_out[0].reason == "it has no outputs and no side effect"
    assert graph.texture("atlas") is atlas
    other = device.texture(TextureDesc("d32f", 16, 16))
    graph.bind("atlas", other)
    graph.execute()
    assert graph.texture("atlas") is other
    with pytest.raises(UsageError, match="atlas"):
        graph.bind("atlsa", other)


def test_all_mistakes_at_once(device: Device) -> None:
    passes = [
        make("forward", forward),
        make("fog", lambda b: (b.read("dpeth"), b.write("hdr"))),
        make("again", lambda b: b.create("hdr", "rgba8")),
        make("wrong", lambda b: b.create("bad", "rgba17", scale=-1.0)),
        make("present", lambda b: b.present("colour")),
    ]
    with pytest.raises(LucarnaError) as caught:
        FrameGraph(passes).compile(device, None, SIZE)
    text = str(caught.value)
    assert "5 mistakes" in text
    assert "pass 'fog': reads 'dpeth', which no pass writes (did you mean 'depth'?)" in text
    assert "pass 'again': creates 'hdr', but pass 'forward' did already" in text
    assert "'rgba17'" in text
    assert "scale -1.0" in text
    assert "pass 'present': presents 'colour'" in text


def test_read_of_what_was_left_out_names_the_reason(device: Device) -> None:
    passes = [
        make("ssao", lambda b: b.create("ao", "r8"), lambda facts: "no occluders"),
        make("use", lambda b: (b.read("ao"), b.side_effect())),
    ]
    with pytest.raises(LucarnaError, match="pass 'ssao' is left out: no occluders"):
        FrameGraph(passes).compile(device, None, SIZE)
    assert len(FrameGraph(passes).compile(device, None, SIZE, force_all=True).passes) == 2


def test_read_before_write_and_cycle(device: Device) -> None:
    late = [make("use", lambda b: b.read("x")), make("make", lambda b: b.create("x", "r8"))]
    with pytest.raises(LucarnaError, match="before pass 'make' creates it"):
        FrameGraph(late).compile(device, None, SIZE)
    cycle = [
        make("a", lambda b: (b.read("y"), b.create("x", "r8"))),
        make("b", lambda b: (b.read("x"), b.create("y", "r8"))),
    ]
    with pytest.raises(LucarnaError, match="cycle: a -> b -> a"):
        FrameGraph(cycle).compile(device, None, SIZE)


def test_two_passes_of_one_name() -> None:
    with pytest.raises(LucarnaError, match="same name: a"):
        FrameGraph([make("a", forward), make("a", forward)])


def test_hooks_surround_each_pass_and_contexts_are_made(device: Device) -> None:
    events: list[str] = []

    @contextlib.contextmanager
    def timed(name: str) -> Iterator[None]:
        events.append(f"+{name}")
        yield
        events.append(f"-{name}")

    graph = frame(events).compile(device, frozenset(), SIZE)
    graph.execute(lambda p: PassContext(device, graph, p.name, frame=1), timed)
    assert events[:3] == ["+forward", "forward", "-forward"]


def test_textures_of_a_pass(device: Device) -> None:
    seen: list[tuple[str, int, int]] = []

    def look(ctx: PassContext) -> None:
        desc = ctx.texture("half").desc
        seen.append((desc.format, desc.width, desc.height))
        assert not ctx.has("hdr")
        with pytest.raises(AssertionError, match="undeclared"):
            ctx.texture("hdr")

    graph = FrameGraph([make("a", lambda b: (b.create("half", "r8", scale=0.5), b.side_effect()), execute=look)])
    graph.compile(device, None, (5, 1)).execute()
    assert seen == [("r8", 3, 1)]
    with pytest.raises(UsageError, match="did you mean 'half'"):
        graph.compile(device, None, (5, 1)).texture("hlaf")


def test_dump_is_the_golden_text(device: Device) -> None:
    lut = device.texture(TextureDesc("rgba16f", 16, 16, "3d", depth=16))
    graph = FrameGraph(
        [
            make("forward", forward),
            make("bloom", lambda b: (b.read("hdr"), b.create("bloom", "rgba16f", scale=0.5, mips=0))),
            make("composite", lambda b: (b.read("bloom"), b.read("ao", optional=True), b.write("hdr"))),
            make("resolve", lambda b: (b.read("hdr"), b.create("taa", "rgba16f"), b.history("taa"))),
            make("blur", lambda b: (b.read("taa"), b.create("blurred", "rgba16f"))),
            make("water", lambda b: b.side_effect(), lambda facts: "there is no water"),
            make("grade", lambda b: (b.read("blurred"), b.import_texture("lut", lut), b.create("color", "rgba8"))),
            make("unused", lambda b: (b.read("taa"), b.create("probe", "r32f", size=(1, 1)))),
            make("output", lambda b: (b.read("color"), b.present("color"), b.side_effect())),
        ]
    ).compile(device, None, SIZE)
    golden = Path(__file__).parent / "data" / "frame.txt"
    assert graph.dump() == golden.read_text(encoding="utf-8")


def test_explain(device: Device) -> None:
    lines = explain(frame().compile(device, frozenset(), SIZE))
    assert lines[0] == "3 passes run: forward, composite, tone_map"
    assert "  ssao: the look has no ambient occlusion (saves 768 B)" in lines


@pytest.mark.parametrize(("count", "text"), [(0, "0 B"), (1024, "1.0 KiB"), (3686400, "3.5 MiB"), (5 << 30, "5.0 GiB")])
def test_human_bytes(count: int, text: str) -> None:
    assert human_bytes(count) == text
