"""Free parameters: found, put in, written back, rounded."""

import copy

import numpy as np
import pytest

from small_scene import sound_scene
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.scene import PD, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import (
    Parameter,
    at_start,
    constant,
    free_parameters,
    greatest,
    pinned,
    start_values,
    substitute,
    with_values,
)
from warpmuscle.scene.validation import scene as checking
from warpmuscle.scene.validation.checks import Checks
from warpmuscle.scene.validation.scene import check_scene


@pytest.fixture
def scene() -> Scene:
    """A scene with three parameters, one of which rules two numbers."""
    scene = sound_scene()
    state = scene.controller.states[0]
    state.time = Free(0.7, 0.5, 0.9, 0.01)
    state.trajectories["SWING_Hip"].components[0].angle[1] = Free(0.2, -0.5, 0.5)
    scene.controller.pd["rHip"] = PD(Free(same_as="controller.pd.lHip.kp"), 1.0)
    check_scene(scene)
    return scene


def test_parameters_are_listed_in_order_with_their_units(scene):
    assert free_parameters(scene) == [
        Parameter("controller.states.0.time", 0.7, 0.5, 0.9, 0.01, "s"),
        Parameter("controller.states.0.trajectories.SWING_Hip.components.0.angle.1", 0.2, -0.5, 0.5, 0.0, "rad"),
        Parameter("controller.pd.lHip.kp", 10.0, 5.0, 20.0, 0.0, "N m/rad"),
    ]


def test_numbers_of_curves_have_the_unit_of_the_curve(scene):
    balance = scene.controller.states[0].balance
    balance.distance_x.value[0] = Free(0.1, 0.0, 0.2)
    scene.controller.states[0].trajectories["SWING_Hip"].strength.value[0] = Free(1.0, 0.0, 1.0)
    units = {parameter.name.split(".", 3)[3]: parameter.unit for parameter in free_parameters(scene)[1:4]}
    assert units["balance.distance_x.value.0"] == "m"
    assert units["trajectories.SWING_Hip.strength.value.0"] == ""


def test_rows_of_values_become_arrays_and_tied_numbers_share_theirs(scene):
    before = copy.deepcopy(scene)
    values = np.array([[0.6, 0.1, 7.0], [0.8, -0.1, 9.0]])
    batch = substitute(scene, values)
    np.testing.assert_array_equal(batch.controller.states[0].time, [0.6, 0.8])
    np.testing.assert_array_equal(batch.controller.pd["lHip"].kp, [7.0, 9.0])
    assert batch.controller.pd["rHip"].kp is batch.controller.pd["lHip"].kp
    assert batch.controller.states[0].trajectories["SWING_Hip"].components[0].angle[0] == 0.1
    assert type(batch.controller.states[0].trajectories["SWING_Hip"].components[0].axis) is tuple
    assert scene == before


def test_numbers_tied_by_a_factor_are_its_multiple_in_every_row(scene):
    scene.controller.pd["lHip"].kd = mirrored = Free(same_as="controller.states.0.time", factor=-1.0)
    scene.controller.pd["rHip"].kd = doubled = Free(same_as="controller.states.0.time", factor=2.0)
    assert [parameter.name for parameter in free_parameters(scene)].count("controller.pd.lHip.kd") == 0
    batch = substitute(scene, np.array([[0.6, 0.1, 7.0], [0.8, -0.1, 9.0]])).controller
    np.testing.assert_array_equal(batch.pd["lHip"].kd, [-0.6, -0.8])
    np.testing.assert_array_equal(batch.pd["rHip"].kd, [1.2, 1.6])
    np.testing.assert_array_equal(batch.states[0].time, [0.6, 0.8])
    assert substitute(scene, start_values(scene)).controller.pd["lHip"].kd == -0.7
    assert with_values(scene, np.array([0.6, 0.1, 7.0])).controller.pd["lHip"].kd == mirrored
    checks = Checks(scene)
    assert (checks.start(mirrored), checks.interval(mirrored)) == (-0.7, (-0.9, -0.5))
    assert (checks.start(doubled), checks.interval(doubled)) == (1.4, (1.0, 1.8))


def test_numbers_that_go_through_points_follow_on_straight_lines_in_every_row(scene):
    time = "controller.states.0.time"
    scene.controller.pd["rHip"].kd = curve = Free(same_as=time, through=((0.6, 10.0), (0.7, 2.0), (0.8, 4.0)))
    assert [parameter.name for parameter in free_parameters(scene)].count("controller.pd.rHip.kd") == 0
    rows = np.array([[0.5, 0.1, 7.0], [0.65, 0.1, 7.0], [0.8, 0.1, 7.0]])
    np.testing.assert_allclose(substitute(scene, rows).controller.pd["rHip"].kd, [10.0, 6.0, 4.0])
    assert substitute(scene, start_values(scene)).controller.pd["rHip"].kd == 2.0
    assert pinned(scene, rows[1], {time}).controller.pd["rHip"].kd == curve
    assert pinned(scene, rows[1], set()).controller.pd["rHip"].kd == pytest.approx(6.0)
    assert Checks(scene).interval(curve) == (2.0, 10.0)  # the least value is in the middle
    assert greatest(scene, curve) == 10.0
    check_scene(scene)


