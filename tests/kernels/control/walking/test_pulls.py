"""Pulls of the walking controller: turns, and units in which its numbers are."""

import numpy as np
from probes import evaluate, vectors
from scipy.spatial.transform import Rotation

from warpmuscle.kernels.control.walking.pulls import turn_by


def test_a_turn_is_about_its_vector_by_its_length():
    turns = np.concatenate([vectors(20, 3), [[0.0, 0.0, 0.0], [2e-3, 0.0, 0.0]]])
    found = Rotation.from_quat(evaluate(turn_by, turns))
    assert np.abs((found * Rotation.from_rotvec(turns).inv()).magnitude()).max() < 2e-6
    np.testing.assert_allclose(np.linalg.norm(evaluate(turn_by, turns), axis=1), 1.0, atol=1e-6)
