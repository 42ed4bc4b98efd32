"""When an instance has failed."""

import numpy as np
import warp as wp
from probes import evaluate, filled

from warpmuscle.kernels.failure import has_fallen, has_turned, nearest_on_the_way, progress_status, remember_place
from warpmuscle.kernels.structs import RUNNING, STOPPED, Model, Scratch, State


@wp.kernel(enable_backward=False)
def go_on(model: Model, state: State, center: wp.array2d[wp.vec3], step: wp.array[int], status: wp.array[int]):
    i = wp.tid()
    work = Scratch()
    work.center = center[i]
    status[i] = progress_status(i, step[i], model, state, work)
    remember_place(i, step[i], model, state, work)


def gone_on(slowest: float, way: np.ndarray, step: np.ndarray) -> tuple[list[int], np.ndarray]:
    """Status and kept places of instances that went a way (n, 3), m, since (1, 2, 3), in windows of 50 steps."""
    start = np.array([1.0, 2.0, 3.0])
    limits = {"no_progress": [[slowest]], "no_progress_window": [[0.5]]}
    model = filled(Model, time_step=0.01, failure=limits)
    state = filled(State, passed=np.float32(np.tile(start, (len(way), 1))))
    center = wp.array(np.float32((start + way)[:, None]), dtype=wp.vec3, device="cpu")
    status = wp.zeros(len(way), dtype=int, device="cpu")
    steps = wp.array(np.int32(step), dtype=int, device="cpu")
    wp.launch(go_on, len(way), [model, state, center, steps, status], device="cpu")
    return status.numpy().tolist(), state.passed.numpy() - start


def test_fallen_is_below_a_fraction_of_the_first_height_or_not_a_number():
    height = np.array([1.0, 0.91, 0.9, 0.89, -1.0, np.nan])
    assert evaluate(has_fallen, height, 1.0, 0.9).tolist() == [0, 0, 0, 1, 1, 1]


def test_turned_is_too_far_from_the_desired_heading_on_the_shorter_way():
    angle, desired = np.array([0.0, 0.7, -0.7, 0.9, -0.9, 3.1, -3.1, 3.1]), np.array([0.0] * 6 + [3.1, 0.0])
    assert evaluate(has_turned, angle, desired, 0.8).tolist() == [0, 0, 0, 1, 1, 1, 0, 1]


def test_without_a_largest_turn_nobody_has_turned():
    assert evaluate(has_turned, np.array([3.0, np.nan]), 0.0, 0.0).tolist() == [0, 0]
    assert evaluate(has_turned, np.array([np.nan]), 0.0, 0.8).tolist() == [1]


def test_whole_revolutions_are_no_turn_and_the_rest_of_several_is():
    turns = np.array([-5.0, -2.0, -1.0, 1.0, 2.0, 7.0]) * 2.0 * np.pi
    assert not any(evaluate(has_turned, np.full(6, 0.3), 0.3 + turns, 0.8))
    assert all(evaluate(has_turned, np.full(6, 0.3), 1.3 + turns, 0.8))
    assert all(evaluate(has_turned, np.full(6, -2.9), 2.4 + turns, 0.8))
    assert not any(evaluate(has_turned, np.full(6, -2.9), 2.8 + turns, 0.8))


def test_on_the_way_to_the_desired_heading_nobody_is_off_it():
    angle = np.array([0.0, 1.0, 2.0, 3.0, -1.0, -3.0])
    found = evaluate(nearest_on_the_way, angle, 0.0, 2.0)
    np.testing.assert_allclose(found, [0.0, 1.0, 2.0, 2.0, 0.0, 0.0], atol=1e-6)
    back = evaluate(nearest_on_the_way, np.array([3.0, -3.0, -2.0, 2.0]), 2.9, -2.9 - 2.0 * np.pi)
    np.testing.assert_allclose(np.cos(back - [3.0, -3.0, -2.9, 2.9]), 1.0, atol=1e-6)


def test_who_goes_less_far_over_the_ground_in_a_window_than_it_must_has_stopped():
    """At 0.4 m/s 0.2 m in half a second, wherever to; upwards is no progress."""
    far, near = 0.21, 0.19
    ways = [(far, 0, 0), (0, 0, -far), (-0.15, 0, 0.15), (near, 0, 0), (0, 0, near), (0, 5.0, 0), (-0.1, 0.3, 0.1)]
    status, _ = gone_on(0.4, np.array(ways), np.full(7, 50))
    assert status == [RUNNING] * 3 + [STOPPED] * 4
    fast, _ = gone_on(3.0, np.array([(1.6, 0, 0), (1.4, 0, 0), (np.nan, 0, 0)]), np.full(3, 100))
    assert fast == [RUNNING, STOPPED, STOPPED]


def test_progress_counts_at_the_ends_of_windows_alone_and_from_their_beginnings():
    way, steps = np.tile([0.01, 0.0, 0.02], (6, 1)), np.array([0, 1, 49, 50, 51, 150])
    status, passed = gone_on(0.4, way, steps)
    assert status == [RUNNING, RUNNING, RUNNING, STOPPED, RUNNING, STOPPED]
    np.testing.assert_allclose(passed, way * np.isin(steps, [0, 50, 150])[:, None], atol=1e-6)
    assert gone_on(0.0, way, steps)[0] == [RUNNING] * 6
