"""The walking controller gets up stairs of 17 cm that it sees, and stops and goes on where it is told to."""

import msgspec
import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.scene import Scene, Terrain
from warpmuscle.scene.terrain.tiles import Stairs
from warpmuscle.simulation.rollout import Rollout


@pytest.fixture(scope="module")
def walks() -> Rollout:
    """Four walks up two stairs of 17 cm, at 0.6 m/s, with noise."""
    scene = msgspec.convert(msgspec.to_builtins(load("course")), Scene)
    scene.ground.terrain = Terrain([Stairs(0.17, 0.35, 2, start=1.0, returns=False)])
    scene.commands["speed"].over, scene.commands["heading"].over = [], []
    scene.duration = 6.0
    rollout = Rollout(scene, 4, "cpu", record=range(4), record_rate=50.0)
    rollout.set_commands({"speed": 0.6})
    rollout.reset(velocity_noise=0.05, seed=1)
    rollout.run()
    return rollout


def test_it_gets_up_stairs_of_17_cm(walks: Rollout):
    rises = [walks.recording(row).com[-1, 1] - walks.recording(row).com[0, 1] for row in range(4)]
    up = np.array(rises) > 0.25
    assert up.sum() >= 3, rises  # with noise, one may fall


def test_a_foot_that_has_come_down_is_on_one_stair(walks: Rollout):
    for row in range(4):
        walk = walks.recording(row)
        for side, force in (("lFoot", walk.foot_force_left), ("rFoot", walk.foot_force_right)):
            foot = walk.body_position[:, list(walk.body_names).index(side)]
            bears = force[:, 1] > 400.0
            stair = np.searchsorted([1.0, 1.35], foot[bears, 2]) * 0.17
            if walk.time[-1] > 5.9:
                assert np.mean(np.abs(foot[bears, 1] - 0.033 - stair) < 0.03) > 0.9


def test_it_stops_and_goes_on_as_it_is_told():
    scene = msgspec.convert(msgspec.to_builtins(load("steer")), Scene)
    scene.commands["speed"].over = [(0.0, 0.7), (3.0, 0.7), (3.5, 0.0), (7.0, 0.0), (7.5, 0.6)]
    scene.duration = 9.5
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=50.0)
    rollout.run()
    walk = rollout.recording(0)
    assert walk.time[-1] > 9.4
    stance = walk.controller_value[:, 1]
    stands = (walk.time > 6.0) & (walk.time < 7.0)
    assert np.all(stance[stands] == 2.0)
    assert np.abs(walk.com_velocity[stands, 2]).max() < 0.1
    assert walk.com_velocity[walk.time > 9.0, 2].mean() > 0.3
