"""What a muscle has of its forces, from those at activations of 1/2 and 1, by a line through them."""

import numpy as np
import pytest
from probes import evaluate

from warpmuscle.kernels.muscle.muscle_strength import strength_of


@pytest.mark.parametrize(
    ("half", "full", "least", "wanted"),
    [
        (60.0, 100.0, 0.01, (20.8, 79.2, 0.01)),  # 20 N at none, 80 N more at full activation; 0.8 N of it at the least
        (20.0, 60.0, 0.01, (0.0, 60.0, 0.25)),  # damping takes 20 N: force begins at 20/80
        (20.0, 60.0, 0.4, (12.0, 48.0, 0.4)),  # at the least activation there is force already
        (5.0, 5.0, 0.01, (5.0, 0.5, 0.01)),  # all passive: the active force is at least a thousandth of f_max
        (-3.0, -3.0, 0.0, (0.0, 0.5, 6.0)),  # no force at any activation: it would begin at 3 N / 0.5 N
    ],
)
def test_passive_and_active_force_and_where_it_begins(half: float, full: float, least: float, wanted: tuple):
    found = evaluate(strength_of, np.array([half]), np.array([full]), np.array([least]), 500.0)
    np.testing.assert_allclose(found[0], wanted, rtol=2e-5, atol=1e-5)
