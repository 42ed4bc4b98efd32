"""Walks of scenes and of policies under the same conditions: each instance as if alone, and as a rollout has it."""

from dataclasses import replace
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from small_policy import learning_curve, random_policy, small_policy
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.learning.episodes import EpisodeBatch
from warpmuscle.learning.player import Player, text_of, undisturbed
from warpmuscle.results.learned import Layer, Learned
from warpmuscle.scene.controller import Command
from warpmuscle.scene.learning import Task, Variation
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.number import Free
from warpmuscle.simulation.perturbations import none
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.walkers import Nerves, PolicyWalker, SceneWalker, loaded, under

TASK = Task(speed=(0.8, 1.6))
pytestmark = pytest.mark.usefixtures("unoptimized_kernels")
SHORT = 0.3  # s


def test_the_gait_that_a_policy_imitates_is_made_once(monkeypatch):
    """Making it takes seconds: later walks are given that of the first."""
    given, made = [], object()

    class FakePlayer:
        def __init__(self, policy, scene, instances, device, task, *, gait=None, **more):
            given.append(gait)
            self.batch = SimpleNamespace(gait=made if gait is None else gait)

        def walk(self, disturbances, told):
            return np.zeros(len(disturbances), int), np.zeros(len(disturbances))

    monkeypatch.setattr("warpmuscle.learning.player.Player", FakePlayer)
    walker = PolicyWalker(Learned(small_policy(), text_of(TASK), learning_curve(1), {}), load("reflex_planar"), "cpu")
    for _ in range(3):
        walker.walk(SHORT, none(2))
    assert given == [None, made, made]


@pytest.fixture(scope="module")
def scene():
    """A planar walker that falls after some tenths of a second without its reflexes."""
    return load("reflex_planar")


@pytest.fixture(scope="module")
def learned(scene):
    """A policy of random weights."""
    return random_policy(scene, TASK)


@pytest.fixture(scope="module")
def conditions(scene):
    """An undisturbed instance, and others that are disturbed in one way each."""
    push = np.zeros((5, 3))
    push[1, 2] = 20.0
    velocity = np.zeros((5, 3))
    velocity[2, 2] = 0.2
    mass = np.ones((5, len(scene.character.bodies)))
    mass[4] = 1.1
    return replace(
        none(5), push=push, push_start=np.full(5, 0.1), velocity=velocity, slope=np.array([0, 0, 0, 0.05, 0]), mass=mass
    )


def test_an_undisturbed_policy_moves_as_in_any_episode(scene, learned):
    walks = PolicyWalker(learned, scene, "cpu", 1, {"speed": 1.1}).walk(SHORT, none(1), record=True)
    task = msgspec.structs.replace(undisturbed(TASK), speed=(1.1, 1.1))
    player = Player(
        learned.policy, msgspec.structs.replace(scene, duration=SHORT), 1, "cpu", task, record=[0], record_rate=200
    )
    while (
        player.batch.rollout.state.status.numpy()[0] == Status.RUNNING and player.batch.episodes.length.numpy()[0] < 30
    ):
        player.decide(restart=False)
    np.testing.assert_array_equal(walks.recordings[0].com, player.batch.rollout.recording().com)


def test_a_policy_meets_every_condition_as_if_it_were_alone(scene, learned, conditions):
    walker = PolicyWalker(learned, scene, "cpu", 1)
    speeds = np.array([1.0, 1.0, 1.0, 1.0, 1.0])
    together = walker.walk(SHORT, conditions, {"speed": speeds}, record=True)
    for one in range(1, 5):
        alone = walker.walk(SHORT, conditions.part(slice(one, one + 1)), {"speed": speeds[:1]}, record=True)
        np.testing.assert_array_equal(alone.recordings[0].com, together.recordings[one].com)
        assert not np.array_equal(together.recordings[0].com[-1], together.recordings[one].com[-1])
    first, pushed = together.recordings[:2]
    before = first.time <= 0.1
    np.testing.assert_array_equal(first.com[before], pushed.com[before])
    faster = together.recordings[2].com_velocity[0] - first.com_velocity[0]
    np.testing.assert_allclose(faster, [0.0, 0.0, 0.2], atol=1e-5)


def test_a_policy_that_always_says_the_same_moves_as_a_rollout_with_these_excitations(scene, learned, conditions):
    layers = tuple(Layer(0.0 * layer.weight, 0.0 * layer.bias) for layer in learned.policy.layers)
    still = replace(learned, policy=replace(learned.policy, layers=layers))
    found = PolicyWalker(still, scene, "cpu", 1).walk(SHORT, conditions, record=True)
    rollout = Rollout(
        msgspec.structs.replace(scene, duration=SHORT), 5, "cpu", record=range(5), record_rate=200, threads=1
    )
    rollout.disturb(conditions)
    rollout.set_excitations([0.0], np.full((1, len(rollout.muscle_names), 1), 0.1))
    rollout.run()
    for one in range(5):
        mine, theirs = found.recordings[one], rollout.recording(one)
        frames = min(mine.frames, theirs.frames)
        assert frames > 30
        np.testing.assert_allclose(mine.com[:frames], theirs.com[:frames], atol=2e-4)
    np.testing.assert_array_equal(found.status, rollout.status())


def test_what_is_not_asked_for_is_the_walking_speed_where_that_was_learnt(scene, learned):
    assert PolicyWalker(learned, scene, "cpu").commands["speed"].asked == 1.25
    assert list(PolicyWalker(learned, scene, "cpu").commands) == ["speed"]
    assert PolicyWalker(learned, scene, "cpu", defaults={"speed": 0.9}).commands["speed"].asked == 0.9
    slow = replace(learned, task=text_of(Task(speed=(0.5, 0.9))))
    assert PolicyWalker(slow, scene, "cpu").commands["speed"].asked == pytest.approx(0.7)
    assert not PolicyWalker(replace(learned, task=text_of(Task())), scene, "cpu").commands


