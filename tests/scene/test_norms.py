"""People's vertical force over the cycle: two feet carry the body, and its waves grow with the speed."""

import numpy as np
import pytest

from warpmuscle.scene.norms import FORCE, NORMS, PERCENT_OF_BIN, STANCE, walking_force


@pytest.mark.parametrize("speed", [0.7, 1.25, 1.8])
def test_two_feet_carry_the_body(speed: float):
    assert 2.0 * walking_force(PERCENT_OF_BIN, speed).mean() == pytest.approx(1.0, abs=0.01)


def test_peaks_and_valley_grow_with_the_speed_squared():
    at = np.array([15.0, 31.0, 49.0])
    away = {speed: walking_force(at, speed) - 1.0 for speed in (0.7, 1.25)}
    np.testing.assert_allclose(away[1.25], [0.05, -0.20, 0.14], atol=1e-12)
    np.testing.assert_allclose(away[0.7], away[1.25] * (0.7 / 1.25) ** 2, atol=1e-12)
    carried = (PERCENT_OF_BIN > 15.0) & (PERCENT_OF_BIN < 49.0)
    assert 0.5 < walking_force(at, 2.5).min() < 0.7  # not a flight
    key_points = NORMS[FORCE].mean(PERCENT_OF_BIN)
    np.testing.assert_allclose(walking_force(PERCENT_OF_BIN, 1.25)[carried], key_points[carried])


def test_a_foot_carries_for_as_long_as_peoples_feet_do():
    force = walking_force(PERCENT_OF_BIN, 1.25)
    assert ((force > 0.0) == (PERCENT_OF_BIN < STANCE)).all()
    assert walking_force(np.array([3.0]), 1.25)[0] > 0.2
    assert np.abs(np.diff(force)).max() < 0.12  # without jumps
