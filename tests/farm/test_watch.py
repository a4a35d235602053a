"""--watch: changes, new and vanished files, mistakes that are mended."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from pathlib import Path

import pytest

from importers.farm.job import Outcome
from importers.farm.plan import Plan, make_plan
from importers.farm.run import Farm, LocalWorkers, Options
from importers.farm.watch import watch
from importers.presets import SettingsResolver
from tests.support.gltf_builder import png, triangle


class Heard:
    """What the watch told of, round by round."""

    def __init__(self) -> None:
        self.rounds: list[tuple[dict[str, str], list[str]]] = []

    def begin(self, total: int) -> None: ...

    def close(self) -> None: ...

    def again(self, outcomes: Sequence[Outcome], gone: Sequence[Path]) -> None:
        self.reasons = {o.job.source.name: o.reasons for o in outcomes}
        self.rounds.append(({o.job.source.name: o.state for o in outcomes}, [p.name for p in gone]))


def test_watch(depot: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, over, heard = depot.parent / "out", threading.Event(), Heard()
    (depot / "blue.gltf.import").write_text("")

    def plan() -> Plan:
        return make_plan([str(depot)], out, SettingsResolver())

    farm = Farm(Options(out), LocalWorkers)
    first = plan()
    outcomes = farm.run(first.jobs, 1)
    thread = threading.Thread(target=watch, args=(plan, first, outcomes, farm, 1, heard, over.is_set))
    thread.start()

    def after(change: object, rounds: int) -> tuple[dict[str, str], list[str]]:
        deadline = time.monotonic() + 20
        while len(heard.rounds) < rounds and time.monotonic() < deadline:
            time.sleep(0.02)
        return heard.rounds[rounds - 1]

    try:
        time.sleep(0.1)
        changed = after((depot / "paint.png").write_bytes(png(4, 4, (9, 9, 9))), 1)
        assert changed == ({"red.gltf": "converted", "blue.gltf": "converted"}, [])
        assert after(triangle().write_glb(depot / "sub" / "new.glb"), 2) == ({"new.glb": "converted"}, []), (
            heard.reasons
        )
        assert after((depot / "sub" / "new.glb").unlink(), 3) == ({}, ["new.glb"])
        (depot / "blue.gltf.import").write_text("qualty = 3")
        while "did you mean 'quality'" not in capsys.readouterr().err:
            # a mistake in a sidecar is a refusal of that source
            if len(heard.rounds) >= 4:
                break
            time.sleep(0.02)
        rounds = len(heard.rounds)
        assert after((depot / "blue.gltf.import").write_text("quality = 'draft'"), rounds + 1)[0] == {
            "blue.gltf": "converted"
        }
    finally:
        over.set()
        thread.join(20)
    assert (out / "sub" / "new.scene.json").is_file()
