"""Limits of failure that are wide while a policy begins to learn."""

import msgspec
import numpy as np
import pytest

from warpmuscle import Rollout
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, toml
from warpmuscle.kernels.learning.rewards import COUNT, FORWARD
from warpmuscle.learning import EpisodeBatch, Rewards, Task, Variation
from warpmuscle.learning.tightening import TighteningLimits, limits_after
from warpmuscle.scene import Failure
from warpmuscle.scene.learning import Tightening
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.scene import check_scene

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")
STILL = Variation(velocity_noise=0.0)


def test_limits_move_evenly_from_the_first_ones_to_those_of_the_scene():
    last = Failure(com_height=0.9, self_collision=0.01, heading=0.5)
    tightening = Tightening(decisions=1000, com_height=0.5, self_collision=0.05)
    assert limits_after(tightening, last, 0) == msgspec.structs.replace(last, com_height=0.5, self_collision=0.05)
    quarter = limits_after(tightening, last, 250)
    assert quarter.com_height == pytest.approx(0.6)
    assert quarter.self_collision == pytest.approx(0.04)
    assert quarter.heading == 0.5
    for decisions in (1000, 10**12):
        assert limits_after(tightening, last, decisions) == last


def test_the_device_has_the_limits_that_a_scene_with_these_numbers_has():
    scene = load("walk56")
    scene.failure = Failure(com_height=0.8, self_collision=0.01, leg_crossing=0.1, no_progress=0.3)
    tightening = Tightening(decisions=4, com_height=0.6, self_collision=0.05, leg_crossing=0.3, no_progress=0.1)
    rollout = Rollout(scene, 2, "cpu")
    limits = TighteningLimits(tightening, rollout, rollout.model)
    shown = []
    for decisions in (1, 4, 0, 1):
        limits.after(decisions)
        other = msgspec.structs.replace(scene, failure=limits.present)
        expected = Rollout(other, 2, "cpu").model
        assert rollout.model.failure.numpy().tolist() == expected.failure.numpy().tolist()
        shown.append(rollout.model.collisions.nearest_sq.numpy().copy())
        np.testing.assert_array_equal(shown[-1], expected.collisions.nearest_sq.numpy())
    np.testing.assert_array_equal(shown[0], shown[3])
    wide = shown[2] > 0.0  # of the others one shape may be anywhere within the other, at first
    assert wide.mean() > 0.5
    assert (shown[1][wide] > shown[0][wide]).all()  # bodies must keep farther apart
    assert (shown[2][wide] < shown[0][wide]).all()


def test_episodes_end_by_the_limits_of_the_moment_and_until_told_by_those_of_the_scene():
    scene = load("reflex_planar")
    scene.failure = msgspec.structs.replace(scene.failure, com_height=0.99)
    tightening = Tightening(decisions=100, com_height=0.3)
    batch = EpisodeBatch(scene, 2, "cpu", Task(variation=STILL, tightening=tightening, episode_time=1.0), threads=1)

    def lasted() -> int:
        """Decisions until the first episode fails, at most 40."""
        batch.reset(0)
        for decision in range(40):
            batch.step()
            if batch.judge.gains.terminated.numpy().any():
                return decision + 1
        return 40

    own = lasted()
    batch.limits.after(0)
    assert lasted() == 40 > own
    batch.limits.after(100)
    assert lasted() == own


def test_instances_that_are_variants_of_a_body_have_them_too():
    scene = load("reflex_planar")
    scene.failure = msgspec.structs.replace(scene.failure, com_height=0.9)
    task = Task(variation=Variation(mass=0.1, variants=3), tightening=Tightening(decisions=10, com_height=0.3))
    batch = EpisodeBatch(scene, 4, "cpu", task, threads=1)
    batch.limits.after(5)
    assert batch._variants.model.failure.numpy()["com_height"].ravel() == pytest.approx([0.6])


def test_costs_grow_evenly_to_all_that_rewards_take_off_also_by_terms_of_the_objective():
    rewards = Rewards(effort=5.0, custom={"smoothness": 0.01})
    task = Task(variation=STILL, rewards=rewards, tightening=Tightening(decisions=100, costs=0.2))
    batch = EpisodeBatch("reflex_planar", 2, "cpu", task, threads=1)
    effort, custom = batch.judge.names.index("effort"), batch.judge.names.index("smoothness") - COUNT

    def costs() -> list[float]:
        """Of the first decision: by effort, and by rough motion."""
        batch.reset(0)
        batch.step()
        gains = batch.judge.gains
        return [float(gains.sums.numpy()[0, effort]), float(gains.custom_sums.numpy()[0, custom])]

    whole = np.array(costs())
    assert (whole < 0.0).all()
    for decisions, share in ((0, 0.2), (50, 0.6), (100, 1.0), (10**9, 1.0)):
        batch.limits.after(decisions)
        np.testing.assert_allclose(costs(), share * whole, rtol=1e-5)


