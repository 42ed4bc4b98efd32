"""Actions: what they tell muscles and joints."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from warpmuscle import Rollout
from warpmuscle.core.errors import SceneError
from warpmuscle.learning import EpisodeBatch, Task, Variation

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

STILL = Variation(velocity_noise=0.0)


def batch_of(scene: str, **settings: object) -> EpisodeBatch:
    return EpisodeBatch(scene, 2, "cpu", Task(variation=STILL, **settings), threads=1)


def test_synergies_of_one_muscle_each_are_excitations():
    plain = batch_of("reflex_planar", action_offset=0.05, action_scale=0.5)
    names = plain.actions.names
    single = batch_of(
        "reflex_planar", actions="synergies", synergies={name: {name: 1.0} for name in names}, action_offset=0.05,
        action_scale=0.5,
    )  # fmt: skip
    rows = np.random.default_rng(3).normal(0.0, 1.0, (5, 2, len(names))).astype(np.float32)
    for action in rows:
        for batch in (plain, single):
            batch.actions.requested.assign(action)
            batch.step()
        expected = np.clip(0.05 + 0.5 * action, 0.0, 1.0)
        np.testing.assert_allclose(plain.actions.excitation.numpy(), expected, atol=1e-6)
    assert np.array_equal(plain.rollout.state.coordinates.numpy(), single.rollout.state.coordinates.numpy())


def test_beyond_the_range_of_actions_muscles_are_excited_no_more_and_no_less():
    batch = batch_of("reflex_planar", action_offset=0.05, action_scale=0.5)
    assert batch.actions.range == pytest.approx((-0.1, 1.9))
    for action, excitation in ((-0.1, 0.0), (-5.0, 0.0), (1.9, 1.0), (5.0, 1.0), (0.9, 0.5)):
        batch.actions.requested.fill_(action)
        batch.step()
        np.testing.assert_allclose(batch.actions.excitation.numpy(), excitation, atol=1e-6)


def test_shares_of_muscles_are_those_of_their_volumes_where_actions_excite_them():
    batch = EpisodeBatch("reflex_planar", 1, "cpu", Task(variation=STILL), threads=1)
    muscles = batch.scene.character.muscles
    shares = batch.actions.muscle_shares
    assert shares is not None
    volume = np.array([float(muscles[name].f_max) * float(muscles[name].l_opt) for name in batch.actions.names])
    np.testing.assert_allclose(shares, volume / volume.sum(), rtol=1e-9)
    others = Task(actions="torques", variation=STILL), Task(action_scale=-0.4, variation=STILL)
    assert all(EpisodeBatch("reflex_planar", 1, "cpu", one, threads=1).actions.muscle_shares is None for one in others)


def test_weights_of_synergies_add_up():
    weights = {"push": {"lSOL": 0.5, "lGAS": 1.0}, "pull": {"lGAS": 0.2, "lTA": 2.0}}
    batch = batch_of("reflex_planar", actions="synergies", synergies=weights, action_offset=0.0, action_scale=1.0)
    batch.actions.requested.assign(np.array([[0.4, 0.3], [-1.0, 0.7]], dtype=np.float32))
    batch.step()
    muscles = batch.rollout.structure.actuation.muscles
    got = dict(zip(muscles, batch.actions.excitation.numpy().T, strict=True))
    np.testing.assert_allclose(got["lSOL"], [0.2, 0.0], atol=1e-6)
    np.testing.assert_allclose(got["lGAS"], [0.46, 0.14], atol=1e-6)
    np.testing.assert_allclose(got["lTA"], [0.6, 1.0], atol=1e-6)
    assert got["rSOL"].tolist() == [0.0, 0.0]


def test_what_is_not_a_number_counts_as_nothing():
    batch = batch_of("reflex_planar")
    batch.actions.requested.assign(np.full((2, 14), np.nan, dtype=np.float32))
    batch.step()
    assert np.allclose(batch.actions.excitation.numpy(), 0.1)
    assert np.isfinite(batch.senses.observation.numpy()).all()


def test_torques_are_those_of_a_rollout():
    batch = batch_of("fwalk", actions="torques", action_scale=20.0)
    rollout = Rollout("fwalk", 2, "cpu", threads=1)
    action = np.random.default_rng(4).normal(0.0, 1.0, (2, len(batch.actions.names))).astype(np.float32)
    for _ in range(3):
        batch.actions.requested.assign(action)
        batch.step()
        rollout.step(batch.decision_steps, torques=20.0 * action)
    np.testing.assert_allclose(
        batch.rollout.state.coordinates.numpy(), rollout.state.coordinates.numpy(), rtol=0.0, atol=1e-5
    )


def test_joints_are_driven_towards_their_targets_by_pd_of_the_scenes_gains():
    batch = batch_of("fwalk", actions="joint_targets", action_scale=0.3)
    rollout = Rollout("fwalk", 2, "cpu", threads=1)
    speeds = list(batch.actions.names)
    action = np.random.default_rng(5).normal(0.0, 1.0, (2, len(speeds))).astype(np.float32)
    pd = rollout.numeric.controller.pd
    start = rollout.state.coordinates.numpy().astype(float)
    batch.actions.requested.assign(action)
    batch.step()
    coordinate = {name: k for k, name in enumerate(rollout.coordinate_names)}
    speed = {name: k for k, name in enumerate(rollout.speed_names)}
    for _ in range(batch.decision_steps):
        q, v = (rollout.state.coordinates.numpy().astype(float), rollout.state.speeds.numpy().astype(float))
        torque = np.zeros_like(action, dtype=float)
        for joint in rollout.names.joints:
            gain = pd[joint]
            own = [name for name in speeds if name == joint or name.startswith(joint + ".")]
            columns = [speeds.index(name) for name in own]
            rate = v[:, [speed[name] for name in own]]
            told = 0.3 * action[:, columns]
            if len(own) == 3:
                quaternion = [coordinate[f"{joint}.q{c}"] for c in "xyzw"]
                at_start = Rotation.from_quat(start[:, quaternion]).as_rotvec()
                target = Rotation.from_rotvec(at_start + told)
                error = (Rotation.from_quat(q[:, quaternion]).inv() * target).as_rotvec()
                scale = np.array(gain.scale)
            else:
                places = [coordinate[name] for name in own]
                error = start[:, places] + told - q[:, places]
                axes = np.array(rollout.scene.character.joints[joint].axes)[: len(own)]
                scale = np.square(axes) @ np.array(gain.scale)
            torque[:, columns] = scale * (gain.kp * error - gain.kd * rate)
        rollout.step(1, torques=torque)
    np.testing.assert_allclose(
        batch.rollout.state.coordinates.numpy(), rollout.state.coordinates.numpy(), rtol=0.0, atol=2e-5
    )
    assert np.abs(rollout.state.coordinates.numpy() - start).max() > 0.01


def test_muscles_take_targets_as_wishes():
    batch = batch_of("walk56", actions="joint_targets")
    for _ in range(10):
        batch.step()
    assert not batch.judge.gains.terminated.numpy().any()
    assert batch.rollout.state.muscles.activation.numpy().max() > 0.05


def test_synergies_need_weights_of_muscles_that_are_there():
    with pytest.raises(SceneError, match=r"learning\.synergies: actions by synergies need some"):
        batch_of("reflex_planar", actions="synergies")
    with pytest.raises(SceneError, match=r"learning\.synergies\.a\.lSOK: no muscle is called 'lSOK'"):
        batch_of("reflex_planar", actions="synergies", synergies={"a": {"lSOK": 1.0}})
