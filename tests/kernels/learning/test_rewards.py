"""What a decision is worth against the same formulas in float64, with random states, weights, gaits and bodies."""

from typing import Any

import numpy as np
import pytest
import warp as wp
from probes import filled

from warpmuscle.kernels.learning import rewards
from warpmuscle.kernels.learning.episodes import EpisodeRules, Episodes
from warpmuscle.kernels.learning.reward_structs import Gains, GaitTable, ObjectiveWeights, RewardRules
from warpmuscle.kernels.learning.rewards import COUNT, LOGGED, TERMS
from warpmuscle.kernels.learning.senses import Surroundings
from warpmuscle.kernels.structs import ROOT_FREE, MuscleState, State

TILTED = np.array([[[0.45, 1.0, 0.6]]])  # of the ground
N, MUSCLES, ACTIONS, BODIES = 40, 5, 3, 4
COORDINATES = 7 + 4 + 1 + 2  # of the root, a ball joint, a hinge, a universal joint
JOINTS = ((7, 11), (11, 12), (12, 14))
SPEEDS, BINS = 3, 8
WEIGHT, LIMIT, SHARE, RIGHT, DECISION = 700.0, 0.8, 0.3, 0.45, 0.02
FIRST_SPEED, SPEED_STEP = 0.8, 0.3
EFFORTS = {rewards.EXCITATIONS: "excitation", rewards.ACTIVATIONS: "activation", rewards.ACTIONS: "action"}


def quaternions(random: np.random.Generator, *shape: int) -> np.ndarray:
    q = random.normal(size=(*shape, 4))
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


@pytest.fixture(scope="module")
def drawn() -> dict[str, Any]:
    """Numbers of all instances, of the gait and of the rules."""
    random = np.random.default_rng(3)
    coordinates = random.normal(0.0, 0.6, (N, COORDINATES))
    gait = random.normal(0.0, 0.6, (SPEEDS * BINS, COORDINATES))
    coordinates[:, 3:7], coordinates[:, 7:11] = quaternions(random, N), quaternions(random, N)
    gait[:, 7:11] = quaternions(random, SPEEDS * BINS)
    for table in (coordinates, gait):
        table[:, 7:11] += (2.0, 0.0, 0.0, 0.0)  # so that some are near one another
        table[:, 7:11] /= np.linalg.norm(table[:, 7:11], axis=1, keepdims=True)
    up = random.normal((0.0, 2.0, 0.0), 1.0, (BINS, 3))
    command = random.normal(0.0, 0.4, (N, 4))
    command[:, 0] = random.uniform(0.4, 2.0, N)
    return {
        "coordinates": coordinates, "gait": gait, "command": command,
        "up": up / np.linalg.norm(up, axis=1, keepdims=True),
        "force": random.uniform(0.0, 1.2, (SPEEDS, BINS)), "phase": random.random(N),
        "foot_force": random.normal(0.0, 1.0, (N, 2, 3)) * WEIGHT, "heading": random.normal(0.0, 1.0, N),
        "felt": np.where(random.random((N, 2)) < 0.3, -1.0, random.random((N, 2))),
        "mean_speed": np.where(random.random(N) < 0.3, rewards.NO_SPEED, random.normal(1.0, 0.6, N)),
        "activation": random.random((N, MUSCLES)), "excitation": random.random((N, MUSCLES)),
        "action": random.normal(0.0, 1.5, (N, ACTIONS)), "previous": random.normal(0.0, 1.5, (N, ACTIONS)),
        "side": random.normal(0.0, 0.6, N), "place": coordinates[:, :3] - random.normal(0.0, 0.02, (N, 3)),
        "start_place": random.normal(0.0, 3.0, (N, 3)), "step": random.integers(50, 90, N),
        "start_step": random.integers(0, 40, N), "status": (np.arange(N) % 5 == 4).astype(int) * 2,
        "length": random.integers(1, 12, N), "torque_integral": random.random((N, BODIES)) * 9.0,
        "muscle_terms": random.random((N, 3, MUSCLES)), "body_terms": random.random((N, 2, BODIES)),
        "instance_terms": random.random((N, 2)),
        "earned": random.normal(size=N), "sums": random.normal(size=(N, LOGGED)),
        "weight": random.uniform(0.3, 1.5, COUNT) * np.where(np.arange(COUNT)[::-1] % 3 == 0, -1.0, 1.0),
    }  # fmt: skip


