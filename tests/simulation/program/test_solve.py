"""Quadratic programmes on a device against SciPy and optimality conditions, in float64."""

from dataclasses import replace

import numpy as np
import pytest

import warpmuscle as wm
from program_problems import by_scipy, objective, optimum, rounded, standing
from warpmuscle.core.errors import ArgumentError

COUNT = 24


@pytest.fixture(scope="module")
def problems():
    return standing(COUNT)


@pytest.fixture(scope="module")
def solved(problems):
    return wm.quadratic_program(**problems.arguments(), device="cpu")


def test_controls_are_those_of_scipy(problems, solved):
    for p in range(6):
        wanted = by_scipy(problems, p)
        muscles, torques = slice(0, 92), slice(92, 105)
        assert solved.control[p, muscles] == pytest.approx(wanted[muscles], abs=1e-5)
        assert solved.control[p, torques] == pytest.approx(wanted[torques], abs=1e-4)
        assert solved.control[p, 105:] == pytest.approx(wanted[105:], abs=1e-2)  # N, of hundreds


def test_all_are_balanced_and_of_every_kind(problems, solved):
    assert np.all((solved.iterations > 0) & (solved.iterations < 60))
    activation, edges = solved.control[:, :92], solved.control[:, 105:]
    assert 0.2 < np.mean((activation > 0.0) & (activation < 1.0)) < 0.9
    assert np.any(activation == 1.0)
    assert np.any(edges == 0.0)
    assert edges.max() > 50.0
    assert np.any(np.abs(solved.control[:, 92:105]) == 5.0)


def test_no_control_can_be_changed_for_the_better(problems, solved):
    random = np.random.default_rng(2)
    for p in range(COUNT):
        best = objective(problems, p, solved.control[p])
        for size in (1e-3, 1e-2, 0.1, 1.0):
            change = size * random.normal(size=(30, len(problems.cost))) * np.r_[np.ones(92), np.full(45, 10.0)]
            for other in np.clip(solved.control[p] + change, problems.low, problems.high):
                assert objective(problems, p, other) > best


def test_accelerations_follow_from_the_controls(problems, solved):
    for p in range(COUNT):
        force = problems.forces[p] @ solved.control[p]
        assert problems.mass[p] @ solved.acceleration[p] + problems.bias[p] == pytest.approx(force, rel=1e-4, abs=2e-2)


@pytest.mark.parametrize("scale", [0.0, 100.0])
def test_controls_are_the_optimum_of_float64(scale):
    """Also where weights are extreme, and SciPy stops before it is there."""
    heavy = standing(16, seed=3)
    heavy = rounded(replace(heavy, weight=heavy.weight + scale * np.eye(19)))
    found = wm.quadratic_program(**heavy.arguments(), device="cpu")
    for p in range(16):
        best = optimum(heavy, p, found.control[p])
        assert found.control[p, :92] == pytest.approx(best[:92], abs=1e-5)
        assert found.control[p, 92:] == pytest.approx(best[92:], abs=1e-3)


def test_bits_depend_on_no_other_programme(problems, solved):
    order = np.random.default_rng(0).permutation(COUNT)
    shuffled = wm.quadratic_program(**problems[order].arguments(), device="cpu")
    assert np.array_equal(shuffled.control, solved.control[order])
    alone = wm.quadratic_program(**problems[:1].arguments(), device="cpu")
    assert np.array_equal(alone.control, solved.control[:1])


def test_one_mass_on_one_force():
    """1/2 (w - u/m + g)^2 W + 1/2 c u^2: u = W/m (w + g)/(W/m^2 + c), or the bound."""
    m, g, w, weight, cost = 2.0, 9.81, 1.5, 3.0, 0.1
    free = weight / m * (w + g) / (weight / m**2 + cost)
    for high, wanted in ((np.inf, free), (5.0, 5.0)):
        found = wm.quadratic_program(
            [[[m]]], [[m * g]], [[[1.0]]], [[w]], weight=weight, cost=cost, low=0.0, high=high, device="cpu"
        )
        assert found.control[0, 0] == pytest.approx(wanted, rel=1e-6)
        assert found.acceleration[0, 0] == pytest.approx(wanted / m - g, rel=1e-5)


def test_bounds_and_costs_of_each_programme_are_its_own():
    count = 3
    high = np.array([[0.1], [0.2], [0.3]])
    found = wm.quadratic_program(
        np.ones((count, 1, 1)), np.zeros((count, 1)), np.ones((count, 1, 1)), np.full((count, 1), 9.0), high=high,
        device="cpu",
    )  # fmt: skip
    assert found.control == pytest.approx(high)


BROKEN = {
    "symmetric": {"mass": [[[1.0, 0.5], [0.0, 1.0]]]},
    "mass must be positive definite": {"mass": [[[1.0, 2.0], [2.0, 1.0]]]},
    "weight must be positive definite": {"weight": [[1.0, 0.0]]},
    "bias has the shape": {"bias": [[1.0]]},
    "cost must be positive": {"cost": 0.0},
    "low must not be greater": {"low": 2.0},
    "not finite": {"wanted": [[np.nan, 0.0]]},
    "leaves no control": {"low": np.inf, "high": np.inf},
    "high has the shape": {"high": [1.0, 1.0]},
}


@pytest.mark.parametrize("said", BROKEN)
def test_what_cannot_be_solved_is_said(said):
    good = {"mass": [np.eye(2)], "bias": [[0.0, 0.0]], "forces": np.ones((1, 2, 3)), "wanted": [[0.0, 0.0]]}
    with pytest.raises(ArgumentError, match=said):
        wm.quadratic_program(**(good | BROKEN[said]), device="cpu")
