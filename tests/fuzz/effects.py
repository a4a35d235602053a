"""Random edits of effects, shaders and materials of an open scene: `python -m tests.fuzz.effects --count 10000`.

Each edit damages one file (bytes, text, or structure: TOML tables, GLSL statements and blocks), seeded. It may be
refused with a place, and then the picture must stay bit for bit, or be taken over; then the file comes back as it was.
Anything else is a failure: an exception, a GPU object left behind, another picture, a problem that remains.
"""

from __future__ import annotations

import argparse
import gc
import os
import random
import re
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from engine.gpu.types import Device
from tests.resources.test_hot_reload import EFFECT, FRAG, INCLUDE, MATERIAL, TONE, Project

VERT = "shaders/effects/surface.vert"
#: of an effect that computes its textures, and extends the one above
COMPUTED, COMP = "shaders/effects/wood.effect.toml", "shaders/effects/wood.comp"
FILES = (FRAG, FRAG, EFFECT, EFFECT, EFFECT, INCLUDE, MATERIAL, TONE, VERT, COMPUTED, COMPUTED, COMP, COMP)
TOKENS = (
    b"{", b"}", b"(", b";", b"[", b"]", b'"', b"=", b"#", b"\x00", b"\xff", b"\xed\xa0\x80", b"\r", b"//", b"/*",
    b"#if ", b"#endif\n", b'#include "lib/lights.glsl"\n', b'extends = "surface"\n', b"[params.x]\n", b"nan", b"1e999",
    b"vec3", b"float", b"discard;", b"\n" * 50, "ä漢".encode(), b"-1", b"99999999999999999999", b"true", b"''", b"\\",
    b"#define color\n", b"#version 450\n", b"#line 9\n", b"const ", b'#include "../../secret"\n',
    b"#extension all : x\n",
)  # fmt: skip
#: what stands in the place of a TOML value
VALUES: tuple[Any, ...] = (
    "", "surface", "float", "#$%\n", 0, -1, 1 << 62, 0.5, -1e308, float("nan"), float("inf"), True, [], [[]], {},
    [1.0] * 5, {"test": 1}, ["normal_map"], "x" * 5000, "../../etc/passwd",
)  # fmt: skip

#: edits between two counts of GPU objects
ROUND = 500


# --- kinds of damage: bytes -> bytes ---


def bytes_flipped(data: bytes, rng: random.Random) -> bytes:
    made = bytearray(data)
    for _ in range(rng.randint(1, 6)):
        made[rng.randrange(len(made))] = rng.randrange(256)
    return bytes(made)


def token_inserted(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data))
    return data[:at] + rng.choice(TOKENS) + data[at:]


def span_removed(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data))
    return data[:at] + data[at + rng.randint(1, 60) :]


def truncated(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data))]


def lines_shuffled(data: bytes, rng: random.Random) -> bytes:
    lines = data.split(b"\n")
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(3)
    if kind == 0:
        lines[a], lines[b] = lines[b], lines[a]
    elif kind == 1:
        lines.insert(a, lines[b])
    else:
        del lines[min(a, b) : max(a, b) + 1]
    return b"\n".join(lines)


def word_replaced(data: bytes, rng: random.Random) -> bytes:
    """A word of the file in the place of another: structure that is nearly right."""
    words = list(re.finditer(rb"[A-Za-z_][A-Za-z0-9_.]*|\d+(?:\.\d+)?", data))
    a, b = rng.choice(words), rng.choice(words)
    return data[: a.start()] + b.group() + data[a.end() :]


def number_changed(data: bytes, rng: random.Random) -> bytes:
    numbers = list(re.finditer(rb"\d+(?:\.\d+)?", data))
    if not numbers:
        return data + b"0"
    a = rng.choice(numbers)
    return data[: a.start()] + rng.choice((b"0", b"-1.0", b"1e30", b"inf", b"7", b'"7"', b"[]")) + data[a.end() :]


