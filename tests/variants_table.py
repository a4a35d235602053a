"""Which shader variants real files make: `python -m tests.variants_table [FOLDER] [--only TEXT] [--explain]`.

Each source is imported, drawn once, small, and its variants are counted against what the features of their effects
would allow (2 to their number for each technique that the scene draws with). Variants that differ in state alone share
a program. `--explain`: what caused each. Exit code 1 where a variant has an error or nothing wants it.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from engine.app.headless import render_image
from engine.app.runtime import Runtime
from engine.core.errors import LucarnaError
from engine.gpu import open_device
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View
from importers.opening import open_path
from importers.registry import source_extensions
from importers.settings import ImportSettings
from importers.variant_inspection import SIZE, variant_rows

ROOT = Path(__file__).resolve().parents[1]
#: what is broken on purpose, and what has no surfaces
SKIPPED = ("malformed",)


@dataclass(slots=True)
class Line:
    """One file: its materials, and its variants as `inspect` tells them."""

    path: Path
    materials: int = 0
    possible: int = 0
    variants: list[dict[str, Any]] = field(default_factory=list)
    error: str = ""

    @property
    def wrong(self) -> list[dict[str, Any]]:
        return [variant for variant in self.variants if variant["error"] or not variant["used_by"]]


def rows(device: Device, folder: Path, only: str = "") -> Iterator[Line]:
    """All sources below `folder`, sorted, one after another."""
    known = source_extensions(in_folders=True)
    for path in sorted(p for p in folder.rglob("*") if p.name.lower().endswith(known) and p.is_file()):
        if only in str(path) and not any(part in SKIPPED for part in path.relative_to(folder).parts):
            yield row(device, path)


def row(device: Device, path: Path) -> Line:
    line = Line(path)
    runtime = Runtime(device, profile=False)
    try:
        open_path(runtime, path, settings=ImportSettings(max_worker_seconds=60.0))
        view = View(runtime.default_camera(SIZE[0] / SIZE[1]), *SIZE, RenderSettings(samples=1))
        render_image(runtime, view)
        line.variants = variant_rows(runtime)
        line.materials = len(runtime.renderer.draws.materials)
        effects = runtime.residency.effects
        roles = {(variant["effect"], variant["role"]) for variant in line.variants}
        line.possible = sum(2 ** len(effects.get(effect).features) for effect, _ in roles)
    except LucarnaError as error:
        line.error = error.message.split("\n")[0]
    finally:
        runtime.close()
    return line


def cause(variant: dict[str, Any]) -> str:
    """`forward normal_map, unlit: why each; for these materials`."""
    features = "; ".join(f"{name}: {why}" for name, why in sorted(variant["reasons"].items())) or "no features"
    streams = ", ".join(name for name in variant["streams"] if name != "object")
    used = variant["used_by"][:4] + ["…"] * (len(variant["used_by"]) > 4)
    state = "".join(f", {word}" for word in variant["state"])
    return f"{variant['effect']} {variant['role']} ({streams}{state}): {features}; for {', '.join(used) or 'nobody'}"


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.variants_table", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT.parent / "shared" / "assets")
    parser.add_argument("--only", default="", metavar="TEXT", help="files whose path holds this")
    parser.add_argument("--explain", action="store_true", help="what caused each variant")
    args = parser.parse_args()
    folder = Path(os.environ.get("LUCARNA_ASSETS", args.folder))
    device = open_device("gl")
    files = failed = wrong = 0
    counts: Counter[int] = Counter()
    sets: Counter[str] = Counter()
    print("| file | materials | variants | programs | possible | roles |\n|---|---:|---:|---:|---:|---|")
    with tempfile.TemporaryDirectory() as cache:
        os.environ.setdefault("LUCARNA_CACHE", cache)
        for line in rows(device, folder, args.only):
            files += 1
            name = line.path.relative_to(folder).as_posix()
            if line.error:
                failed += 1
                print(f"| {name} | | | | | not opened: {line.error[:60]} |", flush=True)
                continue
            roles = Counter(variant["role"] for variant in line.variants)
            told = ", ".join(f"{count} {role}" for role, count in sorted(roles.items()))
            programs = len({variant["program"] for variant in line.variants})
            numbers = f"{line.materials} | {len(line.variants)} | {programs} | {line.possible:,}"
            print(f"| {name} | {numbers} | {told} |", flush=True)
            counts[len(line.variants)] += 1
            wrong += len(line.wrong)
            for variant in line.variants:
                sets[f"{variant['effect']} {variant['role']}: {', '.join(variant['features']) or 'none'}"] += 1
                if args.explain:
                    print(f"|   {cause(variant)} | | | | | |")
    device.release()
    print(f"\n{files} files, {failed} not opened; files by number of variants: {dict(sorted(counts.items()))}")
    print(f"{len(sets)} different sets of features in all; the most common:")
    for text, count in sets.most_common(12):
        print(f"  {count:>4} {text}")
    print(f"{wrong} variants with an error or without a cause")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
