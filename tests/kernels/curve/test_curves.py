"""Curves of muscles and tendons against OpenSim, closed forms in float64, and what they must be at l = 1 and v = 0."""

from pathlib import Path

import numpy as np
import pytest
from probes import evaluate

from warpmuscle.kernels.curve import curves, millard
from warpmuscle.kernels.curve.curve_sets import CURVES
from warpmuscle.kernels.curve.curves import DE_GROOTE, LEE, MILLARD, SARSHARI, THELEN, THELEN_EXPLICIT

MODELS = {"lee": LEE, "thelen": THELEN, "millard": MILLARD, "de groote": DE_GROOTE, "explicit": THELEN_EXPLICIT}
ALL = MODELS | {"sarshari": SARSHARI}  # whose curves pass neither 1 at rest nor 0 at their ends
every_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
TABLE = 2e-4  # error of the tables of Millard's curves


def millard_table(reference_data) -> dict[str, np.ndarray]:
    file = reference_data / "opensim_reference" / "millard_default_curves.csv"
    table = np.genfromtxt(file, delimiter=",", names=True)
    return {name: table[name] for name in table.dtype.names}


def random_states(reference_data, name: str) -> dict[str, np.ndarray]:
    file = reference_data / "opensim_reference" / f"hill_{name}Muscle_random_state.csv"
    table = np.genfromtxt(file, delimiter=",", names=True, dtype=None, encoding=None)
    table = table[np.abs(table["norm_fiber_velocity"]) < 1.0]
    return {column: table[column] for column in table.dtype.names}


def test_default_curves_of_millard_are_those_of_opensim(reference_data):
    t = millard_table(reference_data)
    active = evaluate(curves.active_force_length, MILLARD, t["norm_length"])
    passive = evaluate(curves.passive_force_length, MILLARD, t["norm_length"])
    velocity = evaluate(curves.force_velocity, MILLARD, t["norm_velocity"], 1.0)
    tendon = evaluate(curves.tendon_force_strain, MILLARD, t["tendon_norm_length"] - 1.0)
    np.testing.assert_allclose(active, t["active_fl"], atol=TABLE)
    np.testing.assert_allclose(passive, t["passive_fl"], atol=TABLE)
    np.testing.assert_allclose(velocity, t["fv"], atol=TABLE)
    np.testing.assert_allclose(tendon, t["tendon_force"], atol=TABLE)


@pytest.mark.parametrize(("name", "model"), [("Thelen2003", THELEN), ("Millard2012Equilibrium", MILLARD)])
def test_multipliers_are_those_of_opensim_muscles(name: str, model: int, reference_data):
    s = random_states(reference_data, name)
    length, speed, a = s["norm_fiber_length"], s["norm_fiber_velocity"], s["activation"]
    tolerance = TABLE if model == MILLARD else 2e-5
    np.testing.assert_allclose(evaluate(curves.active_force_length, model, length), s["active_fl_mult"], atol=tolerance)
    np.testing.assert_allclose(
        evaluate(curves.passive_force_length, model, length), s["passive_fl_mult"], atol=tolerance
    )
    np.testing.assert_allclose(evaluate(curves.force_velocity, model, speed, a), s["fv_mult"], atol=tolerance)


@pytest.mark.parametrize("name", millard.CURVES)
def test_table_follows_the_bezier_curve_it_was_made_from(name: str):
    knots, curviness, _ = millard.CURVES[name]
    x = np.linspace(knots[0][0], knots[-1][0], 3000)
    expected, _ = millard.sampled(knots, curviness, x)
    got = evaluate(millard.tabulated, x, np.array(millard.PLACES[name]))
    np.testing.assert_allclose(got[:, 0], expected, atol=TABLE)


def closed_active(model: int, x: np.ndarray) -> np.ndarray:
    if model == DE_GROOTE:
        bells = [
            (0.8174335195120225, 1.054348561163096, 0.16194288662761705, 0.06381565266097716),
            (0.43130780147182907, 0.7163004817144202, -0.029060905806803296, 0.19835014521987723),
            (0.1, 1.0, np.sqrt(0.125), 0.0),
        ]
        return sum(b1 * np.exp(-0.5 * ((x - b2) / (b3 + b4 * x)) ** 2) for b1, b2, b3, b4 in bells)
    return np.exp(-((x - 1.0) ** 2) / {LEE: 0.5, THELEN: 0.45, THELEN_EXPLICIT: 0.45, SARSHARI: 0.0955}[model])


