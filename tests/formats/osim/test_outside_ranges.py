"""Paths beyond the ranges of coordinates are OpenSim's, for every class of functions that moves points and couples."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.formats import load
from warpmuscle.simulation.stages import Stages

opensim = pytest.importorskip("opensim", reason="no OpenSim: pip install opensim")
KNOTS = ("-1 0 0.5 1", "0 0.03 0.05 0.02")
SIMM = small.spline("SimmSpline", *KNOTS)
CONSTANT = "<Constant><value>0.03</value></Constant>"
FUNCTIONS = {
    "simm": SIMM,
    "natural": small.spline("NaturalCubicSpline", *KNOTS),
    "broken": small.spline("PiecewiseLinearFunction", *KNOTS),
    "linear": "<LinearFunction><coefficients>0.05 0.01</coefficients></LinearFunction>",
    "polynomial": "<PolynomialFunction><coefficients>0.02 -0.03 0.04</coefficients></PolynomialFunction>",
    "multiplier": f"<MultiplierFunction><function>{SIMM}</function><scale>1.5</scale></MultiplierFunction>",
    "constant": CONSTANT,
}
ANGLES = [-2.5, -2.1, -1.3, -0.4, 0.3, 0.8, 1.5, 2.2, 2.6]  # rad, of a range from -2 to 2


def moved(function: str) -> str:
    """A model with a point that a function moves along x."""
    function = function.replace(' name="function"', "")
    places = "".join(
        f"<{axis}_location>{function if axis == 'x' else CONSTANT}</{axis}_location>"
        f"<socket_{axis}_coordinate>/jointset/pin/q</socket_{axis}_coordinate>"
        for axis in "xyz"
    )
    frame = "<socket_parent_frame>/bodyset/rod</socket_parent_frame>"
    points = small.point("a", "ground", "0.05 0.2 0") + small.point("m", "rod", "0.04 -0.1 0.01")
    points += f'<MovingPathPoint name="b">{frame}{places}</MovingPathPoint>'
    joint = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"))
    return small.model(small.body("rod", center="0 -0.2 0"), joint, small.muscle("m", points))


def coupled(function: str) -> str:
    """A model with a slide that a function couples to the pin."""
    function = function.replace(' name="function"', "")
    joints = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"))
    joints += small.joint("SliderJoint", "slide", "rod", "tip", small.coordinate("s"))
    constraint = (
        '<ConstraintSet><objects><CoordinateCouplerConstraint name="k"><coupled_coordinates_function>'
        f"{function}</coupled_coordinates_function><independent_coordinate_names>q</independent_coordinate_names>"
        "<dependent_coordinate_name>s</dependent_coordinate_name></CoordinateCouplerConstraint></objects></ConstraintSet>"
    )
    points = small.point("a", "ground", "0.05 0.2 0") + small.point("b", "tip", "0.04 -0.1 0.01")
    bodies = small.body("rod", center="0 -0.2 0") + small.body("tip")
    return small.model(bodies, joints, small.muscle("m", points), constraint)


CASES = [(moved, name) for name in FUNCTIONS] + [(coupled, name) for name in FUNCTIONS if name != "constant"]


@pytest.mark.parametrize(("made", "name"), CASES, ids=[f"{made.__name__}-{name}" for made, name in CASES])
def test_lengths_beyond_ranges_are_those_of_opensim(tmp_path: Path, made, name: str):
    opensim.Logger.setLevelString("off")
    file = small.written(tmp_path, made(FUNCTIONS[name]))
    theirs = opensim.Model(str(file))
    state, expected = theirs.initSystem(), []
    for angle in ANGLES:
        theirs.getCoordinateSet().get("q").setValue(state, angle, True)
        theirs.realizePosition(state)
        expected.append(theirs.getMuscles().get("m").getLength(state))
    stages = Stages(load(file, ignored=[]), len(ANGLES), "cpu")
    coordinates = stages.state.coordinates.numpy()
    coordinates[:, stages.names.coordinate_start[stages.names.body_of_joint("q")]] = ANGLES
    stages.state.coordinates.assign(coordinates)
    np.testing.assert_allclose(stages.muscle_paths().length[:, 0], expected, atol=2e-6)
