"""Thelen's curves with numbers of a muscle's own, against the formulas of the publication in float64."""

import numpy as np
import pytest
import warp as wp
from probes import filled

from warpmuscle.kernels.curve.shaped_family import ShapedCurves
from warpmuscle.kernels.curve.thelen_curves import shaped_active, shaped_velocity
from warpmuscle.kernels.muscle_structs import CurveRow

SHAPE, LONGEST, STRAIGHT, WIDTH = 0.3, 1.8, 0.4, 0.5


@wp.kernel(enable_backward=False)
def curves_at(
    curves: ShapedCurves, speed: wp.array[float], activation: float, length: wp.array[float],
    velocity: wp.array[wp.vec2], active: wp.array[float],
):  # fmt: skip
    i = wp.tid()
    velocity[i] = shaped_velocity(curves, speed[i], activation)
    active[i] = shaped_active(curves, length[i])


def multiplier(v: np.ndarray) -> np.ndarray:
    """Thelen 2003, eq. 6 and 7, solved for the force at full activation; v over v_max."""
    scale = (2.0 + 2.0 / SHAPE) / (LONGEST - 1.0)
    return np.where(v <= 0.0, (1.0 + v) / (1.0 - v / SHAPE), (1.0 + LONGEST * scale * v) / (1.0 + scale * v))


@pytest.mark.parametrize("activation", [1.0, 0.4])
def test_hyperbolas_have_the_muscles_shape_and_lengthening_force_and_go_on_straight(activation: float):
    speed, length = np.linspace(-1.2, 0.6, 60), np.linspace(0.5, 1.5, 60)
    row = filled(CurveRow, velocity_shape=SHAPE, lengthening_force=LONGEST, straight_speed=STRAIGHT, active_width=WIDTH)
    velocity = wp.zeros(60, dtype=wp.vec2, device="cpu")
    active = wp.zeros(60, dtype=float, device="cpu")
    given = [wp.array(np.float32(values), device="cpu") for values in (speed, length)]
    wp.launch(
        curves_at, 60, [filled(ShapedCurves, row=row), given[0], activation, given[1], velocity, active], device="cpu"
    )
    scale = 1.0 / (0.25 + 0.75 * activation)
    v = scale * speed
    inside, d = np.clip(v, -1.0, STRAIGHT), 1e-6
    slope = (multiplier(inside + d) - multiplier(inside - d)) / (2.0 * d)
    np.testing.assert_allclose(velocity.numpy()[:, 0], multiplier(inside) + slope * (v - inside), rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(velocity.numpy()[:, 1], slope * scale, rtol=1e-4)
    np.testing.assert_allclose(active.numpy(), np.exp(-((length - 1.0) ** 2) / WIDTH), rtol=1e-5)
