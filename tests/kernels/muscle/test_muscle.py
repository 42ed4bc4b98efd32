"""Musculotendon forces: OpenSim's numbers, the law of the original program, bounds, and fibres on compliant tendons."""

import numpy as np
import pytest
import warp as wp
from hill import Reference, opensim_states
from probes import evaluate

from warpmuscle.kernels.curve import curves
from warpmuscle.kernels.curve.curves import DE_GROOTE, LEE, MILLARD, THELEN
from warpmuscle.kernels.muscle import muscle

MODELS = {"lee": LEE, "thelen": THELEN, "millard": MILLARD, "de groote": DE_GROOTE}
every_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
opensim_models = pytest.mark.parametrize("model", [THELEN, MILLARD], ids=["thelen", "millard"])
L_OPT, V_MAX, TIME_STEP = 0.1, 10.0, 1.0 / 2000.0


@wp.kernel(enable_backward=False)
def follow(
    # in
    model: int, activation: wp.array2d[float], mt_length: wp.array2d[float], start: wp.array[float],
    slack: wp.array[float], width: wp.array[float], damping: wp.array[float], time_step: float,
    # out
    length: wp.array2d[float], force: wp.array2d[float],
):  # fmt: skip
    """Fibre lengths and tendon forces (steps, units) of units from a fibre length at rest."""
    i = wp.tid()
    now = wp.float32(start[i])
    previous = wp.float32(start[i])
    for step in range(mt_length.shape[0]):
        then = muscle.compliant_step(
            model, activation[step, i], mt_length[step, i], now, previous,
            wp.static(L_OPT), slack[i], width[i], wp.static(V_MAX), damping[i], time_step,
        )  # fmt: skip
        previous = now
        now = then
        length[step, i] = now
        force[step, i] = muscle.compliant_force(model, mt_length[step, i], now, slack[i], width[i])


def followed(model: int, activation, mt_length, start, slack, width, damping, time_step: float):
    """Fibre lengths and forces of `follow` in float64, from arrays that broadcast to (steps, units) or (units,)."""
    shape = mt_length.shape
    given = [np.broadcast_to(v, shape) for v in (activation, mt_length)]
    given += [np.broadcast_to(v, shape[1:]) for v in (start, slack, width, damping)]
    given = [wp.array(np.ascontiguousarray(v, np.float32), dtype=float, device="cpu") for v in given]
    out = [wp.zeros(shape, dtype=float, device="cpu") for _ in range(2)]
    wp.launch(follow, shape[1], [model, *given, time_step, *out], device="cpu")
    return [v.numpy().astype(np.float64) for v in out]


REACH = 2.0 / 3.0 * TIME_STEP * V_MAX * L_OPT  # m, by which a fibre is longer after a step at the greatest speed
SLACK, WIDTH, DAMPING = 0.2, 0.02, 0.1


@wp.kernel(enable_backward=True, module="unique")
def balance(
    activation: wp.array[float], mt_length: wp.array[float], start: wp.array[float], l_opt: wp.array[float],
    reach: float, width: float, speed: wp.array[float], length: wp.array[float],
):  # fmt: skip
    i = wp.tid()
    speed[i] = muscle.equilibrium_speed(
        LEE, activation[i], mt_length[i], start[i], reach, 0.0, l_opt[i], wp.static(SLACK),
        width, wp.static(DAMPING),
    )  # fmt: skip
    length[i] = muscle.fibre_equilibrium(LEE, activation[i], mt_length[i], l_opt[i], wp.static(SLACK), width)


