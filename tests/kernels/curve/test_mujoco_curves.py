"""MuJoCo's muscle curves: its documentation's pieces in float64, and its own functions."""

import numpy as np
import pytest
from probes import evaluate, filled

from warpmuscle.kernels.curve.mujoco_curves import (
    CURVES,
    LENGTHENING,
    MOST,
    PASSIVE,
    bump,
    passive_rise,
    shaped_active,
    shaped_passive,
    shaped_velocity,
    speed_multiplier,
)
from warpmuscle.kernels.curve.shaped_family import ShapedCurves
from warpmuscle.kernels.structs import CurveRow

L, V = np.linspace(-0.2, 2.4, 1301), np.linspace(-1.5, 1.5, 1201)


def bump_of(length: np.ndarray, least: float, most: float) -> np.ndarray:
    """Parabolas that meet half-way between 1 and either end (MuJoCo, "Muscle actuators", FL)."""
    a, b = 0.5 * (least + 1.0), 0.5 * (1.0 + most)
    pieces = [
        0.5 * ((length - least) / (a - least)) ** 2, 1.0 - 0.5 * ((1.0 - length) / (1.0 - a)) ** 2,
        1.0 - 0.5 * ((length - 1.0) / (b - 1.0)) ** 2, 0.5 * ((most - length) / (most - b)) ** 2,
    ]  # fmt: skip
    where = [(length >= least) & (length <= a), (length > a) & (length <= 1), (length > 1) & (length <= b)]
    return np.select([*where, (length > b) & (length <= most)], pieces)


def passive_of(length: np.ndarray, most: float, force: float) -> np.ndarray:
    half = 0.5 * (most - 1.0)
    x = (length - 1.0) / half
    return force * np.select([x <= 0.0, x <= 1.0], [0.0 * x, 0.5 * x**2], 0.5 + (x - 1.0))


def multiplier_of(speed: np.ndarray, most: float) -> np.ndarray:
    y = most - 1.0
    pieces = [0.0 * speed, (speed + 1.0) ** 2, most - (y - speed) ** 2 / y]
    return np.select([speed <= -1.0, speed <= 0.0, speed <= y], pieces, most)


@pytest.mark.parametrize(("least", "most"), [(0.5, 1.6), (0.0, 3.0), (0.42, 1.1)])
def test_active_force_is_a_bump_between_its_ends(least: float, most: float):
    np.testing.assert_allclose(evaluate(bump, L, least, most), bump_of(L, least, most), atol=3e-6)


@pytest.mark.parametrize(("most", "force"), [(1.6, 1.3), (3.0, 0.5)])
def test_passive_force_rises_from_one(most: float, force: float):
    np.testing.assert_allclose(evaluate(passive_rise, L, most, force), passive_of(L, most, force), atol=3e-6)


@pytest.mark.parametrize("most", [1.2, 1.8])
def test_speed_multiplies_the_force_and_its_slope_is_the_derivative(most: float):
    got = evaluate(speed_multiplier, V, most)
    np.testing.assert_allclose(got[:, 0], multiplier_of(V, most), atol=1e-6)
    step = 1e-5
    slope = (multiplier_of(V + step, most) - multiplier_of(V - step, most)) / (2.0 * step)
    smooth = np.abs(V) > 1e-3  # 0 is a corner, where both pieces have slopes of their own
    np.testing.assert_allclose(got[smooth, 1], slope[smooth], atol=2e-4)


def test_without_lengthening_force_the_multiplier_is_one_beyond_rest():
    np.testing.assert_allclose(evaluate(speed_multiplier, V, 1.0)[:, 0], np.where(V > 0.0, 1.0, multiplier_of(V, 1.2)),
                               atol=1e-6)  # fmt: skip


def test_numbers_are_the_defaults_of_mujoco_or_a_muscles_own():
    assert evaluate(CURVES.passive, MOST) == pytest.approx(1.5 * PASSIVE)
    assert evaluate(CURVES.velocity, 1.0, 1.0)[0, 0] == pytest.approx(LENGTHENING)
    row = filled(
        CurveRow, shortest=0.3, active_width=2.0, passive_floor=1.2, passive_rate=1.8, passive_scale=0.7,
        lengthening_force=1.5,
    )  # fmt: skip
    own = filled(ShapedCurves, row=row)
    np.testing.assert_allclose(_of(own, shaped_active, L), bump_of(L, 0.3, 2.0), atol=3e-6)
    np.testing.assert_allclose(_of(own, shaped_passive, L), passive_of(L - 0.2, 1.6, 0.7), atol=4e-6)
    np.testing.assert_allclose(_of(own, shaped_velocity, V, 1.0)[:, 0], multiplier_of(V, 1.5), atol=1e-6)


def test_curves_are_those_of_mujocos_functions():
    mujoco = pytest.importorskip("mujoco")
    for least, most, fastest, passive, lengthening in ((0.5, 1.6, 1.5, 1.3, 1.2), (0.1, 2.4, 8.0, 0.6, 1.5)):
        parameters = [0.5, 1.5, 1.0, 200.0, least, most, fastest, passive, lengthening]
        of = {"lengthrange": [0.5, 1.5], "acc0": 1.0, "prm": parameters}
        gain = [-mujoco.mju_muscleGain(length, 0.0, *of.values()) for length in L]
        np.testing.assert_allclose(evaluate(bump, L, least, most), gain, atol=3e-6)
        gain = [-mujoco.mju_muscleGain(1.0, fastest * speed, *of.values()) for speed in V]
        np.testing.assert_allclose(evaluate(speed_multiplier, V, lengthening)[:, 0], gain, atol=1e-6)
        bias = [-mujoco.mju_muscleBias(length, *of.values()) for length in L]
        np.testing.assert_allclose(evaluate(passive_rise, L, most, passive), bias, atol=3e-6)


def _of(own, function, values: np.ndarray, *others: float) -> np.ndarray:
    """Results of a function of a muscle's own curves."""
    import warp as wp

    got = wp.zeros(len(values), dtype=wp.vec2 if others else float, device="cpu")
    given = wp.array(values.astype(np.float32), dtype=float, device="cpu")
    wp.launch(_kernel(function, bool(others)), dim=len(values), inputs=[own, given], outputs=[got], device="cpu")
    return got.numpy().astype(float)


def _kernel(function, of_speed: bool):
    import warp as wp

    kind = wp.vec2 if of_speed else float

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(own: ShapedCurves, values: wp.array[float], got: wp.array[kind]):
        i = wp.tid()
        if wp.static(of_speed):
            got[i] = function(own, values[i], 1.0)
        else:
            got[i] = function(own, values[i])

    return kernel
