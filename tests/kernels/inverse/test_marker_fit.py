"""The fit of coordinates to markers against SciPy's least squares in float64, frame by frame."""

import numpy as np
import pytest
import warp as wp
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from leg_model import chain_of, leg, markers_of, walk
from warpmuscle.core.warp_start import start_warp
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse.fit_plan import (
    BEYOND,
    WORSE,
    Plan,
    Problem,
    Recorded,
    _may_outlie,
    _outlying,
    _spaced,
    _spaced_in_all,
)
from warpmuscle.inverse.marker_fit import MarkerFitter, _Run
from warpmuscle.inverse.recorded_markers import SUDDEN, FittedFrames, _Buffers
from warpmuscle.kernels.marker_fit_structs import FitFrames

AGREED = 2e-5  # rad or m, of float32


def problem_of(chain, values, noise=0.02, **more):
    markers = markers_of(chain, values, noise)
    weights = np.linspace(0.5, 3.0, len(markers.names))
    count = len(chain.coordinates)
    given = {"task_weights": np.zeros(count), "targets": np.array([chain.neutral]), **more}
    recorded = [Recorded(markers.positions @ TO_OPENSIM, list(range(len(weights))))]
    return Problem(recorded, weights, given["task_weights"], given["targets"])


def places_in(problem):
    """Positions of the only recording (F, K, 3)."""
    return problem.recordings[0].positions


def fitted(chain, problem):
    start_warp()
    return MarkerFitter(chain, list(chain.markers.values()), wp.get_device("cpu")).fit(problem)


def solved(chain, problem, frame, start):
    """Coordinates of a frame by SciPy, within their ranges."""
    places = list(chain.markers.values())
    seen = np.isfinite(places_in(problem)[frame]).all(axis=1)
    root = np.sqrt(problem.weights[seen])[:, None]
    beside = np.sqrt(problem.task_weights * problem.weights[seen].sum())  # of the mean of squares, as in Simbody

    def errors(q):
        at = chain.places(chain.poses(q[None]), places)[0]
        off = root * (places_in(problem)[frame] - at)[seen]
        return np.concatenate([off.ravel(), beside * (problem.targets[0] - q)])

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
    assert np.abs(found.errors - (places_in(problem) - places)).max() < 1e-5


def test_a_missing_marker_does_not_count(chain):
    values = walk(chain)
    problem = problem_of(chain, values)
    places_in(problem)[10, 5] = np.nan
    places_in(problem)[:, 9] = np.nan
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
    weights[[3, 7]] = 0.03, 0.1  # of a shift of the root and of a turn
    targets[0, [3, 7]] = 1.0, 0.4
    problem = problem_of(chain, values, task_weights=weights, targets=targets)
    places_in(problem)[11, 5] = np.nan  # which counts less there, and the target more
    found = fitted(chain, problem)
    free = fitted(chain, problem_of(chain, values))
    for frame in (0, 11):
        assert np.abs(found.values[frame] - solved(chain, problem, frame, values[frame])).max() < AGREED
        assert np.abs(found.values[frame] - free.values[frame]).max() > 0.05


def test_markers_that_miss_by_far_lead_to_a_minimum_yet(chain):
    values = walk(chain, 60, seed=5)
    problem = problem_of(chain, values, noise=0.2)  # m; without damped steps of Newton half of all did not converge
    found = fitted(chain, problem)
    assert (found.iterations < 0).mean() < 0.2
    for frame in np.flatnonzero(found.iterations > 20)[:3]:
        own = found.values[frame]
        assert np.abs(own - solved(chain, problem, frame, own)).max() < 50 * AGREED


def test_coordinates_that_no_marker_tells_stay_and_are_told(chain):
    values = walk(chain, 20)
    problem = problem_of(chain, values, noise=0.0)
    names = list(chain.markers)
    places_in(problem)[:, [k for k, name in enumerate(names) if name.startswith("foot")]] = np.nan
    found = fitted(chain, problem)
    ankle = chain.coordinates.index("ankle")
    assert found.loose[:, ankle].all()
    assert not np.delete(found.loose, ankle, axis=1).any()
    assert np.all(found.values[:, ankle] == chain.neutral[ankle])


