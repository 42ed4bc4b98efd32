"""NLopt turned inside out against NLopt called directly."""

import gc
import subprocess
import sys
import threading

import nlopt
import numpy as np
import pytest

from patience import PATIENCE, until
from search.functions import FUNCTIONS, rosenbrock, run, sphere, start_of
from warpmuscle.core.errors import Error
from warpmuscle.search.differences import gradient, stencil
from warpmuscle.search.nlopt import NloptSearch, algorithms
from warpmuscle.search.strategies import make_search

UNAVAILABLE = "LD_LBFGS_NOCEDAL"  # no build has it


def direct(algorithm, function, start, seed, evaluations):
    """Points that NLopt visits alone."""
    visited = []

    def objective(x, slope):
        visited.append(x.copy())
        return float(function(x[np.newaxis])[0])

    nlopt.srand(seed)
    optimizer = nlopt.opt(getattr(nlopt, algorithm), len(start))
    optimizer.set_lower_bounds(np.zeros(len(start)))
    optimizer.set_upper_bounds(np.ones(len(start)))
    optimizer.set_xtol_abs(1e-9)
    optimizer.set_maxeval(evaluations)
    optimizer.set_min_objective(objective)
    optimizer.optimize(start)
    return np.array(visited)


@pytest.mark.parametrize("dimensions", [10, 50])
@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("algorithm", ["LN_BOBYQA", "LN_SBPLX", "LN_COBYLA", "GN_CRS2_LM", "GN_ESCH", "GN_DIRECT_L"])
def test_visits_what_nlopt_visits(algorithm, function, dimensions):
    evaluations = 300
    expected = direct(algorithm, function, start_of(dimensions), 5, evaluations)
    search = NloptSearch(algorithm, start_of(dimensions), 5)
    visited = np.concatenate(run(search, function, evaluations))
    count = min(len(visited), len(expected))
    np.testing.assert_array_equal(visited[:count], np.clip(expected[:count], 0.0, 1.0))
    assert count == evaluations or search.finished()


@pytest.mark.parametrize("dimensions", [10, 50])
@pytest.mark.parametrize("algorithm", ["LD_LBFGS", "LD_SLSQP", "LD_CCSAQ", "LD_TNEWTON_PRECOND_RESTART"])
def test_differences_lead_where_gradients_lead(algorithm, dimensions):
    search = NloptSearch(algorithm, start_of(dimensions), 1)
    batches = run(search, sphere, 100 * (2 * dimensions + 1))
    assert {len(batch) for batch in batches} <= {1, 2 * dimensions + 1}
    assert search.state()["best_cost"] < 1e-9
    assert search.finished()


def test_follows_a_curved_valley_with_differences():
    search = NloptSearch("LD_LBFGS", np.full(10, 0.55), 1)
    run(search, rosenbrock, 21 * 300)
    assert search.state()["best_cost"] < 1e-4


@pytest.mark.parametrize("algorithm", [name for name in algorithms() if name != UNAVAILABLE])
def test_every_algorithm_is_deterministic_also_interleaved(algorithm):
    start, other = start_of(4), np.full(4, 0.7)
    alone = run(NloptSearch(algorithm, start, 3), sphere, 60)
    first, second = NloptSearch(algorithm, start, 3), NloptSearch(algorithm, other, 4)
    for expected in alone:
        np.testing.assert_array_equal(first.ask(), expected)
        assert np.all((expected >= 0.0) & (expected <= 1.0))
        first.tell(sphere(expected))
        np.random.default_rng()
        if not second.finished():
            second.tell(sphere(second.ask()))


@pytest.mark.parametrize(
    "algorithm",
    [
        pytest.param(name, marks=pytest.mark.long if number % 5 else ())
        for number, name in enumerate(algorithms())
        if name != UNAVAILABLE
    ],
)
def test_threads_end_when_searches_are_dropped(algorithm):
    gc.collect()
    before = set(threading.enumerate())
    for evaluations in (0, 1, 13, 40, 150):
        search = NloptSearch(algorithm, start_of(4), 3)
        run(search, rosenbrock, evaluations)
        del search
        until(lambda: set(threading.enumerate()) <= before)


def test_the_program_ends_with_searches_open():
    program = "from warpmuscle.search.strategies import make_searches as m; s = m('nlopt:LN_BOBYQA', 5, None, 1, 20)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, timeout=PATIENCE, check=True)
    assert done.stderr == b""


def test_gradients_are_exact_for_parabolas_also_at_faces():
    point = np.array([0.0, 0.5, 1.0, 5e-5, 1.0 - 5e-5])
    points, offsets = stencil(point, 1e-4)
    assert points.shape == (11, 5)
    assert np.all((points >= 0.0) & (points <= 1.0))
    values = np.sum((points - 0.3) ** 2, axis=1)
    np.testing.assert_allclose(gradient(values, offsets), 2.0 * (point - 0.3), atol=1e-10)


def test_population_and_initial_step_reach_nlopt():
    search = NloptSearch("LN_BOBYQA", np.full(3, 0.5), 1, sigma=0.1)
    points = np.concatenate(run(search, sphere, 4))
    assert np.max(np.abs(points - 0.5)) == pytest.approx(0.1)
    few, many = (
        np.concatenate(run(NloptSearch("GN_CRS2_LM", start_of(3), 1, population=n), sphere, 300)) for n in (10, 200)
    )
    assert not np.array_equal(few, many)


@pytest.mark.parametrize("algorithm", ["GD_STOGO", "LN_NEWUOA_BOUND"])
def test_algorithms_that_cannot_be_interrupted_are_refused(algorithm):
    with pytest.raises(Error, match="interrupted"):
        make_search(f"nlopt:{algorithm}", 3, None, 1)


@pytest.mark.parametrize(
    ("algorithm", "settings", "text"),
    [
        ("LN_NOTHING", {}, "no algorithm"),
        (UNAVAILABLE, {}, "cannot search 2 parameters"),
        ("LD_LBFGS", {"gradient_step": 0.0}, "gradient"),
        ("GN_ISRES", {"population": 0}, "at least 1"),
        ("LN_BOBYQA", {"sigma": -1.0}, "sigma must be above 0"),
    ],
)
def test_settings_that_cannot_be_used(algorithm, settings, text):
    with pytest.raises(Error, match=text):
        NloptSearch(algorithm, [0.5, 0.5], 1, **settings)
