"""Rewards: the scene's own objective adds up to its cost, and the task's terms are what their formulas say."""

import msgspec
import numpy as np
import pytest

from muscle_arm import arm
from warpmuscle import Rollout
from warpmuscle.core.errors import RolloutError, SceneError
from warpmuscle.kernels.learning.rewards import COUNT, TERMS
from warpmuscle.learning import EpisodeBatch, Rewards, Sense, Task, Variation

NOTHING = dict.fromkeys(TERMS, 0.0)
STILL = Variation(velocity_noise=0.0)
DECISIONS = 20


def batch_of(rewards: dict[str, float], **settings: object) -> EpisodeBatch:
    task = Task(rewards=Rewards(**(NOTHING | rewards)), variation=STILL, **settings)
    return EpisodeBatch("reflex_planar", 2, "cpu", task, threads=1)


def actions(decisions: int, count: int) -> np.ndarray:
    return np.random.default_rng(1).normal(0.0, 0.5, (decisions, 1, count)).astype(np.float32).repeat(2, axis=1)


def test_what_decisions_add_to_the_objective_is_the_cost_of_the_scene():
    batch = batch_of({"objective": 1.0})
    rollout = Rollout("reflex_planar", 2, "cpu", threads=1)
    earned = np.zeros(2)
    for action in actions(DECISIONS, 14):
        batch.actions.requested.assign(action)
        batch.step()
        earned += batch.judge.gains.reward.numpy()
        rollout.step(batch.decision_steps, excitations=np.clip(0.1 + 0.4 * action, 0.0, 1.0))
    np.testing.assert_allclose(earned, -rollout.cost(), rtol=1e-4)
    assert rollout.cost().min() > 0.1


@pytest.mark.parametrize(("wanted", "share"), [(0.0, 1.0), (-0.9, 0.0), (0.1, 1.0)])
def test_progress_is_whole_where_none_is_wanted_and_nothing_the_wrong_way(wanted: float, share: float):
    batch = batch_of({"progress": 1.0}, speed=(wanted, wanted))
    batch.step()
    assert batch.rollout.state.coordinates.numpy()[0, 1] > 0.002  # it walks forwards
    np.testing.assert_allclose(batch.judge.gains.reward.numpy(), share * batch.dt, rtol=1e-5)


def test_terms_of_the_task_are_what_their_formulas_say():
    batch = batch_of(dict.fromkeys(TERMS, 1.0) | {"objective": 0.0, "force_limit": 0.3}, speed=(0.9, 0.9))
    numeric = batch.rollout.numeric
    weight = numeric.gravity * sum(body.mass for body in numeric.character.bodies.values())
    h, place, before = batch.dt, 1, np.zeros((2, 14))
    for action in actions(5, 14):
        start = batch.rollout.state.coordinates.numpy().astype(float)
        sums = batch.judge.gains.sums.numpy().copy()
        batch.actions.requested.assign(action)
        batch.step()
        values = (batch.judge.gains.sums.numpy() - sums)[:, :COUNT] / h
        q = batch.rollout.state.coordinates.numpy().astype(float)
        speed = (q[:, place] - start[:, place]) / h
        load = batch.rollout.state.foot_force.numpy()[:, :, 1] / weight
        expected = {
            "speed": np.exp(-(((speed - 0.9) / 0.5) ** 2)),
            "progress": np.clip(speed / 0.9, 0.0, 1.0),
            "alive": np.ones(2),
            "upright": np.cos(q[:, 2]),
            "pose": np.zeros(2),
            "imitation": np.zeros(2),
            "force": np.zeros(2),
            "contact": np.zeros(2),
            "effort": -np.square(np.clip(0.1 + 0.4 * action, 0.0, 1.0)).mean(axis=1),
            "action": -np.square(action).mean(axis=1),
            "action_rate": -np.square(action - before).mean(axis=1),
            "overload": -np.maximum(load - 0.3, 0.0).sum(axis=1),
            "heading": np.zeros(2),
            "side": np.zeros(2),
            "objective": np.zeros(2),
            "failure": np.zeros(2),
        }
        before = action
        for k, name in enumerate(TERMS):
            np.testing.assert_allclose(values[:, k], expected[name], atol=2e-3, err_msg=name)
        total = sum(expected.values()) * h
        np.testing.assert_allclose(batch.judge.gains.reward.numpy(), total, atol=1e-5)


