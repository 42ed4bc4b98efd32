"""A locked coordinate holds those that it is coupled to where OpenSim 4.6 assembles them."""

from pathlib import Path

import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import Ignored, load
from warpmuscle.scene import Scene

LINE = "<LinearFunction><coefficients>0.5 0.1</coefficients></LinearFunction>"
SPLINE = "<SimmSpline><x>-2 -1 0 1 2</x><y>-0.9 -0.5 0.1 0.5 1.4</y></SimmSpline>"
PLANE = (
    "<MultivariatePolynomialFunction><coefficients>0.02 0.3 -0.2</coefficients><dimension>2</dimension>"
    "<order>1</order></MultivariatePolynomialFunction>"
)


def coupler(name: str, function: str, drivers: str, follower: str) -> str:
    return (
        f'<CoordinateCouplerConstraint name="{name}"><coupled_coordinates_function>{function}'
        f"</coupled_coordinates_function><independent_coordinate_names>{drivers}</independent_coordinate_names>"
        f"<dependent_coordinate_name>{follower}</dependent_coordinate_name></CoordinateCouplerConstraint>"
    )


def loaded(folder: Path, couplers: str, values: dict[str, str]) -> tuple[Scene, list[Ignored]]:
    """Three links on pins, `qa` to `qc`, of which those that have a value are locked there."""
    bodies = "".join(small.body(name, center="0 -0.1 0") for name in "abc")
    joints = ""
    for name, parent in (("a", "ground"), ("b", "a"), ("c", "b")):
        value = values.get(f"q{name}")
        lock = f"<default_value>{value}</default_value><locked>true</locked>" if value is not None else ""
        joints += small.joint("PinJoint", f"j{name}", parent, name, small.coordinate(f"q{name}", lock))
    more = f"<ConstraintSet><objects>{couplers}</objects></ConstraintSet>"
    ignored: list[Ignored] = []
    return load(small.written(folder, small.model(bodies, joints, more=more)), ignored=ignored), ignored


@pytest.mark.parametrize(
    ("couplers", "values", "held"),  # places that OpenSim 4.6 has after initSystem
    [
        (coupler("k", LINE, "qa", "qb"), {"qb": "0.3"}, {"qa": 0.4, "qb": 0.3}),
        (coupler("k", SPLINE, "qa", "qb"), {"qb": "0.3"}, {"qa": 0.50976, "qb": 0.3}),
        (coupler("k", LINE, "qa", "qb"), {"qb": "2.5"}, {"qa": 4.8, "qb": 2.5}),  # beyond the range
        (coupler("k", PLANE, "qa qc", "qb"), {"qb": "0.3", "qa": "0"}, {"qa": 0.0, "qb": 0.3, "qc": 0.28 / 0.3}),
        (
            coupler("k", LINE, "qa", "qb")
            + coupler("l", "<LinearFunction><coefficients>2 0</coefficients></LinearFunction>", "qc", "qa"),
            {"qb": "0.3"},
            {"qa": 0.4, "qb": 0.3, "qc": 0.2},
        ),
    ],
)
def test_what_a_locked_coordinate_is_coupled_to_is_held(tmp_path: Path, couplers: str, values: dict, held: dict):
    scene, ignored = loaded(tmp_path, couplers, values)
    assert scene.opensim.locked == pytest.approx(held, abs=1e-5)
    assert len([note for note in ignored if "is held, too" in note.reason]) == len(held) - len(values)


def test_several_that_a_locked_one_follows_move_and_it_is_told(tmp_path: Path):
    scene, ignored = loaded(tmp_path, coupler("k", PLANE, "qa qc", "qb"), {"qb": "0.3"})
    assert scene.opensim.locked == {"qb": 0.3}
    (note,) = [note for note in ignored if "as if it were not coupled" in note.reason]
    assert "qb is locked, and qa, qc move" in note.reason


def test_a_locked_place_that_its_coupler_never_reaches_is_refused(tmp_path: Path):
    square = "<PolynomialFunction><coefficients>1 0 -0.1</coefficients></PolynomialFunction>"
    with pytest.raises(SceneError, match="no qa near its range gives"):
        loaded(tmp_path, coupler("k", square, "qa", "qb"), {"qb": "-0.5"})
