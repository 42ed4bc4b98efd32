"""Where instances stand: by itself, without any step being simulated."""

from dataclasses import replace

import numpy as np
import pytest

from small_scene import muscle_scene
from warpmuscle.core.arrays import named_arrays
from warpmuscle.core.status import Status
from warpmuscle.model.state import state_struct
from warpmuscle.model.structure import structure_of
from warpmuscle.simulation.batch_state import KEPT, BatchState, InitialValues
from warpmuscle.simulation.extensions import Extensions
from warpmuscle.simulation.perturbations import none

N, STEPS = 4, 100
LAYOUTS = pytest.mark.parametrize("side_by_side", [False, True])  # as on a CPU, and as where paths are long on a GPU


def batch(side_by_side: bool = False) -> BatchState:
    scene = muscle_scene()
    structure = structure_of(scene)
    state = state_struct(scene, structure, N, "cpu", side_by_side)
    return BatchState(state, Extensions(structure, N, "cpu"), STEPS)


def initial(state: BatchState, seed: int = 0, rows: int = N) -> InitialValues:
    """Random values, rows of activations and accelerations."""
    random, s = np.random.default_rng(seed), state.state

    def some(*shape: int) -> np.ndarray:
        return random.normal(size=shape).astype(np.float32)

    speeds = s.speeds.shape[1]
    return InitialValues(
        some(N, s.coordinates.shape[1]), some(N, speeds), some(rows, speeds), some(rows, s.muscles.activation.shape[1]),
        {"simbicon.stance": 1, "simbicon.machine_state": 2},
    )  # fmt: skip


def arrays(batch: BatchState) -> dict[str, np.ndarray]:
    return {name: array.numpy() for name, array in named_arrays(batch.state)}


def spoil(batch: BatchState) -> None:
    """Other values in all arrays."""
    for name, array in named_arrays(batch.state):
        if name not in KEPT:
            array.assign(np.ones(array.shape + array.numpy().shape[array.ndim :], dtype=array.numpy().dtype))


@LAYOUTS
def test_instances_of_a_mask_get_the_bits_of_a_batch_that_restarts_as_a_whole(side_by_side: bool):
    for rows in (1, N):
        one, other = batch(), batch(side_by_side)
        values = initial(one, 3, rows)
        for state in (one, other):
            spoil(state)
        one.restart(values)
        spoiled, mask = arrays(other), np.array([True, False, True, False])
        other.restart_some(mask, values)
        for name, array in arrays(other).items():
            if len(array) == N:
                whole = arrays(one)[name]
                assert array[mask].tobytes() == whole[mask].tobytes(), name
                assert array[~mask].tobytes() == spoiled[name][~mask].tobytes(), name


def test_rows_of_other_initial_values_are_not_those_kept():
    state = batch()
    first, second = initial(state, 1), initial(state, 2)
    mask = np.array([True, False, False, False])
    for values in (first, second, first):
        state.restart_some(mask, values)
        np.testing.assert_array_equal(state.state.speeds.numpy()[0], values.speeds[0])


def test_instances_that_fail_stop_and_those_at_their_end_complete():
    state = batch()
    state.restart(initial(state))
    assert state.next_end == STEPS
    state.state.status.assign(np.array([0, Status.FELL, 0, 0], dtype=np.int32))
    state.came_to(30)
    assert state.running.tolist() == [0, 2, 3]
    state.restart_some(np.array([False, False, False, True]), initial(state))
    assert (state.begun.tolist(), state.next_end) == ([0, 0, 0, 30], STEPS)
    state.came_to(STEPS)
    state.complete()
    assert state.state.status.numpy().tolist() == [Status.COMPLETED, Status.FELL, Status.COMPLETED, Status.RUNNING]
    assert (state.running.tolist(), state.next_end) == ([3], STEPS + 30)


@LAYOUTS
def test_a_snapshot_brings_everything_back(side_by_side: bool):
    state = batch(side_by_side)
    state.restart(initial(state))
    state.came_to(7)
    before, snapshot = arrays(state), state.snapshot()
    spoil(state)
    state.came_to(50)
    assert len(state.running) == 0
    state.restore(snapshot)
    assert (state.steps_done, state.running.tolist()) == (7, [0, 1, 2, 3])
    assert {name: array.tobytes() for name, array in arrays(state).items()} == {
        name: array.tobytes() for name, array in before.items()
    }


def test_a_push_is_an_impulse_over_whole_steps():
    state, impulse = batch(), np.arange(3.0 * N).reshape(N, 3)
    state.push(replace(none(N), push=impulse, push_start=np.array([0.0, 0.01, 0.0149, 1.0])), 0.01)
    assert state.state.push_steps.numpy().tolist() == [[0, 10], [1, 11], [1, 11], [100, 110]]
    np.testing.assert_allclose(state.state.push.numpy() * 10 * 0.01, impulse, rtol=1e-6)
