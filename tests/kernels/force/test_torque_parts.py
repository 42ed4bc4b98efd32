"""Torques of very many muscles on a joint, which lanes add up in parts."""

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.kernels.force.torque_parts import MANY_CROSSINGS, PART
from warpmuscle.model.path_table import Crossing, PathTable
from warpmuscle.model.paths import torque_parts
from warpmuscle.simulation.rollout import Rollout


def table(*counts: int) -> PathTable:
    """Joints 1, 2, ... that so many muscles cross."""
    crossings = [Crossing(joint, muscle, ()) for joint, count in enumerate(counts, 1) for muscle in range(count)]
    return PathTable(tuple(f"m{k}" for k in range(max(counts))), (), crossings=crossings)


@pytest.mark.parametrize("counts", [(MANY_CROSSINGS + 1, 7), (3, 0, 2 * MANY_CROSSINGS, PART, PART + 1)])
def test_parts_are_small_of_one_joint_each_and_have_every_crossing_once(counts: tuple[int, ...]):
    own = table(*counts)
    parts = torque_parts(own)
    assert [k for part in parts for k in part] == list(range(sum(counts)))
    assert all(0 < len(part) <= PART for part in parts)
    assert all(len({own.crossings[k].joint for k in part}) == 1 for part in parts)


def test_joints_of_fewer_muscles_are_not_divided():
    assert torque_parts(table(MANY_CROSSINGS, 5)) == []
    assert torque_parts(PathTable((), ())) == []


def test_a_body_moves_as_with_whole_sums(monkeypatch: pytest.MonkeyPatch):
    """Every joint in parts of two muscles, against the sums of joints in the working set."""

    def moved() -> tuple[np.ndarray, int]:
        rollout = Rollout(load("arm18"), 2, "cpu")
        rollout.reset(0.1, seed=1)
        rollout.run(0.03)
        return rollout.state.coordinates.numpy(), rollout.state.muscles.part_torque.shape[1]

    whole, none = moved()
    monkeypatch.setattr("warpmuscle.model.paths.MANY_CROSSINGS", 0)
    monkeypatch.setattr("warpmuscle.model.paths.PART", 2)
    divided, parts = moved()
    assert none == 0
    assert parts > 2
    np.testing.assert_allclose(divided, whole, atol=2e-5)