def closed_passive(model: int, x: np.ndarray) -> np.ndarray:
    if model == DE_GROOTE:
        floor = np.exp(4.0 * -0.8 / 0.6)
        return np.maximum(np.exp(4.0 * (x - 1.0) / 0.6) - floor, 0.0) / (np.exp(4.0) - floor)
    if model == SARSHARI:
        return 0.067 * np.exp(3.832 * (x - 1.0)) + 0.00378
    k = {LEE: 4.0, THELEN: 5.0, THELEN_EXPLICIT: 5.0}[model]
    return np.where(x > 1.0, np.expm1(k * (x - 1.0) / 0.6) / np.expm1(k), 0.0)


def closed_velocity(model: int, v: np.ndarray) -> np.ndarray:
    """At full activation."""
    if model == DE_GROOTE:
        return -0.3211346127989808 * np.arcsinh(-8.149 * v - 0.374) + 0.8825327733249912
    if model == SARSHARI:
        return 1.9108 / (1.0 + np.exp(-4.994 * v))
    if model == THELEN_EXPLICIT:
        return np.where(v <= 0.0, (1.0 + v) / (1.0 - 4.0 * v), (1.0 + 35.0 * v) / (1.0 + 25.0 * v))
    shape, longest = {LEE: (0.3, 1.8), THELEN: (0.25, 1.4)}[model]
    x, y = v * (2.0 + 2.0 / shape), longest - 1.0
    return np.where(v <= 0.0, (v + 1.0) / (1.0 - v / shape), (longest * x + y) / (x + y))


@pytest.mark.parametrize("model", [model for model in ALL.values() if model != MILLARD])
def test_curves_are_their_closed_forms(model: int):
    x, v = np.linspace(0.3, 1.7, 500), np.linspace(-1.0, 0.18, 500)
    np.testing.assert_allclose(evaluate(curves.active_force_length, model, x), closed_active(model, x), atol=2e-6)
    np.testing.assert_allclose(evaluate(curves.passive_force_length, model, x), closed_passive(model, x), atol=5e-6)
    np.testing.assert_allclose(evaluate(curves.force_velocity, model, v, 1.0), closed_velocity(model, v), atol=5e-6)


@every_model
def test_active_force_has_its_peak_of_one_at_the_optimal_length(model: int):
    x = np.linspace(0.1, 1.9, 2001)
    force = evaluate(curves.active_force_length, model, x)
    assert evaluate(curves.active_force_length, model, 1.0)[0] == pytest.approx(1.0, abs=1e-6)
    assert force.max() < 1.0 + (2e-3 if model == DE_GROOTE else TABLE)  # the fit of De Groote peaks at 1.013
    assert force.min() >= -TABLE


@every_model
def test_force_at_rest_is_isometric_and_grows_with_speed(model: int):
    v = np.linspace(-1.0, 1.0, 2001)
    force = evaluate(curves.force_velocity, model, v, 1.0)
    assert force[1000] == pytest.approx(1.0, abs=1e-6)
    assert force[0] == pytest.approx(0.0, abs=1e-5)
    assert np.all(np.diff(force) > -2e-7)


@every_model
def test_passive_force_and_tendon_force_grow_from_zero(model: int):
    passive = evaluate(curves.passive_force_length, model, np.linspace(0.1, 2.0, 1000))
    tendon = evaluate(curves.tendon_force_strain, model, np.linspace(-0.1, 0.1, 1000))
    assert passive[0] == pytest.approx(0.0, abs=1e-9)
    assert tendon[0] == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.diff(passive) > -2e-7)
    assert np.all(np.diff(tendon) > -2e-7)


@pytest.mark.parametrize("speed", [-0.7, 0.0, 0.3])
def test_explicit_force_velocity_is_that_of_thelen_at_full_activation_and_knows_no_other(speed: float):
    explicit = evaluate(curves.force_velocity, THELEN_EXPLICIT, speed, np.array([0.01, 0.5, 1.0]))
    assert np.ptp(explicit) == 0.0
    if speed < 0.18:  # beyond it Thelen's goes on straight
        assert explicit[0] == pytest.approx(evaluate(curves.force_velocity, THELEN, speed, 1.0)[0], abs=1e-6)


