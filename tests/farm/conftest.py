"""Tests of the farm: a cache of their own, and a small folder of sources."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

ROOT = str(Path(__file__).resolve().parents[2])
if ROOT not in sys.path:
    sys.path.insert(0, ROOT)

from tests.support.gltf_builder import png, textured_triangle, triangle  # noqa: E402  (the path comes first)


@pytest.fixture(autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path_factory.mktemp("cache")))


@pytest.fixture
def real_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Worker processes, which most tests do without."""
    monkeypatch.delenv("LUCARNA_IN_PROCESS", raising=False)


@pytest.fixture
def depot(tmp_path: Path) -> Path:
    """`red.gltf` and `blue.gltf` show paint.png, `sub/plain.glb` shows nothing."""
    folder = tmp_path / "depot"
    (folder / "sub").mkdir(parents=True)
    for name in ("red", "blue"):
        builder = textured_triangle()
        builder.root["images"][0] = {"uri": "paint.png"}
        builder.write_gltf(folder / f"{name}.gltf")
    (folder / "paint.png").write_bytes(png(4, 4))
    triangle().write_glb(folder / "sub" / "plain.glb")
    return folder
