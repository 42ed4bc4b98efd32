"""How activations of one step follow excitations, where a muscle of a scene says which law: in float64."""

import numpy as np
import warp as wp
from probes import filled

from warpmuscle.kernels.curve.curves import LEE
from warpmuscle.kernels.muscle.contraction import RIGID
from warpmuscle.kernels.muscle.hill_law import (
    HILL,
    follow_blended,
    follow_excited,
    follow_excited_rise,
    follow_smoothly,
)
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.muscle.muscle_pipeline import MuscleStep
from warpmuscle.kernels.muscle_structs import Muscles
from warpmuscle.kernels.structs import BLENDED, EXCITED, EXCITED_RISE, Model, State

RISE, FALL, STEP = 0.012, 0.05, 0.004  # s
WIDTHS = 0.0, 0.4, BLENDED, EXCITED, EXCITED_RISE
FLOORS = np.float32([[0.1, 0.25]])
FLOORED = HILL.activate(MuscleKind(LEE, RIGID, HILL, floored=True))


@wp.kernel(enable_backward=False)
def follow(
    model: Model, state: State, rise: float, fall: float, a: wp.array[float], u: wp.array[float],
    smooth: wp.array2d[float], excited: wp.array[float], rising: wp.array[float],
    between: wp.array[float],
):  # fmt: skip
    i = wp.tid()
    muscle = MuscleStep()
    muscle.row.rise_time = rise
    muscle.row.fall_time = fall
    muscle.excitation = u[i]
    for m in range(5):
        smooth[m, i] = follow_smoothly(0, m, a[i], muscle, model, state)
    excited[i] = follow_excited(0, 0, a[i], muscle, model, state)
    rising[i] = follow_excited_rise(0, 0, a[i], muscle, model, state)
    between[i] = follow_blended(0, 0, a[i], muscle, model, state)


def test_activations_relax_at_the_rate_of_their_law():
    """a + (u - a)(1 - exp(-dt/tau)): Thelen's time constant, MuJoCo's smoothed one, 1/(c1 u + c2) of Hyfydy,
    that of De Groote 2016, equation 1, with OpenSim's b = 0.1, and of Schutte 1993, 1/c2 while an activation falls;
    of muscles of several laws side by side as well.
    """
    a, u = np.random.default_rng(3).random((2, 60))
    model = filled(Model, time_step=STEP, muscles=filled(Muscles, count=5, smoothing=np.float32([WIDTHS])))
    smooth = wp.zeros((5, 60), dtype=float, device="cpu")
    alone = [wp.zeros(60, dtype=float, device="cpu") for _ in range(3)]
    given = [wp.array(values.astype(np.float32), device="cpu") for values in (a, u)]
    wp.launch(follow, 60, [model, State(), RISE, FALL, *given], [smooth, *alone], device="cpu")
    scale = 0.5 + 1.5 * a
    up, down = RISE * scale, FALL / scale
    x = np.clip((u - a) / WIDTHS[1] + 0.5, 0.0, 1.0)
    blended = down + (up - down) * (6.0 * x**5 - 15.0 * x**4 + 10.0 * x**3)
    by_excitation = 1.0 / (u / RISE + (1.0 - u) / FALL)
    f = 0.5 * np.tanh(0.1 * (u - a))
    groote = 1.0 / ((0.5 + f) / up + (0.5 - f) / down)
    schutte = np.where(u >= a, by_excitation, FALL)
    laws = [np.where(u > a, up, down), blended, groote, by_excitation, schutte, by_excitation, schutte, groote]
    for got, tau in zip([*smooth.numpy(), *(one.numpy() for one in alone)], laws, strict=True):
        np.testing.assert_allclose(got, u + (a - u) * np.exp(-STEP / tau), atol=2e-6)


@wp.kernel(enable_backward=False)
def floored(model: Model, state: State, rise: float, fall: float, given: wp.array2d[float], after: wp.array2d[float]):
    m, i = wp.tid()
    muscle = MuscleStep()
    muscle.row.rise_time = rise
    muscle.row.fall_time = fall
    muscle.activation = given[0, i]
    muscle.excitation = given[1, i]
    wp.static(FLOORED)(0, m, muscle, model, state)
    after[m, i] = muscle.activation


def test_a_floor_holds_activations_up_before_and_after_a_step():
    """max(f, a') with a' from max(f, a), at Thelen's (2003) rate of the held-up activation, each muscle's own floor."""
    a, u = np.random.default_rng(4).random((2, 60)) * [[0.4], [1.0]]
    u[:20] *= 0.05  # below the floors
    model = filled(
        Model, time_step=STEP, muscles=filled(Muscles, count=2, scaled_rates=1, shape={"minimum_activation": FLOORS}),
    )  # fmt: skip
    after = wp.zeros((2, 60), dtype=float, device="cpu")
    given = wp.array(np.float32([a, u]), device="cpu")
    wp.launch(floored, (2, 60), [model, State(), RISE, FALL, given], [after], device="cpu")
    for floor, got in zip(FLOORS[0], after.numpy(), strict=True):
        start = np.maximum(floor, a)
        tau = np.where(u > start, RISE * (0.5 + 1.5 * start), FALL / (0.5 + 1.5 * start))
        np.testing.assert_allclose(got, np.maximum(floor, u + (start - u) * np.exp(-STEP / tau)), atol=2e-6)
        assert min((a < floor).sum(), (u < floor).sum(), (a > floor).sum()) >= 5
