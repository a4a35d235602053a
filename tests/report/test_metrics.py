from __future__ import annotations

import math

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.report import metrics


def test_known_answers() -> None:
    reference, image = np.array([[1.0, 2.0], [3.0, 0.0]]), np.array([[1.0, 2.0], [3.0, 2.0]])
    assert metrics.rmse(image, reference) == 1.0
    assert metrics.max_error(image, reference) == 2.0
    assert metrics.rel_mse(image, reference) == pytest.approx(4.0 / 0.01 / 4)
    assert metrics.rel_mse([2.0], [1.0]) == pytest.approx(1 / 1.01)


def test_psnr_uses_the_dtype_s_peak() -> None:
    reference = np.zeros((4, 4), np.uint8)
    assert metrics.psnr(reference + np.uint8(1), reference) == pytest.approx(20 * math.log10(255))
    assert metrics.psnr(np.full(3, 0.1), np.zeros(3)) == pytest.approx(20.0)
    assert metrics.psnr(reference, reference) == math.inf


def test_unsigned_bytes_do_not_wrap() -> None:
    assert metrics.max_error(np.array([0], np.uint8), np.array([255], np.uint8)) == 255.0


def test_one_nan_spoils_the_image() -> None:
    image = np.zeros((8, 8, 3))
    image[3, 3, 1] = math.nan
    for metric in (metrics.rmse, metrics.rel_mse, metrics.max_error):
        assert metric(image, np.zeros_like(image)) == math.inf
    assert metrics.psnr(image, np.zeros_like(image)) == -math.inf
    assert metrics.count_nonfinite(image) == 1
    assert metrics.rmse([math.inf, 0], [math.inf, 0]) == 0.0


def test_shapes_must_agree() -> None:
    with pytest.raises(InputError, match=r"\(2,\).*\(3,\)"):
        metrics.rmse(np.zeros(2), np.zeros(3))
    with pytest.raises(InputError, match="empty"):
        metrics.rmse(np.zeros(0), np.zeros(0))


def test_mean_angle() -> None:
    assert metrics.mean_angle([[1, 0, 0], [0, 2, 0]], [[0, 3, 0], [0, 1, 0]]) == pytest.approx(math.pi / 4)
    assert metrics.mean_angle([[0, 0, 0]], [[0, 1, 0]]) == math.pi


def test_blank() -> None:
    assert metrics.is_blank(np.full((4, 4, 3), [0.2, 0.5, 0.9])), "one flat colour, though its channels differ"
    assert metrics.is_blank(np.full((4, 4), math.nan))
    assert metrics.is_blank(np.zeros((0, 0, 3)))
    image = np.zeros((4, 4, 3))
    image[2, 2] = 0.01
    assert not metrics.is_blank(image)
    assert metrics.is_blank(image, tolerance=0.02)


def test_max_angle() -> None:
    assert metrics.max_angle([[1, 0, 0], [0, 2, 0]], [[1, 0, 0], [0, 1, 1]]) == pytest.approx(math.pi / 4)
    assert metrics.max_angle([[math.nan, 0, 1]], [[0, 0, 1]]) == math.pi
    tiny = metrics.max_angle([[1.0, 1e-9, 0.0]], [[1.0, 0.0, 0.0]])
    assert tiny == pytest.approx(1e-9, rel=1e-6), "an acos would say 0"


def test_relative_error_and_its_quantiles() -> None:
    reference = np.array([1.0, 2.0, 4.0, 8.0])
    image = reference * np.array([1.0, 1.1, 1.2, 0.5])
    assert metrics.relative_error(image, reference) == pytest.approx(0.5)
    assert metrics.relative_error(image, reference, 0.67) == pytest.approx(0.2)
    assert metrics.relative_error([0.0, 1.0], [0.0, 1.0]) == 0.0
    assert metrics.relative_error([1e-30], [0.0]) == math.inf
    assert metrics.relative_error([math.nan], [1.0]) == math.inf


def test_energy_deviation() -> None:
    assert metrics.energy_deviation([1.0, 0.7, 1.59]) == pytest.approx(0.59)
    assert metrics.energy_deviation([0.5], 0.25) == 0.25
    assert metrics.energy_deviation([math.inf]) == math.inf