def test_bits_do_not_depend_on_what_is_fitted_beside(chain):
    one, two = walk(chain, 37, seed=4), walk(chain, 90, seed=5)
    alone = [fitted(chain, problem_of(chain, values)) for values in (one, two)]
    first = problem_of(chain, one)
    recordings = [problem_of(chain, values).recordings[0] for values in (one, two, one)]
    others = np.full((len(recordings[1].positions), 2, 3), 7.0)  # markers that do not count, and another order
    count = len(first.weights)
    positions = np.concatenate([others, recordings[1].positions[:, ::-1]], axis=1)
    recordings[1] = Recorded(positions, [count + 1 - k for k in range(count)])
    found = fitted(chain, Problem(recordings, first.weights, first.task_weights, first.targets))
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
    problem = problem_of(chain, walk(chain))
    count = len(problem.weights)
    positions = places_in(problem) @ TO_OPENSIM.T
    positions[random.random(positions.shape[:2]) < 0.2] = np.nan
    positions[7, 2] = 3e5
    weights = np.where(np.arange(count) == 1, 0.0, problem.weights)
    parts = [slice(0, 11), slice(11, 12), slice(12, None)]
    recordings = [Recorded(positions[part], list(range(count))) for part in parts]
    turned = Problem(recordings, weights, problem.task_weights, problem.targets, TO_OPENSIM)
    fitter = MarkerFitter(chain, list(chain.markers.values()), wp.get_device("cpu"))
    recorded = fitter.recorded(turned)
    seen = np.isfinite(positions).all(axis=2)
    assert np.array_equal(recorded.seen, (seen & (weights > 0.0)).sum(axis=1))
    assert np.flatnonzero(recorded.far).tolist() == [7]
    positions[7, 2] = np.nan
    fit = fitter.fit(turned)
    sums = fit.sums
    places = chain.places(chain.poses(fit.values), list(chain.markers.values())) @ TO_OPENSIM.T
    assert np.nanmax(np.abs(fit.errors - (positions - places))) < 1e-5
    for k, part in enumerate(parts):
        known = np.isfinite(positions[part]).all(axis=2)
        assert np.array_equal(sums.seen[k], known.sum(axis=0))
        assert sums.squares[k] == pytest.approx(
            np.nansum(fit.errors[part].astype(np.float64) ** 2, axis=(0, 2)), rel=1e-12
        )
        squares = np.sum(fit.errors[part].astype(np.float64) ** 2, axis=2)
        most = np.nan_to_num(squares).max(axis=0)
        assert sums.most[k] == pytest.approx(most, rel=1e-12)
        assert np.array_equal(sums.near[k], (SUDDEN**2 * squares < most).sum(axis=0))
        assert sums.height[k] == pytest.approx(np.nansum(positions[part, :, 1], axis=0), rel=1e-12)


def test_bodies_are_aligned_as_by_singular_values(chain):
    start_warp()
    random = np.random.default_rng(8)
    problem = problem_of(chain, walk(chain, 6), noise=0.05)
    positions = places_in(problem)
    positions[2, 3:] = np.nan  # three markers, in a plane
    positions[3] = positions[3] * [1.0, 1.0, -1.0]  # a mirror image
    positions[4] += [30.0, 0.0, -7.0]
    turned = Problem(
        [Recorded(positions @ TO_OPENSIM.T, list(range(len(problem.weights))))], problem.weights,
        problem.task_weights, problem.targets, TO_OPENSIM,
    )  # fmt: skip
    fitter = MarkerFitter(chain, list(chain.markers.values()), wp.get_device("cpu"))
    recorded, body = fitter.recorded(turned), random.normal(size=(len(problem.weights), 3))
    order = recorded.order.numpy()
    number = wp.array(np.arange(6, dtype=np.int32), dtype=int, device="cpu")
    turn, shift = recorded.aligned(number, body[order])
    for frame in range(6):
        seen = np.isfinite(positions[frame]).all(axis=1)
        w = np.where(seen, problem.weights, 0.0) / problem.weights[seen].sum()
        there = np.nan_to_num(positions[frame])
        middle, own = w @ there, w @ body
        expected, *_ = Rotation.align_vectors(there[seen] - middle, body[seen] - own, w[seen])
        assert np.abs((Rotation.from_quat(turn[frame]) * expected.inv()).magnitude()) < 1e-6, frame
        assert shift[frame] == pytest.approx(middle - expected.apply(own), abs=1e-6)


