from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import FormatError, InputError, OutputError
from engine.report import image


@pytest.fixture
def pixels() -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, size=(5, 7, 4), dtype=np.uint8)


@pytest.mark.parametrize("channels", [3, 4])
def test_png_round_trip_and_same_bytes(tmp_path: Path, pixels: np.ndarray, channels: int) -> None:
    data = pixels[..., :channels]
    image.save_png(tmp_path / "a.png", data, {"scene": "fuchs ä", "ev": "0"})
    image.save_png(tmp_path / "b.png", data, {"ev": "0", "scene": "fuchs ä"})
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    assert np.array_equal(image.load_png(tmp_path / "a.png"), data)
    assert image.png_metadata(tmp_path / "a.png") == {"scene": "fuchs ä", "ev": "0"}
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.png", "b.png"]


def test_grey_png_loads_as_rgb(tmp_path: Path) -> None:
    image.save_png(tmp_path / "g.png", np.full((2, 3), 9, np.uint8))
    assert np.array_equal(image.load_png(tmp_path / "g.png"), np.full((2, 3, 3), 9))


def test_png_of_floats_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="uint8"):
        image.save_png(tmp_path / "a.png", np.zeros((2, 2, 3)))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("shape", [(2, 2, 2), (2,), (0, 4, 3)])
def test_bad_shapes_are_refused(tmp_path: Path, shape: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match="shape"):
        image.save_png(tmp_path / "a.png", np.zeros(shape, np.uint8))
    with pytest.raises(InputError, match="shape"):
        image.save_exr(tmp_path / "a.exr", np.zeros(shape, np.float32))


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("half", [True, False])
def test_exr_round_trip_and_same_bytes(tmp_path: Path, channels: int, half: bool) -> None:
    data = np.random.default_rng(1).normal(size=(6, 5, channels)).astype(np.float32) * 100
    for name in ("a.exr", "b.exr"):
        image.save_exr(tmp_path / name, data, {"scene": "x"}, half=half)
    assert (tmp_path / "a.exr").read_bytes() == (tmp_path / "b.exr").read_bytes()
    back = image.load_exr(tmp_path / "a.exr")
    assert back.dtype == np.float32
    assert np.array_equal(back, data.astype(np.float16).astype(np.float32) if half else data)


def test_exr_half_clamps_instead_of_overflowing(tmp_path: Path) -> None:
    image.save_exr(tmp_path / "a.exr", np.full((1, 1, 3), 1e9, np.float32))
    assert image.load_exr(tmp_path / "a.exr")[0, 0, 0] == 65504.0


def test_exr_keeps_nan_for_the_metrics_to_find(tmp_path: Path) -> None:
    image.save_exr(tmp_path / "a.exr", np.full((1, 1, 3), math.nan, np.float32))
    assert np.isnan(image.load_exr(tmp_path / "a.exr")).all()


@pytest.mark.parametrize(("load", "name"), [(image.load_png, "a.png"), (image.load_exr, "a.exr")])
def test_bad_files(tmp_path: Path, load: object, name: str) -> None:
    assert callable(load)
    with pytest.raises(InputError, match="no such file"):
        load(tmp_path / name)
    for junk in (b"", b"not an image at all", b"\x89PNG\r\n\x1a\n" + b"\0" * 40, b"v/1\x01" + b"\xff" * 60):
        (tmp_path / name).write_bytes(junk)
        with pytest.raises(FormatError, match=name):
            load(tmp_path / name)


def test_unwritable_folder(tmp_path: Path, pixels: np.ndarray) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        image.save_png(tmp_path / "file" / "a.png", pixels)
