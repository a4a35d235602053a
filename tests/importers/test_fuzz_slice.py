"""A slice of `python -m tests.fuzz`: every format once or twice, and that the run itself would notice a failure."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tests.fuzz import run
from tests.fuzz.mutate import DISK, mutant
from tests.fuzz.seeds import all_seeds


def test_slice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    tally = run.fuzz(32, 5, None, keep=tmp_path / "kept")
    assert not tally.failures, "\n".join(
        f"{f.number} {f.kind} {f.what}: {f.outcome} {f.message}" for f in tally.failures
    )
    kinds = {kind for kind, _ in tally.kinds}
    assert kinds == {seed.kind for seed in all_seeds(None)}
    assert {"glb", "gltf", "fbx ascii", "ogre mesh", "ogre material", "obj", "dae", "ktx2", "scene.json"} <= kinds
    outcomes = {outcome for _, outcome in tally.kinds}
    assert {"imported", "refused"} <= outcomes <= {"imported", "findings", "refused"}


def test_same_seed_same_mutants(tmp_path: Path) -> None:
    seeds = [seed for seed in all_seeds(None) if seed.kind in ("glb", "obj", "png", "scene.json")]
    for number, seed in enumerate(seeds):
        made = []
        for folder in (tmp_path / f"{number}a", tmp_path / f"{number}b"):
            folder.mkdir()
            what, entry = mutant(seed, random.Random(f"1/{number}"), folder)
            target = folder / seed.target
            made.append((what, entry, target.read_bytes() if target.is_file() and what not in DISK else b""))
        assert made[0] == made[1]


ANSWER = "import sys; sys.stdin.readline(); print(sys.argv[1], flush=True)"


@pytest.mark.parametrize(
    ("command", "outcome"),
    [
        (["-c", "import os; os.abort()"], "crash"),
        (["-c", "import time; time.sleep(60)"], "hang"),
        (["-c", ANSWER, '{"outcome": "imported"}'], "imported"),
    ],
)
def test_dead_children_are_noticed(command: list[str], outcome: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "MODULE", command)
    child = run.Child()
    assert child.ask({"path": "x"}, 1.5 if outcome == "hang" else 20.0)["outcome"] == outcome
    child.close()