def test_a_second_fit_is_kept_only_where_it_is_better(chain):
    start_warp()
    values = walk(chain, 5)
    problem = problem_of(chain, values)
    fitter = MarkerFitter(chain, list(chain.markers.values()), wp.get_device("cpu"))
    markers = fitter.recorded(problem)
    found = FittedFrames(markers, len(chain.coordinates), 3, 3)
    pulls = wp.array(0.5 * (np.arange(len(chain.coordinates)) == 2), dtype=wp.float64, device="cpu")

    def put(off, better):
        data, number = FitFrames(), wp.array(np.arange(5, dtype=np.int32), dtype=int, device="cpu")
        base = wp.zeros(5, dtype=wp.vec3d, device="cpu")
        markers.take(number, base, data)
        data.error = wp.array(off[:, None, None] * np.ones((1, markers.markers, 3)), dtype=wp.vec3, device="cpu")
        data.value = wp.array(np.tile(off[:, None], len(chain.coordinates)), dtype=float, device="cpu")
        data.target = wp.zeros(data.value.shape, dtype=float, device="cpu")
        data.iterations = wp.full(5, 7, dtype=int, device="cpu")
        data.loose = wp.zeros(data.value.shape, dtype=int, device="cpu")
        start = wp.full(data.value.shape, 100.0, dtype=wp.float64, device="cpu")
        found.put(number, start, data, pulls, better)

    put(np.array([1.0, 2.0, 3.0, 4.0, 5.0]), better=False)
    put(np.array([2.0, 1.0, 3.0, 5.0, 0.5]), better=True)
    best = [1.0, 1.0, 3.0, 4.0, 0.5]
    kept, errors, iterations, loose = found.found()
    assert found.squares == pytest.approx(3.5 * np.square(best))
    assert kept[:, 0] == pytest.approx(best)
    assert kept[:, 4] == pytest.approx(np.add(best, 100.0))  # a shift of the root
    assert errors[:, 2, 1] == pytest.approx(best)
    assert (iterations == 7).all()
    assert not loose.any()


def test_jumps_between_frames_are_those_of_numpy(chain):
    start_warp()
    values = walk(chain, 30)
    values[17:, chain.coordinates.index("ankle")] += 1.0
    fitter = MarkerFitter(chain, list(chain.markers.values()), wp.get_device("cpu"))
    found = FittedFrames(fitter.recorded(problem_of(chain, values)), len(chain.coordinates), 3, 3)
    found.values.assign(values)
    turns = [k for k in range(6, len(chain.coordinates)) if fitter.turns[k]]
    expected = np.abs(np.diff(values[:, turns], axis=0)).max(axis=1)
    assert found.jumps(6, fitter.turns) == pytest.approx(np.concatenate([[0.0], expected]))
    assert expected.argmax() == 16


def test_the_worse_side_of_a_jump_is_fitted_again_from_the_other_side():
    positions = [np.zeros((count, 3, 3)) for count in (40, 25, 7)]
    problem = Problem([Recorded(one, [0, 1, 2]) for one in positions], np.ones(3), np.zeros(1), np.zeros((1, 1)))
    plan = Plan(problem, np.full(72, 3))
    turned, squares = np.zeros(72), np.full(72, 1.0)
    turned[[10, 14, 40, 62, 65]] = 1.0  # 40 and 65 begin recordings
    squares[10:14] = squares[62:65] = 2.0
    frames, others = plan.jumped(squares, turned)
    assert frames.tolist() == [10, 11, 12, 13, 62, 63, 64]
    assert set(others[:4].tolist()) <= {9, 14}
    assert others[4:].tolist() == [61, 61, 61]
    assert [len(one) for one in plan.jumped(squares, np.zeros(72))] == [0, 0]


