"""Told loads on a pendulum against double precision."""

import numpy as np
import pytest

from muscle_arm import ABOUT_JOINT, MASS, REACH, arm
from warpmuscle.kernels.force.loads import JointLoad, Load, PointLoad
from warpmuscle.scene import Actuation, Force, InitialState, JointState, Scene
from warpmuscle.simulation.rollout import Rollout

STEP, STEPS, GRAVITY = 0.0005, 600, 9.8
JOINT = np.array([0.0, 1.0, 0.0])  # m, the pendulum's axis goes through it, along x
KINDS = {"load": (Load, {"body": "tip"}), "point_load": (PointLoad, {"body": "tip"}),
         "joint_load": (JointLoad, {"joint": "elbow"})}  # fmt: skip


def told(kind: str, **values: float) -> Force:
    struct, where = KINDS[kind]
    return Force(kind, **where, parameters=dict.fromkeys(struct.vars, 0.0) | values)


def swing(scene_forces: dict[str, Force]) -> np.ndarray:
    """Angles of the pendulum at every step."""
    every = {name: told(name) for name in KINDS} | scene_forces  # so that all share a kernel
    scene: Scene = arm(
        actuation={"elbow": Actuation("torque")}, forces=every, duration=STEPS * STEP,
        initial_state=InitialState((0.0, 1.0, 0.0)),
    )  # fmt: skip
    scene.initial_state.joints = {"elbow": JointState(angular_velocity=(3.0, 0.0, 0.0))}
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / STEP)
    rollout.run()
    return rollout.recorded("coordinates")[0, :, 7].astype(float)


def expected(torque) -> np.ndarray:
    """The same by leapfrog in double precision, under a torque (angle, time) about the joint's axis."""
    q, middle = 0.0, 3.0
    found = np.empty(STEPS)
    for step in range(STEPS):
        found[step] = q
        a = (torque(q, (step + 0.5) * STEP) - MASS * GRAVITY * REACH * np.sin(q)) / ABOUT_JOINT
        middle += (STEP if step else 0.5 * STEP) * a
        q += STEP * middle
    return found


def about_joint(force: np.ndarray, point: np.ndarray) -> float:
    return float(np.cross(point - JOINT, force)[0])


def test_an_effort_turns_the_child():
    got = swing({"joint_load": told("joint_load", effort_0=0.7)})
    assert got[:STEPS] == pytest.approx(expected(lambda q, t: 0.7), abs=2e-4)


def test_a_force_at_the_center_of_mass_changes_at_its_rate():
    force, rate, moment = np.array([0.0, 4.0, -6.0]), np.array([0.0, -20.0, 30.0]), 0.3
    got = swing(
        {"load": told("load", since=0.1, force_y=4.0, force_z=-6.0, force_rate_y=-20.0, force_rate_z=30.0,
                      moment_x=moment, moment_rate_x=2.0)}
    )  # fmt: skip

    def torque(q: float, t: float) -> float:
        center = JOINT + REACH * np.array([0.0, -np.cos(q), -np.sin(q)])
        return about_joint(force + rate * (t - 0.1), center) + moment + 2.0 * (t - 0.1)

    assert got == pytest.approx(expected(torque), abs=2e-4)


def test_a_force_at_a_point_of_the_world_acts_there_however_the_body_turns():
    got = swing(
        {"point_load": told("point_load", force_y=10.0, force_z=5.0, force_rate_z=8.0, point_y=0.7, point_z=0.2,
                            point_rate_z=-0.5, moment_x=-0.2)}
    )  # fmt: skip

    def torque(q: float, t: float) -> float:
        point = np.array([0.0, 0.7, 0.2 - 0.5 * t])
        return about_joint(np.array([0.0, 10.0, 5.0 + 8.0 * t]), point) - 0.2

    assert got == pytest.approx(expected(torque), abs=2e-4)
