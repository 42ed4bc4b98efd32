"""Joints of one coordinate against closed forms: a bead that slides along a rail on a turntable."""

import numpy as np
import pytest
from joint_chains import accelerated, chain, lagging

from warpmuscle.scene import Body, Character, Failure, Ground, Joint, Scene
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.inverse_dynamics import inverse_dynamics

ORIGIN = (0.0, 0.0, 0.0)
TABLE, BEAD, MASS = 0.7, 0.02, 1.3  # moments of inertia about the vertical, kg m^2; mass of the bead, kg


def turntable() -> Scene:
    joints = {
        "pivot": Joint("hinge", "stand", "table", ORIGIN, ORIGIN, [(0.0, 1.0, 0.0)]),
        "rail": Joint("slide", "table", "bead", ORIGIN, ORIGIN, [(1.0, 0.0, 0.0)]),
    }
    bodies = {
        "stand": Body(1.0, (1.0, 1.0, 1.0)), "table": Body(2.0, (0.4, TABLE, 0.5)),
        "bead": Body(MASS, (0.03, BEAD, 0.01)),
    }  # fmt: skip
    failure = Failure(com_height=0.0, heading=0.0, max_com_speed=1000.0)
    character = Character("stand", bodies, joints, root_joint="fixed")
    return Scene("turntable", character, ground=Ground(stiffness=0.0), failure=failure)


CHAINS = {
    "nothing prescribed": (
        ("ball", "none"),
        ("slide", "none"),
        ("coupled", "none"),
        ("hinge", "none"),
        ("universal", "none"),
    ),
    "none of them prescribed": (("ball", "none"), ("slide", "none"), ("coupled", "none"), ("hinge", "kinematic")),
    "slides prescribed": (("slide", "kinematic"), ("universal", ["kinematic", "none"]), ("coupled", "none")),
    "coupled joints prescribed": (("coupled", "kinematic"), ("slide", "none"), ("coupled", "kinematic")),
}


@pytest.mark.parametrize("drives", CHAINS.values(), ids=CHAINS)
def test_chains_in_space_accelerate_so_that_no_force_acts_along_what_is_free(drives: tuple):
    """By inverse dynamics in float64, some coordinates prescribed."""
    scene = chain(*drives)
    found = accelerated(scene)
    needed = inverse_dynamics(scene, found.coordinates, found.speeds, found.accelerations)
    weight = 9.8 * sum(body.mass for body in scene.character.bodies.values())
    np.testing.assert_allclose(needed[:, found.others], 0.0, atol=2e-4 * weight)
    assert np.abs(found.accelerations).max() > 10.0


@pytest.mark.parametrize("heading", [0.0, 1.1])
def test_a_bead_on_a_turntable_feels_centrifugal_and_coriolis_forces(heading: float):
    """r'' = r w^2, and (I + m r^2) w' = -2 m r r' w: the angular momentum (I + m r^2) w stays."""
    r, speed, spin = np.array([0.5, -0.3, 0.8, 0.5, 0.5]), np.array([2.0, 1.5, -1.0, 0.0, 2.0]), 3.0
    turn = np.array([spin, -spin, spin, spin, 0.0])
    stages, count, none = Stages(turntable(), 5, "cpu"), 5, np.zeros(5)
    whole = np.array([0.0, np.sin(0.5 * heading), 0.0, np.cos(0.5 * heading)])
    still = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
    angular = np.zeros((count, 2, 3))
    angular[:, 0, 1] = turn
    stages.set_state(
        np.zeros((count, 3)), still, np.zeros((count, 3)), np.zeros((count, 3)),
        np.stack([np.tile(whole, (count, 1)), still], axis=1), angular,
        joint_coordinate=np.column_stack([none, r]), joint_speed=np.column_stack([none, speed]),
    )  # fmt: skip
    rate = stages.forward_dynamics()["speed_rate"]
    slowing = -2.0 * MASS * r * speed * turn / (TABLE + BEAD + MASS * r**2)
    np.testing.assert_allclose(rate[:, 1], r * turn**2, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(rate[:, 0], slowing, rtol=1e-5, atol=1e-5)
    # In numbers: 0.5 m from the middle at 2 m/s outwards and 3 rad/s.
    np.testing.assert_allclose(rate[0], [-7.8 / 1.045, 4.5], rtol=1e-5)


def test_velocities_lag_by_what_their_speeds_gained_in_half_a_step():
    found, gained = lagging(chain(("coupled", "none"), ("slide", "none"), ("hinge", "none"), ("coupled", "none")))
    np.testing.assert_allclose(found[:, :, 2:], gained, atol=2e-5)
    assert np.abs(gained[:, 1:]).min(axis=(0, 1, 3)).max() > 0.0
    assert np.abs(gained).max() > 0.05
