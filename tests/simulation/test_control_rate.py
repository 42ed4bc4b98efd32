"""A controller that decides at a lower rate: its targets are held, PD follows them in every step."""

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, toml
from warpmuscle.scene import Scene
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

RATE, EVERY = 100.0, 20  # Hz, steps of 1/2000 s


def walk(**changes) -> Scene:
    return msgspec.structs.replace(load("fwalk"), **{"duration": 0.4, "control_rate": RATE} | changes)


@pytest.fixture(scope="module")
def motion():
    """Every step of a walk."""
    rollout = Rollout(walk(), 1, "cpu", record=[0], record_rate=2000.0)
    rollout.run()
    return rollout.recording()


def test_targets_stay_between_two_decisions_and_torques_do_not(motion):
    periods = motion.joint_target.reshape(-1, EVERY, *motion.joint_target.shape[1:])
    np.testing.assert_array_equal(periods, np.broadcast_to(periods[:, :1], periods.shape))
    assert (np.abs(np.diff(periods[:, 0], axis=0)).max(axis=(1, 2)) > 0.0).all()
    assert (np.abs(np.diff(motion.joint_torque_desired, axis=0)).max(axis=(1, 2)) > 0.0).all()


def test_a_decision_is_what_the_controller_says_of_the_state_at_that_time(motion):
    at = np.arange(0, len(motion.time), EVERY)
    stages = Stages(walk(), len(at), "cpu")
    stages.set_state(
        motion.root_position[at], motion.root_orientation[at], motion.root_velocity[at],
        motion.root_angular_velocity[at], motion.joint_orientation[at], motion.joint_angular_velocity[at],
        phase=motion.phase[at], stance=motion.stance[at], machine_state=motion.state[at],
    )  # fmt: skip
    np.testing.assert_allclose(motion.joint_target[at], stages.controller_torques()[0], atol=2e-5)


def test_a_decision_in_every_step_is_what_there_is_without_a_rate():
    bits = []
    for rate in (0.0, 2000.0, 1500.0):
        rollout = Rollout(walk(control_rate=rate, duration=0.1), 1, "cpu")
        rollout.run()
        bits.append(rollout.state.coordinates.numpy())
    np.testing.assert_array_equal(bits[1], bits[0])
    np.testing.assert_array_equal(bits[2], bits[0])


def test_an_instance_that_starts_again_decides_by_its_own_clock():
    rollout, alone = Rollout(walk(), 2, "cpu"), Rollout(walk(), 1, "cpu")
    rollout.step(EVERY // 2 + 1)
    rollout.reset(mask=np.array([False, True]))
    rollout.step(3 * EVERY + 5)
    alone.step(3 * EVERY + 5)
    np.testing.assert_array_equal(rollout.state.coordinates.numpy()[1], alone.state.coordinates.numpy()[0])


def test_it_walks_on_a_hundred_decisions_a_second():
    distance = {}
    for rate in (0.0, RATE):
        rollout = Rollout(walk(control_rate=rate, duration=6.0), 1, "cpu")
        rollout.run()
        assert rollout.alive == 1
        distance[rate] = float(rollout.state.coordinates.numpy()[0, 2])
    assert distance[RATE] == pytest.approx(distance[0.0], rel=0.08)


def test_a_file_keeps_the_rate():
    assert toml.loads(toml.dumps(walk())).control_rate == RATE


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"control_rate": -1.0}, "must not be negative"),
        ({"control_rate": float("nan")}, "control_rate"),
        ({"control_rate": 2500.0}, "cannot decide more than once a step, at 2000 Hz"),
        ({"controller": None}, "there is no controller; leave control_rate out"),
        ({"custom_controller": "mine:spring"}, "a custom_controller decides in every step"),
    ],
)
def test_an_impossible_rate_is_a_clear_error(changes: dict, message: str):
    with pytest.raises(SceneError, match=message) as caught:
        check_scene(walk(**changes))
    assert caught.value.key == "control_rate"
