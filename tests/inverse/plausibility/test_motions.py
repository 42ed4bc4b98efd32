"""Notes on motions: holes, jumps, rows out of order, angles beyond ranges or in another unit."""

import numpy as np
import pytest

from warpmuscle.inverse.plausibility.motions import (
    locked_notes,
    range_notes,
    side_notes,
    time_notes,
    unit_notes,
    value_notes,
)

TIMES = np.arange(60) / 100.0
SMOOTH = np.column_stack([0.5 * np.sin(5.0 * TIMES), 1.0 + 0.9 * np.cos(9.0 * TIMES)])
NAMES, UNITS = ("hip", "knee"), ("rad", "rad")


def test_a_smooth_motion_has_no_notes():
    assert time_notes("it", TIMES) == value_notes(NAMES, UNITS, TIMES, SMOOTH) == []


def test_a_hole_is_told_with_its_times():
    (note,) = time_notes("it", np.delete(TIMES, range(20, 40)))
    assert "no frames between 0.19 and 0.4 s" in note


def test_frames_far_apart_are_told():
    (note,) = time_notes("it", np.arange(10) * 0.2)
    assert "0.2 s apart" in note


def test_rows_out_of_order_go_to_and_fro():
    order = np.random.default_rng(1).permutation(60)
    (note,) = value_notes(NAMES, UNITS, TIMES, SMOOTH[order])
    assert note.startswith("hip, knee go to and fro")


def test_noise_of_a_tenth_of_a_degree_is_not_told():
    shaken = SMOOTH + np.random.default_rng(1).normal(0.0, np.radians(0.1), SMOOTH.shape)
    assert value_notes(NAMES, UNITS, TIMES, shaken) == []


def test_one_wrong_value_is_a_jump():
    values = SMOOTH.copy()
    values[30, 1] += 1.2
    (note,) = value_notes(NAMES, UNITS, TIMES, values)
    assert "a jump of 71 degrees in knee" in note
    assert "at 0.31 s" in note


@pytest.mark.parametrize(("beyond", "told"), [(0.05, 0), (0.5, 1)])
def test_an_angle_far_beyond_its_range_is_told(beyond, told):
    values = np.array([[0.0, -1.0], [0.0, 0.2 + beyond]])
    notes = range_notes(NAMES, values, {"knee": (-2.0, 0.2)})
    assert len(notes) == told
    assert all("knee leaves its range, -115 to 11 degrees, by 29" in note for note in notes)


def test_degrees_that_are_as_small_as_radians_are_told():
    values = np.column_stack([SMOOTH, SMOOTH[:, 0]])
    assert "inDegrees=no" in unit_notes(values)[0]
    assert unit_notes(np.degrees(values)) == []
    assert unit_notes(0.0 * values) == []  # a pose that stands still


def test_one_side_in_another_unit_is_told():
    wave = np.sin(np.linspace(0.0, 6.0, 60))
    names, values = ("knee_angle_r", "knee_angle_l", "pelvis_tilt"), np.stack([wave, -wave, 0.1 * wave], axis=1)
    assert side_notes(names, values) == []
    (note,) = side_notes(names, values * (np.pi / 180.0, 1.0, 1.0))
    assert note == "knee_angle_r moves by 2 degrees where that of the other side moves by 1.1e+02: are its numbers rad?"
    assert side_notes(names, values * (0.0, 1.0, 1.0)) == []  # a stiff knee
    assert side_notes((), np.zeros((0, 0))) == []


def test_columns_that_move_what_a_model_locks_are_told():
    moving = np.stack([np.linspace(0.0, 0.3, 5), np.full(5, 0.1)], axis=1)
    (note,) = locked_notes(("subtalar", "mtp"), moving, {"subtalar": 0.0, "mtp": 0.1})
    assert note.startswith("the motion moves subtalar, locked in the model, which stays there")
    (note,) = locked_notes(("subtalar", "mtp"), moving, {"subtalar": 0.0, "mtp": 0.0})
    assert "subtalar, mtp" in note
    assert "stay there" in note
    assert locked_notes(("subtalar", "mtp"), moving, {"mtp": 0.1}) == []
