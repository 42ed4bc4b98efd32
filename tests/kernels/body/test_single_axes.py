"""Runs of bodies that are only children, and which lanes go along them."""

import numpy as np
import pytest
import warp as wp

from warpmuscle.kernels.body.single_axes import begin_run
from warpmuscle.kernels.body_structs import BodyRun
from warpmuscle.kernels.structs import Model
from warpmuscle.model.couplings import runs_of


@wp.kernel
def tasks(first: int, width: int, lanes: int, model: Model, found: wp.array2d[int]):
    """Run, helper, helpers, leaver and how many share the unknowns, of each lane."""
    lane = wp.tid()
    t = begin_run(first, width, lane, lanes, model)
    found[lane, 0] = t.run
    found[lane, 1] = t.helper
    found[lane, 2] = t.helpers
    found[lane, 3] = t.leaver
    found[lane, 4] = t.sharing


def tasks_of(unknowns: list[int], first: int, width: int, lanes: int) -> np.ndarray:
    model, run = Model(), np.zeros(len(unknowns), BodyRun.numpy_dtype())
    run["unknowns"], run["before"] = unknowns, np.cumsum([0, *unknowns[:-1]])
    model.couplings.run = wp.array(run, dtype=BodyRun, device="cpu")
    found = wp.zeros((lanes, 5), dtype=int, device="cpu")
    wp.launch(tasks, lanes, [first, width, lanes, model, found], device="cpu")
    return found.numpy()


@pytest.mark.parametrize("lanes", [1, 3, 4, 8, 12, 16, 32, 96])
@pytest.mark.parametrize("unknowns", [[4], [7, 1, 1, 1, 1, 0], [2, 2], [0, 0, 0], [3, 3, 2, 1, 0, 0, 0, 0, 0, 0]])
def test_every_unknown_of_every_run_has_one_lane_and_every_run_one_that_leaves(unknowns: list[int], lanes: int):
    start = 0
    while start < len(unknowns):
        width = min(len(unknowns) - start, lanes)
        found = tasks_of(unknowns, start, width, lanes)
        for run in range(start, start + width):
            own = found[(found[:, 0] == run) & (found[:, 1] < found[:, 2])]
            helpers, leaver, sharing = own[0, 2:]
            assert sorted(own[:, 1]) == list(range(helpers))
            assert 0 <= leaver < helpers
            assert 1 <= sharing <= helpers
            assert helpers <= 1 or sharing <= max(unknowns[run], 1)
            if unknowns[run] >= helpers:
                assert sharing == helpers
        start += width


def test_most_lanes_help_where_most_unknowns_act():
    found = tasks_of([7, 1, 1, 1, 1, 0], 0, 6, 16)
    helping = np.bincount(found[found[:, 1] < found[:, 2], 0], minlength=6)
    assert helping[0] >= 6
    assert helping.min() == 1


def test_only_children_are_in_one_run_with_what_they_hang_on():
    """A trunk of three, of which two arms of two and a head hang; a finger at the end of each arm with two tips."""
    parents = [-1, 0, 1, 2, 3, 3, 3, 4, 5, 7, 7]
    levels = runs_of(parents, [0] * 4 + [1, 3, 0, 1, 3, 0, 0])
    assert levels == [[[1, 2, 3]], [[5, 8], [4, 7], [6]], [[9], [10]]]


def test_children_of_the_root_begin_runs_of_their_own():
    assert runs_of([-1, 0, 1], [0, 2, 2]) == [[[1, 2]]]
    assert runs_of([-1, 0, 0], [0, 0, 1]) == [[[2], [1]]]
