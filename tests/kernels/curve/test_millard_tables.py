"""Knots of Millard's curves with other numbers: where they are flat, what they reach, and how steep they are there."""

import pytest

from warpmuscle.kernels.curve.millard_tables import Numbers, active_knots, passive_knots, tendon_knots, velocity_knots

# None is OpenSim's own number, so that each has to be read.
OTHER = Numbers(
    active_from=0.5, active_bend=0.75, active_until=1.7, active_slope=0.8, active_least=0.1,
    shortening_end_slope=0.01, shortening_slope=0.3, isometric_slope=4.5, lengthening_slope=0.2,
    lengthening_end_slope=0.02, lengthening_force=1.5, shortening_curviness=0.6, lengthening_curviness=0.9,
    passive_slack=0.05, passive_strain=0.6, passive_low_slope=0.3, passive_slope=3.0, passive_curviness=0.75,
    tendon_slope=1.4, tendon_toe_force=0.6, tendon_curviness=0.5,
)  # fmt: skip


def test_active_force_is_flat_at_both_ends_and_at_its_most():
    first, steep, shallow, most, falling, last = active_knots(OTHER)
    assert (first, most, last) == ((0.5, 0.1, 0.0), (1.0, 1.0, 0.0), (1.7, 0.1, 0.0))
    assert shallow[2] == 0.8
    assert first[0] < steep[0] < shallow[0] < most[0] < falling[0] < last[0]
    # The shallow part is the line through a plateau of 0.1 that begins at 1 - 0.05, down to the bend.
    assert shallow[1] == pytest.approx(1.0 - 0.8 * (0.95 - shallow[0]))
    # Half of the force midway from the plateau's end, 1.05, to the end; as steep as from 1 to 0 within 1.1 to that.
    assert falling == pytest.approx((1.375, 0.5, -1.0 / 0.6))


def test_passive_force_begins_at_slack_and_is_one_at_its_strain():
    zero, toe, one = passive_knots(OTHER)
    assert (zero[:2], one) == ((1.05, 0.0), (1.6, 1.0, 3.0))
    assert zero[2] == 0.0
    assert toe[2] == 0.3
    assert toe[1] == pytest.approx(0.3 * (toe[0] - zero[0]) / 2)
    assert zero[0] < toe[0] < one[0]


def test_a_tendon_is_straight_from_its_toe_to_the_greatest_isometric_force():
    zero, _, end = tendon_knots(OTHER)
    assert zero == (0.0, 0.0, 0.0)
    assert end[1:] == (0.6, 1.4)
    assert end[1] + end[2] * (1.0 - end[0]) == pytest.approx(1.0)


def test_force_over_speed_is_one_at_rest_and_none_at_the_greatest_speed():
    shortening, lengthening = velocity_knots(OTHER)
    assert shortening[0] == (-1.0, 0.0, 0.01)
    assert shortening[-1] == lengthening[0] == (0.0, 1.0, 4.5)
    assert lengthening[-1] == (1.0, 1.5, 0.02)
    assert (shortening[1][2], lengthening[1][2]) == (0.3, 0.2)
    assert shortening[1][1] == pytest.approx(0.1 * (0.3 + 0.01) / 2)
    assert 1.5 - lengthening[1][1] == pytest.approx(0.1 * (0.2 + 0.02) / 2)