def balanced(
    *values: np.ndarray, which: int = 0, reach: float = REACH, width: float = WIDTH
) -> tuple[np.ndarray, np.ndarray]:
    """Speeds (n,), or lengths at rest, at which fibre and tendon balance; derivatives (4, n) by what is given."""
    given = [wp.array(np.float32(v), dtype=float, device="cpu", requires_grad=True) for v in values]
    results = [wp.zeros(len(values[0]), dtype=float, device="cpu", requires_grad=True) for _ in range(2)]
    with wp.Tape() as tape:
        wp.launch(balance, len(values[0]), [*given, reach, width, *results], device="cpu")
    tape.backward(grads={results[which]: wp.ones_like(results[which])})
    return results[which].numpy().astype(float), np.stack([v.grad.numpy() for v in given]).astype(float)


def units_of(count: int = 200) -> list[np.ndarray]:
    """Activation, length of the unit, of the fibre at the start of a step, and optimal length; tendons are taut."""
    rng = np.random.default_rng(8)
    start = (rng.uniform(0.7, 1.0, count) * L_OPT).astype(np.float32).astype(float)
    mt_length = np.sqrt(start**2 - WIDTH**2) + SLACK * (1.0 + rng.uniform(0.005, 0.02, count))
    return [rng.uniform(0.2, 0.9, count), mt_length, start, np.full(count, L_OPT)]


@pytest.mark.parametrize("which", [0, 1], ids=["speed", "length at rest"])
def test_equilibrium_has_the_derivatives_of_differences(which: int):
    """Of free fibres, by activation, the lengths of unit and fibre, and the optimal length."""
    values = units_of()
    found, slopes = balanced(*values, which=which)
    free = (np.abs(np.abs(found) - 0.4) < 0.35) | (which == 1)  # beyond the corner at rest, and within the bounds
    assert free.sum() > 50
    for k, step in enumerate((4e-3, 4e-5, 4e-5, 4e-5)):
        ends = [
            balanced(*(v + sign * step * (j == k) for j, v in enumerate(values)), which=which)[0]
            for sign in (1.0, -1.0)
        ]
        difference = (ends[0] - ends[1]) / (2.0 * step)
        off = np.abs(slopes[k] - difference)[free]
        assert np.quantile(off, 0.9) <= 0.03 * np.abs(difference[free]).max(), k


def test_a_fibre_as_short_as_it_may_be_does_not_depend_on_where_it_would_be():
    """As bound by its pennation: only activation slows its lengthening, and a longer unit makes it faster."""
    a, strain = (v.ravel() for v in np.meshgrid(np.linspace(0.2, 0.9, 8), np.linspace(0.001, 0.012, 12)))
    start, shortest = np.full(len(a), 0.7 * WIDTH), WIDTH / np.sqrt(0.99)
    v, slopes = balanced(a, SLACK * (1.0 + strain) + 0.1 * shortest, start, np.full(len(a), L_OPT))
    well = np.abs(np.abs(v) - 0.45) < 0.4
    assert well.sum() > 10
    np.testing.assert_allclose(slopes[2], 0.0, atol=1e-6)
    assert slopes[0, well].max() < 0.0
    assert slopes[1, well].min() > 0.1


def test_a_fibre_as_short_as_a_part_of_its_optimum_is_longer_where_that_is():
    """Without pennation: 5 % of l_opt. Differences of speeds, some of which a kink lies between."""
    a, strain = (v.ravel() for v in np.meshgrid(np.linspace(0.2, 0.9, 8), np.linspace(0.001, 0.012, 12)))
    values = [a, SLACK * (1.0 + strain) + 0.05 * L_OPT, np.full(len(a), 0.03 * L_OPT), np.full(len(a), L_OPT)]
    v, slopes = balanced(*values, width=0.0)
    ends = [balanced(*values[:3], values[3] + step, width=0.0)[0] for step in (1e-4, -1e-4)]
    well = np.abs(np.abs(v) - 0.45) < 0.4
    assert well.sum() > 10
    difference = (ends[0] - ends[1])[well] / 2e-4
    assert difference.max() < -0.5  # 1/m: a longer fibre leaves its tendon less
    assert np.quantile(np.abs(slopes[3, well] - difference), 0.9) <= 0.03 * np.abs(difference).max()


