"""Lanes that share a programme against a thread that has it alone, and against a solver in float64."""

from __future__ import annotations

import os

import numpy as np
import pytest
import warp as wp

from program_problems import Problems, optimum, standing
from warpmuscle.kernels.program.lanes import LANES
from warpmuscle.simulation.devices import find_device
from warpmuscle.simulation.program.lane_tables import NONE, table_of
from warpmuscle.simulation.program.program_batch import ProgramBatch

COUNT, MUSCLES, TORQUES = 24, 90, 20


def solved(problems: Problems, lanes: int | None, device: str = "cpu") -> ProgramBatch:
    """A batch that has solved these programmes."""
    count, n, m = problems.forces.shape
    rows = [np.flatnonzero(np.any(problems.forces[:, :, j] != 0.0, axis=0)).tolist() for j in range(m)]
    batch = ProgramBatch(count, n, rows, find_device(device), lanes=lanes)
    given = {
        "mass": problems.mass.reshape(count, -1), "weight": problems.weight.reshape(count, -1), "bias": problems.bias,
        "wanted": problems.wanted,
        "entry": np.concatenate([problems.forces[:, one, j] for j, one in enumerate(rows)], axis=1),
        "gain": 1.0 / problems.cost[None], "low": problems.low[None], "high": problems.high[None],
    }  # fmt: skip
    for name, values in given.items():
        getattr(batch.numbers, name).assign(values.astype(np.float32))
    batch.solve()
    return batch


@pytest.fixture(scope="module")
def problems() -> Problems:
    return standing(COUNT, MUSCLES, TORQUES)


def test_lanes_find_what_a_thread_finds(problems, unoptimized_kernels):
    lanes, thread = solved(problems, 1), solved(problems, 0)
    assert lanes.control.numpy() == pytest.approx(thread.control.numpy(), rel=1e-6, abs=1e-6)
    assert lanes.acceleration.numpy() == pytest.approx(thread.acceleration.numpy(), rel=1e-5, abs=1e-5)
    assert np.all(lanes.iterations.numpy() > 0)


def test_lanes_begin_where_a_search_has_ended(problems, unoptimized_kernels):
    batch = solved(problems, 1)
    before, cold = batch.control.numpy().copy(), batch.iterations.numpy().copy()
    batch.solve()
    assert batch.control.numpy() == pytest.approx(before, rel=1e-6, abs=1e-6)
    assert batch.iterations.numpy().max() <= 1 < cold.min()


def test_those_that_are_not_chosen_stay_as_they_are(problems, unoptimized_kernels):
    batch = solved(problems, 1)
    batch.control.fill_(7.0)
    batch.solve(batch.every[1::2].contiguous())
    assert np.all(batch.control.numpy()[::2] == 7.0)
    assert not np.any(batch.control.numpy()[1::2] == 7.0)


def test_a_table_has_every_item_once_in_its_own_column():
    lists = [[(10 * k + i,) for i in range(k % 5)] for k in range(40)]
    heights, target, cells = table_of(lists, 1)
    assert (len(heights), heights[0], len(target)) == (2, 4, 2 * LANES)
    found: dict[int, list[int]] = {k: [] for k in range(40)}
    rows = cells.reshape(-1, LANES)
    for group, first in enumerate(np.cumsum([0, heights[0]])):
        for column in range(LANES):
            whose, own = target[group * LANES + column], rows[first : first + heights[group], column]
            if whose != NONE:
                found[whose] += [int(cell) for cell in own if cell != NONE]
            else:
                assert np.all(own == NONE)
    assert found == {k: [item for (item,) in one] for k, one in enumerate(lists)}


@pytest.mark.gpu
@pytest.mark.parametrize("lanes", [LANES, 0])
def test_a_gpu_is_within_a_float64_solver(problems, lanes):
    if not wp.get_cuda_devices():
        pytest.skip("there is no GPU here")
    batch = solved(problems, lanes, os.environ.get("WARPMUSCLE_GPU_TESTS_ON", "cuda:0"))
    control = batch.control.numpy().astype(float)
    for p in range(COUNT):
        best = optimum(problems, p, control[p])
        assert control[p, :MUSCLES] == pytest.approx(best[:MUSCLES], abs=1e-5)
        assert control[p, MUSCLES:] == pytest.approx(best[MUSCLES:], abs=1e-3)
