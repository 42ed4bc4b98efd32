"""Centre of activity and width of known curves."""

import numpy as np
import pytest

from warpmuscle.synergy.timing import circular_centre, timing, width

PHASE = np.arange(200) / 200.0


def bump(centre, sigma):
    """A Gaussian round a cycle."""
    distance = (PHASE - centre + 0.5) % 1.0 - 0.5
    return np.exp(-0.5 * (distance / sigma) ** 2)


def test_centre_of_a_bump_is_where_it_is_even_across_the_end_of_a_cycle():
    curves = np.array([bump(0.3, 0.05), bump(0.98, 0.05), np.zeros(200)])
    found = circular_centre(curves, PHASE)
    assert found[:2] == pytest.approx([0.3, 0.98], abs=1e-3)
    assert np.isnan(found[2])


def test_width_of_a_gaussian_is_that_of_its_formula():
    assert width(bump(0.5, 0.05)[None])[0] / 200.0 == pytest.approx(2.0 * np.sqrt(2.0 * np.log(2.0)) * 0.05, abs=0.01)


def test_mean_over_cycles_goes_round_their_end():
    curves = np.concatenate([bump(0.98, 0.03), bump(0.04, 0.03)])[None]
    found = timing(curves, np.repeat([0, 1], 200), np.arange(400) / 200.0, cyclic=True)
    assert found.centre[0] == pytest.approx(0.01, abs=1e-3)
    assert found.centre_spread[0] == pytest.approx(0.03, abs=1e-3)


def test_a_recording_in_seconds_has_its_times_in_seconds():
    time = np.tile(np.arange(200) / 100.0, 2)
    curves = np.concatenate([bump(0.25, 0.05), bump(0.75, 0.05)])[None]
    found = timing(curves, np.repeat([0, 1], 200), time, cyclic=False)
    assert found.centre[0] == pytest.approx(1.0, abs=1e-2)
    assert found.centre_spread[0] == pytest.approx(0.5, abs=1e-2)
    assert found.width[0] == pytest.approx(2.0 * 2.355 * 0.05, abs=0.02)
