"""Distances from a patient's strides are those of curves that were put so many standard deviations away."""

import numpy as np
import pytest

from warpmuscle.core.array_types import Floats
from warpmuscle.formats import load
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.sweep.patient.compared import (
    COST,
    Walk,
    angle_distance,
    changed_numbers,
    in_spread,
    judged_distances,
    searched_distances,
    stride_distance,
    within,
)
from warpmuscle.sweep.patient.file import UNCHANGED
from warpmuscle.sweep.patient.gait import UNITS, Gait, pooled, unit_of
from warpmuscle.sweep.patient.recorded import Patient, _spread

CYCLE = np.linspace(0.0, 2.0 * np.pi, 101)
KNEE = 30.0 - 30.0 * np.cos(CYCLE)


def gait(*offsets: float, speed: float = 1.2, scale: float = 1.0) -> Gait:
    """A stride an offset, each curve a wave that lies so much higher."""
    rows = np.array([scale * KNEE + offset for offset in offsets])
    times = np.full(len(offsets), 1.1)
    return Gait({name: dict.fromkeys(SIDES, rows) for name in UNITS}, dict.fromkeys(SIDES, times), speed)


def patient(*offsets: float, least: float = 2.0) -> Patient:
    own = gait(*offsets)
    spread = {name: {side: _spread(own.curves[name][side], least) for side in SIDES} for name in UNITS}
    mean = {name: {side: own.mean(name, side) for side in SIDES} for name in UNITS}
    return Patient(own, load("fwalk"), mean, spread, least)


def test_a_distance_is_in_the_patients_own_standard_deviations():
    one = patient(-4.0, 0.0, 4.0)  # standard deviation 4
    curve: Floats = KNEE + 8.0
    assert in_spread(curve, one, "Knee flexion", "left") == pytest.approx(2.0)
    assert within(curve - 0.1, one, "Knee flexion", "left") == 100.0
    assert within(curve + 0.1, one, "Knee flexion", "left") == 0.0
    assert angle_distance(gait(8.0), one) == pytest.approx(2.0)


def test_a_spread_is_at_least_what_measuring_leaves():
    assert in_spread(KNEE + 8.0, patient(-0.1, 0.1), "Knee flexion", "left") == pytest.approx(4.0)
    assert in_spread(KNEE + 8.0, patient(0.0, least=1.0), "Knee flexion", "left") == pytest.approx(8.0)


def test_own_strides_are_held_against_the_mean_of_the_others():
    # 6 away from the mean of the others at both ends, not at all in the middle, in standard deviations of 4
    assert stride_distance(patient(-4.0, 0.0, 4.0), "Knee flexion", "right") == pytest.approx((1.5 + 0.0 + 1.5) / 3.0)
    assert stride_distance(patient(0.0), "Knee flexion", "right") is None


def test_searched_and_judged_curves_tell_before_and_after_over_seeds():
    one = patient(-4.0, 0.0, 4.0)
    walks = [Walk(seed, "", True, gait(offset)) for seed, offset in ((1, 4.0), (2, 8.0), (3, -4.0))]
    walks.append(Walk(4, "", False, None, why="fell"))
    knee = next(d for d in searched_distances(one, gait(40.0), walks) if (d.name, d.side) == ("Knee flexion", "left"))
    assert (knee.before, knee.found.median, knee.found.count) == pytest.approx((10.0, 1.0, 3))
    moment = next(d for d in judged_distances(one, None, walks) if (d.name, d.side) == ("Hip moment", "right"))
    assert moment.before is None
    assert moment.found.median == pytest.approx(4.0)
    assert moment.likeness is not None
    assert moment.likeness.median == pytest.approx(1.0)
    assert moment.of_strides == pytest.approx(4.0)  # root mean square of 6, 0 and 6 in the mean


def test_changes_are_between_walks_of_the_same_seed():
    one, offsets = patient(0.0, 1.0), (0.0, 3.0, 7.0, 1.0, 5.0, 2.0)
    walks = []
    for seed, offset in enumerate(offsets):
        walks.append(Walk(seed, UNCHANGED, True, gait(offset), 3.0))
        walks.append(Walk(seed, "brace", True, gait(offset - 6.0), 3.5))
    found = {number.name: number for number in changed_numbers(one, [walks[0]], walks)}
    knee = found["left knee, maximum in swing"]
    assert [cell.condition for cell in knee.cells] == [UNCHANGED, "brace"]
    assert knee.cells[1].interval == pytest.approx((-6.0, -6.0))
    assert (knee.patient, knee.spread) == pytest.approx((60.5, np.std([0, 1], ddof=1)))
    assert found[COST].cells[1].change.median == pytest.approx(0.5)
    assert found[COST].patient is None
    assert found["stride length"].cells[0].spread.median == pytest.approx(1.2 * 1.1)


def test_numbers_have_their_side_and_unit():
    numbers = gait(0.0).points
    assert numbers["right knee, maximum in swing"] == pytest.approx(60.0)
    assert (unit_of("right knee, maximum in swing"), unit_of("left hip moment, minimum")) == ("deg", "N m/kg")
    assert (unit_of("left stance"), unit_of("stride time"), unit_of(COST)) == ("% of the cycle", "s", "J/(kg m)")


def test_strides_of_several_recordings_are_one_gait():
    both = pooled([gait(0.0, 2.0, speed=1.0), gait(4.0, speed=1.3)])
    assert both.curves["Hip flexion"]["left"].shape == (3, 101)
    assert both.speed == pytest.approx(1.1)
