"""Curves of each muscle's own as rows and tables of the device, by the definitions of OpenSim's muscles."""

import numpy as np
import pytest

from muscle_arm import leg
from warpmuscle.kernels.curve.curve_sets import DE_GROOTE, LIGAMENT, MILLARD, PATH_ACTUATOR, SPLINE, THELEN
from warpmuscle.kernels.muscle.contraction import COMPLIANT, EITHER, RIGID, SWITCH
from warpmuscle.model import muscle_shapes as model
from warpmuscle.scene import Ligament, Muscle, MuscleModel, PathActuator, Spline
from warpmuscle.scene.muscles.curves import DeGrooteCurves, MillardCurves, SplineCurves, ThelenCurves
from warpmuscle.scene.number import Free


def muscles(**fields: object) -> list[Muscle]:
    """Three muscles, of which the second has these fields."""
    found = list(leg().character.muscles.values())
    for name, value in fields.items():
        setattr(found[1], name, value)
    return found


def column(shapes: model.Shapes, field: str) -> list[float]:
    return np.broadcast_to(shapes.columns[field], (1, 3))[0].astype(float).tolist()


def test_muscles_without_shapes_need_none_and_tendons_are_named_or_differ():
    assert model.muscle_shapes(muscles(), MuscleModel()) is None
    for word, number in (("rigid", RIGID), ("switch", SWITCH), ("compliant", COMPLIANT)):
        assert model.tendon_kind(muscles(), MuscleModel(tendon=word)) == number
        assert model.tendon_kind([], MuscleModel(tendon=word)) == number
    mixed = muscles(tendon="compliant")
    assert model.tendon_kind(mixed, MuscleModel(tendon="rigid")) == EITHER
    shapes = model.muscle_shapes(mixed, MuscleModel(tendon="rigid"))
    assert column(shapes, "tendon") == [RIGID, COMPLIANT, RIGID]
    assert shapes.table.shape == (1, 2)


def test_least_activations_may_be_free():
    usual = MuscleModel(curves="de_groote")
    assert not model.has_floor(muscles(), usual)
    assert model.has_floor(muscles(minimum_activation=0.02), usual)
    assert model.has_floor(muscles(minimum_activation=Free(0.0, 0.0, 0.1)), usual)
    shapes = model.muscle_shapes(muscles(minimum_activation=0.02), usual)
    assert column(shapes, "minimum_activation") == [0.0, 0.02, 0.0]


def test_curves_of_de_groote_are_those_of_the_paper_at_their_strain():
    """De Groote 2016, eq. S3: exp(4 (l - 1)/e0) less its value at 0.2, over exp(4) less the same."""
    shape = DeGrooteCurves(active_width=1.3)
    shapes = model.muscle_shapes(muscles(curve_shape=shape, passive_strain=0.5), MuscleModel(curves="de_groote"))
    floor = [np.exp(4.0 * -0.8 / strain) for strain in (0.6, 0.5, 0.6)]
    assert column(shapes, "curves") == [DE_GROOTE] * 3
    np.testing.assert_allclose(column(shapes, "active_width"), [1.0, 1.0 / 1.3, 1.0])
    np.testing.assert_allclose(column(shapes, "passive_rate"), [4.0 / 0.6, 8.0, 4.0 / 0.6])
    np.testing.assert_allclose(column(shapes, "passive_floor"), floor)
    np.testing.assert_allclose(column(shapes, "passive_scale"), [1.0 / (np.exp(4.0) - one) for one in floor])
    np.testing.assert_allclose(column(shapes, "tendon_rate"), [1.0 / 0.049] * 3)
    np.testing.assert_allclose(column(shapes, "shortest"), [0.2] * 3)
    without = model.muscle_shapes(muscles(curve_shape=DeGrooteCurves(passive=False)), MuscleModel(curves="de_groote"))
    assert column(without, "passive_scale")[1] == 0.0


def test_curves_of_thelen_become_straight_where_their_threshold_is():
    shape = ThelenCurves(0.5, 4.0, 0.3, 1.6, 0.9)
    given = muscles(curve_shape=shape, passive_strain=0.55, tendon_strain=0.033)
    shapes = model.muscle_shapes(given, MuscleModel(curves="thelen"))
    assert column(shapes, "curves") == [THELEN] * 3
    np.testing.assert_allclose(column(shapes, "active_width"), [0.45, 0.5, 0.45])
    np.testing.assert_allclose(column(shapes, "passive_rate"), [5.0 / 0.6, 4.0 / 0.55, 5.0 / 0.6])
    np.testing.assert_allclose(column(shapes, "passive_floor"), [1.0] * 3)
    np.testing.assert_allclose(column(shapes, "passive_scale"), 1.0 / np.expm1([5.0, 4.0, 5.0]))
    np.testing.assert_allclose(column(shapes, "tendon_rate"), [25.0, 1.0 / 0.033, 25.0])
    np.testing.assert_allclose(column(shapes, "velocity_shape"), [0.25, 0.3, 0.25])
    np.testing.assert_allclose(column(shapes, "lengthening_force"), [1.4, 1.6, 1.4])
    for speed, a, longest, part in zip(
        column(shapes, "straight_speed"), (0.25, 0.3, 0.25), (1.4, 1.6, 1.4), (0.95, 0.9, 0.95), strict=True
    ):
        x, y = speed * (2.0 + 2.0 / a), longest - 1.0
        assert (longest * x + y) / (x + y) == pytest.approx(part * longest)


