"""Stability tests: a stage, a probe of the shaders' functions, and `tests.support` importable from anywhere."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from engine.gpu.types import Device

ROOT = str(Path(__file__).resolve().parents[2])
if ROOT not in sys.path:
    sys.path.insert(0, ROOT)

from tests.support.shader_probe import ShaderProbe  # noqa: E402  # the path has to be set first
from tests.support.stage import Stage  # noqa: E402  # likewise


@pytest.fixture
def stage(gl_device: Device) -> Iterator[Stage]:
    made = Stage(gl_device)
    yield made
    made.close()


@pytest.fixture
def probe(gl_device: Device, tmp_path: Path) -> ShaderProbe:
    return ShaderProbe(gl_device, tmp_path)
