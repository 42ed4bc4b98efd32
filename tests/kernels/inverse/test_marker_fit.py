"""The fit of coordinates to markers against SciPy's least squares in float64, frame by frame."""

import numpy as np
import pytest
import warp as wp
from scipy.optimize import least_squares

from leg_model import chain_of, leg, markers_of, walk
from warpmuscle.core.warp_start import start_warp
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse.fit_plan import BEYOND, WORSE, Problem, _outlying
from warpmuscle.inverse.marker_fit import MarkerFitter

AGREED = 2e-5  # rad or m, of float32


def problem_of(chain, values, noise=0.02, starts=(0,), **more):
    markers = markers_of(chain, values, noise)
    weights = np.linspace(0.5, 3.0, len(markers.names))
    count = len(chain.coordinates)
    given = {"task_weights": np.zeros(count), "targets": np.array([chain.neutral]), **more}
    return Problem(markers.positions @ TO_OPENSIM, weights, starts, given["task_weights"], given["targets"])


def fitted(chain, problem):
    start_warp()
    return MarkerFitter(chain, list(chain.markers.values()), wp.get_device("cpu")).fit(problem)


def solved(chain, problem, frame, start):
    """Coordinates of a frame by SciPy, within their ranges."""
    places = list(chain.markers.values())
    seen = np.isfinite(problem.positions[frame]).all(axis=1)
    root = np.sqrt(problem.weights[seen])[:, None]

    def errors(q):
        at = chain.places(chain.poses(q[None]), places)[0]
        off = root * (problem.positions[frame] - at)[seen]
        return np.concatenate([off.ravel(), np.sqrt(problem.task_weights) * (problem.targets[0] - q)])

    low, high = np.array(chain.low), np.array(chain.high)
    inside = np.clip(start, low + 1e-6, high - 1e-6)
    return least_squares(errors, inside, bounds=(low, high), xtol=1e-14, ftol=1e-14, gtol=1e-13).x


@pytest.fixture(scope="module")
def chain(tmp_path_factory):
    return chain_of(leg(tmp_path_factory.mktemp("leg")))


def test_exact_markers_give_the_coordinates_back(chain):
    values = walk(chain)
    found = fitted(chain, problem_of(chain, values, noise=0.0))
    assert np.abs(found.values - values).max() < AGREED
    assert np.abs(found.errors).max() < 1e-5
    assert found.iterations.min() > 0


def test_noisy_markers_of_several_weights_give_the_least_squares(chain):
    values = walk(chain)
    problem = problem_of(chain, values)
    found = fitted(chain, problem)
    for frame in (0, 7, 16, 39):
        assert np.abs(found.values[frame] - solved(chain, problem, frame, values[frame])).max() < AGREED
    places = chain.places(chain.poses(found.values), list(chain.markers.values()))
    assert np.abs(found.errors - (problem.positions - places)).max() < 1e-5


def test_a_missing_marker_does_not_count(chain):
    values = walk(chain)
    problem = problem_of(chain, values)
    problem.positions[10, 5] = np.nan
    problem.positions[:, 9] = np.nan
    found = fitted(chain, problem)
    assert np.abs(found.values[10] - solved(chain, problem, 10, values[10])).max() < AGREED
    assert np.isnan(found.errors[10, 5]).all()


def test_ranges_hold_as_in_bounded_least_squares(chain):
    knee, ankle = chain.coordinates.index("knee"), chain.coordinates.index("ankle")
    values = walk(chain)
    values[:, knee] += 0.9  # beyond 0.2 in many frames
    values[:, ankle] -= 0.6
    problem = problem_of(chain, values, noise=0.01)
    found = fitted(chain, problem)
    held = np.flatnonzero((found.values[:, knee] == np.float32(0.2)) | (found.values[:, ankle] == np.float32(-0.7)))
    assert len(held) > 10
    assert found.values[:, knee].max() <= np.float32(0.2)
    for frame in held[::5]:
        assert np.abs(found.values[frame] - solved(chain, problem, frame, values[frame])).max() < 10 * AGREED


def test_a_target_pulls_with_its_weight(chain):
    values = walk(chain, 20)
    weights, targets = np.zeros(len(chain.coordinates)), np.array([chain.neutral])
    weights[[3, 7]] = 0.3, 2.0  # of a shift of the root and of a turn
    targets[0, [3, 7]] = 1.0, 0.4
    problem = problem_of(chain, values, task_weights=weights, targets=targets)
    found = fitted(chain, problem)
    free = fitted(chain, problem_of(chain, values))
    for frame in (0, 11):
        assert np.abs(found.values[frame] - solved(chain, problem, frame, values[frame])).max() < AGREED
        assert np.abs(found.values[frame] - free.values[frame]).max() > 0.05


