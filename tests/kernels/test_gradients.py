"""Derivatives that Warp's tape takes of equations that are solved by iterations, against differences in float64."""

from typing import Any

import numpy as np
import pytest
import warp as wp
from probes import evaluate

from warpmuscle.kernels.curve import curves
from warpmuscle.kernels.curve.curves import DE_GROOTE, LEE, MILLARD, SARSHARI, THELEN
from warpmuscle.kernels.curve.custom_curves import CustomCurves, with_curves
from warpmuscle.kernels.muscle import muscle

MODELS = {"lee": LEE, "thelen": THELEN, "millard": MILLARD, "de groote": DE_GROOTE, "sarshari": SARSHARI}
L_OPT, SLACK, V_MAX, DAMPING, TIME_STEP = 0.1, 0.2, 10.0, 0.1, 1.0 / 2000.0


@wp.func
def bell(length: float) -> float:
    return wp.exp((length - 1.0) * (length - 1.0) * (-4.0))


own_equilibrium = with_curves(muscle.fibre_equilibrium, CustomCurves(active=bell))


@wp.kernel(enable_backward=True)
def rest(
    model: int, activation: wp.array[float], path: wp.array[float], l_opt: wp.array[float], l_slack: wp.array[float],
    width: wp.array[float], length: wp.array[float],
):  # fmt: skip
    i = wp.tid()
    length[i] = muscle.fibre_equilibrium(model, activation[i], path[i], l_opt[i], l_slack[i], width[i])


@wp.kernel(enable_backward=True)
def own_rest(
    model: int, activation: wp.array[float], path: wp.array[float], l_opt: wp.array[float], l_slack: wp.array[float],
    width: wp.array[float], length: wp.array[float],
):  # fmt: skip
    i = wp.tid()
    length[i] = own_equilibrium(model, activation[i], path[i], l_opt[i], l_slack[i], width[i])


@wp.kernel(enable_backward=True)
def step(
    model: int, activation: wp.array[float], path: wp.array[float], start: wp.array[float],
    previous: wp.array[float], l_opt: wp.array[float], l_slack: wp.array[float], width: wp.array[float],
    v_max: wp.array[float], damping: wp.array[float], length: wp.array[float],
):  # fmt: skip
    i = wp.tid()
    length[i] = muscle.compliant_step(
        model, activation[i], path[i], start[i], previous[i], l_opt[i], l_slack[i], width[i], v_max[i], damping[i],
        wp.static(TIME_STEP),
    )  # fmt: skip


@wp.kernel(enable_backward=True)
def speed(model: int, activation: wp.array[float], path: wp.array[float], found: wp.array[float]):
    i = wp.tid()
    found[i] = muscle.equilibrium_speed(
        model, activation[i], path[i], wp.static(L_OPT), wp.static(TIME_STEP), 0.0, wp.static(L_OPT), wp.static(SLACK),
        0.0, wp.static(DAMPING),
    )  # fmt: skip


def taped(kernel: Any, model: int, *values: Any) -> tuple[np.ndarray, np.ndarray]:
    """Results (n,) of a kernel, and their derivatives (arguments, n)."""
    arrays = [np.ascontiguousarray(v, np.float32) for v in np.broadcast_arrays(*values)]
    given = [wp.array(v, dtype=float, device="cpu", requires_grad=True) for v in arrays]
    result = wp.zeros(len(arrays[0]), dtype=float, device="cpu", requires_grad=True)
    tape = wp.Tape()
    with tape:
        wp.launch(kernel, len(arrays[0]), [model, *given, result], device="cpu")
    tape.backward(grads={result: wp.ones_like(result)})
    return result.numpy().astype(float), np.stack([v.grad.numpy() for v in given]).astype(float)


