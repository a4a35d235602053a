"""The same source imported by the editor and by `lucarna convert`: are the files equal, byte for byte?

    python -m tests.same_bytes [FOLDER|FILE…]   default: all of ../shared/assets; one line a source, exit code 1 if not

Each side has a cache of its own, so that neither can hand its files to the other. A source that one side refuses must
be refused by the other too.
"""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


@dataclass(slots=True)
class Verdict:
    """`different`: names of files that differ or that one side lacks; `refused`: what both said, '' where imported."""

    source: Path
    files: int = 0
    bytes: int = 0
    different: list[str] = field(default_factory=list)
    refused: str = ""

    @property
    def equal(self) -> bool:
        return not self.different


def compare(source: Path, folder: Path) -> Verdict:
    """Import `source` both ways, below `folder`."""
    verdict = Verdict(source)
    with _cache(folder / "editor cache"):
        edited, said = _by_editor(source)
    with _cache(folder / "cli cache"):
        converted, code, told = _by_command(source, folder / "out")
    if not edited or not converted:
        verdict.refused = said or told
        if bool(edited) != bool(converted):
            verdict.different = [f"only one side imported it: editor {said!r}, command {code} {told!r}"]
        return verdict
    for name in sorted({*edited, *converted}):
        one, other = edited.get(name), converted.get(name)
        if one is None or other is None or one.read_bytes() != other.read_bytes():
            verdict.different.append(name)
        else:
            verdict.files += 1
            verdict.bytes += one.stat().st_size
    return verdict


def _by_editor(source: Path) -> tuple[dict[str, Path], str]:
    """(name -> file, what kept it from being imported), by what the window runs for File, Open."""
    from editor.host import EngineHost
    from editor.opening import OpenJob

    job = OpenJob(EngineHost(), source)
    job.wait()
    if job.result is None:
        return {}, str(job.error)
    folder = job.result.scene.parent
    return {p.name: p for p in folder.iterdir() if p.name != "import.json"}, ""


def _by_command(source: Path, out: Path) -> tuple[dict[str, Path], int, str]:
    from importers.cli.main import main

    told = io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
        code = main(["convert", str(source), "--out", str(out)])
    shown = [p for p in out.rglob("*") if p.is_file() and not any(n.startswith(".") for n in p.relative_to(out).parts)]
    files = {p.name: p for p in shown}  # what is hidden are the farm's own records
    return files, code, told.getvalue().strip().splitlines()[-1] if code else ""


@contextlib.contextmanager
def _cache(folder: Path) -> Iterator[None]:
    before = os.environ.get("LUCARNA_CACHE")
    os.environ["LUCARNA_CACHE"] = str(folder)
    try:
        yield
    finally:
        if before is None:
            del os.environ["LUCARNA_CACHE"]
        else:
            os.environ["LUCARNA_CACHE"] = before


def sources_in(folder: Path) -> list[Path]:
    """The files of a folder that the editor opens; images that stand alone too."""
    from importers.registry import source_extensions

    endings = source_extensions()
    return sorted(p for p in folder.rglob("*") if p.is_file() and p.name.lower().endswith(endings))


def main(arguments: Sequence[str]) -> int:
    os.environ.setdefault("LUCARNA_IN_PROCESS", "1")
    paths = [Path(a) for a in arguments] or [ROOT.parent / "shared" / "assets"]
    sources = [s for p in paths for s in (sources_in(p) if p.is_dir() else [p])]
    started, bad, refused, files, size = time.perf_counter(), 0, 0, 0, 0
    for number, source in enumerate(sources, 1):
        folder = Path(tempfile.mkdtemp(prefix="same-bytes-"))
        try:
            verdict = compare(source, folder)
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        bad += not verdict.equal
        refused += bool(verdict.refused)
        files, size = files + verdict.files, size + verdict.bytes
        state = "DIFFERENT " + ", ".join(verdict.different) if not verdict.equal else "equal"
        state += f" (refused: {verdict.refused[:100]})" if verdict.refused else f" ({verdict.files} files)"
        print(f"{number}/{len(sources)} {source}: {state}", flush=True)
    seconds = time.perf_counter() - started
    print(
        f"{len(sources)} sources, {bad} different, {refused} refused by both; {files} files, {size / 1e6:.1f} MB "
        f"equal; {seconds:.0f} s"
    )
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
