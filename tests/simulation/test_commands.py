"""Commands of a batch: bits of one's own, the ground below, masses, what is refused."""

import copy

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import RolloutError
from warpmuscle.formats import load
from warpmuscle.scene import Command, Robustness, Scene
from warpmuscle.scene.number import Free
from warpmuscle.simulation.candidates import CandidateBatch
from warpmuscle.simulation.multi_device import MultiDeviceRollout
from warpmuscle.simulation.perturbations import drawn, none
from warpmuscle.simulation.rollout import Rollout


@pytest.fixture
def scene() -> Scene:
    """fwalk, whose step time follows a speed and whose ground follows a slope."""
    scene = load("fwalk")
    scene.duration, scene.robustness = 0.5, Robustness()
    scene.commands = {"speed": Command(1.0, 0.5, 1.5, unit="m/s"), "slope": Command(0.0, -5.0, 5.0, unit="deg")}
    scene.controller.states[0].time = Free(0.6, per={"speed": -0.2})
    scene.ground.normal = (0.0, 1.0, Free(0.0, per={"slope": -0.0175}))
    return scene


def end_of(batch) -> np.ndarray:
    batch.run()
    return np.concatenate([rollout.state.coordinates.numpy() for rollout in getattr(batch, "rollouts", [batch])])


def test_an_instance_moves_as_a_scene_of_its_commands_alone(scene):
    batch = Rollout(scene, 3, "cpu")
    batch.set_commands({"speed": [0.6, 1.0, 1.4], "slope": [1.0, 0.0, -1.0]})
    alone = msgspec.structs.replace(scene, commands={
        "speed": Command(1.0, 0.5, 1.5, value=1.4), "slope": Command(0.0, -5.0, 5.0, value=-1.0)
    })  # fmt: skip
    ends = end_of(batch)
    np.testing.assert_array_equal(ends[2], end_of(Rollout(alone, 1, "cpu"))[0])
    assert not np.array_equal(ends[0], ends[1])
    shared = MultiDeviceRollout(scene, 3, ["cpu", "cpu"])
    shared.set_commands({"speed": [0.6, 1.0, 1.4], "slope": [1.0, 0.0, -1.0]})
    np.testing.assert_array_equal(end_of(shared), ends)


def test_commands_stay_with_other_parameters_and_what_is_not_named(scene):
    batch = Rollout(scene, 1, "cpu")
    batch.set_commands({"speed": 1.5})
    batch.set_commands({"slope": 1.0})
    batch.set_parameters([parameter.value for parameter in batch.parameters])
    assert batch.numeric.controller.states[0].time == pytest.approx(0.5)
    assert batch.numeric.ground.normal[2] == pytest.approx(-0.0175)


def test_ground_that_is_inclined_under_way_turns_about_the_ground_below_and_is_back_at_the_start(scene):
    batch = Rollout(scene, 2, "cpu")
    batch.run(0.4)
    batch.set_commands({"slope": [5.0, 0.0]}, restart=False)
    place = batch.state.coordinates.numpy()[:, :3].astype(float)
    assert place[0, 2] > 0.1
    ground = batch.numeric.ground
    rise = np.asarray(ground.normal[2])[0]
    length = np.hypot(1.0, rise)
    assert np.asarray(ground.height)[0] == pytest.approx(rise * place[0, 2] / length, abs=1e-6)
    assert np.asarray(ground.height)[1] == pytest.approx(0.0, abs=1e-9)
    batch.run()
    assert (batch.end_time() > 0.45).all()
    batch.reset()
    assert not np.any(batch.numeric.ground.height)


def test_heavier_bodies_are_those_of_a_heavier_character(scene):
    factors = drawn(Robustness(runs=3, mass=0.2, seed=5), 0.5, len(scene.character.bodies)).mass
    assert np.all(factors[0] == 1.0)
    assert 0.8 <= factors.min() < 0.9
    batch, runs = Rollout(scene, 3, "cpu"), none(3)
    batch.disturb(msgspec_replace(runs, mass=factors))
    heavier = copy.deepcopy(batch.scene)
    for body, factor in zip(heavier.character.bodies.values(), factors[1].tolist(), strict=True):
        body.mass, body.inertia = body.mass * factor, tuple(moment * factor for moment in body.inertia)
    np.testing.assert_array_equal(end_of(batch)[1], end_of(Rollout(heavier, 1, "cpu"))[0])


def msgspec_replace(runs, **changes):
    return type(runs)(**(vars(runs) | changes))


def test_every_candidate_walks_at_all_commands_of_its_runs(scene):
    scene.robustness = Robustness(runs=3, commands={"speed": [0.6, 1.4]})
    trials = CandidateBatch(scene, 2, "cpu")
    assert not trials.undisturbed
    np.testing.assert_allclose(trials.batch.numeric.controller.states[0].time, [0.68, 0.52, 0.68] * 2)


@pytest.mark.parametrize(
    ("commands", "words"),
    [
        ({"sped": 1.0}, "takes no command 'sped'; did you mean 'speed'"),
        ({"speed": 2.0}, "command speed: 2 is outside 0.5 to 1.5 m/s"),
        ({"speed": [1.0, np.nan]}, "nan is outside"),
        ({"speed": [1.0] * 3}, "has shape"),
        ("speed", "commands"),
    ],
)
def test_impossible_commands_are_errors(scene, commands, words):
    with pytest.raises(RolloutError, match=words):
        Rollout(scene, 2, "cpu").set_commands(commands)
