"""Scenes that begin in the midst of their own motion."""

from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from small_scene import sound_scene
from warpmuscle.core.errors import RolloutError
from warpmuscle.formats import load
from warpmuscle.scene import Command
from warpmuscle.scene.number import Free
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.steady_state import first_step, steady_state


def motion(scene, duration: float):
    rollout = Rollout(msgspec.structs.replace(scene, duration=duration), 1, "cpu", record=[0], record_rate=2000.0)
    rollout.run()
    return rollout.recording()


def test_settled_walk_goes_on_as_the_walk_does():
    scene = load("fwalk")
    original = motion(scene, 7.0)
    start = steady_state(scene, 4.0)
    steps = np.flatnonzero((np.diff(original.phase) < 0.0) & (original.stance[1:] == 0)) + 1
    begin = next(step for step in steps if original.time[step] > 4.0)
    again = motion(start, 0.5)
    there = slice(begin, begin + len(again.time))
    moved = original.root_position[there] - original.root_position[begin] * (1.0, 0.0, 1.0)
    np.testing.assert_allclose(again.root_position, moved, atol=5e-3)
    np.testing.assert_allclose(again.phase, original.phase[there], atol=2e-3)
    assert np.abs(again.joint_orientation - original.joint_orientation[there]).max() < 0.05


def test_the_first_step_is_that_after_the_time_in_its_state_and_stance():
    phase = np.array([0.0, 0.5, 0.1, 0.6, 0.2, 0.7, 0.0, 0.4, 0.1])  # steps begin in frames 2, 4, 6, 8
    state, stance = np.array([0, 0, 1, 1, 0, 0, 0, 0, 0]), np.array([0, 0, 0, 0, 1, 1, 0, 0, 0])
    motion = SimpleNamespace(time=np.arange(9.0), phase=phase, state=state, stance=stance)
    assert [first_step(motion, after, 0, 0) for after in (0.0, 5.0, 6.0, 8.0)] == [6, 6, 8, None]
    assert first_step(motion, 0.0, 1, 0) == 2
    assert first_step(motion, 0.0, 0, 1) == 4


def test_only_the_start_is_another():
    scene = load("fwalk")
    assert msgspec.structs.replace(steady_state(scene, 1.0), initial_state=scene.initial_state) == scene


def test_what_begins_no_steps_is_said():
    scene = load("fwalk")
    fallen = msgspec.structs.replace(scene, initial_state=msgspec.structs.replace(scene.initial_state))
    fallen.initial_state.root_velocity = (0.0, 0.0, -4.0)
    with pytest.raises(RolloutError, match="fwalk begins no step between 3 s and its end at"):
        steady_state(fallen, 3.0)
    still = msgspec.structs.replace(sound_scene(), controller=None)
    with pytest.raises(RolloutError, match="has no controller"):
        steady_state(still, 1.0)


def test_what_diverges_at_once_begins_no_step():
    state = msgspec.structs.replace(load("fwalk").initial_state, root_velocity=(0.0, 0.0, 1e9))
    with pytest.raises(RolloutError, match="begins no step between 1 s and its end at 0 s"):
        steady_state(msgspec.structs.replace(load("fwalk"), initial_state=state), 1.0)


def test_start_on_a_slope_is_as_high_above_it_as_the_motion_was():
    scene = load("fwalk")
    scene.ground.normal = (0.0, 1.0, -0.02)
    start = steady_state(scene, 1.5).initial_state
    numeric = steady_state(msgspec.structs.replace(scene, initial_state=start), 0.0)
    assert start.root_position[0] == start.root_position[2] == 0.0
    assert start.root_position[1] == pytest.approx(scene.initial_state.root_position[1], abs=0.05)
    assert numeric.initial_state.root_position[1] == pytest.approx(start.root_position[1], abs=0.03)


def test_a_start_that_follows_commands_goes_on_following_them():
    scene = load("fwalk")
    scene.commands = {"speed": Command(1.0, 0.5, 1.5, value=1.1)}
    x, y, z = scene.initial_state.root_velocity
    scene.initial_state.root_velocity = (x, y, Free(z, per={"speed": Free(0.8, 0.0, 1.0)}))
    start = steady_state(scene, 1.0).initial_state
    plain = load("fwalk")
    plain.initial_state.root_velocity = (x, y, z + 0.08)
    there = steady_state(plain, 1.0).initial_state
    assert start.root_velocity[2].per == {"speed": 0.8}
    assert start.root_velocity[2].value + 0.08 == pytest.approx(there.root_velocity[2], abs=2e-6)
    assert start.root_position == there.root_position
