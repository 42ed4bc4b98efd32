"""A simulation that goes on while its numbers change, without a browser."""

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.pose import twist_angle
from warpmuscle.rollout import Rollout
from warpmuscle.status import Status
from warpmuscle.view.live_run import LiveRun, can_change_speed

UP = np.array([0.0, 1.0, 0.0])


@pytest.fixture(scope="module")
def run() -> LiveRun:
    return LiveRun(load("fwalk"))


def later(run: LiveRun, duration: float) -> None:
    for _ in range(round(duration / 0.02)):
        run.step()


def test_motion_is_that_of_a_rollout(run):
    run.restart()
    later(run, 0.4)
    rollout = Rollout(load("fwalk"), 1, "cpu", record=[0], record_rate=50.0)
    rollout.run(0.42)
    assert np.array_equal(run.window(9.0).com, rollout.recording().com)
    tail = rollout.recording(start=0.2)
    np.testing.assert_allclose(tail.time, 0.2 + 0.02 * np.arange(11))
    assert np.array_equal(tail.com, rollout.recording().com[10:])
    assert rollout.recording(start=99.0).frames == 1
    assert run.track().frames == 1


def test_changes_count_without_a_new_start(run):
    run.restart()
    later(run, 0.1)
    index = next(k for k, p in enumerate(run.parameters) if p.name == "controller.pd.lKnee.kp")
    before, body = run.time, run.rollout.names.body_of_joint("rKnee")
    run.values[index], run.turned, run.faster = 444.0, 0.5, 0.25
    run.apply()
    simbicon = run.rollout.model.simbicon
    assert run.time == before
    assert simbicon.kp.numpy()[0, body] == 444.0  # the right side follows the left
    assert simbicon.hip.numpy()[0, 0, 3] == pytest.approx(0.5)
    assert 0.25 in simbicon.knot_value.numpy()
    run.values[index], run.turned, run.faster = 300.0, 0.0, 0.0
    run.apply()


def test_steering_makes_it_faster_and_turns_it(run):
    assert can_change_speed(run.numeric.controller)
    speeds = []
    for faster in (0.0, 0.2):
        run.restart()
        run.faster = faster
        run.apply()
        later(run, 6.0)
        speeds.append(run.window(2.0).com_velocity[:, 2].mean())
    assert speeds[1] > speeds[0] + 0.1
    run.faster, run.turned = 0.0, 0.4
    run.apply()
    later(run, 3.0)
    assert twist_angle(run.window(0.0).root_orientation[-1], UP) == pytest.approx(0.4, abs=0.1)
    run.turned = 0.0
    run.apply()


def test_push_gives_its_impulse_in_the_direction_that_the_biped_sees(run):
    run.restart()
    later(run, 0.2)
    before = run.window(0.0).com_velocity[-1]
    impulse = run.push(20.0, np.pi / 2.0)
    later(run, 0.14)
    undisturbed = LiveRun(load("fwalk"))
    later(undisturbed, 0.34)
    gained = run.window(0.0).com_velocity[-1] - undisturbed.window(0.0).com_velocity[-1]
    assert before.shape == impulse.shape == (3,)
    assert 0.5 * 20.0 / 70.4 < gained[0] < 1.1 * 20.0 / 70.4
    run.push(200.0, np.pi / 2.0)
    later(run, 1.5)
    assert run.status not in (Status.RUNNING, Status.COMPLETED)
    run.restart()
    assert run.status == Status.RUNNING


def test_wall_time_that_was_lost_is_not_made_up_for(run):
    run.restart()
    run.advance(5.0)
    assert run.time < 0.11
