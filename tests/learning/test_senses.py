"""Observations: numbers of the state, as late and as noisy as they are asked to be."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from muscle_arm import arm
from warpmuscle import Rollout
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import SceneLike
from warpmuscle.learning import EpisodeBatch, Sense, Task, Variation
from warpmuscle.learning.variants import drawn
from warpmuscle.scene import JointState
from warpmuscle.simulation.stepper import Stepper

STILL = Variation(velocity_noise=0.0)
FELT = ("fibre_length", "fibre_velocity", "tendon_force")
QUANTITIES = ("muscle_fibre_length", "muscle_fibre_velocity", "muscle_force")
MUSCLES = 14


def batch_of(
    observations: dict[str, Sense],
    count: int = 1,
    scene: SceneLike = "reflex_planar",
    variation: Variation = STILL,
    **more: object,
):
    return EpisodeBatch(scene, count, "cpu", Task(observations=observations, variation=variation, **more), threads=1)


def histories(batch: EpisodeBatch, decisions: int, each: int, seed: int = 0) -> np.ndarray:
    """What is observed, (decisions + 1, instances, numbers), with actions that change after so many decisions."""
    told = np.random.default_rng(2).normal(0.0, 0.5, (decisions // each + 1, 1, MUSCLES)).astype(np.float32)
    batch.reset(seed)
    rows = [batch.senses.observation.numpy().copy()]
    for k in range(decisions):
        batch.actions.requested.assign(told[k // each].repeat(len(batch.actions.requested), axis=0))
        batch.step()
        rows.append(batch.senses.observation.numpy().copy())
    return np.stack(rows)


def history(batch: EpisodeBatch, decisions: int, each: int) -> np.ndarray:
    """What the first instance observes, (decisions + 1, numbers)."""
    return histories(batch, decisions, each)[:, 0]


def test_nerves_tell_what_was_before_the_delay_also_where_that_lies_within_a_decision():
    groups = {"fibre_length": Sense(delay=0.01), "tendon_force": Sense(delay=0.017), "speeds": Sense(delay=0.005)}
    late = batch_of(groups)
    fine = batch_of({name: Sense() for name in groups}, decision_time=0.001)
    seen = history(late, 6, 1)
    truth = history(fine, 60, 10)
    ends = np.cumsum([0, MUSCLES, MUSCLES, seen.shape[1] - 2 * MUSCLES])
    for group, delay in enumerate((10, 17, 5)):
        columns = slice(ends[group], ends[group + 1])
        for decision in range(7):
            expected = truth[max(10 * decision - delay, 0), columns]
            assert np.array_equal(seen[decision, columns], expected), (group, decision)


def test_nerves_of_an_episode_may_be_later_still_but_wanted_speeds_are_known_at_once():
    groups, decisions = {"fibre_length": Sense(delay=0.017), "command": Sense()}, 8
    varied = Variation(velocity_noise=0.0, delay=0.03)
    late = batch_of(groups, 40, variation=varied, speed=(0.5, 2.0), command_time=0.02)
    truth = history(batch_of({"fibre_length": Sense()}, decision_time=0.001), 10 * decisions, 10)
    expected = np.stack([[truth[max(10 * (d - k) - 17, 0)] for d in range(decisions + 1)] for k in range(4)])
    found = []
    for seed in range(2):
        seen = histories(late, decisions, 1, seed)
        fits = (seen[:, :, :MUSCLES] == expected[:, :, None]).all(axis=(1, 3))  # (delays, instances)
        assert (fits.sum(axis=0) == 1).all()
        found.append(fits.argmax(axis=0))
        known = late.senses.critic.numpy()[:, late.senses.critic_names.index("disturbance.delay")]
        np.testing.assert_allclose(3.0 * known, found[-1], atol=1e-6)  # of a critic, over the longest
        told = late.senses.names.index("command.speed")
        np.testing.assert_array_equal(seen[-1, :, told], late.episodes.command.numpy()[:, 0])
        assert (seen[-1, :, told] != seen[0, :, told]).all()
    assert set(found[0]) == set(found[1]) == {0, 1, 2, 3}
    assert (found[0] != found[1]).any()


@pytest.mark.usefixtures("unoptimized_test")
def test_muscles_tell_what_a_recording_says_of_them():
    batch = batch_of({name: Sense() for name in FELT})
    rollout = Rollout(
        "reflex_planar", 1, "cpu", record=[0], record_rate=1000.0,
        quantities=QUANTITIES, threads=1,
    )  # fmt: skip
    for _ in range(5):
        batch.step()
        rollout.step(batch.decision_steps, excitations=np.full((1, MUSCLES), 0.1))
    last = 5 * batch.decision_steps - 1
    muscles = rollout.numeric.character.muscles.values()
    f_max, l_opt = np.array([m.f_max for m in muscles]), np.array([m.l_opt for m in muscles])
    length, speed, force = (rollout.recorded(name)[0] for name in QUANTITIES)
    expected = np.concatenate(
        [length[last] / l_opt - 1.0, 0.1 * speed[last] / l_opt, force[last] / f_max],
    )  # fmt: skip
    np.testing.assert_allclose(batch.senses.observation.numpy()[0], expected, rtol=1e-4, atol=1e-5)


@pytest.mark.usefixtures("unoptimized_test")
def test_the_trunk_is_seen_as_it_faces():
    groups = ("trunk", "trunk_speed", "command", "head")
    batch = batch_of({name: Sense() for name in groups}, scene="walk56")
    q = batch.rollout.state.coordinates.numpy()
    turn = Rotation.from_euler("YX", [0.8, 0.2])
    q[0, 3:7] = turn.as_quat()
    batch.rollout.state.coordinates.assign(q)
    v = batch.rollout.state.speeds.numpy()
    v[0, :6] = [0.3, -0.1, 1.1, 0.5, 0.4, -0.2]
    batch.rollout.state.speeds.assign(v)
    batch.senses.sample_first(batch.rollout.state, batch.episodes)  # all are masked as beginning
    batch.observe_again()
    seen = dict(zip(batch.senses.names, batch.senses.observation.numpy()[0], strict=True))
    up = turn.inv().apply([0.0, 1.0, 0.0])
    facing = Rotation.from_euler("Y", 0.8).inv().apply(v[0, :3])
    turning = 0.2 * turn.inv().apply(v[0, 3:6])
    for k, axis in enumerate("xyz"):
        assert seen[f"trunk.up.{axis}"] == pytest.approx(up[k], abs=1e-6)
        assert seen[f"trunk_speed.velocity.{axis}"] == pytest.approx(facing[k], abs=1e-6)
        assert seen[f"trunk_speed.angular_velocity.{axis}"] == pytest.approx(turning[k], abs=1e-6)
    spin = v[0, 3:6].astype(float)  # of the head, summed up from the root
    for joint in ("pelvis_torso", "torso_head"):
        first = batch.rollout.coordinate_names.index(f"{joint}.qx")
        turn = turn * Rotation.from_quat(q[0, first : first + 4])
        rate = batch.rollout.speed_names.index(f"{joint}.x")
        spin += turn.apply(v[0, rate : rate + 3])
    for k, axis in enumerate("xyz"):
        assert seen[f"head.up.{axis}"] == pytest.approx(turn.inv().apply([0.0, 1.0, 0.0])[k], abs=1e-5)
        assert seen[f"head.angular_velocity.{axis}"] == pytest.approx(0.2 * turn.inv().apply(spin)[k], abs=1e-5)
    wanted = batch.episodes.heading.numpy()[0]
    assert seen["command.turn.sin"] == pytest.approx(np.sin(wanted - 0.8), abs=1e-6)
    assert seen["command.turn.cos"] == pytest.approx(np.cos(wanted - 0.8), abs=1e-6)


def test_noise_is_as_great_as_asked_and_the_same_for_the_same_seed_whatever_the_batch():
    groups = {"activation": Sense(noise=0.3)}
    large, small = batch_of(groups, 400), batch_of(groups, 3)
    plain = batch_of({"activation": Sense()}, 1)
    rows = []
    for batch in (large, small, plain):
        batch.reset(7)
        batch.step()
        rows.append(batch.senses.observation.numpy().copy())
    noise = rows[0] - rows[2]
    assert abs(noise.mean()) < 0.02
    assert noise.std() == pytest.approx(0.3, rel=0.04)
    assert np.array_equal(rows[0][:3], rows[1])
    assert np.abs(np.corrcoef(noise[:, 0], noise[:, 1])[0, 1]) < 0.2
    large.step()
    assert np.abs(np.corrcoef(noise.ravel(), (large.senses.observation.numpy() - rows[2]).ravel())[0, 1]) < 0.2
    large.reset(8)
    large.step()
    assert not np.array_equal(large.senses.observation.numpy()[:3], rows[1])


def test_nerves_of_an_episode_may_be_noisier_but_wanted_speeds_are_known_as_they_are():
    groups = {"activation": Sense(noise=0.3), "command": Sense()}
    noisier = Variation(velocity_noise=0.0, noise=0.4)
    batch = batch_of(groups, 400, variation=noisier)
    rows = histories(batch, 4, 1, seed=7)
    rows -= histories(batch_of({"activation": Sense(), "command": Sense()}, 1), 4, 1)
    of_episode = rows[:, :, :MUSCLES].std(axis=(0, 2))
    assert np.quantile(of_episode, 0.02) == pytest.approx(0.3, rel=0.15)
    assert np.quantile(of_episode, 0.98) == pytest.approx(0.5, rel=0.15)  # the two are independent
    known = batch.senses.critic.numpy()[:, batch.senses.critic_names.index("disturbance.noise")]
    expected = np.hypot(0.3, 0.4 * known)  # of a critic, over the greatest
    np.testing.assert_allclose(of_episode / expected, 1.0, atol=0.4)
    assert np.corrcoef(of_episode, expected)[0, 1] > 0.7
    assert of_episode.mean() == pytest.approx(np.hypot(0.3, np.linspace(0.0, 0.4, 101)).mean(), rel=0.03)
    assert (rows[:, :, MUSCLES:] == 0.0).all()


def test_a_history_is_what_was_observed_before_as_late_as_the_rest_of_its_group():
    batch = batch_of({"fibre_length": Sense(delay=0.013, history=3), "action": Sense(history=1)})
    seen, ends = history(batch, 8, 1), [MUSCLES * k for k in range(7)]
    assert batch.senses.names[MUSCLES] == f"{batch.senses.names[0]}.1_before"
    columns = [seen[:, first : first + MUSCLES] for first in ends[:6]]
    for ago in (1, 2, 3):
        np.testing.assert_array_equal(columns[ago][ago:], columns[0][:-ago])
        np.testing.assert_array_equal(columns[ago][:ago], columns[0][:1].repeat(ago, axis=0))
    np.testing.assert_array_equal(columns[5][1:], columns[4][:-1])
    assert (columns[4][1:] != columns[4][:-1]).any(axis=1).all()


def test_actions_are_observed_as_far_as_they_count():
    """A policy that acts without noise clips what it does, so that it would see what it never saw in learning."""
    batch = batch_of({"action": Sense()})
    told = np.linspace(-3.0, 4.0, MUSCLES, dtype=np.float32)[None]
    batch.actions.requested.assign(told)
    batch.step()
    np.testing.assert_allclose(batch.senses.observation.numpy(), np.clip(told, -0.25, 2.25), rtol=1e-6)


@pytest.mark.parametrize("count", [-1, 101])
def test_a_history_has_an_end(count: int):
    with pytest.raises(SceneError, match=f"must be 0 to 100 decisions, is {count}") as caught:
        batch_of({"speeds": Sense(history=count)})
    assert caught.value.key == "learning.observations.speeds.history"


def test_groups_that_are_not_there_are_named_before_anything_is_compiled(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(Stepper, "load", lambda stepper: pytest.fail("is compiled"))
    with pytest.raises(SceneError, match="there is no group 'fibre_lengt'; did you mean 'fibre_length'"):
        batch_of({"fibre_lengt": Sense()})
    with pytest.raises(SceneError, match=r"learning\.observations\.foot_force: there is nothing of it in this scene"):
        batch_of({"foot_force": Sense()}, scene=arm())


def test_the_height_is_that_above_the_ground_on_any_slope():
    sloping = Variation(velocity_noise=0.0, slope=0.1, variants=4)
    task = Task(observations={"trunk": Sense()}, variation=sloping)
    batch = EpisodeBatch("reflex_planar", 4, "cpu", task, threads=1)
    q = batch.rollout.state.coordinates.numpy()
    q[:, 0], q[:, 1] = 0.9, 3.0  # y, z
    batch.rollout.state.coordinates.assign(q)
    batch.senses.sample_first(batch.rollout.state, batch.episodes)
    batch.observe_again()
    _, _, slopes, _ = drawn(batch.task.variation, batch.rollout, 4)
    slope = slopes[batch.episodes.variant.numpy()]
    assert np.ptp(slope) > 0.01
    height = batch.senses.observation.numpy()[:, batch.senses.names.index("trunk.height")]
    np.testing.assert_allclose(height, 0.9 * np.cos(slope) - 3.0 * np.sin(slope), atol=1e-6)


@pytest.mark.usefixtures("unoptimized_test")
def test_a_head_on_a_fixed_root_turns_as_its_joint_does():
    scene = arm()
    scene.objective.head_body = "tip"
    scene.initial_state.joints["elbow"] = JointState(angular_velocity=(1.5, 0.0, 0.0))
    batch = batch_of({"head": Sense(), "speeds": Sense()}, scene=scene)
    for _ in range(3):
        seen = batch.senses.observation.numpy()[0]
        speed = 10.0 * seen[batch.senses.names.index("speeds.elbow")]
        np.testing.assert_allclose(5.0 * seen[3:6], [speed, 0.0, 0.0], atol=1e-4)
        assert speed > 0.5
        batch.step()
