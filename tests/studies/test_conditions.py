"""Statistics of studies: medians and bands, intervals that hold what they say, trends, and what was expected."""

import numpy as np
import pytest

from warpmuscle.studies.conditions import (
    Cell,
    Expected,
    Spread,
    cells_of,
    farthest,
    has_value,
    interval_of,
    spread_of,
    trend_of,
    verdict_of,
)


def test_spread_is_of_what_is_finite():
    found = spread_of(np.array([3.0, np.nan, 1.0, 2.0]))
    assert (found.count, found.median) == (3, 2.0)
    assert 1.0 <= found.low < 1.2
    assert 2.8 < found.high <= 3.0
    assert np.isnan(spread_of(np.array([np.nan])).median)


@pytest.mark.parametrize("count", [6, 9, 20])
def test_interval_has_the_median_in_95_of_100_samples_of_a_skewed_distribution(count: int):
    draws = np.random.default_rng(3).exponential(size=(4000, count))
    ends = np.array([interval_of(row) for row in draws])
    held = np.mean((ends[:, 0] <= np.log(2.0)) & (ends[:, 1] >= np.log(2.0)))
    assert 0.945 < held < 0.985


def test_fewer_than_six_values_have_no_interval():
    assert np.isnan(interval_of(np.arange(5.0))).all()
    assert np.isnan(interval_of(np.array([]))).all()
    assert interval_of(np.arange(6.0)) == (0.0, 5.0)


def test_trend_is_kendalls():
    # 8 of the 10 pairs agree: tau = (8 - 2) / 10.
    found = trend_of(np.array([1.0, 3.0, 2.0, 5.0, 4.0]), [1.0, 2.0, 3.0, 4.0, 5.0])
    assert found is not None
    assert found.tau == pytest.approx(0.6)
    assert 0.05 < found.chance < 0.3
    assert trend_of(np.arange(5.0), ["a", "b", "c", "d", "e"]) is None
    assert trend_of(np.full(5, np.nan), [1.0, 2.0, 3.0, 4.0, 5.0]) is None


def test_changes_are_of_pairs_with_the_same_seed():
    values = np.array([1.0, 10.0, 3.0, 11.0, 7.0])
    conditions, seeds = [1.0, 1.0, 0.5, 0.5, 0.5], [1, 2, 1, 2, 3]
    walked = np.array([True, True, True, False, True])
    whole, weak = cells_of(values, walked, conditions, seeds, 1.0)
    assert (weak.condition, weak.runs, weak.walked) == (0.5, 3, 2)
    assert (weak.change.count, weak.change.median) == (2, 1.5)
    assert (whole.change.count, whole.change.median) == (2, 0.0)
    values[0] = np.nan
    assert cells_of(values, walked, conditions, seeds, 1.0)[1].change.count == 1


def cell(low: float, high: float) -> Cell:
    nothing = Spread(0, np.nan, np.nan, np.nan)
    return Cell(0.5, 6, 6, nothing, nothing, (low, high))


@pytest.mark.parametrize(
    ("expected", "interval", "verdict"),
    [
        (Expected("a", "falls"), (-3.0, -1.0), "agrees"),
        (Expected("a", "falls"), (1.0, 3.0), "contradicts"),
        (Expected("a", "falls"), (-1.0, 3.0), "open"),
        (Expected("a", "rises"), (1.0, 3.0), "agrees"),
        (Expected("a", "rises"), (-3.0, -1.0), "contradicts"),
        (Expected("a", "rises"), (0.0, 3.0), "open"),
        (Expected("a", "stays"), (-1.0, 3.0), "agrees"),
        (Expected("a", "stays"), (1.0, 3.0), "contradicts"),
        (Expected("a", "stays", within=2.0), (-1.0, 1.5), "agrees"),
        (Expected("a", "stays", within=2.0), (0.5, 1.5), "agrees"),
        (Expected("a", "stays", within=2.0), (-1.0, 3.0), "open"),
        (Expected("a", "stays", within=2.0), (2.5, 3.0), "contradicts"),
        (Expected("a", "stays", within=2.0), (-3.0, -2.5), "contradicts"),
        (Expected("a", value=2.0), (1.0, 3.0), "agrees"),
        (Expected("a", value=4.0), (1.0, 3.0), "contradicts"),
        (Expected("a", "rises"), (np.nan, np.nan), "open"),
    ],
)
def test_what_was_expected_is_held_against_the_interval(expected, interval, verdict):
    assert verdict_of(expected, cell(*interval)) == verdict


def test_an_expected_value_lies_in_the_interval_or_not():
    assert has_value(Expected("a", "rises", value=2.0), cell(1.0, 3.0)) is True
    assert has_value(Expected("a", "rises", value=4.0), cell(1.0, 3.0)) is False
    assert has_value(Expected("a", "rises"), cell(1.0, 3.0)) is None
    assert has_value(Expected("a", "rises", value=4.0), cell(np.nan, np.nan)) is None


def test_farthest_condition_is_by_number_or_the_last_word():
    assert farthest([1.0, 0.5, 1.2], 1.0) == 0.5
    assert farthest(["normal", "brace", "weak"], "normal") == "weak"
    assert farthest([1.0], 1.0) == 1.0
