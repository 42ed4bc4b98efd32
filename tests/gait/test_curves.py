"""Curves over the gait cycle, and people's beside them."""

import json

import numpy as np
import pytest

from small_result import march, walk_scene
from warpmuscle.gait.curves import FORWARDS, PRESSURE, Curves, as_numbers, gait_curves, mean_of
from warpmuscle.gait.cycles import over_strides, steady_strides
from warpmuscle.gait.joint_moments import leg_moments
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.people.pinzone import MOMENTS


@pytest.fixture(scope="module")
def walk():
    scene = substitute(walk_scene(), start_values(walk_scene()))
    motion = march(scene.character, 1.2, 4.0, 401, len(scene.character.muscles))
    return scene, motion, steady_strides(motion, scene)


def test_every_curve_has_its_cycles_its_unit_and_people_where_they_were_measured(walk):
    scene, motion, cycles = walk
    curves = gait_curves(motion, scene, cycles)
    units = {
        "Hip flexion": "deg", "Knee moment": "N m/kg", "Ankle power": "W/kg", FORWARDS: "body weights",
        PRESSURE: "% of the foot", "Pelvis rotation": "deg", "Trunk tilt": "deg",
    }  # fmt: skip
    assert {name: curves[name].unit for name in units} == units
    for curve in curves.values():
        assert {side: rows.shape for side, rows in curve.sides.items()} == {
            side: (len(cycles[side]), 101) for side in ("left", "right")
        }
    beside = {name for name, curve in curves.items() if curve.people is not None}
    legs = {f"{joint} {what}" for joint in ("Hip", "Knee", "Ankle") for what in ("moment", "power")}
    assert beside == legs | {"Pelvis tilt", "Pelvis obliquity", "Pelvis rotation"}
    knee = leg_moments(motion, scene)["Knee moment"]["right"]
    np.testing.assert_array_equal(
        curves["Knee moment"].sides["right"], over_strides(motion.time, knee, cycles["right"])
    )


def test_files_hold_mean_curves_with_nothing_where_there_is_nothing(walk):
    scene, motion, cycles = walk
    numbers = json.loads(json.dumps(as_numbers(gait_curves(motion, scene, cycles)), allow_nan=False))
    assert numbers["percent"] == list(range(101))
    assert {len(numbers["Ankle moment"][key]) for key in ("left", "right", "people", "people_sd")} == {101}
    people = float(MOMENTS["Ankle moment"].mean(np.array([48.0]))[0])
    assert numbers["Ankle moment"]["people"][48] == pytest.approx(people, abs=1e-4)
    assert people > 1.1  # N m/kg, as they push off
    assert numbers[PRESSURE]["left"][80] is None  # in swing


def test_a_mean_is_of_those_cycles_that_have_a_value():
    rows = np.array([[1.0, np.nan, np.nan], [3.0, 4.0, np.nan], [5.0, 6.0, 7.0]])
    np.testing.assert_array_equal(mean_of(rows), [3.0, 5.0, np.nan])


def test_numbers_of_files_have_five_decimals():
    row = np.array([[1.23456789, -0.00000449, np.nan]])
    numbers = as_numbers({"angle": Curves("deg", {"left": row, "right": -row}, None)})
    assert numbers["angle"] == {"unit": "deg", "left": [1.23457, 0.0, None], "right": [-1.23457, 0.0, None]}
