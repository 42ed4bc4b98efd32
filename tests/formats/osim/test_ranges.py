"""Ranges of coordinates push with no force, as in OpenSim; that is told, and a stiffness may be given."""

from pathlib import Path

import pytest

import osim_models as small
from warpmuscle.core.errors import ArgumentError
from warpmuscle.formats import Ignored, load
from warpmuscle.scene import Scene

TWO = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q")) + small.joint(
    "SliderJoint", "slider", "rod", "tip", small.coordinate("s")
)
HELD = (
    '<CoordinateLimitForce name="stop"><coordinate>q</coordinate><upper_stiffness>2</upper_stiffness>'
    "<upper_limit>90</upper_limit><lower_stiffness>3</lower_stiffness><lower_limit>-45</lower_limit>"
    "<damping>0.1</damping><transition>5</transition></CoordinateLimitForce>"
)


def two(folder: Path, forces: str = "", **options: float) -> tuple[Scene, list[str]]:
    """A pin and a slider on it, and the notes on ranges."""
    ignored: list[Ignored] = []
    text = small.model(small.body("rod", center="0 -0.5 0") + small.body("tip"), TWO, forces)
    scene = load(small.written(folder, text), ignored=ignored, **options)
    return scene, [one.reason for one in ignored if "leaves" in one.reason]


def test_ranges_that_push_with_no_force_are_told_once(tmp_path: Path):
    scene, (told,) = two(tmp_path)
    assert {joint.limit_stiffness for joint in scene.character.joints.values() if joint.limits} == {0.0}
    assert "the ranges of 2 coordinates (q, s) push with no force" in told
    assert "--limit-stiffness" in told


def test_a_stiffness_is_that_of_all_ranges_but_those_that_a_force_of_the_model_holds(tmp_path: Path):
    scene, told = two(tmp_path, limit_stiffness=500.0)
    assert not told
    for name in ("q", "s"):
        joint = scene.character.joints[name]
        assert (joint.limits, joint.limit_stiffness, joint.limit_damping) == ([(-2.0, 2.0)], 500.0, 2.5)
    scene, told = two(tmp_path, HELD, limit_stiffness=500.0)
    assert not told
    assert scene.forces["stop"].type == "coordinate_limit"
    assert scene.character.joints["q"].limit_stiffness == 0.0
    assert scene.character.joints["s"].limit_stiffness == 500.0
    assert "the range of s pushes with no force" in two(tmp_path, HELD)[1][0]


@pytest.mark.parametrize("stiffness", [-1.0, float("nan"), "stiff"])
def test_a_stiffness_is_a_number_and_not_negative(tmp_path: Path, stiffness: float):
    with pytest.raises(ArgumentError, match="limit_stiffness must be a finite number, 0 or greater"):
        two(tmp_path, limit_stiffness=stiffness)
