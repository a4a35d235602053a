"""Pruning tests: a stage, the textures that random scenes use, and `tests.support` importable from anywhere."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from engine.gpu.types import Device

ROOT = str(Path(__file__).resolve().parents[2])
if ROOT not in sys.path:
    sys.path.insert(0, ROOT)

from tests.pruning.scenes import write_textures  # noqa: E402  # the path has to be set first
from tests.support.stage import Stage  # noqa: E402  # likewise


@pytest.fixture(scope="session")
def texture_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("textures")
    write_textures(folder)
    return folder


@pytest.fixture
def stage(gl_device: Device) -> Iterator[Stage]:
    made = Stage(gl_device)
    yield made
    made.close()
