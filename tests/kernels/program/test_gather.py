"""What muscles are told of a programme's answer: excitations by which they come to it, each with its own times."""

import numpy as np
import pytest
import warp as wp
from probes import filled

from warpmuscle.kernels.muscle_structs import Muscles
from warpmuscle.kernels.program.controller import REPORTED
from warpmuscle.kernels.program.gather import tell_muscles
from warpmuscle.kernels.program.structs import Layout, Programs
from warpmuscle.kernels.structs import Model, MuscleState, State

EVERY, STEP = 10, 0.001  # steps between decisions, and s
RISE = np.array([[0.01, 0.02, 0.015], [0.03, 0.012, 0.025]])  # s, by instance and muscle
FALL = np.array([[0.05, 0.04, 0.06], [0.03, 0.07, 0.045]])
NOW = np.array([[0.2, 0.5, 0.4], [0.3, 0.6, 0.5]])  # activations
AIM = np.array([[0.3, 0.45, 0.42], [0.38, 0.55, 0.56]])


@pytest.mark.parametrize("rows", [1, 2], ids=["one row for all", "a row each"])
def test_excitations_bring_activations_to_their_aim_until_the_next_decision(rows: int):
    """a(t) = e + (a - e) exp(-t/T), solved for e."""
    muscles = filled(Muscles, count=3, row={"rise_time": RISE[:rows], "fall_time": FALL[:rows]})
    model = filled(Model, time_step=STEP, muscles=muscles)
    state = filled(State, muscles=filled(MuscleState, activation=np.float32(NOW)))
    layout = filled(Layout, every=EVERY, torque=np.zeros((0, 2), np.int32))
    programs = filled(Programs, wanted=np.zeros((2, 1), np.float32), weight=np.zeros((2, 1), np.float32))
    due, iterations = (wp.array(values, dtype=int, device="cpu") for values in ([1, 1], [4, 5]))
    control, acceleration = (wp.array(np.float32(v), device="cpu") for v in (AIM, np.zeros((2, 1))))
    memory = wp.zeros((2, 1, REPORTED + 3), dtype=float, device="cpu")
    given = [model, state, layout, due, programs, control, acceleration, iterations]
    wp.launch(tell_muscles, 2, given, [memory], device="cpu")
    own = [0, rows - 1]
    rest = np.exp(-EVERY * STEP / np.where(AIM > NOW, RISE[own], FALL[own]))
    wanted = (AIM - NOW * rest) / (1.0 - rest)
    assert np.all((wanted > 0.0) & (wanted < 1.0))
    np.testing.assert_allclose(memory.numpy()[:, 0, REPORTED:], wanted, rtol=1e-4)
    np.testing.assert_array_equal(memory.numpy()[:, 0, 1], [4.0, 5.0])
