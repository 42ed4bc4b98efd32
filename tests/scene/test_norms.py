"""People's vertical force over the cycle: two feet carry the body, and its waves grow with the speed."""

import numpy as np
import pytest

from warpmuscle.scene.norms import FORCE, NORMS, PERCENT_OF_BIN, walking_force


@pytest.mark.parametrize("speed", [0.7, 1.25, 1.8])
def test_two_feet_carry_the_body(speed: float):
    assert 2.0 * walking_force(PERCENT_OF_BIN, speed).mean() == pytest.approx(1.0, abs=0.04)


def test_peaks_and_valley_grow_with_the_speed_squared():
    at = np.array([15.0, 31.0, 49.0])
    away = {speed: walking_force(at, speed) - 1.0 for speed in (0.7, 1.25)}
    np.testing.assert_allclose(away[1.25], [0.05, -0.20, 0.14], atol=1e-12)
    np.testing.assert_allclose(away[0.7], away[1.25] * (0.7 / 1.25) ** 2, atol=1e-12)
    np.testing.assert_array_equal(walking_force(PERCENT_OF_BIN, 1.25), NORMS[FORCE].mean(PERCENT_OF_BIN))
    assert 0.5 < walking_force(at, 2.5).min() < 0.7  # a walk becomes a run, not a flight
