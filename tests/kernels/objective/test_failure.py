"""When an instance has failed."""

import numpy as np
import warp as wp
from probes import evaluate, filled

from warpmuscle.kernels.objective.failure import (
    begin_step,
    has_fallen,
    has_turned,
    nearest_on_the_way,
    posture_status,
    progress_status,
    remember_place,
)
from warpmuscle.kernels.structs import (
    CROSSED,
    DIVERGED,
    FELL,
    RUNNING,
    STOPPED,
    TURNED,
    Contacts,
    Feet,
    Model,
    Scratch,
    State,
)


@wp.kernel(enable_backward=False)
def stand(
    model: Model, state: State, orientation: wp.array2d[wp.quat], position: wp.array2d[wp.vec3],
    center: wp.array2d[wp.vec3], status: wp.array[int],
):  # fmt: skip
    i = wp.tid()
    work = Scratch()
    work.orientation = orientation[i]
    work.position = position[i]
    work.center = center[i]
    status[i] = posture_status(i, model, state, work)


def standing(
    yaw: list[float], feet: list[float] | None = None, height: list[float] | None = None, speed: float = 1.0,
    controlled: int = 0, wanted: float = 0.0, **limits: float,
) -> list[int]:  # fmt: skip
    """Status of instances that face so, whose left foot is so far to the left, with their COM so high; start: 0.2 rad.

    The body that is not the root faces another way.
    """
    count = len(yaw)
    half = 0.5 * np.stack([np.array(yaw), np.full(count, 2.5), np.full(count, -2.0)], axis=1)
    orientation = np.stack([0.0 * half, np.sin(half), 0.0 * half, np.cos(half)], axis=-1)
    position = np.ones((count, 3, 3))
    left = np.stack([np.cos(yaw), np.zeros(count), -np.sin(yaw)], axis=1)
    position[:, 1] += left * np.array(feet if feet is not None else [0.2] * count)[:, None]
    center = np.zeros((count, 2, 3))
    center[:, 0, 1], center[:, 1, 2] = height if height is not None else [1.0] * count, speed
    names = ("com_height", "heading", "max_speed", "leg_crossing", "no_progress", "no_progress_window")
    model = filled(
        Model, fastest=9.0, failure={name: [[limits.get(name, 0.0)]] for name in names},
        feet=filled(Feet, left=1, right=2),
        turns_from_start=1 - controlled, heading=[[wanted]],
        contacts=filled(Contacts, normal=[[[0.0, 1.0, 0.0]]], height=[[0.0]]),
    )  # fmt: skip
    state = filled(State, start_height=np.ones(count), start_heading=np.full(count, 0.2))
    given = [
        wp.array(np.float32(values), dtype=kind, device="cpu")
        for values, kind in ((orientation, wp.quat), (position, wp.vec3), (center, wp.vec3))
    ]
    status = wp.zeros(count, dtype=int, device="cpu")
    wp.launch(stand, count, [model, state, *given, status], device="cpu")
    return status.numpy().tolist()


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


def test_the_root_turns_away_from_its_first_heading_or_from_the_desired_one():
    yaw = [0.2, 0.9, -0.5, 1.1, -0.7, 3.0, np.nan]
    assert standing(yaw, heading=0.8) == [RUNNING] * 3 + [TURNED] * 4
    towards = standing([0.2, 1.0, 1.9, 2.1, -0.7], heading=0.8, controlled=1, wanted=1.2)
    assert towards == [RUNNING, RUNNING, RUNNING, TURNED, TURNED]  # on the way from 0.2 to 1.2 nobody is off it
    assert standing(yaw[:6]) == [RUNNING] * 6  # without a limit


def test_legs_cross_by_how_far_the_left_foot_is_to_the_right_as_the_root_faces():
    apart = [0.2, 0.0, -0.04, -0.06, -0.5]
    for yaw in (0.0, 1.0, -2.0):
        assert standing([yaw] * 5, apart, leg_crossing=0.05) == [RUNNING] * 3 + [CROSSED] * 2
    assert standing([0.0] * 5, apart) == [RUNNING] * 5


def test_who_is_low_has_fallen_and_who_is_nowhere_or_too_fast_has_diverged():
    assert standing([0.0] * 3, height=[0.95, 0.85, np.nan], com_height=0.9) == [RUNNING, FELL, DIVERGED]
    assert standing([0.0], speed=8.9) == [RUNNING]
    assert standing([0.0], speed=9.1) == standing([0.0], speed=np.nan) == [DIVERGED]


@wp.kernel(enable_backward=False)
def begin(
    model: Model, state: State, orientation: wp.array2d[wp.quat], center: wp.array2d[wp.vec3], flags: wp.array2d[int],
    step: wp.array[int],
):  # fmt: skip
    i = wp.tid()
    work = Scratch()
    work.orientation = orientation[i]
    work.center = center[i]
    work.flags = flags[i]
    begin_step(i, step[i], model, state, work)


def test_the_height_and_heading_of_the_first_step_are_remembered_and_those_of_others_not():
    """Above ground at 0.1 m; in no step has anything diverged yet."""
    half = 0.5 * np.array([0.6, 0.9])
    orientation = np.stack([0.0 * half, np.sin(half), 0.0 * half, np.cos(half)], axis=-1)[:, None]
    model = filled(Model, contacts=filled(Contacts, normal=[[[0.0, 1.0, 0.0]]], height=[[0.1]]))
    state = filled(State, start_height=np.full(2, 0.7), start_heading=np.full(2, 0.2))
    center, flags = np.zeros((2, 2, 3)), wp.array(np.ones((2, 2)), dtype=int, device="cpu")
    center[:, 0, 1] = 1.0
    given = [
        wp.array(np.float32(values), dtype=kind, device="cpu")
        for values, kind in ((orientation, wp.quat), (center, wp.vec3))
    ]
    wp.launch(begin, 2, [model, state, *given, flags, wp.array([0, 3], dtype=int, device="cpu")], device="cpu")
    np.testing.assert_allclose(state.start_height.numpy(), [0.9, 0.7], rtol=1e-6)
    np.testing.assert_allclose(state.start_heading.numpy(), [0.6, 0.2], rtol=1e-6)
    assert flags.numpy().tolist() == [[1, 0], [1, 0]]
