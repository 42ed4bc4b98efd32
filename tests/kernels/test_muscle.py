"""Musculotendon forces: OpenSim's numbers, the law of the original program, bounds, and fibres on compliant tendons."""

import numpy as np
import pytest
from hill import Reference, opensim_states
from probes import evaluate

from warpmuscle.kernels import curves, muscle
from warpmuscle.kernels.curves import DE_GROOTE, LEE, MILLARD, THELEN

MODELS = {"lee": LEE, "thelen": THELEN, "millard": MILLARD, "de groote": DE_GROOTE}
every_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
opensim_models = pytest.mark.parametrize("model", [THELEN, MILLARD], ids=["thelen", "millard"])
L_OPT, V_MAX, TIME_STEP = 0.1, 10.0, 1.0 / 2000.0


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
    given = s.mt_length, s.length, 0.0, s.l_opt, s.l_slack, s.width, damping
    v = evaluate(muscle.equilibrium_speed, model, s.activation, *given)
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
    given = slack + over, 0.0, length, L_OPT, slack, width, V_MAX, 0.1, TIME_STEP
    end = evaluate(muscle.compliant_step, model, a, *given)
    assert np.all(np.isfinite(end))
    assert np.all(np.abs(end - length) <= TIME_STEP * V_MAX * L_OPT * 1.001)
    np.testing.assert_array_less(width, end + 1e-6)


@every_model
def test_fibre_on_a_compliant_tendon_follows_a_sinusoidal_stretch(model: int):
    """Against steps five times finer, in float64, within half a percent of f_max."""
    grid = np.meshgrid([0.05, 0.1, 0.3, 1.0], [0.01, 0.1, 0.5, 1.0], [0.0, 0.4], indexing="ij")
    slack, a, pennation = (axis.ravel() for axis in grid)
    width, fine, steps = L_OPT * np.sin(pennation), 5, 400
    turn = 2.0 * np.pi * 4.0 * TIME_STEP / fine * np.arange(fine * steps + 1)[:, None]
    path = slack + L_OPT * np.cos(pennation) + 0.15 * L_OPT * np.sin(turn)
    rate = 0.15 * L_OPT * 2.0 * np.pi * 4.0 * np.cos(turn)
    start = length = evaluate(muscle.fibre_equilibrium, model, a, path[0], L_OPT, slack, width)
    reference = Reference(model, a, L_OPT, slack, width, V_MAX, 0.1).forces(path, start, TIME_STEP / fine)[::fine]
    for step in range(1, steps + 1):
        at = fine * step
        given = path[at], rate[at, 0], length, L_OPT, slack, width, V_MAX, 0.1, TIME_STEP
        length = evaluate(muscle.compliant_step, model, a, *given)
        force = evaluate(muscle.compliant_force, model, path[at], length, slack, width)
        np.testing.assert_allclose(force, reference[step], atol=0.005)


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
    fibre = evaluate(muscle.fibre_equilibrium, model, a, whole, L_OPT, slack, 0.0)
    force = evaluate(muscle.compliant_force, model, whole, fibre, slack, 0.0)
    speed, work, effort, energy = np.zeros_like(a), 0.0, 0.0, []
    for _ in range(600):
        strain = (whole - fibre - slack) / slack
        stored = slack * tendon_energy(strain)
        stored = stored + L_OPT * passive_energy(fibre / L_OPT)
        energy.append(0.5 * mass * speed**2 - mass * g * whole + f_max * stored - work)
        halfway = speed + 0.5 * h * (g - f_max * force / mass)
        whole = whole + h * halfway
        given = whole, halfway, fibre, L_OPT, slack, 0.0, V_MAX, beta, h
        end = evaluate(muscle.compliant_step, model, a, *given)
        v, x = (end - fibre) / (h * V_MAX * L_OPT), 0.5 * (end + fibre) / L_OPT
        active = a * evaluate(curves.active_force_length, model, x) * evaluate(curves.force_velocity, model, v, a)
        done = -f_max * (active + beta * v) * (end - fibre)
        work, effort, fibre = work + done, effort + np.abs(done), end
        force = evaluate(muscle.compliant_force, model, whole, fibre, slack, 0.0)
        speed = halfway + 0.5 * h * (g - f_max * force / mass)
    drift = np.abs(np.array(energy) - energy[0]).max(axis=0)
    assert np.all(effort > 0.1)
    assert np.all(drift < 1e-4 * effort)
