"""A live run that a policy moves: what the policy says, pushed, told, and begun again."""

import msgspec
import numpy as np
import pytest

from small_policy import random_policy
from warpmuscle.formats import load
from warpmuscle.learning.player import Player, commands_of, undisturbed
from warpmuscle.scene import Command
from warpmuscle.scene.learning import Task
from warpmuscle.scene.number import Free
from warpmuscle.view.live_run import STEERING_INTERVAL
from warpmuscle.view.policy_run import PolicyRun

TASK = Task(speed=(0.8, 1.6))


@pytest.fixture(scope="module")
def learned():
    """A policy of random weights for a planar walker."""
    return random_policy(load("reflex_planar"), TASK)


@pytest.fixture
def run(learned):
    return PolicyRun(load("reflex_planar"), learned)


def state(run):
    return run.rollout.state.coordinates.numpy().copy()


def test_it_moves_as_the_policy_says(run, learned):
    run.asked["speed"] = 1.1
    run.restart()
    for _ in range(5):
        run.advance(0.02)
    task = msgspec.structs.replace(undisturbed(TASK), speed=(1.1, 1.1), episode_time=300.0)
    player = Player(learned.policy, load("reflex_planar"), 1, "cpu", task)
    for _ in range(round(run.time / 0.01)):
        player.decide(restart=False)
    np.testing.assert_array_equal(state(run), player.batch.rollout.state.coordinates.numpy())
    assert run.window(1.0).frames > 1


def test_it_begins_again_where_it_began(run):
    first = state(run)
    run.advance(0.05)
    assert not np.array_equal(state(run), first)
    run.restart()
    np.testing.assert_array_equal(state(run), first)


def test_a_push_moves_it_to_the_side_that_is_asked_for(run):
    run.advance(0.01)
    impulse = run.push(20.0, 0.0)
    np.testing.assert_allclose(np.linalg.norm(impulse), 20.0, rtol=1e-6)
    before = state(run)
    run.advance(0.03)
    pushed = state(run)
    run.restart()
    run.advance(0.01)
    np.testing.assert_array_equal(state(run), before)
    run.advance(0.03)
    assert not np.array_equal(state(run), pushed)


def test_what_it_can_be_told_is_what_it_has_learnt(run):
    commands = commands_of(TASK)
    assert (commands["speed"].min, commands["speed"].max, commands["speed"].unit) == (0.8, 1.6, "m/s")
    assert list(run.scene.commands) == list(commands)
    run.asked["speed"] = 99.0
    run.advance(0.02)
    assert run.player.batch.episodes.command.numpy()[0, 0] == pytest.approx(1.6)


def test_the_ground_inclines_below_the_body_as_the_scene_is_commanded(learned):
    ground = load("reflex_planar").ground
    inclined = (0.0, 1.0, Free(0.0, per={"slope": -0.0175}))
    scene = msgspec.structs.replace(
        load("reflex_planar"), ground=msgspec.structs.replace(ground, normal=inclined),
        commands={"slope": Command(0.0, -5.0, 5.0, unit="deg"), "speed": Command(1.0, 0.0, 2.0)},
    )  # fmt: skip
    run = PolicyRun(scene, learned)
    level = PolicyRun(load("reflex_planar"), learned)
    assert list(run.asked) == ["speed", "turning_rate", "slope"]
    np.testing.assert_array_equal(state(run), state(level))
    run.asked["slope"] = 4.0
    for one in (run, level):
        for _ in range(10):
            one.advance(0.02)
    normal = run.rollout.model.contacts.normal.numpy().reshape(3)
    steps = int((run.time - run.player.batch.dt) / STEERING_INTERVAL + 1e-6)
    degrees = 1.0 * steps * STEERING_INTERVAL  # a tenth of 10 degrees a second
    assert steps >= 1
    assert -normal[2] / normal[1] == pytest.approx(0.0175 * degrees, rel=1e-3)
    assert not np.array_equal(state(run), state(level))
    run.asked["slope"] = 0.0
    run.restart()
    level.restart()
    np.testing.assert_array_equal(state(run), state(level))