@pytest.mark.parametrize("longer", [1.0, 10.0])
def test_fibre_and_tendon_are_in_equilibrium_at_the_speed_that_is_found(longer: float):
    """(a f_l f_v + f_p + damping v) cos(pennation) = f_t (Millard 2013, eq. 8), by the curves of the device.

    In steps of half a millisecond, and of five, within which the tendon takes up most.
    """
    a, mt_length, start, l_opt = units_of()
    v = balanced(a, mt_length, start, l_opt, reach=longer * REACH)[0]
    length = start + longer * REACH * v
    along = np.sqrt(length**2 - WIDTH**2)
    fibre = evaluate(muscle.fibre_force, LEE, a, length / L_OPT, v, DAMPING) * along / length
    tendon = evaluate(curves.tendon_force_strain, LEE, (mt_length - SLACK - along) / SLACK)
    inside = (v > -0.99) & (v < 0.99)
    assert inside.sum() > 150
    assert np.quantile(np.abs(fibre - tendon)[inside], 0.9) < 5e-4


def test_no_fibre_shortens_faster_than_its_greatest_speed():
    """A slack tendon lets it go: 1 v_max, also where the balance asks for more."""
    start = np.full(3, 0.15)
    v = balanced(np.array([0.0, 0.01, 1.0]), np.full(3, 0.15), start, np.full(3, L_OPT))[0]
    assert v.min() == pytest.approx(-1.0, abs=1e-3)


@opensim_models
@pytest.mark.parametrize("kind", ["random_state", "static_equilibrium"])
def test_forces_of_fibre_and_tendon_are_those_of_opensim(model: int, kind: str, reference_data):
    s = opensim_states(reference_data, model, kind)
    tendon = evaluate(muscle.compliant_force, model, s.mt_length, s.length, s.l_slack, s.width)
    damping = muscle.FIBRE_DAMPING if model == MILLARD else 0.0
    fibre = evaluate(muscle.fibre_force, model, s.activation, s.length / s.l_opt, s.speed, damping)
    np.testing.assert_allclose(tendon, s.force, atol=5e-4)
    np.testing.assert_allclose(fibre * np.sqrt(1.0 - (s.width / s.length) ** 2), s.force, atol=5e-4)


@opensim_models
def test_static_equilibrium_is_that_of_opensim(model: int, reference_data):
    s = opensim_states(reference_data, model, "static_equilibrium")
    length = evaluate(muscle.fibre_equilibrium, model, s.activation, s.mt_length, s.l_opt, s.l_slack, s.width)
    force = evaluate(muscle.compliant_force, model, s.mt_length, length, s.l_slack, s.width)
    np.testing.assert_allclose(force, s.force, atol=5e-4)


@opensim_models
def test_speed_of_equilibrium_is_that_of_opensim(model: int, reference_data):
    """With no time to move, the step's speed is the one that balances fibre and tendon."""
    s = opensim_states(reference_data, model, "random_state")
    damping = muscle.FIBRE_DAMPING if model == MILLARD else 0.0
    own, v = (s.l_opt, s.l_slack, s.width, damping), 0.0
    for _ in range(3):  # the first ends within the tolerances of a step
        v = evaluate(muscle.equilibrium_speed, model, s.activation, s.mt_length, s.length, 0.0, v, *own)
    force = evaluate(muscle.fibre_force, model, s.activation, s.length / s.l_opt, v, damping)
    np.testing.assert_allclose(force * np.sqrt(1.0 - (s.width / s.length) ** 2), s.force, atol=5e-4)


