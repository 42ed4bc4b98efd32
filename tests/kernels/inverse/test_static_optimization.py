"""Static optimisation on the device against optimality conditions and SciPy, in float64."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize

from small_leg import loads, motion, small_leg
from warpmuscle.inverse.activations import ActivationOptions
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import prepare
from warpmuscle.inverse.static_optimization import SMALLEST_BEND, Solver, activations_of

MUSCLES = 10


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> BodyModel:
    return BodyModel(small_leg(tmp_path_factory.mktemp("leg")), "cpu")


def shares(solved, strength: float, power: int):
    """Reserves over their strength: the slope of their cost |r|^p / p is the multiplier times the strength."""
    u = strength * solved.multiplier.astype(float)
    return np.sign(u) * np.abs(u) ** (1.0 / (max(power, 2) - 1))


class Problem:
    """Frames of the leg with moments that its muscles can make, and the matrices of float64."""

    def __init__(self, body: BodyModel, scale: float = 1.0, frames: int = 20) -> None:
        self.body, self.trials = body, prepare(body, motion(frames), None, None, None)
        muscles = body.muscle_frames(self.trials.states, slice(0, frames))
        arm, active = muscles.moment_arm.numpy().astype(float), muscles.active.numpy().astype(float)
        self.b = np.zeros((frames, body.topology.speeds, MUSCLES))
        for k, (muscle, speed) in enumerate(zip(body.lever_muscle, body.lever_speed, strict=True)):
            self.b[:, speed, muscle] += arm[:, k] * active[:, muscle]
        wanted = np.random.default_rng(1).uniform(0.05, 0.6, (frames, MUSCLES))
        self.effort = scale * np.einsum("fsm,fm->fs", self.b, wanted)

    def solved(self, **options):
        solver = Solver(self.body, self.trials, ActivationOptions(pennation=True, **options), ())
        return solver, solver.run(self.effort, None)

    def balance(self, solved, reserve: float, power: int = 2):
        """What the moments miss, over what muscles can make."""
        own = slice(6, None)
        made = np.einsum("fsm,fm->fs", self.b, solved.activation.astype(float))[:, own]
        made += reserve * shares(solved, reserve, power)[:, own]
        strength = np.sqrt(np.sum(self.b**2, axis=2) + reserve**2)[:, own]
        return np.abs(made - self.effort[:, own]) / strength


@pytest.mark.parametrize("scale", [0.3, 1.0, 3.0])  # the last is beyond what the muscles can do
def test_squares_are_as_small_as_scipy_finds_them(body, scale):
    problem, d = Problem(body, scale), 1.0
    _, solved = problem.solved(reserve=d, least=0.01)
    assert (solved.iterations >= 0).all()
    for f in range(20):
        b, tau = problem.b[f, 6:], problem.effort[f, 6:]
        matrix = np.concatenate([np.eye(MUSCLES), b / d])
        wanted = lsq_linear(matrix, np.concatenate([np.zeros(MUSCLES), tau / d]), (0.01, 1.0), method="bvls", tol=1e-12)
        assert solved.activation[f] == pytest.approx(wanted.x, abs=2e-3)


@pytest.mark.parametrize("power", [1, 2, 3, 4])
def test_activations_are_optimal_for_every_power(body, power):
    problem, d, low = Problem(body), 0.5, 0.02
    _, solved = problem.solved(power=power, reserve=d, least=low)
    assert (solved.iterations >= 0).all()
    assert problem.balance(solved, d, power).max() < 1e-4
    a, y = solved.activation.astype(float), np.einsum("fsm,fs->fm", problem.b, solved.multiplier.astype(float))
    slope = a ** (power - 1) if power > 1 else 1.0 + SMALLEST_BEND * a  # of the cost
    free = (a > low + 1e-3) & (a < 1.0 - 1e-3)
    assert free.sum() > 20
    assert slope[free] == pytest.approx(y[free], rel=0.01, abs=0.005)
    assert (y[a <= low] <= slope[a <= low] + 0.005).all()
    assert (y[a >= 1.0] >= slope[a >= 1.0] - 0.005).all()


@pytest.mark.parametrize("power", [3, 4])
def test_reserves_cost_the_power_of_activations(body, power):
    problem, d = Problem(body, 1.5), 5.0  # beyond what muscles can do in some frames
    solver, solved = problem.solved(power=power, reserve=d, least=0.0)
    assert (solved.iterations >= 0).all()
    (found,) = solver.activations(solved, problem.effort)
    for f in range(0, 20, 5):
        b, tau = problem.b[f, 6:], problem.effort[f, 6:]

        def cost(a, b=b, tau=tau):
            r = (tau - b @ a) / d
            return np.sum(a**power) + np.sum(np.abs(r) ** power)

        def slope(a, b=b, tau=tau):
            r = (tau - b @ a) / d
            return power * (a ** (power - 1) - b.T @ (np.sign(r) * np.abs(r) ** (power - 1)) / d)

        own = solved.activation[f].astype(float)
        best = minimize(cost, own, jac=slope, bounds=[(0.0, 1.0)] * MUSCLES, method="L-BFGS-B", options={"ftol": 1e-15})
        assert cost(own) == pytest.approx(best.fun, rel=1e-4)
        assert np.sort(np.abs(found.reserve[f]))[-1] == pytest.approx(np.abs(tau - b @ own).max(), rel=0.01)


def test_heavier_weights_take_less_part(body):
    problem = Problem(body)
    _, plain = problem.solved(reserve=0.5)
    weighted, other = problem.solved(reserve=0.5, weight="volume")
    heavy, light = weighted.weight.argmax(), weighted.weight.argmin()
    assert weighted.weight.mean() == pytest.approx(1.0)
    if weighted.weight[heavy] > weighted.weight[light] * 1.01:
        assert other.activation[:, heavy].mean() < plain.activation[:, heavy].mean()
    assert problem.balance(other, 0.5).max() < 1e-4


def test_what_muscles_lack_is_a_reserve_and_no_failure(body):
    problem = Problem(body, 20.0)
    _, solved = problem.solved(reserve=0.1)
    assert (solved.iterations >= 0).all()
    assert problem.balance(solved, 0.1).max() < 1e-4
    assert solved.activation.max() == 1.0


def test_bits_depend_on_no_other_frame(body):
    problem = Problem(body)
    _, whole = problem.solved(reserve=0.5)
    body_of_one = Problem(body, frames=20)
    parts = []
    for k in range(20):
        one = prepare(body, motion(20), None, None, motion(20).times[k : k + 1])
        own = Solver(body, one, ActivationOptions(reserve=0.5, pennation=True), ())
        parts.append(own.run(body_of_one.effort[k : k + 1], None).activation)
    assert np.array_equal(np.concatenate(parts), whole.activation)


def test_frames_whose_balance_is_rounding_are_given_up_soon_and_solved_in_double_precision(body):
    problem = Problem(body, 8.0)  # far beyond what muscles can do: multipliers of weak reserves are huge
    solver = Solver(body, problem.trials, ActivationOptions(reserve=1e-2, least=0.01, pennation=True), ())
    part = slice(0, 20)
    one = solver.launch(problem.effort, body.muscle_frames(problem.trials.states, part), part)
    one.run()
    assert (one.outputs[2].numpy() < 0).any()
    one.mend()
    steps = one.outputs[2].numpy()
    assert (steps > 0).all()
    solved = solver.run(problem.effort, None)
    assert np.array_equal(solved.iterations, steps)
    assert problem.balance(solved, 1e-2).max() < 1e-3  # multipliers come back in single precision


def test_the_order_in_memory_that_gpus_like_changes_no_bit(body, monkeypatch):
    problem = Problem(body)
    _, plain = problem.solved(reserve=0.5)
    monkeypatch.setattr(body, "apart", True)
    _, other = problem.solved(reserve=0.5)
    assert np.array_equal(plain.activation, other.activation)
    assert np.array_equal(plain.multiplier, other.multiplier)


def test_activations_change_as_fast_as_muscles_can(body):
    trials = prepare(body, motion(60), loads(motion(60).times), None, None)
    free, bound = (
        activations_of(body, trials, ActivationOptions(rates=rates, reserve=5.0))[0] for rates in (False, True)
    )
    rise, fall = (1.0 - np.exp(-0.01 / time) for time in (0.01, 0.04))  # of 10 ms
    a, low = bound.activation.astype(float), 0.01
    assert (np.diff(a, axis=0) <= rise * (1.0 - a[:-1]) + 1e-4).all()
    assert (-np.diff(a, axis=0) <= fall * (a[:-1] - low) + 1e-4).all()
    assert a[0] == pytest.approx(free.activation[0])
    assert np.abs(np.diff(free.activation, axis=0)).max() > np.abs(np.diff(a, axis=0)).max()
