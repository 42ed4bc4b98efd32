"""Half impulses of survivals that are made up, and trials of a ball and of the biped, short ones."""

import inspect

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.scene import Scene
from warpmuscle.studies import robustness
from warpmuscle.studies.robustness import PushTrials, half_impulse, push_trials, slope_trials, upright
from warpmuscle.studies.walkers import SceneWalker, Walker, Walks

LEVELS = np.array([0.0, 10.0, 20.0, 30.0])


@pytest.fixture(scope="module")
def scene() -> Scene:
    """The walk on torques."""
    return load("fwalk")


@pytest.mark.parametrize(
    ("survival", "half"),
    [
        ([1.0, 1.0, 0.0, 0.0], 15.0),
        ([1.0, 0.8, 0.5, 0.1], 20.0),
        ([1.0, 0.75, 0.25, 0.0], 15.0),
        ([1.0, 0.4, 0.8, 0.0], 20.0 + 10.0 * 0.1 / 0.6),  # 0.4 and 0.8 count as 0.6 each
        ([1.0, 1.0, 1.0, 0.6], np.inf),
        ([0.0, 0.0, 0.0, 0.0], 0.0),
    ],
)
def test_half_impulse_is_where_the_falling_survival_crosses_one_half(survival: list[float], half: float):
    assert half_impulse(LEVELS, np.array(survival)) == pytest.approx(half)


def test_range_holds_the_half_and_is_that_of_the_pushes_drawn_again():
    limits = np.array([12.0, 13.0, 14.0, 26.0, 27.0])  # N s, that each push may have
    survived = LEVELS[:, None] < limits
    trials = PushTrials(LEVELS, survived, np.zeros(5), np.zeros(5))
    low, high = trials.range
    assert low <= trials.half <= high
    assert 10.0 < low < 16.0
    assert 20.0 < high <= 30.0
    sure = PushTrials(LEVELS, np.repeat(survived[:, :1], 5, axis=1), np.zeros(5), np.zeros(5))
    assert sure.range == (sure.half, sure.half) == (15.0, 15.0)


@pytest.mark.parametrize(("strong", "end"), [(3, 1), (2, 0)])
def test_a_range_leaves_out_a_twentieth_at_each_end(strong: int, end: int):
    """Of five pushes three are alike: 7.8 % of the draws have these alone, and 1 % the other two."""
    limits = np.array([12.0] * (5 - strong) + [26.0] * strong)  # N s
    trials = PushTrials(LEVELS, LEVELS[:, None] < limits, np.zeros(5), np.zeros(5))
    alone = (15.0, 25.0)[end]
    assert trials.range[end] == pytest.approx(alone)
    assert trials.range[1 - end] != pytest.approx((15.0, 25.0)[1 - end])


class Standing(Walker):
    """Stands, and keeps what disturbed it."""

    def scene(self, commands=None):
        raise NotImplementedError

    def walk(self, duration, disturbances, commands=None, *, record=False):
        self.duration, self.met = duration, disturbances
        return Walks(np.full(len(disturbances), int(Status.COMPLETED)), np.full(len(disturbances), duration), [])

    def _walked(self, scene, disturbances, commands, recorded):
        raise NotImplementedError


def test_pushes_come_between_2_and_6_s_from_all_sides_as_the_seed_says():
    walker, pushes = Standing(), 500
    trials = push_trials(walker, [30.0, 60.0], pushes, seed=4)
    assert walker.duration == 10.0
    drawn = np.random.default_rng(4).random((2, pushes))
    np.testing.assert_allclose(trials.direction, 2.0 * np.pi * drawn[0])
    np.testing.assert_allclose(trials.start, 2.0 + 4.0 * drawn[1])
    np.testing.assert_allclose(walker.met.push_start, np.tile(trials.start, 3))
    expected = np.outer([0.0, 30.0, 60.0], np.ones(pushes)).ravel()
    np.testing.assert_allclose(np.linalg.norm(walker.met.push, axis=1), expected, atol=1e-9)


def test_pushes_are_the_same_at_each_impulse_and_greater_ones_let_fall(scene: Scene, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(robustness, "PUSHED_FROM", 0.2)
    monkeypatch.setattr(robustness, "PUSHED_UNTIL", 0.4)
    monkeypatch.setattr(robustness, "AFTERWARDS", 1.0)
    trials = push_trials(SceneWalker(scene, "cpu", 1), [200.0], 4)
    assert trials.survived.tolist() == [[True] * 4, [False] * 4]
    assert trials.impulses.tolist() == [0.0, 200.0]
    assert np.all((trials.start >= 0.2) & (trials.start <= 0.4))
    assert trials.half == 100.0
    again = push_trials(SceneWalker(scene, "cpu", 1), [200.0], 4)
    assert np.array_equal(again.direction, trials.direction)


def test_a_steep_slope_lets_fall_and_a_level_one_does_not(scene: Scene):
    level, steep = slope_trials(SceneWalker(scene, "cpu", 1), [0.0, 0.3], 1.0)
    assert (level.survived, level.end_time) == (True, pytest.approx(1.0))
    assert 0.3 < level.speed < 1.5
    assert not steep.survived
    assert steep.end_time < 1.0


def test_runs_that_start_at_other_speeds_are_counted_if_they_stay_upright(scene: Scene):
    assert upright(SceneWalker(scene, "cpu", 1), 3, 0.02, 0.5) == 3
    strict = msgspec.structs.replace(scene, failure=msgspec.structs.replace(scene.failure, com_height=1.2))
    assert upright(SceneWalker(strict, "cpu", 1), 3, 0.02, 0.5) == 0


@pytest.mark.parametrize("impulses", [[], [-1.0], [np.inf]])
def test_impossible_impulses_are_an_error(scene: Scene, impulses: list[float]):
    with pytest.raises(Error, match="positive numbers"):
        push_trials(SceneWalker(scene, "cpu"), impulses, 2)


def test_by_default_each_impulse_is_given_20_times_for_a_tenth_of_a_second():
    told = inspect.signature(push_trials).parameters
    assert (told["pushes"].default, told["push_duration"].default) == (20, 0.1)