def test_coordinates_that_no_marker_tells_stay_and_are_told(chain):
    values = walk(chain, 20)
    problem = problem_of(chain, values, noise=0.0)
    names = list(chain.markers)
    problem.positions[:, [k for k, name in enumerate(names) if name.startswith("foot")]] = np.nan
    found = fitted(chain, problem)
    ankle = chain.coordinates.index("ankle")
    assert found.loose[:, ankle].all()
    assert not np.delete(found.loose, ankle, axis=1).any()
    assert np.all(found.values[:, ankle] == chain.neutral[ankle])


def test_bits_do_not_depend_on_what_is_fitted_beside(chain):
    one, two = walk(chain, 37, seed=4), walk(chain, 90, seed=5)
    alone = [fitted(chain, problem_of(chain, values)) for values in (one, two)]
    positions = np.concatenate([problem_of(chain, values).positions for values in (one, two, one)])
    first = problem_of(chain, one)
    both = Problem(positions, first.weights, (0, 37, 127), first.task_weights, first.targets)
    found = fitted(chain, both)
    for name in ("values", "errors", "iterations"):
        parts = np.split(getattr(found, name), [37, 127])
        for part, expected in zip(parts, (*alone, alone[0]), strict=True):
            assert part.tobytes() == getattr(expected, name).tobytes(), name


@pytest.mark.parametrize("heading", [0.0, 1.6, 3.1, -2.4])
def test_the_subject_may_face_anywhere_and_lie_down(chain, heading):
    values = walk(chain, 10)
    values[:, chain.coordinates.index("turn")] = heading
    values[:, chain.coordinates.index("tilt")] = -1.5  # lies
    problem = problem_of(chain, values, noise=0.0)
    found = fitted(chain, problem)
    assert np.abs(found.errors).max() < 1e-4


def test_sums_of_recordings_are_those_of_numpy(chain):
    start_warp()
    random = np.random.default_rng(5)
    problem = problem_of(chain, walk(chain), starts=(0, 11, 12))
    count = len(problem.weights)
    positions = problem.positions @ TO_OPENSIM.T
    positions[random.random(positions.shape[:2]) < 0.2] = np.nan
    positions[7, 2] = 3e5
    weights = np.where(np.arange(count) == 1, 0.0, problem.weights)
    turned = Problem(positions, weights, problem.starts, problem.task_weights, problem.targets, TO_OPENSIM)
    fitter = MarkerFitter(chain, list(chain.markers.values()), wp.get_device("cpu"))
    recorded = fitter.recorded(turned)
    seen = np.isfinite(positions).all(axis=2)
    assert np.array_equal(recorded.seen, (seen & (weights > 0.0)).sum(axis=1))
    assert np.flatnonzero(recorded.far).tolist() == [7]
    positions[7, 2] = np.nan
    turned = Problem(positions, weights, problem.starts, problem.task_weights, problem.targets, TO_OPENSIM)
    recorded = fitter.recorded(turned)
    fit, sums = fitter.fit(turned, recorded), recorded.sums(turned.starts)
    places = chain.places(chain.poses(fit.values), list(chain.markers.values())) @ TO_OPENSIM.T
    assert np.nanmax(np.abs(fit.errors - (positions - places))) < 1e-5
    for k, part in enumerate((slice(0, 11), slice(11, 12), slice(12, None))):
        known = np.isfinite(positions[part]).all(axis=2)
        assert np.array_equal(sums.seen[k], known.sum(axis=0))
        assert sums.squares[k] == pytest.approx(np.nansum(fit.errors[part] ** 2, axis=(0, 2)), rel=1e-12)
        assert sums.height[k] == pytest.approx(np.nansum(positions[part, :, 1], axis=0), rel=1e-12)


def test_frames_that_fit_badly_are_told_from_the_median_of_their_recording():
    random = np.random.default_rng(2)
    counts = [1, 2, 7, 10, 33]
    ends = np.cumsum(counts)
    squares = random.lognormal(-7.0, 2.0, ends[-1])
    found = np.split(_outlying(squares, ends - counts, ends), ends[:-1])
    for own, part in zip(found, np.split(squares, ends[:-1]), strict=True):
        assert np.array_equal(own, part > WORSE * np.median(part) + BEYOND)
    assert np.concatenate(found).any()
