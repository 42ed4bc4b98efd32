"""Notes on forces: what they carry, and where they act."""

import numpy as np
import pytest

from warpmuscle.inverse.plausibility.ground_forces import Applied, place_notes, push_notes, swing_notes, weight_notes

MASS = 70.0
UP = np.tile([0.0, MASS * 9.81, 0.0], (5, 1))
STILL = np.zeros((5, 3))


def applied(name: str, body: str, force: np.ndarray, point: np.ndarray, places: dict) -> Applied:
    """A force without a moment on bodies that do not move."""
    return Applied(name, body, force, point, STILL, places, dict.fromkeys(places, np.zeros(5)))


@pytest.mark.parametrize(
    ("factor", "told"),
    [(1.0, ""), (0.9, ""), (0.001, "carry 0.001 times"), (2.0, "carry 2 times"), (-1.0, "pull the body down")],
)
def test_what_forces_carry_is_held_against_the_weight(factor, told):
    notes = weight_notes(factor * UP, MASS)
    assert len(notes) == bool(told)
    assert all(told in note for note in notes)


def test_forces_of_swapped_feet_and_of_another_unit_are_far_away():
    places = {"left": np.zeros((5, 3)), "right": np.tile([0.0, 0.0, 0.7], (5, 1))}
    sound = [applied("a", "left", UP, places["left"] + 0.1, places), applied("b", "right", UP, places["right"], places)]
    assert place_notes(sound) == []
    swapped = [one._replace(body=other) for one, other in zip(sound, ("right", "left"), strict=True)]
    notes = place_notes(swapped)
    assert len(notes) == 2
    assert "'a' on 'right' acts 0.62 m from it, nearer to 'left'" in notes[0]
    (far,) = place_notes([sound[0]._replace(point=1000.0 * sound[0].point)])
    assert "far from 'left'" in far


def test_where_a_plate_is_empty_its_point_does_not_matter():
    places = {"left": np.zeros((5, 3))}
    assert place_notes([applied("a", "left", 0.01 * UP, places["left"] + 9.0, places)]) == []


def test_a_moment_of_another_unit_is_as_of_a_force_far_away():
    places = {"left": STILL}
    sound = applied("a", "left", UP, STILL, places)._replace(moment=np.tile([0.0, 8.0, 0.0], (5, 1)))
    assert place_notes([sound]) == []
    (note,) = place_notes([sound._replace(moment=1000.0 * sound.moment)])
    assert "the moment of 'a' about its point is as that of its force at an arm of 11.6 m" in note


@pytest.mark.parametrize(("carried", "told"), [(0.0, 0), (0.04, 0), (0.5, 1)])
def test_feet_that_swing_carry_nothing(carried, told):
    places, speeds = {"left": STILL, "right": STILL}, {"left": np.full(5, 3.0), "right": np.full(5, 0.1)}
    left = Applied("a", "left", carried * UP, STILL, STILL, places, speeds)
    right = Applied("b", "right", UP, STILL, STILL, places, speeds)
    notes = swing_notes([left, right], MASS)
    assert len(notes) == told
    assert all("the force 'a' is 343 N while 'left' swings and another foot stands" in note for note in notes)
    on_a_treadmill = {"left": np.full(5, 2.8), "right": np.full(5, 1.2)}
    assert len(swing_notes([one._replace(speeds=on_a_treadmill) for one in (left, right)], MASS)) == told
    both = {"left": np.full(5, 1.2), "right": np.full(5, 1.2)}  # a jump
    assert swing_notes([one._replace(speeds=both) for one in (left, right)], MASS) == []
    assert swing_notes([left._replace(speeds={"left": speeds["left"]})], MASS) == []


def test_forces_push_the_body_the_way_that_it_goes_faster():
    times = np.linspace(0.0, 1.5, 80)
    aside, ahead = 0.4 * np.cos(6.0 * times), np.sin(11.0 * times)  # m/s^2
    force = MASS * np.stack([aside, 9.81 + 0.0 * times, ahead], axis=1)
    motion = {"x": 0.4 * np.sin(6.0 * times) / 6.0, "y": 0.0 * times, "z": 1.3 - np.cos(11.0 * times) / 11.0}
    assert push_notes(times, force, motion, MASS) == []
    (note,) = push_notes(times, force * (1.0, 1.0, -1.0), motion, MASS)
    assert note.startswith("the loads push forwards when the body is slowed down")
    (note,) = push_notes(times, force * (-1.0, 1.0, 1.0), motion, MASS)
    assert note.startswith("the loads push sideways")
    up_and_down = {"y": motion["y"]}
    assert push_notes(times, force * (1.0, 1.0, -1.0), up_and_down, MASS) == []
    assert push_notes(times, 0.01 * force * (1.0, 1.0, -1.0), motion, MASS) == []
