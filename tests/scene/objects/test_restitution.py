"""Restitution of spring and damper against the motion itself, integrated."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from warpmuscle.scene.objects.restitution import damping_ratio, restitution_of


def bounced(ratio: float) -> float:
    """Speed with which a mass of 1 leaves a spring of 1 N/m that it meets at 1 m/s, as soon as it is not pushed."""

    def pushed(t: float, state: np.ndarray) -> float:
        return -(state[0] + 2.0 * ratio * state[1]) if t > 1e-9 else -1.0

    pushed.terminal, pushed.direction = True, 1.0
    motion = solve_ivp(
        lambda t, s: [s[1], -s[0] - 2.0 * ratio * s[1]], (0.0, 1e3), [0.0, 1.0], events=pushed, rtol=1e-10, atol=1e-12
    )
    return float(-motion.y[1, -1])


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.3, 0.7, 0.9, 1.5, 3.0])
def test_restitution_is_that_of_the_integrated_motion(ratio: float):
    assert restitution_of(ratio) == pytest.approx(bounced(ratio), abs=1e-5)


def test_a_damping_ratio_has_the_restitution_that_it_was_asked_for():
    asked = np.linspace(0.05, 1.0, 200)
    np.testing.assert_allclose(restitution_of(damping_ratio(asked)), asked, atol=2e-4)
    assert damping_ratio(1.0) == 0.0
    assert damping_ratio(0.0) == pytest.approx(2.0)
