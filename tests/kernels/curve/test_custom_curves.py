"""Curves of one's own in the place of a model's: each of the three, and the others as they are."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate

from warpmuscle.kernels.curve.curve_sets import THELEN
from warpmuscle.kernels.curve.custom_curves import CustomCurves, custom_functions, with_curves
from warpmuscle.kernels.muscle import muscle

ACTIVATION, DAMPING = 0.6, 0.05
LENGTH, SPEED = np.linspace(0.6, 1.5, 10), np.linspace(-0.4, 0.3, 10)


@wp.func
def bell(length: float) -> float:
    return wp.exp(-(length - 1.0) * (length - 1.0) / 0.3)


@wp.func
def parabola(length: float) -> float:
    return 0.4 * length * length


@wp.func
def line(speed: float) -> float:
    return 1.0 + 0.5 * speed


OWN = {
    "active": (bell, lambda length, _: np.exp(-((length - 1.0) ** 2) / 0.3)),
    "passive": (parabola, lambda length, _: 0.4 * length**2),
    "velocity": (line, lambda _, speed: 1.0 + 0.5 * speed),
}
MODEL = {
    "active": lambda: evaluate(muscle.active_force_length, THELEN, LENGTH),
    "passive": lambda: evaluate(muscle.passive_force_length, THELEN, LENGTH),
    "velocity": lambda: evaluate(muscle.force_velocity, THELEN, SPEED, ACTIVATION),
}


def pulls(function: wp.Function) -> np.ndarray:
    """Forces of a fibre; each function in a kernel of its own, for all of them have one name."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(length: wp.array[float], speed: wp.array[float], force: wp.array[float]):
        i = wp.tid()
        force[i] = function(wp.static(THELEN), wp.static(ACTIVATION), length[i], speed[i], wp.static(DAMPING))

    given = [wp.array(np.float32(values), device="cpu") for values in (LENGTH, SPEED)]
    force = wp.zeros(len(LENGTH), dtype=float, device="cpu")
    wp.launch(kernel, len(LENGTH), [*given, force], device="cpu")
    return force.numpy().astype(float)


@pytest.mark.parametrize("names", [("active",), ("passive",), ("velocity",), ("active", "passive", "velocity")])
def test_a_fibre_pulls_by_the_curves_that_are_given_and_else_by_its_models(names: tuple[str, ...]):
    own = with_curves(muscle.fibre_force, CustomCurves(**{name: OWN[name][0] for name in names}))
    active, passive, velocity = (OWN[name][1](LENGTH, SPEED) if name in names else MODEL[name]() for name in OWN)
    expected = np.maximum(ACTIVATION * active * velocity + passive + DAMPING * SPEED, 0.0)
    np.testing.assert_allclose(pulls(own), expected, rtol=2e-4, atol=2e-5)


def test_the_slope_of_a_curve_of_speed_is_that_of_its_differences():
    slope = custom_functions(CustomCurves(velocity=line))["force_velocity_slope"]

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(speed: wp.array[float], found: wp.array[wp.vec2]):
        i = wp.tid()
        found[i] = slope(0, speed[i], 1.0)

    found = wp.zeros(len(SPEED), dtype=wp.vec2, device="cpu")
    wp.launch(kernel, len(SPEED), [wp.array(np.float32(SPEED), device="cpu"), found], device="cpu")
    np.testing.assert_allclose(found.numpy()[:, 0], 1.0 + 0.5 * SPEED, rtol=1e-5)
    np.testing.assert_allclose(found.numpy()[:, 1], 0.5, rtol=1e-2)