def test_rigid_tendon_leaves_the_fibre_what_it_does_not_take():
    length, width = np.random.default_rng(0).uniform([[0.05], [0.0]], [[0.2], [0.04]], (2, 200))
    mt_length = 0.3 + evaluate(muscle.along_tendon, length, width)
    np.testing.assert_allclose(evaluate(muscle.rigid_fibre_length, mt_length, L_OPT, 0.3, width), length, atol=1e-6)
    moved = evaluate(muscle.rigid_fibre_length, mt_length + 1e-3, L_OPT, 0.3, width)
    back = evaluate(muscle.rigid_fibre_length, mt_length - 1e-3, L_OPT, 0.3, width)
    speed = evaluate(muscle.rigid_fibre_speed, 1.0, length, width)
    np.testing.assert_allclose(speed, (moved - back) / 2e-3, atol=1e-3)


@every_model
def test_rigid_and_compliant_units_agree_with_a_very_stiff_tendon_at_rest(model: int):
    """A tendon much shorter than the fibre hardly stretches."""
    mt_length, slack, width = np.linspace(0.06, 0.14, 50) + 1e-3, 1e-3, 0.02
    length = evaluate(muscle.fibre_equilibrium, model, 0.5, mt_length, L_OPT, slack, width)
    compliant = evaluate(muscle.compliant_force, model, mt_length, length, slack, width)
    rigid = evaluate(muscle.rigid_force, model, 0.5, mt_length, 0.0, L_OPT, slack, width, V_MAX, 0.1)
    np.testing.assert_allclose(compliant, rigid, atol=5e-3)


def test_legacy_law_is_that_of_the_original_program():
    """Written out from its source: switch, gaussian, hyperbolas, and a passive term in N; negative forces stay."""
    rng, l_slack, f_max = np.random.default_rng(0), 0.2, 800.0
    mt_length, speed, a = rng.uniform([[0.15], [-2.0], [0.0]], [[0.4], [2.0], [1.0]], (3, 500))
    length = evaluate(muscle.switched_fibre_length, mt_length, L_OPT, l_slack)
    rigid = mt_length - L_OPT < l_slack
    np.testing.assert_allclose(length, np.where(rigid, mt_length - l_slack, L_OPT), atol=1e-7)
    x, v = length / L_OPT, speed / L_OPT
    big = v * (2.0 + 2.0 / 0.3)
    factor = np.where(v <= 0.0, (v + 10.0) / (10.0 - v / 0.3), (1.8 * big + 8.0) / (big + 8.0))
    expected = f_max * a * np.exp(-((x - 1.0) ** 2) / 0.5) * factor
    force = evaluate(muscle.legacy_force, f_max, a, length, speed, L_OPT)
    np.testing.assert_allclose(force, expected, atol=2e-3)
    assert force.min() < 0.0
    long = evaluate(muscle.legacy_force, f_max, 0.0, 1.3 * L_OPT, 0.0, L_OPT)
    np.testing.assert_allclose(long, np.expm1(4.0 * 0.3 / 0.6) / np.expm1(4.0), rtol=1e-4)


def test_switched_tendon_stretches_alone_beyond_the_optimal_length():
    speed = evaluate(muscle.switched_fibre_speed, np.array([0.25, 0.35]), 0.7, L_OPT, 0.2)
    np.testing.assert_allclose(speed, [0.7, 0.0], rtol=1e-6)


@every_model
def test_no_state_gives_a_force_out_of_bounds(model: int):
    rng = np.random.default_rng(0)
    a, mt_length, speed = rng.uniform([[0.0], [0.0], [-50.0]], [[1.0], [3.0], [50.0]], (3, 5000))
    force = evaluate(muscle.rigid_force, model, a, mt_length, speed, L_OPT, 0.3, 0.03, V_MAX, 0.1)
    assert force.min() >= 0.0
    assert force.max() < 1.5 + 2.5 + 0.1
    length = evaluate(muscle.rigid_fibre_length, mt_length, L_OPT, 0.3, 0.0)
    assert length.min() == pytest.approx(0.05 * L_OPT)


