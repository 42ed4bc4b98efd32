"""Actuators and ligaments among muscles: polynomials of pieces and forces in float64, many muscles and instances."""

import numpy as np
import warp as wp
from probes import filled

from warpmuscle.kernels.curve.curve_sets import LEE, LIGAMENT, PATH_ACTUATOR
from warpmuscle.kernels.muscle import cables
from warpmuscle.kernels.muscle.contraction import RIGID, contraction_of
from warpmuscle.kernels.objective.term_functions import MuscleWork
from warpmuscle.kernels.path.path import PathState
from warpmuscle.kernels.structs import (
    Model,
    ModelRef,
    MuscleRow,
    Muscles,
    MuscleState,
    Scratch,
    ScratchRef,
    State,
    StateRef,
)

STARTS, COEFFICIENTS = (0.9, 1.1, 1.4), ((0.1, 0.5, -0.2, 0.3), (0.7, -1.2, 0.4, 2.0), (1.5, 2.5, -0.7, -0.1))
DISSIPATION = 0.35  # s/m
FAMILIES = (LEE, PATH_ACTUATOR, LIGAMENT)
F_MAX, L_SLACK = (900.0, 40.0, 250.0), (0.2, 0.3, 0.25)
FIRST = 2  # row of the table
TABLE = np.concatenate(
    [np.full((FIRST, 2), 9.0), [(len(STARTS), DISSIPATION)]]
    + [[(start, c[0]), (c[1], c[2]), (c[3], 0.0)] for start, c in zip(STARTS, COEFFICIENTS, strict=True)]
).astype(np.float32)


def tension(stretch: float, speed: float) -> float:
    """Of the ligament over its scale: cubics of the distance from the start of the piece; none when it is slack."""
    if stretch <= 1.0:
        return 0.0
    piece = max((k for k, start in enumerate(STARTS) if start <= stretch), default=0)
    return np.polyval(COEFFICIENTS[piece][::-1], stretch - STARTS[piece]) * (1.0 + DISSIPATION * speed)


@wp.kernel(enable_backward=False)
def evaluated(table: wp.array[wp.vec2], first: int, x: wp.array[float], value: wp.array2d[float]):
    i = wp.tid()
    value[i, 0] = cables.piecewise(table, first, x[i])
    value[i, 1] = cables.ligament_tension(table, first, x[i], 0.7)


