"""sin(theta)/theta as a series in e = 1 - cos(theta), which is smooth where theta is 0.

theta^2 = 2 sum_n (2 e)^n/(n^2 binomial(2 n, n)), put into sin(theta)/theta = sum_k (-theta^2)^k/(2 k + 1)!.
"""

import math

import numpy as np

DEGREE = 12
STRAIGHT = 0.2  # e up to which the series is taken; it converges within 2


def _series() -> np.ndarray:
    """Its coefficients (DEGREE + 1,), the constant first."""
    square = np.zeros(DEGREE + 1)
    for n in range(1, DEGREE + 1):
        square[n] = 2.0 * 2.0**n / (n * n * math.comb(2 * n, n))
    found, power = np.zeros(DEGREE + 1), np.eye(DEGREE + 1)[0]
    for k in range(DEGREE + 1):
        found += (-1) ** k / math.factorial(2 * k + 1) * power
        power = np.convolve(power, square)[: DEGREE + 1]
    return found


SERIES = _series()