def test_rewards_move_from_the_first_numbers_to_the_last_as_if_the_task_had_these():
    first = {"speed": 5.0, "speed_width": 2.0, "overload": 3.0, "progress": 4.0, "force_limit": 0.5}
    last = Rewards(speed=15.0, speed_width=0.4, overload=7.0, progress=0.0, custom={"smoothness": 0.01, "head": 2.0})
    tightening = Tightening(held=100, decisions=300, rewards=first, custom={"smoothness": 0.05})

    def sums(rewards: Rewards, told: Tightening | None, decisions: int) -> tuple[np.ndarray, np.ndarray]:
        """What each reward of the first two decisions was worth."""
        task = Task(variation=STILL, rewards=rewards, tightening=told)
        batch = EpisodeBatch("reflex_planar", 2, "cpu", task, threads=1)
        batch.judge.after(decisions)
        batch.reset(0)
        for _ in range(2):
            batch.step()
        return batch.judge.gains.sums.numpy()[:, :COUNT], batch.judge.gains.custom_sums.numpy()

    for decisions, part in ((0, 0.0), (100, 0.0), (150, 0.25), (300, 1.0), (10**12, 1.0)):
        numbers = {name: one + part * (getattr(last, name) - one) for name, one in first.items()}
        custom = {"smoothness": 0.05 + part * (0.01 - 0.05), "head": 2.0}
        got = sums(last, tightening, decisions)
        expected = sums(msgspec.structs.replace(last, custom=custom, **numbers), None, 0)
        for one, other in zip(got, expected, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-5, atol=1e-7)
        assert (got[0][:, 0] > 0.0).all()
        assert (got[1] < 0.0).all()


@pytest.mark.parametrize("smoothing", [0.0, 0.1, 0.5])
def test_the_rewarded_speed_is_a_mean_over_the_time_told_and_begins_anew_with_an_episode(smoothing: float):
    rewards = Rewards(speed=2.0, speed_width=0.2, speed_smoothing=smoothing)
    batch = EpisodeBatch("reflex_planar", 1, "cpu", Task(variation=STILL, rewards=rewards, speed=(1.3, 1.3)), threads=1)
    gains, duration = batch.judge.gains, batch.decision_steps * batch.scene.time_step

    def worth(decisions: int) -> tuple[list[float], list[float]]:
        """What speed was worth in each decision, and what it ought to be by the speeds themselves."""
        earned, gone = [0.0], [0.0]
        for _ in range(decisions):
            batch.step()
            sums = gains.sums.numpy()[0]
            earned.append(float(sums[0]))
            gone.append(float(sums[FORWARD]))
        speeds = np.diff(gone)
        mean, expected = speeds[0], []
        for speed in speeds:
            mean += (1.0 - np.exp(-duration / smoothing) if smoothing else 1.0) * (speed - mean)
            expected.append(2.0 * duration * np.exp(-(((mean - 1.3) / 0.2) ** 2)))
        return list(np.diff(earned)), expected

    batch.reset(0)
    for _ in range(2):
        got, expected = worth(6)
        np.testing.assert_allclose(got, expected, rtol=2e-3, atol=1e-6)
        assert np.ptp(expected) > 1e-4
        batch.reset(0)


def test_what_counts_at_a_speed_counts_less_where_another_is_wanted():
    def roughness(at_speed: dict[str, tuple[float, float]], wanted: float) -> float:
        """What the rough motion of the first decision cost."""
        rewards = Rewards(custom={"smoothness": 0.01}, at_speed=at_speed)
        batch = EpisodeBatch("reflex_planar", 1, "cpu", Task(variation=STILL, rewards=rewards, speed=(wanted, wanted)))
        batch.step()
        return float(batch.judge.gains.custom_sums.numpy()[0, 0])

    whole = roughness({}, 1.2)
    assert whole < 0.0
    for wanted in (1.2, 1.5, 0.5):
        share = np.exp(-(((wanted - 1.2) / 0.4) ** 2))
        assert roughness({"smoothness": (1.2, 0.4)}, wanted) == pytest.approx(share * whole, rel=1e-5)
    assert roughness({}, 0.5) == whole


