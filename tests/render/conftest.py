"""The stage of the renderer's tests: a uniform environment, no sun."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from engine.assets.material import MaterialAsset
from engine.gpu.types import Device
from tests.support.stage import Stage
from tests.support.stage import surface as make_surface


@pytest.fixture
def stage(gl_device: Device) -> Iterator[Stage]:
    made = Stage(gl_device, kind="uniform", sun_illuminance=0.0)
    yield made
    made.close()


@pytest.fixture
def null_stage(null_device: Device) -> Iterator[Stage]:
    made = Stage(null_device, kind="uniform", sun_illuminance=0.0)
    yield made
    made.close()


@pytest.fixture
def surface() -> Callable[..., MaterialAsset]:
    """A surface material by parameters."""
    return make_surface
