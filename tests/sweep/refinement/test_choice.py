"""Where adaptive points go: close to where results change, into gaps, and the same however many are asked for."""

import numpy as np
import pytest

from warpmuscle.sweep.refinement.choice import next_points


def refined(function, dimensions: int, count: int) -> np.ndarray:
    """Points after so many have been chosen, four at a time, of a function of the unit cube."""
    points = np.random.default_rng(0).random((4 * (dimensions + 1), dimensions))
    for _ in range(count // 4):
        points = np.vstack([points, next_points(points, function(points)[:, None], 4, seed=1)])
    return points


def test_points_gather_where_a_result_changes():
    found = refined(lambda x: np.where(x[:, 0] < 0.62, 0.0, 5.0), 1, 24)[8:, 0]
    assert (np.abs(found - 0.62) < 0.05).mean() > 0.25  # a tenth of them lies there by chance
    below, above = found[found < 0.62].max(), found[found >= 0.62].min()
    assert above - below < 0.01  # of 32 even ones it were 0.03


def test_they_follow_an_edge_in_a_plane():
    found = refined(lambda x: np.tanh(20.0 * (x.sum(axis=1) - 1.0)), 2, 60)[12:]
    off = np.abs(found.sum(axis=1) - 1.0) / np.sqrt(2.0)
    by_chance = np.abs(np.random.default_rng(1).random((20000, 2)).sum(axis=1) - 1.0) / np.sqrt(2.0)
    assert np.median(off) < 0.6 * np.median(by_chance)


def test_no_gap_stays_where_nothing_changes():
    found = np.sort(refined(lambda x: np.where(x[:, 0] < 0.1, 0.0, 1.0), 1, 40)[:, 0])
    assert np.diff(found).max() < 0.15


def test_fewer_are_the_first_of_more():
    points = np.random.default_rng(0).random((6, 2))
    values = points.sum(axis=1)[:, None]
    many = next_points(points, values, 5, seed=3)
    assert np.array_equal(next_points(points, values, 2, seed=3), many[:2])
    assert ((many >= 0.0) & (many <= 1.0)).all()
    assert not np.array_equal(next_points(points, values, 5, seed=4), many)


@pytest.mark.parametrize("lost", [[2], range(6)])
def test_points_of_which_nothing_came_count_as_places_only(lost):
    points = np.random.default_rng(0).random((6, 2))
    values = points[:, :1].copy()
    values[list(lost)] = np.nan
    found = next_points(points, values, 4, seed=3)
    assert np.isfinite(found).all()
    away = np.linalg.norm(found[:, None] - points, axis=2).min(axis=1)
    assert away.min() > 0.02