@pytest.mark.parametrize(("model", "strain"), [(LEE, 0.04), (THELEN, 0.04), (MILLARD, 0.049), (DE_GROOTE, 0.049)])
def test_tendon_carries_the_largest_isometric_force_at_its_strain(model: int, strain: float):
    assert evaluate(curves.tendon_force_strain, model, strain)[0] == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("model", ALL.values(), ids=ALL)
def test_slopes_are_derivatives(model: int):
    v, strain, h = np.linspace(-0.98, 0.98, 198), np.linspace(-0.0103, 0.06, 150), 2e-3
    cases = [(lambda x: evaluate(curves.force_velocity_slope, model, x, 0.5), v, h, 0.1)]
    cases.append((lambda x: evaluate(curves.tendon_force_slope, model, x), strain, h / 20, 1.0))
    for function, x, h, tolerance in cases:
        difference = (function(x + h)[:, 0] - function(x - h)[:, 0]) / (2.0 * h)
        np.testing.assert_allclose(function(x)[:, 1], difference, atol=tolerance)


def test_curves_of_hyfydy_are_the_polynomials_of_its_manual_near_those_of_millard():
    # Hyfydy User Manual 1.0.2, actuator forces; its passive curve has c_P1 twice in print, the second read as c_P2.
    hyfydy = CURVES["hyfydy"]
    length, speed, strain = np.linspace(0.3, 2.0, 400), np.linspace(-1.4, 1.4, 401), np.linspace(-0.02, 0.06, 100)
    x, e = length - 1.0, np.maximum(strain, 0.0)
    active = np.where((length > 0.46899) & (length < 1.80528), 1.5 * x**3 - 2.75 * x**2 + 1.0, 0.0)
    passive = np.where(x > 0.0, 1.08027 * x**3 + 1.27368 * x**2, 0.0)
    slow = np.clip(speed, -1.0, 0.0)
    velocity = np.where(
        speed < 0.0, 0.227 * (slow + 1.0) / (0.227 - slow), (1.6 * speed + 0.11) / (0.11 + np.maximum(speed, 0.0))
    )
    found = (
        evaluate(curves.active_force_length, hyfydy, length), evaluate(curves.passive_force_length, hyfydy, length),
        evaluate(curves.force_velocity, hyfydy, speed, 0.3), evaluate(curves.tendon_force_strain, hyfydy, strain),
    )  # fmt: skip
    for got, wanted in zip(found, (active, passive, velocity, 260.972 * e**2 + 7.9706 * e), strict=True):
        np.testing.assert_allclose(got, wanted, atol=1e-5)
    assert np.max(np.abs(evaluate(curves.active_force_length, MILLARD, length) - active)) < 0.12
    assert np.max(np.abs(evaluate(curves.tendon_force_strain, MILLARD, strain[:80]) - found[3][:80])) < 0.06


def test_slopes_of_hyfydys_curves_are_those_of_their_values():
    speed, strain, step = np.array([-0.9, -0.3, -0.01, 0.01, 0.5]), np.array([0.005, 0.02, 0.05]), 1e-3
    hyfydy = CURVES["hyfydy"]
    for function, at in ((curves.force_velocity_slope, speed), (curves.tendon_force_slope, strain)):
        rest = (0.5,) if function is curves.force_velocity_slope else ()
        high, low = (evaluate(function, hyfydy, at + d, *rest)[:, 0] for d in (step, -step))
        slope = evaluate(function, hyfydy, at, *rest)[:, 1]
        np.testing.assert_allclose(slope, (high - low) / (2.0 * step), rtol=5e-3)


def test_a_file_of_curves_without_a_name_is_told(tmp_path: Path):
    for name in ("lee", "shaped", "elastic"):
        (tmp_path / f"{name}_curves.py").touch()
    with pytest.raises(TypeError, match=r"in elastic_curves.py has no name: add it to `CurveSet` in curve_sets.py"):
        curves.check_names(tmp_path)
