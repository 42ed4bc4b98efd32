"""Kernels over muscles of instances against the functions they are made of."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate

from warpmuscle.kernels import activation, muscle, muscles
from warpmuscle.kernels.curves import MILLARD

INSTANCES, MUSCLES, CAPACITY, TIME_STEP = 3, 4, 16, 1.0 / 2000.0
OWN = ("l_opt", "l_slack", "width", "v_max", "damping")  # as the functions take them


def setting(rows: int) -> tuple[muscles.Muscles, muscles.MuscleState, dict[str, np.ndarray]]:
    """Random muscles with numbers for all instances (one row) or for each, their state, and the numbers as arrays."""
    low = [500.0, 0.05, 0.05, 0.0, 8.0, 0.05, 0.01, 0.03]
    high = [2000.0, 0.1, 0.3, 0.02, 12.0, 0.15, 0.02, 0.06]
    names = ("f_max", *OWN, "rise_time", "fall_time")
    drawn = np.random.default_rng(0).uniform(low, high, (rows, MUSCLES, len(names)))
    numbers = {name: drawn[..., i] for i, name in enumerate(names)}
    model, state = muscles.Muscles(), muscles.MuscleState()
    model.model = MILLARD
    for name in names:
        setattr(model, name, wp.array(numbers[name], dtype=float, device="cpu"))
    model.delay_steps = wp.array(np.arange(MUSCLES)[None], dtype=int, device="cpu")
    full = {name: np.broadcast_to(value, (INSTANCES, MUSCLES)).ravel() for name, value in numbers.items()}
    numbers = full | {"activation": np.random.default_rng(1).random(INSTANCES * MUSCLES)}
    state.activation = wp.array(numbers["activation"].reshape(INSTANCES, MUSCLES), dtype=float, device="cpu")
    state.excitation_ring = wp.zeros((CAPACITY, INSTANCES, MUSCLES), dtype=float, device="cpu")
    state.fibre_length = wp.zeros((INSTANCES, MUSCLES), dtype=float, device="cpu")
    state.force = wp.zeros((INSTANCES, MUSCLES), dtype=float, device="cpu")
    return model, state, numbers


def launch(kernel: wp.Kernel, *values) -> None:
    """Over all muscles; NumPy arrays (instances * muscles,) become Warp's."""
    given = [
        wp.array(v.reshape(INSTANCES, MUSCLES), dtype=float, device="cpu") if isinstance(v, np.ndarray) else v
        for v in values
    ]
    wp.launch(kernel, (INSTANCES, MUSCLES), given, device="cpu")


@pytest.mark.parametrize("rows", [1, INSTANCES])
def test_rigid_forces_are_those_of_the_function(rows: int):
    model, state, n = setting(rows)
    mt_length, mt_speed = n["l_slack"] + 0.9 * n["l_opt"], np.linspace(-0.3, 0.3, INSTANCES * MUSCLES)
    launch(muscles.muscle_force_rigid, model, mt_length, mt_speed, state)
    own = [n[name] for name in OWN]
    expected = n["f_max"] * evaluate(muscle.rigid_force, MILLARD, n["activation"], mt_length, mt_speed, *own)
    np.testing.assert_allclose(state.force.numpy().ravel(), expected, rtol=1e-5)


@pytest.mark.parametrize("rows", [1, INSTANCES])
def test_compliant_forces_are_those_of_the_functions(rows: int):
    model, state, n = setting(rows)
    mt_length, mt_speed = n["l_slack"] + n["l_opt"], np.linspace(-0.3, 0.3, INSTANCES * MUSCLES)
    launch(muscles.settle_fibres, model, mt_length, state)
    start = evaluate(
        muscle.fibre_equilibrium, MILLARD, n["activation"], mt_length, n["l_opt"], n["l_slack"], n["width"]
    )
    np.testing.assert_allclose(state.fibre_length.numpy().ravel(), start, atol=1e-6)
    then, own = mt_length + TIME_STEP * mt_speed, [n[name] for name in OWN]
    launch(muscles.muscle_force_compliant, model, then, mt_speed, TIME_STEP, state)
    length = evaluate(muscle.compliant_step, MILLARD, n["activation"], then, mt_speed, start, *own, TIME_STEP)
    force = n["f_max"] * evaluate(muscle.compliant_force, MILLARD, then, length, n["l_slack"], n["width"])
    np.testing.assert_allclose(state.fibre_length.numpy().ravel(), length, atol=1e-6)
    np.testing.assert_allclose(state.force.numpy().ravel(), force, atol=2e-4 * n["f_max"].max())


def test_activations_follow_delayed_excitations():
    """Muscle m hears of an excitation m steps late."""
    model, state, n = setting(1)
    excitation = np.random.default_rng(2).random((30, INSTANCES * MUSCLES))
    delay = np.tile(np.arange(MUSCLES), INSTANCES)
    expected = n["activation"]
    for step in range(30):
        launch(muscles.activate, model, excitation[step], step, TIME_STEP, state)
        heard = excitation[np.maximum(step - delay, 0), np.arange(INSTANCES * MUSCLES)]
        rate = evaluate(activation.activation_rate, expected, heard, n["rise_time"], n["fall_time"])
        expected = evaluate(activation.activation_relaxed, expected, heard, rate, TIME_STEP)
        np.testing.assert_allclose(state.activation.numpy().ravel(), expected, atol=1e-6)
