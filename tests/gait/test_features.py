"""Key points of curves over the gait cycle, against norms, whose points are known, and curves made up to order."""

import numpy as np
import pytest

from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.features import force_humps, greatest, least, norm_deviation, peak, stance_part
from warpmuscle.scene.norms import NORMS

FORCE = NORMS["Vertical ground force"].mean(PERCENT)


@pytest.mark.parametrize("name", NORMS)
def test_a_curve_as_far_off_as_the_edge_of_the_band_deviates_by_one(name: str):
    norm = NORMS[name]
    mean = norm.mean(PERCENT)
    assert norm_deviation(name, mean) == 0.0
    assert norm_deviation(name, mean - norm.half_width) == pytest.approx(1.0)
    half = np.where(PERCENT < 50.0, mean + 3.0 * norm.half_width, mean)
    assert norm_deviation(name, half) == pytest.approx(1.5)


def test_extremes_are_those_of_their_part_of_the_cycle():
    knee = NORMS["Knee flexion"].mean(PERCENT)
    assert greatest(knee) == pytest.approx((63.4, 72.0))
    assert peak(knee, 2.0, 45.0) == pytest.approx((19.4, 12.0))
    assert least(knee, 20.0, 60.0) == pytest.approx((7.2, 39.0))


def test_a_curve_that_only_rises_has_a_greatest_value_but_no_peak():
    assert greatest(PERCENT, 10.0, 40.0) == (40.0, 40.0)
    assert peak(PERCENT, 10.0, 40.0) is None


def test_humps_of_the_norm_are_found_where_they_are():
    humps = force_humps(FORCE)
    assert humps.first is not None
    assert humps.valley is not None
    assert humps.second is not None
    np.testing.assert_allclose([humps.first, humps.valley, humps.second], [(1.05, 15), (0.8, 31), (1.14, 49)], atol=1.1)
    np.testing.assert_allclose([humps.first[0], humps.valley[0], humps.second[0]], [1.05, 0.8, 1.14], atol=0.025)
    assert humps.depth == pytest.approx(0.25, abs=0.04)


def test_neither_an_impact_nor_ripples_make_humps_of_one():
    one = np.sin(np.pi * np.clip(PERCENT / 60.0, 0.0, 1.0))
    ripple = 0.05 * np.sin(2.0 * np.pi * PERCENT / 4.0) * (one > 0.0)
    impact = 1.5 * (PERCENT < 3.0)
    for force in (one, one + ripple, one + impact):
        humps = force_humps(force)
        assert (humps.valley, humps.second, humps.depth) == (None, None, 0.0)
        assert humps.first is not None
        assert humps.first.percent == pytest.approx(30.0, abs=2.0)


def test_a_foot_that_never_leaves_the_ground_or_never_touches_it_is_all_stance_or_none():
    assert stance_part(FORCE) == pytest.approx(62.0, abs=2.0)
    assert stance_part(np.ones(101)) == 100.0
    assert stance_part(np.zeros(101)) == 0.0
    assert force_humps(np.zeros(101)).first is None


def test_a_scuff_in_the_swing_does_not_end_it():
    scuffed = FORCE + 0.1 * ((PERCENT > 90.0) & (PERCENT < 93.0))
    assert stance_part(scuffed) == stance_part(FORCE)


def test_a_valley_without_a_peak_on_one_side_makes_no_humps():
    falling = np.interp(PERCENT, [0.0, 30.0, 50.0, 65.0, 100.0], [1.2, 0.5, 1.1, 0.0, 0.0])
    humps = force_humps(falling)
    assert humps.first.percent == pytest.approx(50.0, abs=2.0)
    assert (humps.valley, humps.second, humps.depth) == (None, None, 0.0)
