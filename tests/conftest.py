"""Fixtures for all tests: the shared assets, and devices that are checked for errors and leaks after each test."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from engine.core.errors import DeviceError
from engine.gpu import open_device
from engine.gpu.types import Device

ROOT = Path(__file__).resolve().parent.parent

#: shared by descriptor and kept by the device on purpose
CACHED_KINDS = ("sampler", "program", "query")


# Imports in this process: a worker costs half a second, and most tests are about what comes after it. Tests of the
# workers and of the farm take this away again.
os.environ.setdefault("LUCARNA_IN_PROCESS", "1")

# Compile what is tested, whatever the user's cache holds. Tests of the program cache give it a folder of its own.
os.environ.setdefault("LUCARNA_PROGRAM_CACHE", "off")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "keeps_objects: leaves GPU objects behind on purpose (no leak check)")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Whatever uses the device is marked `gl`, whatever uses the shared assets `assets`."""
    for item in items:
        names = getattr(item, "fixturenames", ())
        if "gl_device" in names:
            item.add_marker(pytest.mark.gl)
        if "shared_assets" in names:
            item.add_marker(pytest.mark.assets)


@pytest.fixture(scope="session")
def shared_assets() -> Path:
    """The folder of test assets shared between checkouts; LUCARNA_ASSETS overrides where it is."""
    folder = Path(os.environ.get("LUCARNA_ASSETS", ROOT.parent / "shared" / "assets"))
    if not folder.is_dir():
        pytest.skip(f"no shared assets at {folder}; set LUCARNA_ASSETS")
    return folder


@pytest.fixture(scope="session")
def gl_device() -> Iterator[Device]:
    """One OpenGL device without a window for the whole session, in debug mode."""
    try:
        device = open_device("gl", debug=True)
    except DeviceError as error:
        pytest.skip(f"no OpenGL device: {error}")
    yield device
    device.release()


@pytest.fixture
def null_device() -> Device:
    """A fresh recording device; its call stream is `null_device.calls`."""
    return open_device("null")


@pytest.fixture(autouse=True)
def _gl_clean_after_test(request: pytest.FixtureRequest) -> Iterator[None]:
    """A test that uses gl_device leaves no GL error, open pass or unreleased object."""
    if "gl_device" not in request.fixturenames:
        yield
        return
    device: Device = request.getfixturevalue("gl_device")
    before = _settled(device)
    yield
    after = _settled(device)
    if request.node.get_closest_marker("keeps_objects"):
        return
    leaked = {kind: after[kind] - before[kind] for kind in after if after[kind] > before[kind]}
    assert not leaked, f"GPU objects not released: {leaked}"


def _settled(device: Device) -> dict[str, int]:
    gc.collect()
    device.end_frame()  # frees what the collector let go; raises on GL errors
    return {kind: count for kind, count in device.live_objects().items() if kind not in CACHED_KINDS}