class Balance:
    """Fibre and tendon in float64, on curves between closely set values of the device's."""

    def __init__(self, model: int, active: Any = None) -> None:
        self.x, self.strain = np.linspace(0.0, 2.5, 2001), np.linspace(-0.3, 0.3, 6001)
        self.f_active = active(self.x) if active else evaluate(curves.active_force_length, model, self.x)
        self.f_passive = evaluate(muscle.bounded_passive, model, self.x)
        self.f_tendon = evaluate(curves.tendon_force_strain, model, self.strain)
        self.isometric = evaluate(curves.force_velocity, model, 0.0, 1.0)[0]

    def excess(self, length, a, path, l_opt, slack, width, multiplier=None, damped=0.0):
        """Force of the fibre along the tendon, less that of the tendon; at rest by default."""
        x, along = length / l_opt, np.sqrt(length**2 - width**2)
        active = a * cubic(self.x, self.f_active, x) * (self.isometric if multiplier is None else multiplier)
        pull = active + cubic(self.x, self.f_passive, x) + damped
        return pull * along / length - cubic(self.strain, self.f_tendon, (path - slack - along) / slack)


def cubic(grid: np.ndarray, value: np.ndarray, at: np.ndarray) -> np.ndarray:
    """A cubic through the four values around each place."""
    h = grid[1] - grid[0]
    i = np.clip(((at - grid[0]) / h).astype(int), 1, len(grid) - 3)
    s = (at - grid[i]) / h
    a, b, c, d = value[i - 1], value[i], value[i + 1], value[i + 2]
    return b + 0.5 * s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * (b - c) + d - a)))


def by_differences(excess: Any, values: list[np.ndarray], root: np.ndarray, steps: list[float]) -> np.ndarray:
    """Derivatives (arguments, n) of the root of an excess(root, *values) that grows with it; each by bisection."""

    def solved(given: list[np.ndarray]) -> np.ndarray:
        low, high = root - 1e-3, root + 1e-3
        for _ in range(50):
            middle = 0.5 * (low + high)
            above = excess(middle, *given) > 0.0
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        return high

    found = []
    for k, h in enumerate(steps):
        up, down = ([v + sign * h if j == k else v for j, v in enumerate(values)] for sign in (1.0, -1.0))
        found.append((solved(up) - solved(down)) / (2.0 * h))
    return np.array(found)


def assert_derivatives(got: np.ndarray, expected: np.ndarray, share: float = 0.01) -> None:
    """Within a share of each argument's largest."""
    assert np.all(np.isfinite(expected))
    for mine, theirs in zip(got, expected, strict=True):
        largest = np.abs(theirs).max()
        assert largest > 0.0
        np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=share * largest)


def units(count: int = 200) -> list[np.ndarray]:
    """Activation, path, l_opt, l_slack and width of units whose fibres are on the rising part of their curve."""
    rng = np.random.default_rng(5)
    a, x, width = rng.uniform(0.1, 1.0, count), rng.uniform(0.7, 0.95, count), rng.uniform(0.002, 0.04, count)
    path = 1.02 * SLACK + np.sqrt((x * L_OPT) ** 2 - width**2)
    given = [a, path, np.full(count, L_OPT), np.full(count, SLACK), width]
    return [v.astype(np.float32).astype(float) for v in given]


STEPS = [1e-3, 2e-5, 2e-5, 2e-5, 2e-5]


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_equilibrium_at_rest_has_the_derivatives_of_differences(model: int) -> None:
    given = units()
    length, got = taped(rest, model, *given)
    expected = by_differences(Balance(model).excess, given, length, STEPS)
    assert np.abs(expected[1]).min() > 0.01
    assert_derivatives(got, expected)


def test_equilibrium_with_a_curve_of_ones_own_has_them_too() -> None:
    given = units()
    length, got = taped(own_rest, LEE, *given)
    law = Balance(LEE, lambda x: np.exp(-4.0 * (x - 1.0) ** 2))
    assert_derivatives(got, by_differences(law.excess, given, length, STEPS))
    assert np.abs(got - taped(rest, LEE, *given)[1]).max() > 0.02


