"""Laws of contraction: the legacy law, and how much a force changes with the speed of the path."""

import numpy as np
import warp as wp
from probes import evaluate, filled

from warpmuscle.kernels.curve.curves import LEE
from warpmuscle.kernels.muscle import muscle
from warpmuscle.kernels.muscle.contraction import RIGID, Contraction, contraction_of
from warpmuscle.kernels.muscle.legacy_law import legacy_contraction
from warpmuscle.kernels.path.path import PathState
from warpmuscle.kernels.structs import Model, MuscleRow, MuscleState, State

F_MAX, L_OPT, SLACK, STEP = 800.0, 0.12, 0.2, 0.0005
damped = contraction_of(LEE, RIGID, implicit=True)


@wp.kernel(enable_backward=False)
def contract(
    legacy: bool, path: wp.array2d[float], activation: wp.array[float], row: MuscleRow, model: Model, state: State,
    result: wp.array[Contraction],
):  # fmt: skip
    i = wp.tid()
    stretch = PathState()
    stretch.fixed = path[i, 0]
    stretch.moving = path[i, 1]
    stretch.speed = path[i, 2]
    if legacy:
        result[i] = legacy_contraction(i, 0, activation[i], stretch, row, model, state)
    else:
        result[i] = damped(i, 0, activation[i], stretch, row, model, state)


def contracted(
    legacy: bool, path: np.ndarray, activation: np.ndarray, step: int = 1, before: float = 0.1, **row: float
):
    """Contractions on paths (n, 3) of a fixed part, a moving part and a speed; and the fibre lengths kept."""
    count = len(path)
    own = filled(MuscleRow, f_max=F_MAX, l_opt=L_OPT, l_slack=SLACK, v_max=10.0, damping=0.1, **row)
    muscles = filled(MuscleState, fibre_length=np.full((count, 1), before, np.float32))
    state = filled(State, step=np.full(count, step, np.int32), muscles=muscles)
    result = wp.zeros(count, dtype=Contraction, device="cpu")
    given = [wp.array(np.float32(v), dtype=float, device="cpu") for v in (path, activation)]
    wp.launch(contract, count, [legacy, *given, own, filled(Model, time_step=STEP), state, result], device="cpu")
    return result.numpy(), state.muscles.fibre_length.numpy()[:, 0].astype(float)


def paths(count: int = 60, speed: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Of fibres of 0.6 to 1.3 optimal lengths; and activations."""
    rng = np.random.default_rng(3)
    fixed, fibre = rng.uniform(0.02, 0.12, count), L_OPT * rng.uniform(0.6, 1.3, count)
    moving = SLACK + fibre - fixed
    return np.stack([fixed, moving, rng.uniform(-speed, speed, count)], axis=1), rng.uniform(0.05, 1.0, count)


def test_legacy_fibres_have_what_the_tendon_leaves_of_the_whole_path_up_to_their_optimal_length():
    path, activation = paths()
    found, kept = contracted(True, path, activation)
    whole = path[:, 0] + path[:, 1]
    length = np.minimum(whole - SLACK, L_OPT)
    assert 10 < np.sum(length == L_OPT) < 50
    np.testing.assert_allclose(found["length"], length, atol=1e-6)
    np.testing.assert_allclose(found["speed"], (length - 0.1) / STEP, atol=1e-6 / STEP)
    np.testing.assert_allclose(kept, length, atol=1e-6)
    expected = evaluate(muscle.legacy_force, F_MAX, activation, found["length"], found["speed"], L_OPT)
    np.testing.assert_allclose(found["force"], expected, rtol=1e-5, atol=1e-3)


def test_a_legacy_fibre_has_no_speed_in_the_first_step():
    path, activation = paths()
    found, kept = contracted(True, path, activation, step=0)
    np.testing.assert_array_equal(found["speed"], 0.0)
    np.testing.assert_allclose(kept, np.minimum(path[:, 0] + path[:, 1] - SLACK, L_OPT), atol=1e-6)


def test_damping_is_the_slope_of_the_force_by_the_speed_of_the_path():
    for width in (0.0, 0.04):
        path, activation = paths(speed=0.6)
        path[:, 1] += np.sqrt((path[:, 0] + path[:, 1] - SLACK) ** 2 - width**2) - (path[:, 0] + path[:, 1] - SLACK)
        found, _ = contracted(False, path, activation, width=width)
        step = np.array([0.0, 0.0, 2e-3])
        up, down = (contracted(False, path + sign * step, activation, width=width)[0]["force"] for sign in (1, -1))
        slope = (up.astype(float) - down.astype(float)) / 4e-3
        away = np.abs(path[:, 2]) > 0.01  # not across the corner of the force-velocity curve
        np.testing.assert_allclose(found["damping"][away], slope[away], rtol=0.02, atol=0.5)
        assert np.ptp(found["damping"]) > 100.0
