"""Conversion against other tools, on the same files: cold per file (process start included), and a whole folder.

Peers: gltf-transform, gltfpack, the assimp CLI, OgreXMLConverter; those that are not there are left out, with a
reason. They are found on PATH or in .cache/peers (`npm install --prefix .cache/peers @gltf-transform/cli gltfpack`;
Debian: assimp-utils, ogre-1.12-tools). What they do with a file is not the same: gltf-transform `copy` reads and
writes, `optimize` and gltfpack reorder and quantise the geometry, none of the three touches textures here; assimp
exports GLB; OgreXMLConverter writes XML. Ours reorders geometry and writes textures: once as they are (mips, no
compression), once as BC7, which none of the peers can.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from engine.report.summary import measure
from tests.bench.harness import Context, Row

ROOT = Path(__file__).resolve().parents[2]
ASSETS = Path(os.environ.get("LUCARNA_ASSETS", ROOT.parent / "shared" / "assets"))
LOCAL = ROOT / ".cache" / "peers" / "node_modules" / ".bin"
FILES = (
    "gltf/CesiumMan/glTF-Binary/CesiumMan.glb", "gltf/BrainStem/glTF-Binary/BrainStem.glb",
    "gltf/Duck/glTF-Binary/Duck.glb", "fbx/spider.fbx", "ogre/models/ninja.mesh", "ogre/models/athene.mesh",
)  # fmt: skip
#: tool -> (endings it reads, arguments before, suffix of the output, endings of its command)
Peer = tuple[str, tuple[str, ...], Callable[[str, Path, Path], list[str]]]
PEERS: tuple[Peer, ...] = (
    ("gltf-transform copy", (".glb", ".gltf"), lambda tool, a, b: [tool, "copy", str(a), str(b / "o.glb")]),
    ("gltf-transform optimize", (".glb", ".gltf"), lambda tool, a, b: [
        tool, "optimize", str(a), str(b / "o.glb"), "--compress", "quantize", "--texture-compress", "false"]),
    ("gltfpack", (".glb", ".gltf"), lambda tool, a, b: [tool, "-i", str(a), "-o", str(b / "o.glb")]),
    ("assimp export", (".glb", ".gltf", ".fbx"), lambda tool, a, b: [tool, "export", str(a), str(b / "o.glb")]),
    ("OgreXMLConverter", (".mesh",), lambda tool, a, b: [tool, "-q", "-log", str(b / "l"), str(a), str(b / "o.xml")]),
)  # fmt: skip
OURS = (("lucarna, textures as they are", ("--no-compress",)), ("lucarna, textures as BC7", ()))


def run(ctx: Context) -> list[Row]:
    """Rows of all files and the folder; notes hold the ratio to ours (textures as they are)."""
    rows: list[Row] = []
    repeats = 1 if ctx.quick else 5
    with tempfile.TemporaryDirectory(prefix="lucarna-bench-") as text:
        base = Path(text)
        for name in FILES:
            source = _find(name)
            if source is not None:
                rows += _file(source, base, repeats)
        rows += _folder(base, 16 if ctx.quick else 60)
    for name, _, _ in PEERS:
        if _tool(name) is None:
            print(f"  {name}: not there (see the head of {Path(__file__).name})", file=sys.stderr)
    return rows


def _find(name: str) -> Path | None:
    exact = ASSETS / name
    return exact if exact.is_file() else next(iter(sorted(ASSETS.rglob(exact.name))), None)


def _tool(name: str) -> str | None:
    command = name.split()[0]
    local = LOCAL / command
    return str(local) if local.exists() else shutil.which(command)


def _lucarna(sources: list[Path], base: Path, flags: tuple[str, ...]) -> None:
    """Convert into `base`/ours, with a cache of its own there."""
    command = [sys.executable, "-m", "importers.cli.main", "convert", *map(str, sources)]
    command += ["--out", str(base / "ours" / "out"), "--jobs", "2", "--quiet", *flags]
    environment = os.environ | {"LUCARNA_CACHE": str(base / "ours" / "cache")}
    subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, check=False)


def _cold(sources: list[Path], base: Path, flags: tuple[str, ...]) -> None:
    shutil.rmtree(base / "ours", ignore_errors=True)
    _lucarna(sources, base, (*flags, "--force"))


def _file(source: Path, base: Path, repeats: int) -> list[Row]:
    rows = []
    for stage, flags in OURS:
        time = measure(partial(_cold, [source], base, flags), repeats=repeats, warm_up=1)
        rows.append(Row(source.name, stage, time))
    for name, endings, command in PEERS:
        tool = _tool(name)
        if tool is None or source.suffix.lower() not in endings:
            continue
        out = base / "peer"
        out.mkdir(exist_ok=True)
        line = command(tool, source, out)
        done = subprocess.run(line, capture_output=True, check=False, cwd=out)
        if done.returncode != 0:
            print(f"  {name}: refuses {source.name}", file=sys.stderr)
            continue
        rows.append(Row(source.name, name, measure(partial(_run, line, out), repeats=repeats, warm_up=0)))
    return _compared(rows)


def _run(line: list[str], folder: Path) -> None:
    subprocess.run(line, capture_output=True, check=False, cwd=folder)


def _folder(base: Path, most: int) -> list[Row]:
    """A folder of glTF files: ours in one process with a warm pool, each peer once per file, all on two processors."""
    sources = [p for p in sorted(ASSETS.glob("gltf*/**/*.gl[tb]*")) if p.suffix in (".glb", ".gltf")][:most]
    if not sources:
        return []
    case = f"folder of {len(sources)} glTF files, 2 jobs"
    rows = []
    for stage, flags in OURS:
        rows.append(Row(case, stage, measure(partial(_cold, sources, base, flags), repeats=1, warm_up=0)))
    again = measure(partial(_lucarna, sources, base, OURS[-1][1]), repeats=3, warm_up=1)
    rows.append(Row(case, "lucarna, run again", again))
    for name, endings, command in PEERS:
        tool = _tool(name)
        if tool is None or ".glb" not in endings:
            continue
        lines = []
        for number, source in enumerate(sources):
            out = base / f"peer{number}"
            out.mkdir(exist_ok=True)
            lines.append(command(tool, source, out))
        rows.append(Row(case, name, measure(partial(_two_at_a_time, lines), repeats=1, warm_up=0)))
    return _compared(rows)


def _two_at_a_time(lines: list[list[str]]) -> None:
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda line: subprocess.run(line, capture_output=True, check=False), lines))


def _compared(rows: list[Row]) -> list[Row]:
    """With each peer's time by ours in its note."""
    ours = rows[0].time.median
    return [rows[0], *(replace(row, note=f"{row.time.median / ours:.2f} of ours") for row in rows[1:])]