def test_commands_of_the_scene_act_on_a_policy_that_is_not_told_of_them(scene, learned):
    sloping = msgspec.structs.replace(
        scene, commands={"slope": Command(0.0, -5.0, 5.0), "speed": Command(1.0, 0.5, 2.0)},
        ground=msgspec.structs.replace(scene.ground, normal=(0.0, 1.0, Free(0.0, per={"slope": -0.0175}))),
    )  # fmt: skip
    walker, plain = PolicyWalker(learned, sloping, "cpu", 1), PolicyWalker(learned, scene, "cpu", 1)
    assert list(walker.commands) == ["speed", "slope"]
    assert walker.commands["speed"].max == 1.6
    assert walker.scene({"slope": 2.0, "speed": 1.1}).ground.normal[2] == pytest.approx(-0.035)
    found = walker.walk(SHORT, none(2), {"slope": np.array([0.0, 4.0])}, record=True)
    steep = replace(none(2), slope=np.array([0.0, np.arctan(0.07)]))
    expected = plain.walk(SHORT, steep, record=True)
    np.testing.assert_array_equal(found.recordings[0].com, expected.recordings[0].com)
    np.testing.assert_allclose(found.recordings[1].com, expected.recordings[1].com, atol=1e-4)
    assert not np.allclose(found.recordings[1].com[-1], found.recordings[0].com[-1], atol=1e-3)


def test_variants_of_a_body_are_not_disturbed_besides(scene):
    batch = EpisodeBatch(scene, 2, "cpu", Task(variation=Variation(mass=0.1)))
    with pytest.raises(RolloutError, match="variants"):
        batch.begin_under(none(2), {})


def test_a_scene_walks_as_its_rollout(scene):
    walks = SceneWalker(scene, "cpu", 1).walk(SHORT, none(2))
    assert walks.recordings == []
    assert walks.upright.tolist() == [True, True]
    assert walks.end_time == pytest.approx(SHORT)


def test_a_load_is_carried_by_the_heaviest_body_and_a_slope_is_the_ground(scene):
    plain = SceneWalker(scene, "cpu").scene()
    carrying = loaded(plain, none(2), np.array([0.0, 10.0]))
    assert body_mass(under(plain, carrying, 0).character) == pytest.approx(body_mass(plain.character))
    heavy = under(plain, carrying, 1).character.bodies
    assert body_mass(under(plain, carrying, 1).character) == pytest.approx(body_mass(plain.character) + 10.0)
    assert sum(heavy[name].mass != body.mass for name, body in plain.character.bodies.items()) == 1
    steep = under(plain, replace(none(1), slope=np.array([0.1])), 0).ground.normal
    np.testing.assert_allclose(steep, [0.0, np.cos(0.1), -np.sin(0.1)], atol=1e-7)


def test_nerves_that_do_not_hinder_change_nothing_and_others_do(scene, learned):
    walker = PolicyWalker(learned, scene, "cpu", 1, {"speed": 1.1})
    every = [walker, *(walker.with_nerves(Nerves(**how)) for how in ({}, {"delay": 0.02}, {"noise": 0.02}))]
    plain, same, late, noisy = (one.walk(SHORT, none(2), record=True).recordings for one in every)
    np.testing.assert_array_equal(plain[0].com, same[0].com)
    assert not np.array_equal(plain[0].com, late[0].com)
    np.testing.assert_array_equal(late[0].com, late[1].com)
    assert not np.array_equal(noisy[0].com, noisy[1].com)


def test_what_a_policy_knows_by_no_nerve_is_neither_late_nor_noisy(scene, learned):
    hindered = PolicyWalker(learned, scene, "cpu").with_nerves(Nerves(0.02, 0.03))
    senses = hindered._task.observations
    assert set(senses) == {name.partition(".")[0] for name in learned.policy.observation}
    assert (senses["command"].delay, senses["command"].noise) == (0.0, 0.0)
    assert (senses["coordinates"].delay, senses["coordinates"].noise) == (0.02, 0.03)
    again = hindered.with_nerves(Nerves(0.01, 0.04))._task.observations["coordinates"]
    assert (again.delay, again.noise) == pytest.approx((0.03, 0.05))


def test_muscles_hear_of_a_controller_of_the_scene_so_much_later(scene):
    walker = SceneWalker(scene, "cpu", 1)
    late = walker.with_nerves(Nerves(delay=0.02))
    before, after = (one.scene().character.muscles for one in (walker, late))
    assert all(after[name].delay == pytest.approx(muscle.delay + 0.02) for name, muscle in before.items())
    paths = [one.walk(SHORT, none(1), record=True).recordings[0].com for one in (walker, late)]
    assert not np.array_equal(*paths)
    assert (walker.senses, PolicyWalker.senses) == (False, True)


def test_ground_of_less_friction_is_that_of_the_scene(scene):
    walker = SceneWalker(scene, "cpu")
    assert walker.on_ground(0.4).scene().ground.friction == 0.4
    assert walker.scene().ground.friction != 0.4


def test_a_scene_as_a_weaker_instance_meets_it_has_its_strengths(scene):
    plain = SceneWalker(scene, "cpu").scene()
    factors = np.ones((2, len(plain.character.muscles)))
    factors[1, 0] = 0.8
    weaker = under(plain, replace(none(2), strength=factors), 1).character.muscles
    first = next(iter(plain.character.muscles))
    assert np.asarray(weaker[first].f_max).item() == pytest.approx(0.8 * plain.character.muscles[first].f_max)
