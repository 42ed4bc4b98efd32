"""Static optimisation of redundant muscles against a general solver, and what it says of muscles too weak."""

import time

import numpy as np
import pytest
from scipy.optimize import minimize

from warpmuscle.core.errors import Error
from warpmuscle.synergy.static_optimization import static_optimization

ARMS = np.array([[0.04, -0.03, 0.0, 0.02], [0.0, 0.01, 0.034, -0.021]])  # m, two joints, four muscles
FORCE = np.array([[2000.0, 800.0, 1000.0, 1600.0]])


def torques(activation, passive=0.0):
    """Torques (T, J) that activations (T, M) make."""
    return np.einsum("jm,tm->tj", ARMS, FORCE * activation + passive)


def test_activations_equal_those_of_a_general_solver():
    rng = np.random.default_rng(0)
    passive = rng.uniform(0.0, 50.0, (6, 4))
    wanted = torques(rng.random((6, 4)), passive)
    found = static_optimization(wanted, ARMS[None], FORCE, passive)
    assert found.feasible.all()
    np.testing.assert_allclose(torques(found.activation, passive), wanted, atol=1e-6)
    for t in range(6):
        equal = {"type": "eq", "fun": lambda a, t=t: torques(a[None], passive[t])[0] - wanted[t]}
        best = minimize(lambda a: a @ a, np.full(4, 0.5), bounds=[(0, 1)] * 4, constraints=[equal], tol=1e-12)
        np.testing.assert_allclose(found.activation[t], best.x, atol=1e-4)


def test_bounds_shift_the_load_to_another_muscle_where_one_is_at_its_limit():
    arms = np.array([[[0.04, 0.01]]])
    found = static_optimization([[45.0]], arms, [[1000.0, 1000.0]], [[0.0, 0.0]])
    assert found.needed[0, 0] > 1.0
    np.testing.assert_allclose(found.activation, [[1.0, 0.5]], atol=1e-6)
    assert found.feasible.all()
    assert found.shortages() == []


def test_muscle_too_weak_is_named_with_what_it_lacks():
    pairs = np.array([[[0.04, -0.03, 0.0, 0.0], [0.0, 0.0, 0.034, -0.021]]])
    found = static_optimization([[16.0, 10.2], [0.0, 85.0]], pairs, FORCE, np.zeros((1, 4)))
    assert found.feasible.tolist() == [True, False]
    assert found.activation.max() <= 1.0
    assert [(s.muscle, s.frame, round(s.needed, 6)) for s in found.shortages()] == [(2, 1, 2.5)]
    text = found.explanation(["deltoid", "lat", "biceps", "triceps"], ["shoulder", "elbow"], [0.0, 0.1])
    assert text == "the muscles do not suffice in 1 of 2 frames: biceps lacks 150% of its force at 0.1 s"


def test_torque_that_no_muscle_pulls_for_is_unreachable():
    found = static_optimization([[-7.0]], [[[0.04, 0.03]]], [[100.0, 100.0]], [[0.0, 0.0]])
    np.testing.assert_allclose(found.unreachable, [[-7.0]])
    assert "no muscle makes the -7 N m of knee at 0.5 s" in found.explanation(["a", "b"], ["knee"], [0.5])


def test_muscle_without_force_is_left_alone():
    found = static_optimization([[4.0]], [[[0.04, 0.04]]], [[1000.0, 0.0]], [[0.0, 0.0]])
    np.testing.assert_allclose(found.activation, [[0.1, 0.0]], atol=1e-9)


def test_frames_of_throws_take_a_small_part_of_what_a_general_solver_takes():
    wanted = torques(np.random.default_rng(1).random((330, 4)) * 1.3)

    def general(t):
        equal = {"type": "eq", "fun": lambda a: torques(a[None])[0] - wanted[t]}
        minimize(lambda a: a @ a, np.full(4, 0.5), bounds=[(0, 1)] * 4, constraints=[equal])

    def taken(work):  # processor time, s
        begin = time.process_time()
        work()
        return time.process_time() - begin

    ours = min(taken(lambda: static_optimization(wanted, ARMS[None], FORCE, np.zeros((1, 4)))) for _ in range(3)) / 330
    others = min(taken(lambda t=t: general(t)) for t in range(3))
    assert ours < 0.5 * others


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"torque": [1.0]}, "torques are (frames, joints)"),
        ({"moment_arm": np.zeros((1, 3, 4))}, "moment arms have shape (1, 3, 4), not (2, 2, 4)"),
        ({"active_force": np.zeros((3, 4))}, "active forces have shape (3, 4), not (2, 4)"),
        ({"passive_force": np.full((2, 4), np.nan)}, "passive forces hold a value that is not finite, in frame 0"),
        ({"active_force": -FORCE}, "active force of muscle 0 is negative in frame 0"),
    ],
)
def test_input_that_does_not_fit_is_said(changed, says):
    given = {"torque": np.zeros((2, 2)), "moment_arm": ARMS[None], "active_force": FORCE, "passive_force": FORCE}
    with pytest.raises(Error) as caught:
        static_optimization(**given | changed)
    assert says in str(caught.value)
