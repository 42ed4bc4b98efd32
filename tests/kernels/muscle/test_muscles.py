"""Kernels over muscles of instances against the functions they are made of."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate

from warpmuscle.core.arrays import structs_to_device
from warpmuscle.kernels.curve.curves import MILLARD
from warpmuscle.kernels.muscle import activation, muscle, muscles
from warpmuscle.kernels.structs import MuscleRow, Muscles, MuscleState

INSTANCES, MUSCLES, CAPACITY, TIME_STEP = 3, 4, 16, 1.0 / 2000.0
OWN = ("l_opt", "l_slack", "width", "v_max", "damping")  # as the functions take them


def setting(rows: int) -> tuple[Muscles, MuscleState, dict[str, np.ndarray]]:
    """Random muscles with numbers for all instances (one row) or for each, their state, and the numbers as arrays."""
    low = [500.0, 0.05, 0.05, 0.0, 8.0, 0.05, 0.01, 0.03]
    high = [2000.0, 0.1, 0.3, 0.02, 12.0, 0.15, 0.02, 0.06]
    names = ("f_max", *OWN, "rise_time", "fall_time")
    drawn = np.random.default_rng(0).uniform(low, high, (rows, MUSCLES, len(names)))
    numbers = {name: drawn[..., i] for i, name in enumerate(names)}
    model, state = Muscles(), MuscleState()
    model.model = MILLARD
    rests = {f"{way}_rest": np.exp(-TIME_STEP / numbers[f"{way}_time"]) for way in ("rise", "fall")}
    columns = numbers | rests | {"delay_steps": np.arange(MUSCLES)[None]}
    model.row = structs_to_device(MuscleRow, columns, "cpu")
    full = {name: np.broadcast_to(value, (INSTANCES, MUSCLES)).ravel() for name, value in numbers.items()}
    numbers = full | {"activation": np.random.default_rng(1).random(INSTANCES * MUSCLES)}
    state.activation = wp.array(numbers["activation"].reshape(INSTANCES, MUSCLES), dtype=float, device="cpu")
    state.excitation_ring = wp.zeros((INSTANCES, CAPACITY, MUSCLES), dtype=float, device="cpu")
    for name in ("fibre_length", "previous_fibre_length", "force"):
        setattr(state, name, wp.zeros((INSTANCES, MUSCLES), dtype=float, device="cpu"))
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
    own, before, now = [n[name] for name in OWN], start, start
    for step in range(1, 4):
        then = mt_length + step * TIME_STEP * mt_speed
        launch(muscles.muscle_force_compliant, model, then, TIME_STEP, state)
        length = evaluate(muscle.compliant_step, MILLARD, n["activation"], then, now, before, *own, TIME_STEP)
        before, now = now, length
        force = n["f_max"] * evaluate(muscle.compliant_force, MILLARD, then, now, n["l_slack"], n["width"])
        np.testing.assert_allclose(state.fibre_length.numpy().ravel(), now, atol=1e-6)
        np.testing.assert_allclose(state.force.numpy().ravel(), force, atol=2e-4 * n["f_max"].max())


@pytest.mark.parametrize("scaled", [False, True], ids=["linear", "scaled"])
def test_activations_follow_delayed_excitations(scaled: bool):
    """Muscle m hears of an excitation m steps late."""
    model, state, n = setting(1)
    model.scaled_rates = int(scaled)
    excitation = np.random.default_rng(2).random((30, INSTANCES * MUSCLES))
    delay = np.tile(np.arange(MUSCLES), INSTANCES)
    expected = n["activation"]
    for step in range(30):
        launch(muscles.activate, model, excitation[step], step, TIME_STEP, state)
        heard = excitation[np.maximum(step - delay, 0), np.arange(INSTANCES * MUSCLES)]
        rate = 1.0 / np.where(heard > expected, n["rise_time"], n["fall_time"])
        if scaled:
            rate = evaluate(activation.activation_rate, expected, heard, n["rise_time"], n["fall_time"])
        expected = evaluate(activation.activation_relaxed, expected, heard, rate, TIME_STEP)
        np.testing.assert_allclose(state.activation.numpy().ravel(), expected, atol=1e-6)
