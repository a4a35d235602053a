"""How two pictures differ: known answers."""

from __future__ import annotations

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.report.picture_difference import difference_map, picture_difference


def pair() -> tuple[np.ndarray, np.ndarray]:
    """8 x 4 grey, and the same with one pixel three levels darker in green and ten brighter in blue."""
    a = np.full((4, 8, 4), 100, np.uint8)
    b = a.copy()
    b[1, 5] = (100, 97, 110, 0)
    return a, b


def test_numbers_are_those_of_the_one_pixel() -> None:
    found = picture_difference(*pair())
    assert (found.largest, found.worst, found.differing) == (10, (5, 1), 1 / 32)
    assert found.rmse == pytest.approx(((9 + 100) / (32 * 3)) ** 0.5)
    assert found.flip is None
    assert "max 10" in found.line()


def test_equal_pictures_say_so_and_alpha_does_not_count() -> None:
    a, _ = pair()
    b = a.copy()
    b[..., 3] = 0
    found = picture_difference(a, b, perceptual=True)
    assert found.equal
    assert found.flip == 0.0
    assert found.line() == "equal in every pixel"


def test_black_is_darkened_as_much_as_white_is_lightened() -> None:
    white, black = np.full((2, 2, 3), 255, np.uint8), np.zeros((2, 2, 3), np.uint8)
    assert picture_difference(white, black).largest == picture_difference(black, white).largest == 255


def test_the_map_is_black_where_nothing_differs() -> None:
    shown = difference_map(*pair())
    assert shown.shape == (4, 8, 3)
    dark = shown.reshape(-1, 3).astype(int).sum(axis=1)
    assert (np.delete(dark, 13) == dark.min()).all()
    assert dark[13] > 500, "ten levels are more than the brightest of the ramp"


def test_other_sizes_are_refused() -> None:
    a, _ = pair()
    with pytest.raises(InputError, match="8x4 and 7x4"):
        picture_difference(a, a[:, :7])
    with pytest.raises(InputError, match="u1"):
        picture_difference(a, a.astype(np.float32))
