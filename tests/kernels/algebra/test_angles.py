"""Polynomials for angles against NumPy."""

import numpy as np
from probes import evaluate

from warpmuscle.kernels.algebra.angles import arcsine_ratio, sine_cosine


def test_sine_and_cosine_are_exact_to_single_precision():
    x = np.linspace(-2.0 * np.pi, 2.0 * np.pi, 100_001).astype(np.float32).astype(float)
    np.testing.assert_allclose(evaluate(sine_cosine, x), np.stack([np.sin(x), np.cos(x)], axis=1), atol=3e-7, rtol=0)


def test_sine_and_cosine_of_large_angles_lose_no_more_than_the_angle_itself():
    x = np.linspace(-1000.0, 1000.0, 100_001).astype(np.float32).astype(float)
    error = np.abs(evaluate(sine_cosine, x) - np.stack([np.sin(x), np.cos(x)], axis=1))
    assert np.all(error < 2e-7 + np.finfo(np.float32).eps * np.abs(x[:, None]))


def test_arcsine_ratio_is_exact_to_single_precision():
    square = np.linspace(0.0, 1.0, 100_001).astype(np.float32).astype(float)
    x = np.sqrt(square[1:])
    error = np.abs(evaluate(arcsine_ratio, square) / [1.0, *(np.arcsin(x) / x)] - 1.0)
    assert error[square < 0.9].max() < 5e-7
    assert error.max() < 5e-6


def test_arcsine_ratio_bears_rounding_beyond_one():
    np.testing.assert_allclose(evaluate(arcsine_ratio, np.array([1.0, 1.000001])), np.pi / 2.0, rtol=1e-6)