def structure_changed(data: bytes, rng: random.Random) -> bytes:
    """TOML: a table or value goes, moves, doubles, or becomes something else. GLSL: the same with blocks and
    statements."""
    try:
        tables = tomllib.loads(data.decode("utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError):
        return _code_changed(data, rng)
    import tomlkit

    for _ in range(rng.randint(1, 3)):
        _table_changed(tables, rng)
    return tomlkit.dumps(tables).encode("utf-8", "replace")


def _table_changed(tables: dict[str, Any], rng: random.Random) -> None:
    every: list[dict[str, Any]] = [tables]
    for table in every:
        every += [value for value in table.values() if isinstance(value, dict)]
    table = rng.choice([t for t in every if t] or every)
    if not table:
        return
    key, kind = rng.choice(list(table)), rng.randrange(5)
    if kind == 0:
        del table[key]
    elif kind == 1:
        table[key] = rng.choice(VALUES)
    elif kind == 2:
        table[rng.choice(("nme", "params", "x" * 300, "a b", "ä", key + "2"))] = table.pop(key)
    elif kind == 3:
        other = rng.choice(every)
        if other is not table[key]:
            other[rng.choice(list(other) or ["y"])] = rng.choice(VALUES)
    else:
        table[key] = {"inner": {"more": [rng.choice(VALUES)]}}


def _code_changed(data: bytes, rng: random.Random) -> bytes:
    blocks = list(re.finditer(rb"\{[^{}]*\}", data)) or list(re.finditer(rb"[^;\n]+;", data))
    statements = list(re.finditer(rb"[^;{}\n]+;", data))
    parts = blocks if rng.random() < 0.4 else statements
    if not parts:
        return data + b"\n"
    a, b, kind = rng.choice(parts), rng.choice(parts), rng.randrange(3)
    if kind == 0:
        return data[: a.start()] + data[a.end() :]
    if kind == 1:
        return data[: a.end()] + b.group() + data[a.end() :]
    return data[: a.start()] + b.group() + data[a.end() :]


CHANGES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    bytes_flipped, token_inserted, span_removed, truncated, lines_shuffled, word_replaced, word_replaced,
    number_changed, structure_changed, structure_changed,
)  # fmt: skip


# --- the run ---


@dataclass(slots=True)
class Tally:
    """Counts by (what was done, outcome); `failures`: in words. `leaked`: GPU objects by kind."""

    changes: Counter[tuple[str, str]] = field(default_factory=Counter)
    files: Counter[tuple[str, str]] = field(default_factory=Counter)
    failures: list[str] = field(default_factory=list)
    leaked: dict[str, int] = field(default_factory=dict)
    compared: int = 0

    def outcome(self, name: str) -> int:
        return sum(count for (_, outcome), count in self.changes.items() if outcome == name)

    def table(self) -> str:
        lines = []
        for title, counts in (("damage", self.changes), ("file", self.files)):
            outcomes = sorted({outcome for _, outcome in counts})
            lines.append(f"{title:<22}" + "".join(f"{o:>18}" for o in outcomes) + f"{'all':>8}")
            for name in sorted({name for name, _ in counts}):
                row = [counts[name, outcome] for outcome in outcomes]
                lines.append(f"{name:<22}" + "".join(f"{n or '':>18}" for n in row) + f"{sum(row):>8}")
            lines.append("")
        return "\n".join(lines)


def fuzz(
    device: Device, folder: Path, count: int, seed: int, tell: Callable[[int, Tally], None] | None = None
) -> Tally:
    """Make `count` edits in a project in `folder`; the same seed makes the same edits."""
    tally = Tally()
    project = Project(device, folder, effect="wood")
    try:
        for file in dict.fromkeys(FILES):
            write(folder / file, (folder / file).read_bytes(), -1.0)
        good = project.picture()
        project.poll()
        project.picture()
        before = settled(device)
        for step in range(count):
            rng = random.Random(f"{seed}/{step}")
            _one(project, good, step, rng, tally)
            if tell is not None:
                tell(step + 1, tally)
            if (step + 1) % ROUND == 0 or step + 1 == count:
                after = settled(device)
                tally.leaked = {kind: after[kind] - before[kind] for kind in after if after[kind] > before[kind]}
                if tally.leaked:
                    tally.failures.append(f"{step}: left behind {tally.leaked}")
                    break
    finally:
        project.runtime.close()
    return tally


def _one(project: Project, good: Any, step: int, rng: random.Random, tally: Tally) -> None:
    file, change = rng.choice(FILES), rng.choice(CHANGES)
    path = project.folder / file
    sound = path.read_bytes()
    fuzzed = change(sound, rng)
    write(path, fuzzed, step)
    name = f"{step} ({change.__name__} of {file})"
    try:
        result = project.poll()
        assert result is not None, "the edit was not noticed"
        outcome = "taken" if result.names else "no difference"
        if result.problems:
            outcome = "taken, complaints" if result.names else f"refused: {_kind(result.problems[0])}"
        if not result.names:  # a fuzzed shader that compiles may never end: only what must be good is drawn
            tally.compared += 1
            if not np.array_equal(project.picture(), good):
                tally.failures.append(f"{name}: the picture is not the last good one")
        for problem in result.problems:
            assert problem.where.file, f"no place: {problem}"
    except Exception as error:  # whatever it is, it is what is looked for here
        outcome = "failed"
        tally.failures.append(f"{name}: {type(error).__name__}: {error}")
    tally.changes[change.__name__, outcome] += 1
    tally.files[Path(file).name, outcome] += 1
    write(path, sound, step + 0.5)
    project.poll()
    if project.problems:
        tally.failures.append(f"{name}: remains {project.problems[0]}")
    elif outcome.startswith("taken") and step % 4 == 0 and not np.array_equal(project.picture(), good):
        tally.failures.append(f"{name}: the picture is another one after the file came back")


def _kind(problem: Exception) -> str:
    text = str(problem)
    if "does not link" in text:
        return "link"
    if " stage of " in text:
        return "compile"
    return "include" if "#" in text.split("\n")[0] else "text"


def write(path: Path, data: bytes, step: float) -> None:
    """With a time of its own: edits come faster here than some clocks tick."""
    path.write_bytes(data)
    os.utime(path, ns=(0, int((1000 + step) * 1e9)))


def settled(device: Device) -> dict[str, int]:
    """GPU objects by kind, when all that was let go is gone."""
    gc.collect()
    device.end_frame()
    return dict(device.live_objects())


def main() -> int:
    from engine.gpu import open_device

    parser = argparse.ArgumentParser(prog="python -m tests.fuzz.effects", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    os.environ.setdefault("LUCARNA_PROGRAM_CACHE", "off")  # mutants are not worth keeping
    started = time.perf_counter()

    def tell(done: int, tally: Tally) -> None:
        if done % 500 == 0:
            print(f"{done} in {time.perf_counter() - started:.0f} s, {len(tally.failures)} failed", flush=True)

    with tempfile.TemporaryDirectory(prefix="lucarna-effects-") as folder:
        os.environ.setdefault("MESA_SHADER_CACHE_DIR", f"{folder}/driver")
        device = open_device("gl", debug=True)
        tally = fuzz(device, Path(folder) / "project", args.count, args.seed, tell)
        device.release()
    print(tally.table())
    for failure in tally.failures[:40]:
        print(failure)
    print(
        f"{args.count} edits, {tally.compared} pictures compared, {len(tally.failures)} failures, left behind: "
        f"{tally.leaked or 'nothing'}, {time.perf_counter() - started:.0f} s"
    )
    return 1 if tally.failures else 0


if __name__ == "__main__":
    sys.exit(main())
