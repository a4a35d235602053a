from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.experiments.harness.references import ReferenceCache


@pytest.fixture
def cache(tmp_path: Path) -> ReferenceCache:
    return ReferenceCache(tmp_path / "references")


def test_made_once_then_read(cache: ReferenceCache) -> None:
    calls = []

    def make() -> dict[str, np.ndarray]:
        calls.append(1)
        return {"a": np.arange(5.0), "noise_floor": np.array(1e-9)}

    first, second = (cache.get("truth", {"n": 5}, make) for _ in range(2))
    assert len(calls) == 1
    np.testing.assert_array_equal(first["a"], second["a"])
    assert float(second["noise_floor"]) == 1e-9


def test_whatever_goes_in_changes_the_key(cache: ReferenceCache) -> None:
    keys = [{"n": 5}, {"n": 6}, {"m": 5}, {"n": np.arange(3)}, {"n": np.arange(3.0)}, {"n": np.array([0, 1, 3])}]
    paths = [cache.path("truth", key) for key in keys] + [cache.path("other", keys[0]), cache.path("truth", keys[0], 7)]
    assert len(set(paths)) == len(paths)
    assert cache.path("truth", {"a": 1, "b": 2}) == cache.path("truth", {"b": 2, "a": 1})
    assert paths[-1].name.endswith("-seed7.npz")


@pytest.mark.parametrize("junk", [b"", b"PK\x03\x04 no", b"\x93NUMPY"])
def test_a_damaged_file_is_made_anew(cache: ReferenceCache, junk: bytes) -> None:
    def make() -> dict[str, np.ndarray]:
        return {"a": np.ones(2)}

    cache.get("t", {}, make)
    cache.path("t", {}).write_bytes(junk)
    assert cache.get("t", {}, make)["a"].tolist() == [1.0, 1.0]
    assert cache.path("t", {}).stat().st_size > len(junk)


def test_objects_are_never_unpickled(cache: ReferenceCache) -> None:
    path = cache.path("t", {})
    path.parent.mkdir(parents=True)
    with path.open("wb") as file:
        np.savez(file, a=np.array([{"x": 1}], dtype=object))
    assert cache.get("t", {}, lambda: {"a": np.zeros(1)})["a"].tolist() == [0.0]