def test_a_failure_costs_once_and_ends_the_episode():
    batch = batch_of({"failure": 2.0, "alive": 1.0}, episode_time=5.0)
    ends = 0
    for _ in range(150):
        batch.actions.requested.fill_(-1.0)  # limp
        batch.step()
        failed = batch.judge.gains.terminated.numpy()
        reward = batch.judge.gains.reward.numpy()
        np.testing.assert_allclose(reward, np.where(failed, -2.0, batch.dt), rtol=1e-6)
        assert (batch.episodes.length.numpy()[failed] == 0).all()
        ends += int(failed.sum())
    assert ends >= 2
    assert not batch.judge.gains.truncated.numpy().any()


@pytest.mark.usefixtures("unoptimized_test")
def test_a_wanted_pose_of_an_arm_is_rewarded_by_how_near_it_is():
    task = Task(
        actions="joint_targets", pose={"elbow": (0.3, 1.2)}, episode_time=0.5,
        rewards=Rewards(**(NOTHING | {"pose": 1.0, "pose_width": 0.4})),
    )  # fmt: skip
    batch = EpisodeBatch(arm(), 8, "cpu", task, threads=1)
    assert batch.senses.names[-1] == "command.elbow"
    wanted = batch.episodes.command.numpy()[:, 2]
    assert ((wanted >= 0.3) & (wanted <= 1.2)).all()
    assert np.ptp(wanted) > 0.2
    batch.step()
    column = batch.rollout.coordinate_names.index("elbow")
    error = batch.rollout.state.coordinates.numpy()[:, column] - wanted
    np.testing.assert_allclose(batch.judge.gains.reward.numpy() / batch.dt, np.exp(-((error / 0.4) ** 2)), rtol=1e-4)


@pytest.mark.usefixtures("unoptimized_test")
def test_a_wanted_coordinate_that_is_not_there_is_named():
    with pytest.raises(SceneError, match=r"learning\.pose\.elbo: there is no coordinate 'elbo'; did you mean 'elbow'"):
        EpisodeBatch(arm(), 1, "cpu", Task(actions="joint_targets", pose={"elbo": (0.0, 1.0)}), threads=1)


def test_tasks_are_checked_with_their_scene():
    with pytest.raises(SceneError, match=r"learning\.speed: 2 is greater than 1"):
        EpisodeBatch("reflex_planar", 1, "cpu", Task(speed=(2.0, 1.0)))
    with pytest.raises(SceneError, match=r"learning\.turning_rate"):
        EpisodeBatch("reflex_planar", 1, "cpu", Task(turning_rate=3.0))
    with pytest.raises(SceneError, match=r"learning\.speed"):
        EpisodeBatch("reflex_planar", 1, "cpu", Task(speed=object()))
    with pytest.raises(RolloutError, match="task must be a Task, not"):
        EpisodeBatch("reflex_planar", 1, "cpu", {"speed": (1.0, 1.2)})
    with pytest.raises(SceneError, match=r"learning\.observations\.trunk\.delay: must be 1 s at most, is 3"):
        EpisodeBatch("reflex_planar", 1, "cpu", Task(observations={"trunk": Sense(delay=3.0)}))
    with pytest.raises(SceneError, match="muscles drive no joint"):
        EpisodeBatch("fwalk", 1, "cpu", Task())
    assert msgspec.json.decode(msgspec.json.encode(Task()), type=Task) == Task()
