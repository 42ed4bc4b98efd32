"""What a body under a quadratic programme leans on: a fixed object bears it, along its own normal, as far as it may."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from muscle_arm import arm
from warpmuscle.core.pose import rotate
from warpmuscle.scene import Actuation, Capsule, Controller, Scene, Sphere
from warpmuscle.scene.objects.part import BoxObject
from warpmuscle.simulation.rollout import Rollout

RADIUS, TILT = 0.05, 0.3  # m, rad
SEAT = (0.3, 0.1, 0.4)  # m


def seated(gap: float = -0.001, tilt: float = 0.0, shape: Any = None, **parameters: float) -> Scene:
    """An arm at rest, whose base is so far from the middle of a tilted seat; its centre of mass is to stay."""
    given = {"rate": 1000.0, "contact_effort": 1e-4, "com_weight": 1e3, "com_kp": 0.0, "com_kd": 0.0}
    controller = Controller(type="quadratic_program", parameters={**given, **parameters},
                            by_joint={"others": {"weight": 1.0, "kp": 0.0, "kd": 0.0, "torque": 100.0}},
                            by_body={"base": {"turn_weight": 0.01}, "others": {}})  # fmt: skip
    scene = arm(controller=controller, time_step=0.001, actuation={"elbow": Actuation("torque")})
    scene.character.muscles = {}
    scene.character.root_joint = "free"
    scene.character.bodies["base"].shapes = [shape or Sphere((0.0, 0.0, 0.0), RADIUS)]
    turn = np.array([np.sin(0.5 * tilt), 0.0, 0.0, np.cos(0.5 * tilt)])
    normal = rotate(turn, np.array([0.0, 1.0, 0.0]))
    height = 0.5 * SEAT[1] + RADIUS + gap
    scene.initial_state.root_position = (0.0, 2.0, 0.0)
    place = np.array([0.0, 2.0, 0.0]) - height * normal
    solid = BoxObject(size=SEAT, fixed=True, position=tuple(place), orientation=tuple(turn), friction=0.8)
    scene.objects = {"shelf": BoxObject(size=SEAT, fixed=True, position=(0.0, 5.0, 0.0)), "seat": solid}
    return scene


def decided(scene: Scene) -> tuple[float, float, float]:
    """Of the first decision: what is missed of what is wanted, the sum of forces along edges, and the weight, N."""
    rollout = Rollout(scene, 1, "cpu")
    rollout.step(1)
    unmet, _, load = rollout.controller_state[0, :3]
    return float(unmet), float(load), float(rollout.model.skeleton.total_mass.numpy()[0, 0] * scene.gravity)


@pytest.mark.usefixtures("unoptimized_test")
class TestSupports:
    def test_a_seat_bears_the_weight(self):
        unmet, load, weight = decided(seated())
        assert load == pytest.approx(weight, rel=1e-4)
        assert unmet < 0.05

    def test_forces_are_about_the_normal_of_a_seat_that_is_tilted(self):
        """A vertical force has that part along the normal, which the edges of a cone add up to."""
        unmet, load, weight = decided(seated(tilt=TILT))
        assert load == pytest.approx(weight * np.cos(TILT), rel=1e-3)
        assert unmet / np.sqrt(1e3) < 0.02

    def test_friction_is_the_smaller_of_both(self):
        """With 0.1, across a slope of 0.3 rad, most of what pulls down along it is left."""
        unmet, _, _ = decided(seated(tilt=TILT, friction=0.1))
        assert unmet / np.sqrt(1e3) > 9.8 * (np.sin(TILT) - 0.1 * np.cos(TILT)) * np.cos(TILT) * 0.9

    def test_it_bears_no_more_than_its_share(self):
        unmet, load, weight = decided(seated(support=0.1))
        assert load == pytest.approx(0.4 * weight, rel=1e-4)
        assert unmet / np.sqrt(1e3) == pytest.approx(0.6 * 9.81, rel=0.02)

    def test_it_bears_nothing_from_afar_or_where_no_share_is_given(self):
        assert decided(seated(gap=0.01))[1] == 0.0
        assert decided(seated(support=0.0))[1] == 0.0

    def test_a_capsule_lies_on_it(self):
        """It is longer than the seat is wide; the point is in the middle of the part that lies there."""
        capsule = Capsule((-0.3, 0.0, 0.0), (0.3, 0.0, 0.0), RADIUS)
        assert decided(seated(shape=capsule))[1] == pytest.approx(decided(seated())[2], rel=1e-3)


def test_without_objects_nothing_is_there_to_lean_on(unoptimized_kernels):
    scene = seated()
    scene.objects = {}
    rollout = Rollout(scene, 1, "cpu")
    assert rollout._program._layout.support.shape == (0, 3)
    rollout.step(1)
    assert rollout.controller_state[0, 2] == 0.0
