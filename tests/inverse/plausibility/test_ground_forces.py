"""Notes on forces: what they carry, and where they act."""

import numpy as np
import pytest

from warpmuscle.inverse.plausibility.ground_forces import Applied, place_notes, weight_notes

MASS = 70.0
UP = np.tile([0.0, MASS * 9.81, 0.0], (5, 1))


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
    sound = [Applied("a", "left", UP, places["left"] + 0.1, places), Applied("b", "right", UP, places["right"], places)]
    assert place_notes(sound) == []
    swapped = [one._replace(body=other) for one, other in zip(sound, ("right", "left"), strict=True)]
    notes = place_notes(swapped)
    assert len(notes) == 2
    assert "'a' on 'right' acts 0.62 m from it, nearer to 'left'" in notes[0]
    (far,) = place_notes([sound[0]._replace(point=1000.0 * sound[0].point)])
    assert "far from 'left'" in far


def test_where_a_plate_is_empty_its_point_does_not_matter():
    places = {"left": np.zeros((5, 3))}
    assert place_notes([Applied("a", "left", 0.01 * UP, places["left"] + 9.0, places)]) == []
