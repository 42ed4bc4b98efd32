"""Left and right beside each other, and how steps vary, of walks made by hand."""

import dataclasses

import numpy as np
import pytest

from small_result import march
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.gait import sides
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.measures import Steps, measure, steps_of
from warpmuscle.gait.sides import OfSides, measures_of_sides
from warpmuscle.scene.parameters import start_values, substitute


@pytest.fixture(scope="module")
def scene():
    free = load("walk56")
    return substitute(free, start_values(free))


def marching(scene, speed: float = 1.2):
    return march(scene.character, speed, 8.0, 801, len(scene.character.muscles))


def test_the_symmetry_index_is_the_difference_over_the_mean():
    assert OfSides("m", 0.6, 0.4).symmetry == pytest.approx(40.0)
    assert OfSides("m", -0.4, -0.6).symmetry == pytest.approx(-40.0)
    assert OfSides("m", 0.5, 0.5).symmetry == 0.0
    assert OfSides("deg", 2.0, -3.0).symmetry is None
    assert OfSides("deg", 0.0, 3.0).symmetry is None
    assert OfSides("deg", 0.4, 0.1).symmetry is None
    assert OfSides("deg", 5.0, 3.0).symmetry == pytest.approx(50.0)
    assert OfSides("W/kg", 0.4, 0.1).symmetry == pytest.approx(120.0)


def test_a_walk_that_is_its_own_image_is_symmetric(scene):
    found = measures_of_sides(marching(scene), scene)
    for name in ("step length", "stance", "maximum vertical force", "gait profile score"):
        assert found[name].symmetry == pytest.approx(0.0, abs=2.0), name
    assert found["stance"].left == pytest.approx(60.0, abs=2.0)
    assert "activation of soleus" in found


def test_a_foot_that_is_set_farther_ahead_makes_longer_steps(scene):
    motion = marching(scene)
    places = motion.body_position.copy()
    places[:, motion.body_names.index("lFoot"), 2] += 0.05
    limping = dataclasses.replace(motion, body_position=places)
    lengths, before = (measures_of_sides(one, scene)["step length"] for one in (limping, motion))
    assert lengths.left - before.left == pytest.approx(0.05, abs=1e-6)
    assert lengths.right - before.right == pytest.approx(-0.05, abs=1e-6)


def test_the_side_that_carries_more_has_the_greater_force(scene):
    motion = marching(scene)
    force = motion.foot_force_left * [1.0, 1.5, 1.0]
    heavier = dataclasses.replace(motion, foot_force_left=force.astype(np.float32))
    one = measures_of_sides(heavier, scene)["maximum vertical force"]
    assert one.left / one.right == pytest.approx(1.5, rel=1e-3)
    assert one.symmetry == pytest.approx(40.0, abs=0.1)


def test_a_limp_is_no_variability_and_uneven_steps_are():
    sides = np.tile([0, 1], 50)
    limping = Steps(sides, np.where(sides == 0, 0.7, 0.5), np.zeros(100))
    assert limping.length_deviation == pytest.approx(0.0, abs=1e-12)
    lengths = np.random.default_rng(3).normal(0.6, 0.02, 2000)
    uneven = Steps(np.tile([0, 1], 1000), lengths, np.zeros(2000))
    assert uneven.length_deviation == pytest.approx(0.02, rel=0.05)
    assert Steps(sides[:5], lengths[:5], np.zeros(5)).length_deviation is None


def test_steps_are_those_that_a_gait_has_the_mean_of(scene):
    motion = marching(scene)
    gait, steps = measure(motion, scene), steps_of(motion, scene, measure(motion, scene).start)
    assert len(steps.lengths) == gait.steps > 4
    assert steps.lengths.mean() == pytest.approx(gait.step_length)
    assert set(steps.sides.tolist()) == {0, 1}


def test_without_whole_cycles_there_is_nothing_to_compare(scene):
    with pytest.raises(Error, match="no whole gait cycle"):
        measures_of_sides(march(scene.character, 1.2, 0.4, 41, len(scene.character.muscles)), scene)


def test_greatest_values_are_looked_for_in_their_part_of_the_cycle(scene, monkeypatch: pytest.MonkeyPatch):
    """Of curves that rise by one a percent: where they end, or less than nothing where they begin."""
    monkeypatch.setattr(sides, "mean_of", lambda _: PERCENT)
    found = measures_of_sides(marching(scene), scene)
    ends = {
        "maximum vertical force": 100, "maximum braking force": 0, "maximum driving force": 100,
        "hip, maximum extension": -20, "knee, maximum in stance": 45, "knee, maximum in swing": 100,
        "ankle, maximum dorsiflexion in stance": 62, "hip extension moment, maximum": 50,
        "knee extension moment in loading, maximum": 30, "ankle moment, maximum": 100, "hip power, maximum": 100,
        "ankle power, maximum": 100, "pelvis, drop of the other side in single support": 45,
        "trunk, lean to this side in single support": -10,
    }  # fmt: skip
    assert {name: (found[name].left, found[name].right) for name in ends} == {name: (x, x) for name, x in ends.items()}