@every_model
def test_step_stays_finite_and_bounded_from_any_state(model: int):
    """Slack, short, long, and pulled at thousands of f_max."""
    rng, slack = np.random.default_rng(1), np.array([0.05, 0.1, 0.3, 1.0])[np.arange(4000) % 4]
    a, over, length, width = rng.uniform([[0.0], [-0.2], [0.0], [0.0]], [[1.0], [0.5], [0.3], [0.06]], (4, 4000))
    length = evaluate(muscle.bounded_fibre_length, length, L_OPT, width)
    before = length + TIME_STEP * V_MAX * L_OPT * rng.uniform(-1.0, 1.0, 4000)
    before = evaluate(muscle.bounded_fibre_length, before, L_OPT, width)
    given = slack + over, length, before, L_OPT, slack, width, V_MAX, 0.1, TIME_STEP
    end = evaluate(muscle.compliant_step, model, a, *given)
    assert np.all(np.isfinite(end))
    moved = (end - length) / (TIME_STEP * V_MAX * L_OPT)
    assert moved.min() >= -1.001
    assert moved.max() <= 1.001 * muscle.FASTEST_STRETCH
    np.testing.assert_array_less(width, end + 1e-6)


@every_model
def test_fibre_on_a_compliant_tendon_follows_a_sinusoidal_stretch(model: int):
    """Against steps five times finer, in float64: within 1 % of f_max, and 0.2 % once the sudden start is over."""
    grid = np.meshgrid([0.05, 0.1, 0.3, 1.0], [0.01, 0.1, 0.5, 1.0], [0.0, 0.4], indexing="ij")
    slack, a, pennation = (axis.ravel() for axis in grid)
    width, fine, steps = L_OPT * np.sin(pennation), 5, 400
    turn = 2.0 * np.pi * 4.0 * TIME_STEP / fine * np.arange(fine * steps + 1)[:, None]
    path = slack + L_OPT * np.cos(pennation) + 0.15 * L_OPT * np.sin(turn)
    start = evaluate(muscle.fibre_equilibrium, model, a, path[0], L_OPT, slack, width)
    reference = Reference(model, a, L_OPT, slack, width, V_MAX, 0.1).forces(path, start, TIME_STEP / fine)[::fine]
    _, force = followed(model, a, path[fine::fine], start, slack, width, 0.1, TIME_STEP)
    np.testing.assert_allclose(force, reference[1:], atol=0.01)
    np.testing.assert_allclose(force[10:], reference[11:], atol=0.002)