def test_a_function_of_pieces_is_the_cubic_of_the_piece_and_a_slack_ligament_pulls_not():
    x = np.linspace(0.5, 2.0, 151)
    table, value = wp.array(TABLE, dtype=wp.vec2, device="cpu"), wp.zeros((len(x), 2), device="cpu")
    wp.launch(evaluated, len(x), [table, FIRST, wp.array(x.astype(np.float32), device="cpu"), value], device="cpu")
    pieces = np.clip(np.searchsorted(STARTS, x.astype(np.float32).astype(float), side="right") - 1, 0, None)
    expected = [np.polyval(COEFFICIENTS[k][::-1], v - STARTS[k]) for k, v in zip(pieces, x, strict=True)]
    inside = np.abs(x[:, None] - STARTS).min(axis=1) > 1e-4
    np.testing.assert_allclose(value.numpy()[inside, 0], np.array(expected)[inside], rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(value.numpy()[inside, 1], [tension(v, 0.7) for v in x[inside]], rtol=1e-5, atol=1e-5)


@wp.func
def count(instance: int, m: int, w: MuscleWork, model: ModelRef, state: StateRef, work: ScratchRef):
    state.muscles.force[instance, m] = state.muscles.force[instance, m] + w.activation


count_muscles = cables.terms_of_muscles(count)


@wp.kernel(enable_backward=False)
def counted(model: Model, state: State, work: Scratch):
    i, m = wp.tid()
    w, its = MuscleWork(), work
    w.activation = 0.25
    count_muscles(i, m, w, model, state, its)


def test_terms_count_muscles_and_no_cables():
    model = filled(Model, muscles=filled(Muscles, shape={"curves": [FAMILIES]}))
    state = filled(State, muscles=filled(MuscleState, force=np.ones((1, 3), np.float32)))
    wp.launch(counted, (1, 3), [model, state, Scratch()], device="cpu")
    np.testing.assert_allclose(state.muscles.force.numpy(), [[1.25, 1.0, 1.0]])


contracted = cables.with_cables(contraction_of(LEE, RIGID))
plain = contraction_of(LEE, RIGID)


@wp.kernel(enable_backward=False)
def pulling(
    model: Model, state: State, activation: float, excitation: float, stretch: PathState, row: wp.array[MuscleRow],
    force: wp.array2d[float], signal: wp.array2d[wp.vec2],
):  # fmt: skip
    i, m = wp.tid()
    signal[i, m] = cables.cable_signals(i, m, activation, excitation, model)
    force[i, m] = contracted(i, m, activation, stretch, row[m], model, state).force
    if m == 0:
        force[i, 3] = plain(i, m, activation, stretch, row[m], model, state).force
    if cables.is_cable(i, m, model):
        force[i, 4 + m] = 1.0


def pulled(excitation: float, activation: float = 0.6) -> tuple[np.ndarray, np.ndarray]:
    """Forces and signals of two instances, of which the second has its three muscles in another order."""
    orders = np.array([(0, 1, 2), (2, 0, 1)])
    shape = {"curves": np.array(FAMILIES)[orders], "table": np.full((2, 3), FIRST)}
    model = filled(Model, muscles=filled(Muscles, shape=shape, curve_table=TABLE))
    rows = {"f_max": F_MAX, "l_slack": L_SLACK, "l_opt": (0.1, 0.1, 0.1), "v_max": (10.0,) * 3}
    muscles = filled(Rows, row=rows)
    stretch = PathState()
    stretch.fixed, stretch.moving, stretch.speed = 0.11, 0.25, 0.4
    force, signal = wp.zeros((2, 7), device="cpu"), wp.zeros((2, 3), dtype=wp.vec2, device="cpu")
    given = [model, State(), activation, excitation, stretch, muscles.row, force, signal]
    wp.launch(pulling, (2, 3), given, device="cpu")
    return force.numpy(), signal.numpy()


@wp.struct
class Rows:
    """Numbers of muscles."""

    row: wp.array[MuscleRow]


def test_an_actuator_pulls_by_its_activation_and_a_ligament_by_its_length_whichever_muscle_each_is():
    force, _ = pulled(0.3)
    assert force[0, 1] == np.float32(0.6 * F_MAX[1])
    np.testing.assert_allclose(force[0, 2], F_MAX[2] * tension(0.36 / L_SLACK[2], 0.4), rtol=1e-5)
    np.testing.assert_allclose(force[1, 0], F_MAX[0] * tension(0.36 / L_SLACK[0], 0.4), rtol=1e-5)
    np.testing.assert_allclose(force[1, 2], 0.6 * F_MAX[2], rtol=1e-6)
    assert force[0, 0] == force[0, 3]
    np.testing.assert_array_equal(force[:, 4:], [[0.0, 1.0, 1.0], [1.0, 0.0, 1.0]])


def test_an_actuator_follows_its_excitation_within_bounds_a_ligament_none_and_a_muscle_its_own():
    for excitation, followed in ((0.3, 0.3), (-0.4, 0.0), (1.7, 1.0)):
        _, signal = pulled(excitation)
        expected = {LEE: (0.6, excitation), PATH_ACTUATOR: (followed, excitation), LIGAMENT: (0.0, 0.0)}
        for i, families in enumerate((FAMILIES, (LIGAMENT, LEE, PATH_ACTUATOR))):
            np.testing.assert_allclose(signal[i], [expected[family] for family in families], rtol=1e-6)
