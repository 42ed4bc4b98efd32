"""Tables of curves through knots hold the curves, beside SciPy's splines."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from warpmuscle.kernels.curve.splines import PLACES, SIZE
from warpmuscle.model.expressions.curve_tables import spline_table
from warpmuscle.scene import Spline, SplineCurves

X = [0.0, 0.4, 0.7, 1.0, 1.3, 1.6, 3.0]
ACTIVE = Spline(X, [0.0, 0.0, 0.8, 1.0, 0.7, 0.0, 0.0], "natural")
PASSIVE = Spline([0.0, 1.0, 1.2, 1.6, 3.0], [0.0, 0.0, 0.1, 1.5, 9.0], "natural")
TENDON = Spline([0.0, 0.02, 0.04, 0.06, 1.0], [0.0, 0.3, 1.1, 2.0, 50.0], "natural")
VELOCITY = Spline([-1.0, -0.5, 0.0, 0.5, 1.0], [0.0, 0.2, 1.0, 1.4, 1.5], "natural")


def held(table: np.ndarray, name: str) -> tuple[np.ndarray, CubicHermiteSpline]:
    """The places of a curve's knots in a table, and what the device interpolates between them."""
    head, first, count = (int(number) for number in PLACES[name])
    x = np.linspace(*table[head], count + 1)
    rows = table[first : first + count + 1]
    return x, CubicHermiteSpline(x, rows[:, 0], rows[:, 1] / (x[1] - x[0]))


@pytest.mark.parametrize("name", ["active", "passive", "tendon", "velocity"])
def test_a_table_is_within_1e_5_of_its_curve(name: str):
    shape = SplineCurves(ACTIVE, PASSIVE, TENDON, VELOCITY)
    knots, curve = held(spline_table(shape), name)
    given = getattr(shape, name)
    exact = CubicSpline(given.x, given.y, bc_type="natural")
    places = np.linspace(max(knots[0], given.x[0]), min(knots[-1], given.x[-1]), 10_001)
    np.testing.assert_allclose(curve(places), exact(places), atol=1e-5)


def test_a_tendon_is_tabulated_up_to_five_times_its_force_and_no_speed_needs_no_curve():
    table = spline_table(SplineCurves(ACTIVE, PASSIVE, TENDON))
    assert table.shape == (SIZE, 2)
    knots, curve = held(table, "tendon")
    assert float(curve(knots[-1])) == pytest.approx(5.0, abs=0.05)
    assert not table[int(PLACES["velocity"][1]) :].any()
