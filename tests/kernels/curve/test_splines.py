"""Schutte's force over speed solves the equations that OpenSim's muscle takes its speed from."""

import numpy as np
from probes import evaluate

from warpmuscle.kernels.curve.splines import schutte_velocity

KV, SLOPE, MOST = 0.15, 0.13, 1.4  # of Schutte1993Muscle_Deprecated::calcFiberVelocity


def speed_of(force: np.ndarray, active: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Speed of a fibre that pulls with a force besides its passive one, by OpenSim 4.6's two quadratic equations."""
    c = KV * (force - active) / damping
    b = -KV * (force / KV + active + damping) / damping
    shortening = 0.5 * (-b - np.sqrt(b * b - 4.0 * c))
    c = -(SLOPE * KV / (damping * (KV + 1.0))) * (force - active)
    b = -(force / damping - MOST * active / damping - SLOPE * KV / (KV + 1.0))
    lengthening = 0.5 * (-b + np.sqrt(b * b - 4.0 * c))
    return np.where(force < active, shortening, lengthening)


def test_force_over_speed_is_what_the_speed_was_taken_from():
    random = np.random.default_rng(1)
    active, damping = random.uniform(0.05, 1.0, 4000), random.uniform(0.01, 0.3, 4000)
    force = active * random.uniform(0.02, 1.7, 4000)
    speed = speed_of(force, active, damping)
    assert speed.min() < -0.6
    assert speed.max() > 0.5
    multiplier = evaluate(schutte_velocity, speed)[:, 0]
    np.testing.assert_allclose(active * multiplier + damping * speed, force, atol=2e-6)


def test_the_slope_is_the_derivative():
    v = np.array([-1.5, -0.9, -0.3, -0.01, 0.01, 0.2, 1.5])
    step = 1e-3
    rise = evaluate(schutte_velocity, v + step)[:, 0] - evaluate(schutte_velocity, v - step)[:, 0]
    np.testing.assert_allclose(evaluate(schutte_velocity, v)[:, 1], rise / (2.0 * step), rtol=5e-3, atol=1e-3)
