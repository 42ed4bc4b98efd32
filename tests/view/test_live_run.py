"""A simulation that goes on while its numbers change, without a browser."""

from functools import reduce

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.core.pose import twist_angle
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.scene import Command
from warpmuscle.scene.number import Free
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.view.live_run import (
    COMMAND_RATE,
    SPEED_RATE,
    STEERING_INTERVAL,
    TURN_RATE,
    LiveRun,
    can_change_speed,
    parts_that_follow,
)

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
    run.values[index] = 444.0
    run.apply()
    assert run.time == before
    assert run.rollout.model.simbicon.gains.numpy()["kp"][0, body] == 444.0  # the right side follows the left
    run.values[index] = 300.0
    run.apply()


def heading_of_controller(run: LiveRun) -> float:
    return float(run.rollout.model.simbicon.hip.numpy()["desired_heading"][0, 0])


def test_what_is_no_number_or_beyond_the_bounds_does_not_reach_the_batch(run):
    run.restart()
    index = next(k for k, p in enumerate(run.parameters) if p.name == "controller.pd.lKnee.kp")
    body = run.rollout.names.body_of_joint("rKnee")
    for asked, had in ((1e308, 600.0), (float("inf"), 600.0), (-float("inf"), 150.0), (float("nan"), 150.0)):
        run.values[index] = asked
        run.apply()
        assert run.rollout.model.simbicon.gains.numpy()["kp"][0, body] == run.values[index] == had
    run.values[index] = 300.0
    run.apply()
    assert not np.any(run.push(float("nan"), 0.0))
    assert not np.any(run.push(float("inf"), 0.0))
    for asked in (1e308, float("nan"), float("inf"), -float("inf")):
        run.faster = run.turned = asked
        later(run, 0.24)
        assert abs(heading_of_controller(run)) <= TURN_RATE * run.time
    run.faster = run.turned = 0.0


def test_a_turn_asked_for_at_once_reaches_the_controller_as_a_ramp_that_the_walk_survives(run):
    run.restart()
    later(run, 2.0)
    run.turned, begun, before = np.radians(60.0), run.time, 0.0
    while run.time < begun + 10.0:
        later(run, 0.1)
        now = heading_of_controller(run)
        assert 0.0 <= now - before <= TURN_RATE * 2.0 * STEERING_INTERVAL + 1e-6
        assert now <= TURN_RATE * (run.time - begun) + 1e-6
        before = now
    assert np.degrees(TURN_RATE) == pytest.approx(8.0)
    assert before == pytest.approx(np.radians(60.0))
    assert run.status == Status.RUNNING
    assert twist_angle(run.window(0.0).root_orientation[-1], UP) == pytest.approx(np.radians(60.0), abs=0.1)
    run.restart()  # straight ahead again: the turn begins anew
    assert heading_of_controller(run) == 0.0
    assert run.status == Status.RUNNING
    run.turned = 0.0


def test_steering_begins_gently_after_a_long_time_of_none_and_goes_back(run):
    run.restart()
    later(run, 1.0)
    run.faster = 0.03
    later(run, 0.1)
    first = run.rollout.model.simbicon.knots.numpy()["value"].flat[0]  # of the balance of the first state
    assert 0.0 < first <= SPEED_RATE * 2.0 * STEERING_INTERVAL + 1e-6
    later(run, 0.5)
    assert run.rollout.model.simbicon.knots.numpy()["value"].flat[0] == pytest.approx(0.03)
    run.faster = 0.0
    later(run, 0.5)
    plain = LiveRun(load("fwalk")).rollout.model.simbicon
    for field in ("hip", "knots", "balance_knots"):
        assert np.array_equal(getattr(run.rollout.model.simbicon, field).numpy(), getattr(plain, field).numpy())


def test_a_start_that_fails_at_once_shows_what_was_seen_before(run):
    run.restart()
    later(run, 0.1)
    before = run.window(0.0)
    scene = msgspec.structs.replace(run.scene, failure=msgspec.structs.replace(run.scene.failure, com_height=9.0))
    limits = run.rollout.model.failure.numpy()
    limits["com_height"] = 9.0
    run.rollout.model.failure.assign(limits)
    run.restart()
    assert run.status == Status.FELL
    assert run.rollout.recording(0).frames == 0
    assert run.window(5.0) is before
    assert run.track().frames == 1
    run.apply()
    run.restart()
    assert run.window(0.0) is not before
    with pytest.raises(Error, match=r"fwalk cannot be shown: in its first step it fell"):
        LiveRun(scene)


def test_steering_makes_it_faster_and_turns_it(run):
    assert can_change_speed(run.numeric.controller)
    speeds = []
    for faster in (0.0, 0.2):
        run.restart()
        run.faster = faster
        later(run, 8.0)
        speeds.append(run.window(2.0).com_velocity[:, 2].mean())
    assert speeds[1] > speeds[0] + 0.1
    run.faster, run.turned = 0.0, 0.4
    later(run, 6.0)
    assert twist_angle(run.window(0.0).root_orientation[-1], UP) == pytest.approx(0.4, abs=0.1)
    run.turned = 0.0


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


def test_a_step_is_one_frame_also_where_the_next_one_was_nearly_due(run):
    run.restart()
    run.advance(0.02 * 0.99995)
    before = run.time
    run.step()
    assert run.time == pytest.approx(before + 0.02)


def test_commands_are_reached_as_ramps_and_an_inclined_ground_stays_below_the_feet():
    scene = load("fwalk")
    scene.commands = {"speed": Command(1.0, 0.5, 1.5), "slope": Command(0.0, -1.0, 1.0)}
    scene.controller.states[0].time = Free(0.6, per={"speed": -0.2})
    scene.ground.normal = (0.0, 1.0, Free(0.0, per={"slope": -0.0175}))
    run = LiveRun(scene)
    later(run, 1.0)
    run.asked |= {"speed": 9.0, "slope": 1.0}
    begin = run.time
    later(run, 2.0)
    passed = run.time - begin
    time = float(run.numeric.controller.states[0].time)
    assert time == pytest.approx(0.6 - 0.2 * COMMAND_RATE * 1.0 * passed, abs=0.2 * COMMAND_RATE * 0.15)
    assert run.numeric.ground.normal[2] == pytest.approx(-0.0175 * COMMAND_RATE * 2.0 * passed, abs=0.001)
    assert np.any(run.numeric.ground.height)
    assert run.status == Status.RUNNING
    later(run, 4.0)
    assert float(run.numeric.controller.states[0].time) == pytest.approx(0.5)
    run.asked["speed"] = float("nan")
    run.restart()
    assert float(run.numeric.controller.states[0].time) == pytest.approx(0.5)
    assert not np.any(run.numeric.ground.height)


def test_what_follows_commands_is_all_that_is_made_anew():
    scene = load("walk56_commands")
    assert set(parts_that_follow(scene) or ()) == {"controller", "bodies", "slope", "objective"}
    run = LiveRun(scene)
    run.asked |= {"speed": 1.8, "slope": 5.0, "load": 10.0}
    later(run, 0.3)
    whole = Rollout(run.scene, 1, "cpu")
    whole.change(run.numeric)
    for place in ("simbicon.knots", "simbicon.gains", "simbicon.state_time", "contacts.normal", "skeleton.row"):
        parts = (reduce(getattr, place.split("."), rollout.model).numpy() for rollout in (run.rollout, whole))
        np.testing.assert_array_equal(*parts, err_msg=place)
    scene.muscle_model.specific_tension = Free(6e5, per={"speed": 1.0})
    assert parts_that_follow(scene) is None
