"""Damaged FBX files: each is imported in part or refused in words; none costs more than its own worker."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

from engine.assets.lanim import check_channel
from engine.assets.lmesh import check_mesh
from engine.core.errors import LucarnaError, Place
from importers.fbx.reader import load
from importers.model import ImportedModel
from importers.settings import ImportSettings
from tests.support.fbx_builder import rich_scene

SETTINGS = ImportSettings(max_worker_seconds=20.0, max_worker_bytes=2 << 30)
NUMBERS = ("-1", "4294967295", "1e400", "nan", "99999999999999999999", "0", "-2147483648", "*9999999")


def mutant(text: str, seed: int) -> str:
    rng = random.Random(seed)
    kind = rng.randrange(6)
    if kind == 0:
        return text[: rng.randrange(200, len(text))]
    if kind == 1:
        lines = text.split("\n")
        del lines[rng.randrange(len(lines))]
        return "\n".join(lines)
    if kind == 2:
        links = [line for line in text.split("\n") if line.startswith("C: ")]
        one, other = rng.choice(links), rng.choice(links)
        return text.replace(one, ",".join([*one.split(",")[:2], *other.split(",")[2:]]), 1)
    spots = [match.span() for match in re.finditer(r"-?\d+\.?\d*", text)]
    for first, last in sorted(rng.sample(spots, 1 + kind // 4), reverse=True):
        text = text[:first] + rng.choice(NUMBERS) + text[last:]
    return text


def attempt(path: Path) -> tuple[ImportedModel | None, str]:
    try:
        return load(path, SETTINGS), ""
    except LucarnaError as error:
        return None, str(error)


def test_the_whole_file_is_sound(tmp_path: Path) -> None:
    path = tmp_path / "a.fbx"
    path.write_text(rich_scene(), encoding="utf-8")
    model = load(path, SETTINGS)
    assert (len(model.meshes), len(model.clips), len(model.materials)) == (1, 1, 1)
    assert model.meshes[0].skeleton is not None
    assert sorted(c.path for c in model.clips[0].channels) == ["rotation", "translation", "weights"]


@pytest.mark.parametrize("seed", range(24))
def test_mutants(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "a.fbx"
    path.write_text(mutant(rich_scene(), seed), encoding="utf-8")
    model, refusal = attempt(path)
    if model is None:
        assert "a.fbx" in refusal
        assert "makes no sense" not in refusal
        assert "crashed" not in refusal
        return
    for mesh in model.meshes:
        check_mesh(mesh, Place("mesh"))
    for clip in model.clips:
        for channel in clip.channels:
            check_channel(channel, Place("channel"))
