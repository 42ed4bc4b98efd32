"""Numbers of scenes are called what people call them, each by a name of its own, and angles are in degrees."""

from collections import Counter

import pytest

from warpmuscle.formats import load
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.view.editing.names import called, joint_words, shown_unit
from warpmuscle.view.editing.numbers import editable
from warpmuscle.view.editing.parameters import ParameterSliders

HIP = "controller.states.0.trajectories.SWING_Hip.components"


@pytest.mark.parametrize(
    ("key", "group", "whole"),
    [
        (f"{HIP}.2.angle.0", "swing hip", "swing hip sideways angle"),
        (f"{HIP}.1.angle.1", "swing hip", "swing hip angle at 23 %"),
        (f"{HIP}.1.phase.1", "swing hip", "swing hip angle, phase of point 2"),
        (f"{HIP}.1.feedback.cv", "swing hip", "swing hip angle, speed feedback (cv)"),
        ("controller.states.0.time", "step", "step duration"),
        ("controller.pd.lKnee.kp", "gains, left knee", "left knee stiffness (kp)"),
        ("controller.pd.rHip.scale.1", "gains, right hip", "right hip torque scale (y)"),
        ("character.muscles.lGLU.l_opt", "muscle lGLU", "lGLU optimal fibre length (l_opt)"),
        ("initial_state.root_velocity.2", "initial state", "root velocity (z)"),
    ],
)
def test_a_path_has_the_name_that_people_give_it(key, group, whole):
    scene = load("walk56")
    found = called(tuple(key.split(".")), scene)
    assert (found.group, found.full) == (group, whole)


@pytest.mark.parametrize("name", ["walk56", "reflex_walk", "throw18", "walk56_commands", "bwalk_stairs"])
def test_no_two_numbers_of_a_scene_have_one_name(name):
    scene = load(name)
    numbers, curves = editable(scene)
    names = Counter((one.group, one.name) for one in (*numbers, *curves))
    assert [name for name, count in names.items() if count > 1] == []
    wholes = Counter(called(tuple(one.name.split(".")), scene).full for one in free_parameters(scene))
    assert [name for name, count in wholes.items() if count > 1] == []


def test_joints_are_words():
    names = {"lHip": "left hip", "SWING_Ankle": "swing ankle", "knee_r": "right knee", "lToeJoint": "left toe joint"}
    assert {name: joint_words(name) for name in names} == names
    assert joint_words("_") == "_"


def test_angles_are_shown_in_degrees_and_all_else_as_it_is():
    assert shown_unit("rad") == ("deg", pytest.approx(57.29578))
    assert shown_unit("rad s/m")[0] == "deg s/m"
    assert [shown_unit(unit) for unit in ("N m/rad", "m", "")] == [("N m/rad", 1.0), ("m", 1.0), ("", 1.0)]


def test_a_slider_in_degrees_gives_radians_and_follows_them():
    scene, heard = load("fwalk"), []
    sliders = ParameterSliders(scene, free_parameters(scene), lambda name, value: heard.append((name, value)))
    name = f"{HIP}.1.angle.1"
    slider = sliders.sliders[name]
    assert slider.unit == "deg"
    slider.changed(45.0)
    assert heard == [(name, pytest.approx(0.7853982))]
    sliders.follow({name: 3.0})
    assert slider.value == slider.max == pytest.approx(171.8873)
