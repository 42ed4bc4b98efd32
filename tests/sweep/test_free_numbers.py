"""Numbers freed by patterns of their paths, within intervals around their values."""

import re

import pytest

from small_scene import muscle_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.sweep.free_numbers import Interval, read_interval, with_free_numbers


def freed(scene: Scene, *texts: str) -> tuple[dict[str, tuple[float, float, float]], list[str]]:
    """Value, min and max of what is free then and was not, or not so, and the notes."""
    before = free_parameters(scene)
    changed, notes = with_free_numbers(scene, [read_interval(text) for text in texts])
    return {p.name: (p.value, p.min, p.max) for p in free_parameters(changed) if p not in before}, notes


def test_intervals_are_read():
    assert read_interval("character.muscles.?SOL.* = 20 %") == Interval("character.muscles.?SOL.*", part=0.2)
    assert read_interval("gravity=2.5%") == Interval("gravity", part=0.025)
    assert read_interval("a.b=[-1e-3, .5]") == Interval("a.b", ends=(-1e-3, 0.5))


@pytest.mark.parametrize(
    "text", ["", "a", "a=", "=20 %", "a = 20", "a = -20 %", "a = 0 %", "a = [1, 1]", "a = [1, nan]", "a = [1]"]
)
def test_what_is_no_interval_is_one_line_with_both_ways_to_write_one(text):
    with pytest.raises(SceneError, match=re.escape(f"{text!r}: write PATTERN = 20 %, or PATTERN = [min, max]")):
        read_interval(text)


def test_pattern_frees_every_number_around_its_value():
    scene = muscle_scene()
    muscles = scene.character.muscles
    found, _ = freed(scene, "character.muscles.*.f_max = 20 %")
    assert found == {
        f"character.muscles.{name}.f_max": (muscle.f_max, muscle.f_max * (1.0 - 0.2), muscle.f_max * (1.0 + 0.2))
        for name, muscle in muscles.items()
    }
    assert len(found) > 1
    scene.ground.height = -0.5  # around which the interval turns over
    assert freed(scene, "ground.height = 20 %")[0] == {"ground.height": (-0.5, -0.6, -0.4)}
    assert freed(scene, "ground.height = [-1, 2]", "gravity = 10 %")[0]["ground.height"] == (-0.5, -1.0, 2.0)


def test_what_is_free_already_keeps_value_and_step_and_what_follows_goes_on_following():
    scene = muscle_scene()
    scene.controller.pd["lHip"].kp = Free(10.0, 5.0, 20.0, step=0.5)
    scene.controller.pd["rHip"] = type(scene.controller.pd["lHip"])(Free(same_as="controller.pd.lHip.kp"), 1.0)
    changed, _ = with_free_numbers(scene, [read_interval("controller.pd.?Hip.kp = 10 %")])
    assert changed.controller.pd["lHip"].kp == Free(10.0, 9.0, 11.0, step=0.5)
    assert changed.controller.pd["rHip"].kp == Free(same_as="controller.pd.lHip.kp")
    assert scene.controller.pd["lHip"].kp == Free(10.0, 5.0, 20.0, step=0.5)


def test_zeros_stay_as_they_are_with_a_note():
    scene = load("walk56")
    found, notes = freed(scene, "initial_state.root_position.* = 20 %")
    zeros = [index for index, value in enumerate(scene.initial_state.root_position) if value == 0.0]
    assert zeros
    assert set(found) == {f"initial_state.root_position.{index}" for index in range(3) if index not in zeros}
    (note,) = notes
    assert f"initial_state.root_position.{zeros[0]}" in note
    assert "no interval in percent" in note


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "character.muscles.XSOL*.f_max = 20 %",
            "character.muscles.XSOL*.f_max: no number that may be free",
        ),
        ("character.musles.*.f_max = 20 %", "there is no 'musles' in character"),
        ("character.muscles.HFL.f_mx = 20 %", "there is no 'f_mx' in character.muscles.HFL"),
        ("duration = 20 %", "duration: is not a number that may be free"),
        ("ground.height = 20 %", "ground.height: is 0 or without end"),
        ("controller.pd.rHip.kp = 20 %", "controller.pd.rHip.kp: follows controller.pd.lHip.kp: free that one"),
        ("gravity = [20, 30]", "gravity: value 9.81 is outside its interval [20, 30]"),
        ("character.muscles.HFL.f_max = 200 %", "character.muscles.HFL.f_max: "),
    ],
)
def test_errors_name_what_matched_nothing(text, message):
    scene = muscle_scene()
    scene.ground.height, scene.gravity = 0.0, 9.81
    scene.controller.pd["lHip"].kp = Free(10.0, 5.0, 20.0)
    scene.controller.pd["rHip"] = type(scene.controller.pd["lHip"])(Free(same_as="controller.pd.lHip.kp"), 1.0)
    with pytest.raises(SceneError, match=re.escape(message)):
        freed(scene, text)
