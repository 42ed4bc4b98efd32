"""Names of both sides find each other; names at the edge of a panel keep apart."""

import numpy as np

from warpmuscle.plots.pairs import Pair, pairs
from warpmuscle.plots.style import apart


def test_sides_are_paired_however_they_are_marked():
    names = ["lSOL", "Neck_Flex", "rSOL", "bic_l", "bic_r", "left_knee", "right_knee", "lonely", "L_ELB", "R_ELB"]
    assert pairs(names) == [
        Pair("SOL", "lSOL", "rSOL"), Pair("Neck_Flex", "Neck_Flex", "Neck_Flex"), Pair("bic", "bic_l", "bic_r"),
        Pair("knee", "left_knee", "right_knee"), Pair("lonely", "lonely", "lonely"), Pair("ELB", "L_ELB", "R_ELB"),
    ]  # fmt: skip


def test_labels_move_as_little_as_possible():
    np.testing.assert_allclose(apart([0.0, 5.0, 5.0, 9.0], 1.0), [0.0, 4.5, 5.5, 9.0])
    np.testing.assert_allclose(apart([1.0, 1.0, 1.0], 2.0), [-1.0, 1.0, 3.0])
    assert apart([], 1.0).tolist() == []