def test_tables_of_millard_are_made_once_for_each_set_of_numbers():
    shape = MillardCurves(active_from=0.5)
    given = muscles(curve_shape=shape)
    shapes = model.muscle_shapes(given, MuscleModel(curves="millard"))
    starts = column(shapes, "table")
    assert starts[0] == starts[2] == 0.0
    assert starts[1] == len(shapes.table) / 2
    assert column(shapes, "curves") == [MILLARD] * 3
    np.testing.assert_allclose(column(shapes, "shortest"), [0.4441, 0.5, 0.4441])


def test_numbers_of_millard_that_are_not_given_are_those_that_opensim_derives():
    """Millard2012EquilibriumMuscle of OpenSim 4.6: defaults of its curves, and what changes without damping."""
    numbers = model.millard_numbers(MillardCurves(), 0.049, 0.7, undamped=False)
    assert numbers.passive_slope == pytest.approx(2.0 / 0.7)
    assert (numbers.passive_low_slope, numbers.passive_curviness, numbers.passive_strain) == (0.2, 0.75, 0.7)
    assert (numbers.tendon_slope, numbers.tendon_toe_force, numbers.tendon_curviness) == (1.375, 2.0 / 3.0, 0.5)
    assert (numbers.active_least, numbers.shortening_end_slope, numbers.lengthening_end_slope) == (0.0, 0.0, 0.0)
    own = MillardCurves(passive_slack=0.1, tendon_slope=30.0, shortening_end_slope=0.2, lengthening_end_slope=0.12)
    numbers = model.millard_numbers(own, 0.05, 0.6, undamped=True)
    assert numbers.passive_slope == pytest.approx(4.0)
    assert numbers.tendon_slope == pytest.approx(1.5)
    assert (numbers.active_least, numbers.shortening_end_slope, numbers.lengthening_end_slope) == (0.1, 0.2, 0.12)
    low = model.millard_numbers(MillardCurves(shortening_end_slope=0.3), 0.05, 0.6, undamped=True)
    assert (low.shortening_end_slope, low.lengthening_end_slope) == (0.1, 0.1)
    flat = model.millard_numbers(MillardCurves(lengthening_slope=0.1), 0.05, 0.6, undamped=True)
    assert flat.lengthening_end_slope == pytest.approx(0.099)  # a corner of one slope has no place
    kept = model.millard_numbers(MillardCurves(shortening_end_slope=0.3), 0.05, 0.6, undamped=False)
    assert (kept.shortening_end_slope, kept.lengthening_end_slope) == (0.0, 0.0)


def test_millard_muscles_without_damping_on_compliant_tendons_are_never_quite_at_rest():
    given = muscles(curve_shape=MillardCurves(), damping=0.0, tendon="compliant", minimum_activation=0.002)
    shapes = model.muscle_shapes(given, MuscleModel(curves="millard", damping=0.1))
    assert column(shapes, "minimum_activation")[1] == pytest.approx(0.01)
    given[1].damping = 0.1
    assert column(model.muscle_shapes(given, MuscleModel(curves="millard")), "minimum_activation")[1] == 0.002


def test_curves_through_knots_have_schutte_s_speed_where_they_have_none_of_their_own():
    """Schutte 1993: kv = 0.15. A shape of 0 says that the speed is in the table."""
    curve = Spline([0.0, 0.5, 1.0, 1.5], [0.0, 0.7, 1.0, 1.4], "natural")
    given = muscles(curve_shape=SplineCurves(curve, curve, curve))
    given[2].curve_shape = SplineCurves(curve, curve, curve, velocity=curve)
    shapes = model.muscle_shapes(given, MuscleModel(curves="de_groote"))
    assert column(shapes, "curves")[1:] == [SPLINE] * 2
    np.testing.assert_allclose(column(shapes, "velocity_shape")[1:], [0.15, 0.0])
    np.testing.assert_allclose(column(shapes, "shortest")[1:], [1e-4] * 2)
    assert len(set(column(shapes, "table")[1:])) == 2


def test_ligaments_have_their_pieces_and_actuators_none():
    line = Ligament([1.0, 1.1, 1.3], [0.0, 0.5, 2.5], ends="linear", dissipation=0.2)
    given = muscles(curve_shape=line)
    given[0].curve_shape = PathActuator()
    shapes = model.muscle_shapes(given, MuscleModel(curves="de_groote"))
    assert column(shapes, "curves") == [PATH_ACTUATOR, LIGAMENT, DE_GROOTE]
    table = model.ligament_table(line)
    np.testing.assert_array_equal(table, shapes.table)
    pieces, dissipation = table[0]
    assert (len(table), dissipation) == (1 + 3 * int(pieces), 0.2)
    for x, y in zip(line.x, line.y, strict=True):
        rows = [k for k in range(1, len(table), 3) if table[k, 0] <= x + 1e-12] or [1]
        t = x - table[rows[-1], 0]
        c = [table[rows[-1], 1], *table[rows[-1] + 1], table[rows[-1] + 2, 0]]
        assert np.polyval(c[::-1], t) == pytest.approx(y, abs=1e-9)
