"""How far belts have gone, against sums of their speeds."""

import numpy as np
import pytest

from warpmuscle.scene import Ground, Treadmill
from warpmuscle.scene.treadmill.belt_motion import belt_speeds, gone, mean_shift, share

PROFILE = [(0.5, 1.0), (0.7, -0.5), (1.0, 0.0), (2.0, 2.0)]


@pytest.mark.parametrize("start", [0.0, 0.8, -0.6])
def test_the_way_is_the_integral_of_the_profile(start: float):
    treadmill = Treadmill(profile=PROFILE, start=start)
    times = np.linspace(0.0, 4.0, 40001)
    summed = np.concatenate([[0.0], np.cumsum(0.5 * (share(treadmill, times)[1:] + share(treadmill, times)[:-1]))])
    np.testing.assert_allclose(gone(treadmill, times), summed * 1e-4, atol=1e-6)
    assert gone(treadmill, 0.0) == 0.0


def test_belts_move_backwards_at_their_mean_speed_along_an_inclined_plane():
    ground = Ground(treadmill=Treadmill(speed=1.0, left=0.5, sideways=0.2))
    assert belt_speeds(ground.treadmill) == (1.5, 1.0)
    np.testing.assert_allclose(mean_shift(ground, np.array([0.0, 2.0])), [[0, 0, 0], [0.4, 0.0, -2.5]], atol=1e-12)
    slope = Ground(normal=(0.0, np.cos(0.3), -np.sin(0.3)), treadmill=Treadmill(speed=1.0))
    np.testing.assert_allclose(mean_shift(slope, 1.0), [0.0, -np.sin(0.3), -np.cos(0.3)], atol=1e-12)
    assert not mean_shift(Ground(), np.ones(3)).any()
