"""Feet belong to the character: contacts, objectives, failures and measures of gaits need no SIMBICON for them."""

import msgspec
import numpy as np
import pytest

from short_walks import OF_TORQUES
from warpmuscle.core.errors import SceneError
from warpmuscle.core.status import Status
from warpmuscle.formats import load, toml
from warpmuscle.gait.measures import measure
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Objective, Scene
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout

FEET = ("lFoot", "rFoot")


def limp(**failure: float) -> Scene:
    """A biped that falls down, its controller being without any strength."""
    scene = load("fwalk")
    scene.duration, scene.controller.pd, scene.controller.heading_control = 0.3, {}, False
    scene.failure = msgspec.structs.replace(scene.failure, com_height=0.0, heading=0.0, **failure)
    scene.objective = Objective(**OF_TORQUES, ground_force_bound=0.1)
    return scene


def uncontrolled(feet: tuple[str, str] | None = FEET, **failure: float) -> Scene:
    """The same without a controller."""
    scene = limp(**failure)
    scene.controller, scene.character.feet = None, feet
    return scene


def run(scene: Scene) -> tuple[Rollout, Recording]:
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1000)
    rollout.run()
    return rollout, rollout.recording()


def test_forces_on_feet_and_terms_of_them_are_the_same_without_a_controller():
    (own, plain), (other, controlled) = run(uncontrolled()), run(limp())
    for side in ("left", "right"):
        force = getattr(plain, f"foot_force_{side}")
        np.testing.assert_array_equal(force, getattr(controlled, f"foot_force_{side}"))
        assert force[:, 1].max() > 100.0
    assert own.terms()["ground_force"][0] == other.terms()["ground_force"][0] > 0.0
    footless = uncontrolled(feet=None)
    footless.objective = Objective()
    assert not run(footless)[1].foot_force_left.any()


def test_legs_cross_and_gaits_are_compared_with_human_ones_without_a_controller():
    for feet, outcome in ((FEET, Status.RUNNING), (FEET[::-1], Status.CROSSED)):
        rollout = Rollout(uncontrolled(feet, leg_crossing=0.05), 1, "cpu", record=[0])
        rollout.step(10)
        assert rollout.status()[0] == outcome
    scene = uncontrolled()
    rollout, motion = run(scene)
    assert rollout.terms()["norms"][0] > 0.0
    assert rollout.terms()["norm_force"][0] > 0.0
    assert np.isfinite(measure(motion, *scene.feet, start=0.0).speed_forward)


def test_feet_of_the_character_go_before_those_of_its_controller():
    scene = load("fwalk")
    assert scene.feet == FEET
    scene.character.feet = ("lToes", "rToes")
    assert scene.feet == ("lToes", "rToes")
    assert toml.loads(toml.dumps(scene)).feet == scene.feet
    scene.controller = scene.character.feet = None
    assert scene.feet is None


@pytest.mark.parametrize(
    ("feet", "message"),
    [
        (("lFoot", "rFot"), "character.feet.1: no body is called 'rFot'; did you mean 'rFoot'"),
        (("lFoot", "lFoot"), "character.feet: left and right are both 'lFoot'"),
    ],
)
def test_feet_are_two_bodies(feet: tuple[str, str], message: str):
    with pytest.raises(SceneError, match=message):
        check_scene(uncontrolled(feet))