def test_the_shortest_fibre_and_the_end_of_a_slack_tendon_move_as_they_must() -> None:
    """Units too short for any force, one of them bound by its pennation, and one at which nothing pulls."""
    a, width = np.array([0.5, 0.5, 0.0]), np.array([0.001, 0.03, 0.03])
    path = SLACK + np.array([-0.1, -0.1, 0.06])
    length, got = taped(rest, MILLARD, a, path, L_OPT, SLACK, width)
    np.testing.assert_allclose(length, [0.05 * L_OPT, 0.03 / np.sqrt(0.99), np.hypot(0.06, 0.03)], rtol=1e-3)
    np.testing.assert_allclose(got[:, 0], [0.0, 0.0, 0.05, 0.0, 0.0], atol=1e-7)
    np.testing.assert_allclose(got[:, 1], [0.0, 0.0, 0.0, 0.0, 1.0 / np.sqrt(0.99)], rtol=1e-6)
    along, across = 0.06 / np.hypot(0.06, 0.03), 0.03 / np.hypot(0.06, 0.03)
    np.testing.assert_allclose(got[[1, 3, 4], 2], [along, -along, across], atol=0.01)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_a_step_on_a_compliant_tendon_has_the_derivatives_of_differences(model: int) -> None:
    """l = start + reach v, with the speed that balances fibre and tendon there; both change with what is given."""
    rng, law = np.random.default_rng(6), Balance(model)
    a, path, l_opt, slack, width = units()
    count = len(a)
    before = taped(rest, model, a, path, l_opt, slack, width)[0]
    path = path + rng.choice([-4e-4, 4e-4], count)  # at v = 0 some curves have a kink
    given = [a, path, before, before, l_opt, slack, width, np.full(count, V_MAX), np.full(count, DAMPING)]
    given = [v.astype(np.float32).astype(float) for v in given]
    length, got = taped(step, model, *given)
    speed = np.linspace(-4.0, 4.0, 16001)

    def excess(end, a, path, now, previous, l_opt, slack, width, v_max, damping):
        v = (end - now - (now - previous) / 3.0) / (2.0 / 3.0 * TIME_STEP * v_max * l_opt)
        multiplier = velocity(v, a)
        return law.excess(end, a, path, l_opt, slack, width, multiplier, damping * v)

    def velocity(v, a):
        if model == THELEN:  # at most 0.25 + 0.75 a of the speed
            return np.interp(v / (0.25 + 0.75 * a), speed, curve)
        return np.interp(v, speed, curve)

    curve = evaluate(curves.force_velocity, model, speed, 1.0)
    expected = by_differences(excess, given, length, [1e-3, 2e-6, 2e-6, 2e-6, 2e-6, 2e-6, 2e-5, 1e-2, 1e-3])
    moved = (length - given[2]) / (TIME_STEP * V_MAX * L_OPT)
    well = (np.abs(moved) > 0.01) & (np.abs(moved) < 0.5)
    assert well.sum() > 50
    by_v_max = 7  # in proportion to the speed itself, which a step finds within some tolerance only
    assert_derivatives(got[by_v_max:][:1, well], expected[by_v_max:][:1, well], 0.1)
    others = [k for k in range(len(got)) if k != by_v_max]
    assert_derivatives(got[others][:, well], expected[others][:, well], 0.02)


def test_a_speed_at_its_bound_does_not_change() -> None:
    """Tendons pull so hard that the fibre is as fast as it may be, whatever its activation and path."""
    path = np.array([SLACK + 2.0 * L_OPT, SLACK + 1.5 * L_OPT])
    found, slopes = taped(speed, MILLARD, np.array([0.2, 0.9]), path)
    np.testing.assert_allclose(found, muscle.FASTEST_STRETCH, rtol=1e-3)
    assert not slopes.any()
