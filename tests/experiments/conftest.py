"""Experiments run with the importers' tools and a cache of their own."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from engine.experiments.harness.context import Context
from engine.experiments.harness.references import ReferenceCache
from engine.gpu.types import Device
from importers.cli.report_tools import ImporterTools


@pytest.fixture(scope="session")
def references(tmp_path_factory: pytest.TempPathFactory) -> ReferenceCache:
    return ReferenceCache(tmp_path_factory.mktemp("references"))


@pytest.fixture
def quick(gl_device: Device, references: ReferenceCache) -> Callable[[], Context]:
    """Contexts as `lucarna report --quick` makes them."""
    return lambda: Context(device=gl_device, quick=True, references=references, tools=ImporterTools())
