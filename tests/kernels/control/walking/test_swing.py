"""The way of the foot: where it is at rest, how high it is lifted, that it goes up early and down late."""

import numpy as np
import pytest
from probes import evaluate

from warpmuscle.kernels.control.walking.swing import LOWERED, STAIR, as_a_stair, lift, progress, way_height


def test_progress_is_a_smooth_step_at_rest_at_both_ends():
    phase = np.linspace(-0.2, 1.2, 57)
    s = np.clip((phase - 0.1) / 0.7, 0.0, 1.0)
    np.testing.assert_allclose(evaluate(progress, phase, 0.1, 0.8), 3 * s**2 - 2 * s**3, atol=1e-6)


def test_the_foot_is_lifted_once_and_down_in_time():
    phase = np.linspace(0.0, 1.2, 49)
    s = np.clip(phase / float(LOWERED), 0.0, 1.0)
    found = evaluate(lift, phase)
    np.testing.assert_allclose(found, (4.0 * s * (1.0 - s)) ** 2, atol=1e-6)
    assert found.max() == pytest.approx(1.0, abs=1e-3)
    assert found[0] == 0.0
    assert np.all(found[phase >= float(LOWERED)] == 0.0)


@pytest.mark.parametrize("rise", [0.17, -0.17])
def test_a_foot_goes_up_early_and_down_late(rise: float):
    phase = np.linspace(0.0, 1.0, 21)
    height = evaluate(way_height, phase, 0.3, 0.3 + rise)
    assert (height[0], height[-1]) == (pytest.approx(0.3), pytest.approx(0.3 + rise))
    straight = 0.3 + rise * phase
    assert np.mean(height - straight) > 0.03  # in both cases the foot is above the straight way for most of it


def test_what_is_as_high_as_a_stair_is_climbed_as_one_and_what_is_lower_in_part():
    height = np.array([-0.1, 0.0, 0.5 * float(STAIR), float(STAIR), 0.4])
    np.testing.assert_allclose(evaluate(as_a_stair, 0.7, 0.9, height), [0.7, 0.7, 0.8, 0.9, 0.9], atol=1e-6)