def test_greatest_value_of_a_number_is_its_own_or_its_maximum_or_that_of_what_it_follows(scene):
    numbers = [3.0, scene.controller.states[0].time, Free(same_as="controller.states.0.time")]
    assert [greatest(scene, number) for number in numbers] == [3.0, 0.9, 0.9]
    assert greatest(scene, Free(same_as="controller.states.0.time", factor=-1.0)) == -0.5
    assert greatest(scene, Free(same_as="controller.states.0.time", factor=2.0)) == 1.8


@pytest.mark.parametrize(
    ("members", "message"),
    [
        ({"same_as": "a.b", "factor": float("inf")}, "factor must be finite"),
        ({"value": 1.0, "min": 0.0, "max": 2.0, "factor": -1.0}, "only a number with `same_as` takes a factor"),
        ({"same_as": "a.b", "factor": -1.0, "min": 0.0}, "takes value, min, max and step from that parameter"),
        ({"same_as": "a.b", "factor": 2.0, "through": ((0.0, 1.0), (1.0, 2.0))}, "takes no factor"),
        ({"same_as": "a.b", "through": ((0.0, 1.0),)}, "two finite points at least"),
        ({"same_as": "a.b", "through": ((0.0, 1.0), (0.0, 2.0))}, "must increase, but 0 follows 0"),
        ({"same_as": "a.b", "through": ((0.0, 1.0), (1.0, float("nan")))}, "two finite points at least"),
        ({"value": 1.0, "min": 0.0, "max": 2.0, "through": ((0.0, 1.0), (1.0, 2.0))}, "only a number with `same_as`"),
    ],
)
def test_factors_and_points_belong_to_tied_numbers(members, message):
    with pytest.raises(ValueError, match=message):
        Free(**members)


def test_one_vector_becomes_plain_numbers_of_a_sound_scene(scene):
    plain = substitute(scene, np.array([0.6, 0.1, 7.0]))
    assert type(plain.controller.states[0].time) is float
    assert plain.controller.pd["rHip"].kp == 7.0
    assert free_parameters(plain) == []
    check_scene(plain)


def test_scene_without_parameters_takes_empty_values(scene):
    plain = substitute(scene, start_values(scene))
    assert substitute(plain, np.empty((4, 0))) == plain


def test_values_written_back_stay_free(scene):
    again = with_values(scene, np.array([0.6, 0.1, 7.0]))
    np.testing.assert_array_equal(start_values(again), [0.6, 0.1, 7.0])
    assert again.controller.states[0].time == Free(0.6, 0.5, 0.9, 0.01)
    assert again.controller.pd["rHip"].kp == Free(same_as="controller.pd.lHip.kp")
    assert start_values(scene)[0] == 0.7


def test_values_outside_their_interval_are_an_error_not_clipped(scene):
    with pytest.raises(Error, match=r"controller\.states\.0\.time: value 1 is outside its interval \[0\.5, 0\.9\]"):
        with_values(scene, np.array([1.0, 0.1, 7.0]))


@pytest.mark.parametrize("values", [np.zeros(2), np.zeros((3, 2)), np.zeros((1, 1, 3)), np.float64(1.0)])
def test_wrong_shapes_are_named(scene, values):
    with pytest.raises(Error, match="expected values of shape"):
        substitute(scene, values)


def test_values_must_be_finite(scene):
    with pytest.raises(Error, match=r"pd\.lHip\.kp: value is not finite"):
        substitute(scene, np.array([0.6, 0.1, np.nan]))


def test_a_constant_scene_is_checked_once_and_every_time_afterwards(scene, monkeypatch):
    checked = []
    check = checking._Check.scene
    monkeypatch.setattr(checking, "_content", lambda scene: None)  # by which equal ones are known elsewhere
    monkeypatch.setattr(checking._Check, "scene", lambda self: (checked.append(self.checked), check(self)))
    with constant([scene]):
        check_scene(scene)
        check_scene(scene)
        check_scene(copy.deepcopy(scene))  # an equal one, of which nobody said that it stays
    assert len(checked) == 2
    scene.name = " "
    with pytest.raises(SceneError, match="needs a name"):
        check_scene(scene)


def test_a_constant_scene_that_is_unsound_is_so_every_time(scene):
    scene.name = " "
    for _ in range(2):
        with constant([scene]), pytest.raises(SceneError, match="needs a name"):
            check_scene(scene)
        with pytest.raises(SceneError, match="needs a name"):
            check_scene(scene)


def test_a_scene_at_its_start_has_numbers_and_shares_what_has_none(scene):
    plain = at_start(scene)
    assert plain == substitute(scene, start_values(scene))
    assert plain.controller.pd["rHip"].kp == 10.0
    assert plain.character is scene.character
    with constant([scene]):
        assert at_start(scene) == plain
