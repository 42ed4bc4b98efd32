"""Joint reactions of simulated runs against closed forms, and against what a body on its feet needs."""

import numpy as np
import pytest

from muscle_arm import ABOUT_JOINT, MASS, REACH, arm, constant
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.reactions.run_reactions import run_reactions
from warpmuscle.scene import MuscleModel
from warpmuscle.simulation.rollout import Rollout

GRAVITY = 9.8  # m/s^2, of a scene that says nothing of it


def recorded(scene, duration, angle=0.0):
    """A run of the arm that begins at an angle, rad."""
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1000.0)
    if angle:
        start = rollout.state.coordinates.numpy()
        start[:, -1] = angle
        rollout.set_initial(start, rollout.state.speeds.numpy())
    rollout.run(duration)
    return rollout.recording(0)


@pytest.fixture(scope="module")
def pendulum(unoptimized_kernels):
    """The lower body alone swings on the upper one, which is held."""
    scene = arm(time_step=0.001)
    scene.character.muscles = {}
    return scene, recorded(scene, 0.5, angle=1.0)


def test_a_pendulum_pulls_as_it_swings(pendulum):
    """R along the string is m g cos + m l w^2, across it m g sin (1 - m l^2/I)."""
    scene, motion = pendulum
    found = run_reactions(scene, motion, device="cpu").reactions  # in the child's axes, OpenSim's: z is the hinge's
    angle, rate = motion.coordinate[:, -1], motion.speed[:, -1]
    along = MASS * GRAVITY * np.cos(angle) + MASS * REACH * rate**2
    across = MASS * GRAVITY * np.sin(angle) * (1.0 - MASS * REACH**2 / ABOUT_JOINT)
    assert found.force[:, 0, 1] == pytest.approx(along, abs=2e-3)
    assert np.abs(found.force[:, 0, 0]) == pytest.approx(np.abs(across), abs=2e-3)
    assert found.force[:, 0, 2] == pytest.approx(0.0 * along, abs=1e-4)
    assert found.moment[:, 0] == pytest.approx(np.zeros_like(found.moment[:, 0]), abs=2e-3)
    assert np.ptp(along) > 10.0


def test_the_parent_bears_the_opposite(pendulum):
    scene, motion = pendulum
    child, parent = (
        run_reactions(scene, motion, on=on, frame="ground", device="cpu").reactions for on in ("child", "parent")
    )
    assert child.force == pytest.approx(-parent.force)
    assert child.moment == pytest.approx(-parent.moment, abs=1e-6)


def test_a_muscle_presses_its_joint_together(unoptimized_kernels):
    """An arm at rest: what the joint bears is the muscle's pull along its line, less the weight of what hangs on it."""
    scene = arm(time_step=0.001, muscle_model=MuscleModel(tendon="rigid"))
    for muscle in scene.character.muscles.values():
        muscle.excitation = constant(0.3)  # of both: the arm hangs straight
    motion = recorded(scene, 1.5)
    found = run_reactions(scene, motion, frame="ground", device="cpu").reactions
    assert np.abs(motion.coordinate[-1, -1]) < 1e-3
    pull = np.zeros(2)
    for k, z in enumerate((0.04, -0.04)):
        line = np.array([0.12 - (-0.1), z - z])  # up and forwards, from the tip's point to the last on the base
        pull += motion.muscle_force[-1, k] * line / np.linalg.norm(line)
    assert motion.muscle_force[-1].min() > 50.0
    assert found.force[-1, 0, 1] == pytest.approx(MASS * GRAVITY - pull[0], rel=1e-4)


def test_what_lacks_is_said(pendulum):
    scene, motion = pendulum
    with pytest.raises(ArgumentError, match="recorded without joint_torque"):
        run_reactions(scene, motion.changed(joint_torque=np.zeros((0, 1, 3))), device="cpu")
    with pytest.raises(ArgumentError, match="another body"):
        run_reactions("gait2392_stand", motion, device="cpu")
    with pytest.raises(ArgumentError, match="child"):
        run_reactions(scene, motion, on="middle", device="cpu")