@pytest.mark.parametrize(
    ("rewards", "tightening", "key", "said"),
    [
        ({}, Tightening(rewards={"sped": 1.0}), "tightening.rewards.sped", "did you mean"),
        ({}, Tightening(rewards={"force_smoothing": 1.0}), "tightening.rewards.force_smoothing", "can change"),
        ({}, Tightening(rewards={"speed_width": 0.0}), "tightening.rewards.speed_width", "above 0, is 0"),
        ({}, Tightening(rewards={"speed": -1.0}), "tightening.rewards.speed", "must not be negative"),
        ({}, Tightening(custom={"head": 1.0}), "tightening.custom.head", "learning.rewards.custom"),
        ({}, Tightening(decisions=10, held=10, costs=0.1), "tightening.held", "less than decisions, 10"),
        ({}, Tightening(held=-1, costs=0.1), "tightening.held", "must be 0 to"),
        ({"at_speed": {"head": (1.0, 0.2)}}, None, "rewards.at_speed.head", "learning.rewards.custom"),
        ({"custom": {"head": 1.0}, "at_speed": {"head": (1.0, 0.0)}}, None, "rewards.at_speed.head", "width above 0"),
    ],
)
def test_rewards_that_cannot_be_so_are_refused_with_their_key(rewards: dict, tightening, key: str, said: str):
    scene = load("walk56")
    scene.learning = Task(rewards=Rewards(**rewards), tightening=tightening)
    with pytest.raises(SceneError, match=said) as caught:
        check_scene(scene)
    assert caught.value.key == f"learning.{key}"


def test_a_scene_says_it_in_its_table():
    scene = load("walk56")
    scene.failure.self_collision = 0.01
    scene.learning = Task(tightening=Tightening(decisions=5, self_collision=0.05))
    text = toml.dumps(scene)
    assert "tightening = { decisions = 5, self_collision = 0.05 }" in text
    assert toml.loads(text).learning == scene.learning


@pytest.mark.parametrize(
    ("failure", "tightening", "key", "said"),
    [
        ({}, Tightening(), "", "name at least one limit"),
        ({}, Tightening(costs=1.0), ".costs", "must be less than 1"),
        ({}, Tightening(costs=-0.1), ".costs", "-0.1"),
        ({}, Tightening(decisions=0, com_height=0.1), ".decisions", "must be 1 at least"),
        ({}, Tightening(self_collision=0.05), ".self_collision", "failure.self_collision is 0, which switches it off"),
        ({"self_collision": 0.05}, Tightening(self_collision=0.01), ".self_collision", "must be greater than .* 0.05"),
        ({"self_collision": 0.05}, Tightening(self_collision=float("inf")), ".self_collision", "inf is not a finite"),
        ({"self_collision": 0.05}, Tightening(self_collision=float("nan")), ".self_collision", "nan is not a finite"),
        ({"self_collision": Free(0.05, 0.01, 0.1)}, Tightening(self_collision=0.2), ".self_collision", "not free"),
        ({}, Tightening(com_height=0.95), ".com_height", "must be less than failure.com_height, 0.9, is 0.95"),
        ({}, Tightening(com_height=-0.1), ".com_height", "must not be negative"),
        ({"no_progress": 0.3}, Tightening(no_progress=0.3), ".no_progress", "must be less than"),
        ({}, Tightening(heading=0.5), ".heading", "must be greater than"),
    ],
)
def test_limits_that_cannot_tighten_are_refused_with_their_key(failure: dict, tightening: Tightening, key, said):
    scene = load("walk56")
    scene.failure = msgspec.structs.replace(Failure(), **failure)
    scene.learning = Task(tightening=tightening)
    with pytest.raises(SceneError, match=said) as caught:
        check_scene(scene)
    assert caught.value.key == f"learning.tightening{key}"


def test_a_heading_does_not_tighten_where_turns_are_asked_for():
    scene = load("walk56")
    scene.learning = Task(turning_rate=(-0.3, 0.3), tightening=Tightening(heading=1.5))
    with pytest.raises(SceneError, match=r"turning is not a failure where learning\.turning_rate asks"):
        check_scene(scene)