@every_model
def test_halving_the_step_divides_the_error_by_about_four(model: int):
    """Of a stretch that starts at rest and smoothly, against steps eight times finer."""
    slack, a = (axis.ravel() for axis in np.meshgrid([0.1, 0.3], [0.3, 1.0], indexing="ij"))
    finest, ends = TIME_STEP / 2.0, []
    for coarser in (16, 8, 1):
        time = finest * coarser * np.arange(1, 1600 // coarser + 1)[:, None]
        path = slack + L_OPT * (1.0 + 0.05 * (1.0 - np.cos(2.0 * np.pi * 2.0 * time)))
        start = evaluate(muscle.fibre_equilibrium, model, a, slack + L_OPT, L_OPT, slack, 0.0)
        _, force = followed(model, a, path, start, slack, 0.0, 0.1, finest * coarser)
        ends.append(force[16 // coarser - 1 :: 16 // coarser])
    rough, half = (np.sqrt(np.mean((force - ends[2]) ** 2)) for force in ends[:2])
    assert half < 0.35 * rough


@every_model
def test_damping_takes_up_the_same_impulse_of_a_jump_in_steps_of_any_length(model: int):
    """Of a fibre without activation, less its passive force: beta times its stretch."""
    slack, start, out, beta = 0.2, 0.7 * L_OPT, np.array([0.1, 0.02]) * L_OPT, 0.1
    for time_step in (2e-3, 5e-4, 1e-4):
        path = np.repeat((slack + start + out)[None], int(0.3 / time_step), axis=0)
        length, force = followed(model, 0.0, path, np.full(2, start), slack, 0.0, beta, time_step)
        passive = evaluate(muscle.bounded_passive, model, (length / L_OPT).ravel()).reshape(length.shape)
        impulse = time_step * (force - passive).sum(axis=0)
        stretch = length[-1] - start
        assert np.all(stretch > 0.5 * out)
        np.testing.assert_allclose(impulse, beta * stretch / (V_MAX * L_OPT), rtol=0.02, atol=0.4 * beta * time_step)


PHASES = [(1.0, 0.0), (0.01, 0.0), (0.0, 0.0), (0.3, -0.5), (0.3, 0.3), (1.0, 0.5), (0.5, -0.1)]  # activation, l_opt


@pytest.mark.usefixtures("optimized_test")
@every_model
@pytest.mark.parametrize(("rate", "overshoot"), [(4000, 0.1), (2000, 0.15), (500, 0.25)])
def test_jumps_of_activation_and_length_settle_without_oscillation(model: int, rate: int, overshoot: float):
    """Full and no activation, a tendon that falls slack, and one that is taken up and torn by half of l_opt."""
    grid = np.meshgrid([0.05, 0.1, 0.3, 1.0], [0.0, 0.3, 0.6], [0.7, 1.0, 1.3], [0.0, 0.02, 0.1], indexing="ij")
    slack, pennation, x, damping = (axis.ravel() for axis in grid)
    width, steps = L_OPT * np.sin(pennation), int(0.6 * rate)
    base = 1.01 * slack + np.sqrt((x * L_OPT) ** 2 - width**2)
    a = np.repeat([a for a, _ in PHASES], steps)[:, None]
    path = base + L_OPT * np.repeat([by for _, by in PHASES], steps)[:, None]
    start = evaluate(muscle.fibre_equilibrium, model, 0.01, base, L_OPT, slack, width)
    length, force = followed(model, a, path, start, slack, width, damping, 1.0 / rate)
    shortest = evaluate(muscle.bounded_fibre_length, 0.0, L_OPT, width)
    moved = np.diff(length, axis=0, prepend=start[None]) * rate / (V_MAX * L_OPT)
    assert np.all(np.isfinite(force))
    assert np.all(length > shortest - 1e-7)
    assert moved.min() >= -1.005
    assert moved.max() <= 1.005 * muscle.FASTEST_STRETCH
    for phase, (level, _) in enumerate(PHASES):
        last = (phase + 1) * steps - 1
        f, x = force[last + 1 - steps : last + 1], length[last]
        beyond = np.maximum(f - np.maximum(f[0], f[-1]), np.minimum(f[0], f[-1]) - f)
        assert beyond.max() < overshoot  # a unit held still moves one way only
        assert np.abs(np.diff(f[-rate // 20 :], axis=0)).max() < 2e-3
        speed = 0.5 * (3.0 * x - 4.0 * length[last - 1] + length[last - 2]) * rate / (V_MAX * L_OPT)
        pull = evaluate(muscle.fibre_force, model, level, x / L_OPT, speed, damping) * np.sqrt(1.0 - (width / x) ** 2)
        free = x > shortest + 1e-5
        np.testing.assert_allclose(pull[free], f[-1][free], atol=1e-3)


@every_model
def test_held_unit_comes_to_its_static_equilibrium(model: int):
    """From fibres up to a tenth too long or short; where active force grows with length there is only one."""
    grid = np.meshgrid([0.05, 0.1, 0.3, 1.0], [0.01, 0.3, 1.0], [0.0, 0.4], [-0.1, 0.1], indexing="ij")
    slack, a, pennation, off = (axis.ravel() for axis in grid)
    width = L_OPT * np.sin(pennation)
    whole = 1.01 * slack + 0.9 * L_OPT * np.cos(pennation)
    rest = evaluate(muscle.fibre_equilibrium, model, a, whole, L_OPT, slack, width)
    path = np.broadcast_to(whole, (4000, len(whole)))
    _, force = followed(model, a, path, rest + off * L_OPT, slack, width, 0.1, TIME_STEP)
    expected = evaluate(muscle.compliant_force, model, whole, rest, slack, width)
    np.testing.assert_allclose(force[-1], expected, atol=5e-4)


def integral(function, model: int):
    """Integral from 0 of a curve, as a function."""
    grid = np.linspace(0.0, 2.0, 40001)
    value = evaluate(function, model, grid)
    total = np.concatenate([[0.0], np.cumsum(0.5 * (value[1:] + value[:-1]) * np.diff(grid))])
    return lambda x: np.interp(x, grid, total)


@every_model
def test_energy_of_a_mass_on_a_muscle_changes_by_the_work_of_its_active_part(model: int):
    """Kinetic, gravitational, tendon and passive energy, less the work of contraction and damping."""
    f_max, g, h, beta = 1000.0, 9.81, TIME_STEP, 0.1
    slack, a = (axis.ravel() for axis in np.meshgrid([0.1, 0.3], [0.2, 0.6], indexing="ij"))
    tendon_energy, passive_energy = integral(curves.tendon_force_strain, model), integral(muscle.bounded_passive, model)
    mass = 0.8 * a * f_max / g
    whole = slack + L_OPT
    fibre = previous = evaluate(muscle.fibre_equilibrium, model, a, whole, L_OPT, slack, 0.0)
    force = evaluate(muscle.compliant_force, model, whole, fibre, slack, 0.0)
    speed, work, effort, energy = np.zeros_like(a), 0.0, 0.0, []
    for _ in range(600):
        strain = (whole - fibre - slack) / slack
        stored = slack * tendon_energy(strain)
        stored = stored + L_OPT * passive_energy(fibre / L_OPT)
        energy.append(0.5 * mass * speed**2 - mass * g * whole + f_max * stored - work)
        halfway = speed + 0.5 * h * (g - f_max * force / mass)
        whole = whole + h * halfway
        given = whole, fibre, previous, L_OPT, slack, 0.0, V_MAX, beta, h
        end = evaluate(muscle.compliant_step, model, a, *given)
        v, x = (end - fibre) / (h * V_MAX * L_OPT), 0.5 * (end + fibre) / L_OPT
        active = a * evaluate(curves.active_force_length, model, x) * evaluate(curves.force_velocity, model, v, a)
        done = -f_max * (active + beta * v) * (end - fibre)
        work, effort, previous, fibre = work + done, effort + np.abs(done), fibre, end
        force = evaluate(muscle.compliant_force, model, whole, fibre, slack, 0.0)
        speed = halfway + 0.5 * h * (g - f_max * force / mass)
    drift = np.abs(np.array(energy) - energy[0]).max(axis=0)
    assert np.all(effort > 0.1)
    assert np.all(drift < 5e-5 * effort)


@every_model
def test_damping_of_a_fibre_is_the_slope_of_its_force(model: int):
    rng = np.random.default_rng(3)
    a, x, v = rng.uniform(0.05, 1.0, 300), rng.uniform(0.5, 1.5, 300), rng.uniform(-0.9, 0.9, 300)
    h, around = 2e-3, np.abs(v) > 0.02  # hyperbolas have a kink in their slope at rest
    ahead, behind = (evaluate(muscle.fibre_force, model, a, x, v + d, 0.1) for d in (h, -h))
    got = evaluate(muscle.fibre_damping, model, a, x, v, 0.1)
    pulling = around & (behind > 0.0)
    assert pulling.mean() > 0.5
    np.testing.assert_allclose(got[pulling], ((ahead - behind) / (2.0 * h))[pulling], atol=0.03)
    assert np.all(got[(ahead == 0.0) & around] == 0.0)
    assert evaluate(muscle.fibre_damping, model, 1.0, 1.0, 1.2, 0.1)[0] == 0.0