def test_an_arm_that_came_to_bend_the_wrong_way_is_bent_back(chain):
    values = walk(chain, 33)
    problem = problem_of(chain, values, noise=0.0)
    start_warp()
    fitter = MarkerFitter(chain, list(chain.markers.values()), wp.get_device("cpu"))
    recorded = fitter.recorded(problem)
    run = _Run(fitter, problem, recorded)
    plan = Plan(problem, recorded.seen)
    run.from_afar(plan.first, plan.coarse)
    run.between(plan.rest, plan.between())
    right, kept = run.found.values.numpy().copy(), run.found.values.numpy()
    kept[20:24, chain.coordinates.index("ankle")] += 1.0
    run.found.values.assign(kept)
    run.found._squares.assign(np.where((np.arange(33) >= 20) & (np.arange(33) < 24), 1.0, run.found.squares))
    run.from_others(*plan.jumped(run.found.squares, run.jumps()))
    assert np.abs(run.found.values.numpy() - right).max() < AGREED


def test_frames_that_fit_badly_are_told_from_the_median_of_their_recording():
    random = np.random.default_rng(2)
    parts = [random.lognormal(-7.0, 2.0, count) for count in (1, 2, 7, 10, 33)]
    found = [_outlying(part) for part in parts]
    for own, part in zip(found, parts, strict=True):
        assert np.array_equal(own, part > WORSE * np.median(part) + BEYOND)
    assert np.concatenate(found).any()


def test_frames_of_many_recordings_are_chosen_as_of_each():
    random = np.random.default_rng(8)
    counts = np.array([1, 2, 16, 17, 18, 33, 5, 160])
    ends = np.cumsum(counts)
    starts = ends - counts
    for part in (1.0, 0.7):
        good = random.uniform(size=ends[-1]) < part
        good[starts] = True
        each = [_spaced(good, first, end) for first, end in zip(starts.tolist(), ends.tolist(), strict=True)]
        found = _spaced_in_all(good, starts, ends)
        assert [one.tolist() for one in found] == [one.tolist() for one in each]


def test_recordings_without_far_values_are_passed_over_and_no_others():
    random = np.random.default_rng(9)
    starts = np.arange(0, 4000, 40)
    squares = random.lognormal(-8.0, np.repeat(random.uniform(0.1, 1.5, 100), 40))
    outlying = [k for k, first in enumerate(starts) if _outlying(squares[first : first + 40]).any()]
    looked_at = _may_outlie(squares, starts).tolist()
    assert set(outlying) <= set(looked_at)
    assert 10 < len(outlying) < len(looked_at) < 100


@pytest.mark.parametrize("room", [4, 7, 100])
def test_rows_come_through_two_buffers_in_order(room, monkeypatch):
    """With copies that are late, as on a GPU: a buffer that is filled too soon would be seen."""
    start_warp()
    found = wp.zeros((23, 2), dtype=wp.vec3d, device="cpu")
    buffers, late, rows = _Buffers(found, room, 2), [], np.arange(23 * 6.0).reshape(23, 2, 3)
    buffers._on_cpu, buffers._events = False, [None, None]
    buffers._arrays = [wp.zeros((room, 2), dtype=wp.vec3d, device="cpu") for _ in range(2)]
    buffers._views = [one.numpy() for one in buffers._arrays]

    def copy(*arguments, **named):
        late.append((wp_copy, arguments, named))

    class Stream:
        def record_event(self):
            return len(late)

    def wait(event):
        for work, arguments, named in late[:event]:
            work(*arguments, **named)
        late[:event] = [(lambda *_, **__: None, (), {})] * event

    wp_copy = wp.copy
    monkeypatch.setattr(wp, "copy", copy)
    monkeypatch.setattr(wp, "get_stream", lambda device: Stream())
    monkeypatch.setattr(wp, "synchronize_event", wait)
    for part in (rows[:5], rows[5:6], rows[6:]):
        first = 0
        while first < len(part):
            place = buffers.place(len(part) - first)
            place[:] = part[first : first + len(place)]
            buffers.filled(len(place))
            first += len(place)
    buffers.finish()
    assert found.numpy().tolist() == rows.tolist()