OBJECTIVE = {
    "torque": 0.013, "muscle": (0.4, 0.0, -0.7), "body": (0.2, -0.3), "instance": (1.1, -0.6), "basal": 0.021,
    "energy": 1, "transport": 2.3, "mass": 71.0, "basal_power": 83.0, "time_step": 0.005,
}  # fmt: skip


def objective(d: dict[str, Any], i: int) -> float:
    """The scene's weighted objective since the start of an episode; transport counts for 1 m at least."""
    w, steps = OBJECTIVE, d["step"][i] - d["start_step"][i]
    muscle = d["muscle_terms"][i].sum(axis=1)
    total = w["torque"] * d["torque_integral"][i].sum() + np.dot(w["muscle"], muscle) + w["basal"] * steps
    total += np.dot(w["body"], d["body_terms"][i].sum(axis=1)) + np.dot(w["instance"], d["instance_terms"][i])
    gone = d["coordinates"][i, [0, 2]] - d["start_place"][i, [0, 2]]
    energy = (muscle[w["energy"]] + w["basal_power"] * steps) * w["time_step"]
    return total + w["transport"] * energy / (w["mass"] * max(np.hypot(*gone), 1.0))


def turned(q: np.ndarray) -> np.ndarray:
    """Rotation matrix of a quaternion xyzw."""
    x, y, z, w = q
    return np.array(
        [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    )  # fmt: skip


def terms(d: dict[str, Any], i: int, effort: int) -> dict[str, float]:
    """Values of all terms of an instance that has not failed, of formulas as the reference on learning has them."""
    q, command, phase = d["coordinates"][i], d["command"][i], d["phase"][i]
    up = turned(q[3:7])[1]  # the vertical in axes of the trunk
    wanted = d["heading"][i]
    moved = q[:3] - d["place"][i]
    forward = (moved[0] * np.sin(wanted) + moved[2] * np.cos(wanted)) / DECISION
    mean = forward if d["mean_speed"][i] < -1e8 else d["mean_speed"][i] + 0.3 * (forward - d["mean_speed"][i])
    row = int(np.clip(np.round((command[0] - FIRST_SPEED) / SPEED_STEP), 0, SPEEDS - 1))
    near = d["gait"][row * BINS + int(phase * BINS)]
    imitation = 0.25 * np.exp(-np.sum((up - d["up"][int(phase * BINS)]) ** 2) / 0.7**2)
    for (first, end), share in zip(JOINTS, (0.35, 0.25, 0.15), strict=True):
        one, other = q[first:end], near[first:end]
        squared = 4.0 * (1.0 - np.dot(one, other) ** 2) if end - first == 4 else np.sum((one - other) ** 2)
        imitation += share * np.exp(-squared / 0.7**2)
    load = np.maximum(d["foot_force"][i, :, 1] / WEIGHT, 0.0)
    before = d["felt"][i]
    felt = np.where(before < 0.0, load, before + SHARE * (load - before))
    people = [d["force"][row, int(((phase - lag) % 1.0) * BINS)] for lag in (0.0, RIGHT)]
    facing = 2.0 * np.arctan2(q[4], q[6])
    return {
        "speed": np.exp(-(((mean - command[0]) / 0.5) ** 2)),
        "progress": np.clip(forward / command[0], 0.0, 1.0), "alive": 1.0, "upright": up[1],
        "pose": np.exp(-np.mean((q[[11, 13]] - command[2:]) ** 2) / 0.6**2), "imitation": imitation,
        "force": np.mean(np.exp(-(((felt - people) / 0.4) ** 2))),
        "contact": np.mean((load > 0.03) == (np.array(people) > 0.03)), "effort": np.mean(d[EFFORTS[effort]][i] ** 2),
        "action": min(np.mean(d["action"][i] ** 2), 4.0),
        "action_rate": np.mean((d["action"][i] - d["previous"][i]) ** 2),
        "overload": np.maximum(load - LIMIT, 0.0).sum(), "heading": 1.0 - np.cos(wanted - facing),
        "side": min(abs(d["side"][i] + moved[0] * np.cos(wanted) - moved[2] * np.sin(wanted)), 1.0),
        "objective": objective(d, i) - d["earned"][i], "failure": 0.0,
    }  # fmt: skip


def judged(
    d: dict[str, Any], effort: int, uneven: float = 0.0, costs: float = 1.0, **own: Any
) -> tuple[Gains, Episodes]:
    """What the kernel says of all instances; `own` are parts of the scene's own among the gains."""
    first, end = np.transpose(JOINTS)
    gait = filled(
        GaitTable, coordinate=d["gait"], up=d["up"], first=first, end=end, weight=(0.35, 0.25, 0.15), up_weight=0.25,
        force=d["force"], right=RIGHT, speeds=SPEEDS, first_speed=FIRST_SPEED, speed_step=SPEED_STEP,
    )  # fmt: skip
    rules = filled(
        RewardRules, weight=rewards.term_values(*d["weight"]), now=[*d["weight"], 0.5, 0.6, 0.7, 0.4, LIMIT],
        pose=[11, 13], gait=gait, force_share=SHARE, speed_share=0.3, total_mass=[[WEIGHT / 9.5]], gravity=[[9.5]],
        longest=9, effort=effort, uneven=uneven, costs=[costs],
        around=filled(Surroundings, root=ROOT_FREE, normal=TILTED, ground=[[0.3]]),
    )  # fmt: skip
    state = filled(
        State, coordinates=d["coordinates"], foot_force=d["foot_force"], step=d["step"], status=d["status"],
        torque_integral=d["torque_integral"], muscle_terms=d["muscle_terms"], body_terms=d["body_terms"],
        instance_terms=d["instance_terms"], muscles=filled(MuscleState, activation=d["activation"]),
    )  # fmt: skip
    names = ("command", "phase", "heading", "side", "place", "start_place", "start_step", "length")
    episodes = filled(Episodes, **{name: d[name] for name in names}, mask=np.zeros(N, bool))
    gains = filled(
        Gains, action=d["action"], previous=d["previous"], excitation=d["excitation"], foot_force=d["felt"],
        speed=d["mean_speed"], objective=d["earned"], sums=d["sums"], finished=np.full((N, LOGGED), 7.0),
        reward=np.zeros(N), terminated=np.zeros(N, bool), truncated=np.zeros(N, bool), **own,
    )  # fmt: skip
    of_episode = filled(EpisodeRules, root=ROOT_FREE, decision_time=DECISION)
    inputs = [rules, filled(ObjectiveWeights, **OBJECTIVE), of_episode, episodes, state, gains]
    wp.launch(rewards.judge, N, inputs, device="cpu")
    return gains, episodes


@pytest.mark.parametrize("effort", EFFORTS)
def test_every_term_is_what_its_formula_says(drawn: dict[str, Any], effort: int):
    gains, _ = judged(drawn, effort)
    got = gains.sums.numpy() - drawn["sums"]
    running = np.flatnonzero(drawn["status"] == 0)
    for i in running:
        expected = terms(drawn, i, effort)
        assert tuple(expected) == TERMS
        worth = drawn["weight"] * np.array(list(expected.values()))
        for k, name in enumerate(TERMS):
            assert got[i, k] == pytest.approx(worth[k], rel=1e-4, abs=2e-5), name
        assert gains.reward.numpy()[i] == pytest.approx(worth.sum(), rel=1e-4, abs=1e-4)
        load = np.maximum(drawn["foot_force"][i, :, 1] / WEIGHT, 0.0)
        before = drawn["felt"][i]
        felt = np.where(before < 0.0, load, (1.0 - SHARE) * before + SHARE * load)
        np.testing.assert_allclose(gains.foot_force.numpy()[i], felt, rtol=1e-5, atol=1e-6)
    values = np.array([list(terms(drawn, i, effort).values()) for i in running])
    seen = [name for name in TERMS if name not in ("alive", "failure")]
    assert all(np.ptp(values[:, TERMS.index(name)]) > 0.1 for name in seen)
    np.testing.assert_allclose(
        gains.objective.numpy()[running], [objective(drawn, i) for i in running], rtol=1e-5, atol=1e-6
    )


def test_a_gait_counts_as_met_where_the_ground_asks_for_other_steps(drawn: dict[str, Any]):
    limit = 0.06
    gains, _ = judged(drawn, rewards.ACTIONS, limit)
    got = (gains.sums.numpy() - drawn["sums"]) / np.pad(drawn["weight"], (0, LOGGED - COUNT), constant_values=1.0)
    shares = []
    for i in np.flatnonzero(drawn["status"] == 0):
        q = drawn["coordinates"][i]
        facing = 2.0 * np.arctan2(q[4], q[6])
        rise = 0.1 * abs(TILTED[0, 0, 0] * np.sin(facing) + TILTED[0, 0, 2] * np.cos(facing)) / TILTED[0, 0, 1]
        shares.append(np.clip(2.0 * rise / limit - 1.0, 0.0, 1.0))
        plain = terms(drawn, i, rewards.ACTIONS)
        for name in TERMS:
            free = shares[-1] if name in ("imitation", "force", "contact") else 0.0
            expected = plain[name] + free * (1.0 - plain[name])
            assert got[i, TERMS.index(name)] == pytest.approx(expected, rel=1e-4, abs=5e-5), name
    assert min(shares) == 0.0
    assert max(shares) > 0.5


def test_a_share_of_the_costs_is_taken_off_and_all_that_is_earned_counts(drawn: dict[str, Any]):
    whole, part = judged(drawn, rewards.ACTIONS)[0], judged(drawn, rewards.ACTIONS, costs=0.3)[0]
    gained, now = (gains.sums.numpy()[:, :COUNT] - np.float32(drawn["sums"][:, :COUNT]) for gains in (whole, part))
    costs = drawn["weight"] < 0.0
    np.testing.assert_allclose(now[:, costs], 0.3 * gained[:, costs], rtol=1e-3, atol=2e-5)
    np.testing.assert_array_equal(now[:, ~costs], gained[:, ~costs])
    assert np.abs(gained[:, costs]).max() > 0.1


def test_a_failure_costs_its_weight_alone_and_ends_with_a_long_episode_are_logged(drawn: dict[str, Any]):
    gains, episodes = judged(drawn, rewards.ACTIONS)
    failed, late = drawn["status"] != 0, drawn["length"] >= 9
    assert failed.any()
    assert (late & ~failed).any()
    assert (late & failed).any()
    assert not (failed | late).all()
    np.testing.assert_allclose(gains.reward.numpy()[failed], drawn["weight"][-1], rtol=1e-6)
    np.testing.assert_array_equal(gains.terminated.numpy(), failed)
    np.testing.assert_array_equal(gains.truncated.numpy(), late & ~failed)
    np.testing.assert_array_equal(episodes.mask.numpy(), failed | late)
    finished, sums = gains.finished.numpy(), gains.sums.numpy()
    np.testing.assert_array_equal(finished[~(failed | late)], 7.0)
    np.testing.assert_array_equal(finished[failed | late], sums[failed | late])
    np.testing.assert_array_equal(finished[failed | late, rewards.DECISIONS], drawn["length"][failed | late])
    np.testing.assert_array_equal(finished[failed | late, rewards.COMPLETED], (late & ~failed)[failed | late])
    np.testing.assert_array_equal(finished[failed | late, rewards.ENDED], 1.0)
    np.testing.assert_array_equal(
        sums[~(failed | late), rewards.ENDED], np.float32(drawn["sums"])[~(failed | late), -1]
    )
    moved, wanted = drawn["coordinates"][:, :3] - drawn["place"], drawn["heading"]
    forward = (moved[:, 0] * np.sin(wanted) + moved[:, 2] * np.cos(wanted)) / DECISION
    np.testing.assert_allclose(
        sums[:, rewards.FORWARD] - drawn["sums"][:, rewards.FORWARD], forward, rtol=1e-4, atol=1e-4
    )


def test_own_ends_are_failures_or_reached_and_own_rewards_count_at_their_speed(drawn: dict[str, Any]):
    random = np.random.default_rng(8)
    ends, worth = (random.random((N, 2)) < 0.3).astype(float), random.normal(size=(N, 3))
    worth[3, 1] = np.nan
    weight, speed, width = np.array([0.8, -0.4, 0.5]), np.array([1.0, 1.4, 0.0]), np.array([0.3, 0.5, 0.0])
    sums = random.normal(size=(N, 3))
    gains, episodes = judged(
        drawn, rewards.ACTIONS, costs=0.6, custom=worth, custom_weight=weight, custom_speed=speed, custom_width=width,
        custom_sums=sums, custom_finished=np.full((N, 3), 7.0), custom_end=ends, end_fails=[0, 1],
        reached=np.zeros(N, bool),
    )  # fmt: skip
    failed = (drawn["status"] != 0) | (ends[:, 1] > 0.0)
    reached = (ends[:, 0] > 0.0) & ~failed
    late = drawn["length"] >= 9
    assert (failed & (drawn["status"] == 0)).any()
    assert (late & reached).any()
    np.testing.assert_array_equal(gains.terminated.numpy(), failed | reached)
    np.testing.assert_array_equal(gains.reached.numpy(), reached)
    np.testing.assert_array_equal(gains.truncated.numpy(), late & ~failed & ~reached)
    np.testing.assert_array_equal(episodes.mask.numpy(), failed | late | reached)
    away = (drawn["command"][:, :1] - speed) / np.where(width > 0.0, width, np.inf)
    own = np.where(weight < 0.0, 0.6, 1.0) * weight * np.nan_to_num(worth) * np.exp(-(away**2))
    own[failed] = 0.0
    now = gains.custom_sums.numpy()
    np.testing.assert_allclose(now - sums, own, rtol=1e-4, atol=1e-6)
    ended = failed | late | reached
    np.testing.assert_array_equal(gains.custom_finished.numpy()[ended], now[ended])
    np.testing.assert_array_equal(gains.custom_finished.numpy()[~ended], 7.0)
    bare = judged(drawn, rewards.ACTIONS, costs=0.6)[0].reward.numpy()
    np.testing.assert_allclose(gains.reward.numpy()[~failed], (bare + own.sum(axis=1))[~failed], rtol=1e-4, atol=1e-4)
    assert drawn["weight"][-1] < 0.0  # which is a cost, of which a share is taken off
    np.testing.assert_allclose(gains.reward.numpy()[failed], 0.6 * drawn["weight"][-1], rtol=1e-6)
    forgotten = np.arange(N) % 2 == 0
    wp.launch(rewards.forget, N, [wp.array(forgotten, dtype=bool, device="cpu"), gains], device="cpu")
    np.testing.assert_array_equal(gains.custom_sums.numpy()[forgotten], 0.0)
    np.testing.assert_array_equal(gains.custom_sums.numpy()[~forgotten], now[~forgotten])


def test_a_new_episode_forgets_the_old_one_and_others_go_on(drawn: dict[str, Any]):
    gains, _ = judged(drawn, rewards.ACTIONS)
    kept = {
        name: getattr(gains, name).numpy().copy() for name in ("objective", "sums", "action", "foot_force", "speed")
    }
    mask = np.arange(N) % 2 == 0
    wp.launch(rewards.forget, N, [wp.array(mask, dtype=bool, device="cpu"), gains], device="cpu")
    begun_anew = {"objective": 0.0, "sums": 0.0, "action": 0.0, "foot_force": -1.0, "speed": rewards.NO_SPEED}
    for name, begun in begun_anew.items():
        now = getattr(gains, name).numpy()
        np.testing.assert_array_equal(now[mask], begun)
        np.testing.assert_array_equal(now[~mask], kept[name][~mask])


def test_a_place_that_is_no_number_or_very_far_is_a_failure(drawn: dict[str, Any]):
    place = drawn["place"].copy()
    place[0], place[1] = np.nan, 1e5
    turn = drawn["heading"][2]
    place[2] += 1e8 * np.array([np.cos(turn), 0.0, -np.sin(turn)])  # far to the side alone
    gains, _ = judged(drawn | {"place": place}, rewards.ACTIONS)
    assert gains.terminated.numpy()[:3].all()
    np.testing.assert_allclose(gains.reward.numpy()[:3], drawn["weight"][-1], rtol=1e-6)
    assert np.isfinite(gains.sums.numpy()).all()


def test_a_reward_without_a_value_is_named(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(rewards, "TERMS", (*TERMS, "grace"))
    with pytest.raises(TypeError, match=r"the reward grace .* has no value in task_terms"):
        rewards._check_rewards()
