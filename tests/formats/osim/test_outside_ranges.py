"""Paths beyond the ranges of coordinates, for every class of functions that moves points, couples or moves joints.

What is expected is computed here in float64 NumPy from the models' numbers. The values of splines are typed: they are
those of OpenSim 4.6's `Function.calcValue`, to 1e-9. Where OpenSim is installed, it is asked, too.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.formats.lines import Ignored
from warpmuscle.scene.constraints.pose import start_coordinates
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.moment_arms import muscle_geometry

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

Made = Callable[[str], tuple[str, Floats]]
KNOTS = ("-1 0 0.5 1", "0 0.03 0.05 0.02")
MANY = ("-1.5 -1 -0.4 0 0.5 1 1.4 1.8", "0.01 0 0.02 0.03 0.05 0.02 0.03 0.01")
SIMM = small.spline("SimmSpline", *KNOTS)
CONSTANT = "<Constant><value>0.03</value></Constant>"
ANGLES = np.array([-2.5, -2.1, -2.0, -1.3, -0.4, 0.3, 0.8, 1.5, 2.0, 2.2, 2.6])  # rad, of a range from -2 to 2
CUBIC = np.array(
    [0.085, 0.187 / 3, 0.17 / 3, 0.017, 0.00488, 0.04576, 0.04056, -0.145 / 3, -0.35 / 3, -0.144, -0.596 / 3]
)
A, B = np.array([0.05, 0.2, 0.0]), np.array([0.04, -0.1, 0.01])  # m, ends of the path


def multiplied(function: str, scale: float) -> str:
    """A function times a number."""
    return f"<MultiplierFunction><function>{function}</function><scale>{scale}</scale></MultiplierFunction>"


def gcv(half: int) -> str:
    """A generalised cross-validatory spline."""
    text = small.spline("GCVSpline", *MANY)
    return text.replace("<x>", f"<half_order>{half}</half_order><x>").replace(' name="function"', "")


FUNCTIONS: dict[str, tuple[str, Floats]] = {  # text, and the values at ANGLES
    "simm": (SIMM, CUBIC),
    "natural": (small.spline("NaturalCubicSpline", *KNOTS), CUBIC),
    "broken": (
        small.spline("PiecewiseLinearFunction", *KNOTS),
        np.array([-0.045, -0.033, -0.03, -0.009, 0.018, 0.042, 0.032, -0.01, -0.04, -0.052, -0.076]),
    ),
    "linear": ("<LinearFunction><coefficients>0.05 0.01</coefficients></LinearFunction>", 0.05 * ANGLES + 0.01),
    "polynomial": (
        "<PolynomialFunction><coefficients>0.02 -0.03 0.04</coefficients></PolynomialFunction>",
        0.02 * ANGLES**2 - 0.03 * ANGLES + 0.04,
    ),
    "multiplier": (multiplied(SIMM, 1.5), 1.5 * CUBIC),
    "nested": (multiplied(multiplied(SIMM, -2.0), 0.5), -CUBIC),
    "constant": (CONSTANT, np.full(len(ANGLES), 0.03)),
    "gcv1": (gcv(1), np.array([0.01, 0.01, 0.01, 0.006, 0.02, 0.042, 0.032, 0.025, 0.01, 0.01, 0.01])),
    "gcv2": (gcv(2), np.array([0.044859237, 0.030915542, 0.027429618, 0.003503648, 0.02, 0.046729548, 0.030595461,
        0.028570295, -0.00544045, -0.020880899, -0.051761798])),
    "gcv3": (gcv(3), np.array([0.189466838, 0.091844857, 0.072821704, -0.000068379, 0.02, 0.04758076, 0.030651718,
        0.031039319, -0.026761595, -0.081924041, -0.247451481])),
    "gcv4": (gcv(4), np.array([0.670802999, 0.252158427, 0.184555763, -0.005528788, 0.02, 0.047515862, 0.03188517,
        0.033766726, -0.062637901, -0.206604855, -0.797328771])),
}  # fmt: skip


def text_of(name: str) -> str:
    """A function without the name that only an axis needs."""
    return FUNCTIONS[name][0].replace(' name="function"', "")


def turned(axis: int, angle: float) -> Floats:
    """The matrix of a turn about x, y or z."""
    c, s = np.cos(angle), np.sin(angle)
    found = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found[i, i] = found[j, j] = c
    found[i, j], found[j, i] = -s, s
    return found


def moved(name: str) -> tuple[str, Floats]:
    """A model with a point that a function moves along x, held at the ends of the range; and its path's lengths, m."""
    places = "".join(
        f"<{axis}_location>{text_of(name) if axis == 'x' else CONSTANT}</{axis}_location>"
        f"<socket_{axis}_coordinate>/jointset/pin/q</socket_{axis}_coordinate>"
        for axis in "xyz"
    )
    frame = "<socket_parent_frame>/bodyset/rod</socket_parent_frame>"
    points = small.point("a", "ground", "0.05 0.2 0") + small.point("m", "rod", "0.04 -0.1 0.01")
    points += f'<MovingPathPoint name="b">{frame}{places}</MovingPathPoint>'
    joint = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"))
    values = FUNCTIONS[name][1].copy()
    values[ANGLES < -2.0], values[ANGLES > 2.0] = values[ANGLES == -2.0], values[ANGLES == 2.0]
    first = [np.linalg.norm(turned(2, q) @ B - A) for q in ANGLES]
    second = [np.linalg.norm(np.array([x, 0.03, 0.03]) - B) for x in values]
    return small.model(small.body("rod", center="0 -0.2 0"), joint, small.muscle("m", points)), np.add(first, second)


def slid(function: str, more: str = "") -> str:
    """A model with a slide that a function couples to the pin."""
    joints = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"))
    joints += small.joint("SliderJoint", "slide", "rod", "tip", small.coordinate("s"))
    constraint = (
        '<ConstraintSet><objects><CoordinateCouplerConstraint name="k"><coupled_coordinates_function>'
        f"{function}</coupled_coordinates_function><independent_coordinate_names>q</independent_coordinate_names>"
        f"<dependent_coordinate_name>s</dependent_coordinate_name>{more}</CoordinateCouplerConstraint>"
        "</objects></ConstraintSet>"
    )
    points = small.point("a", "ground", "0.05 0.2 0") + small.point("b", "tip", "0.04 -0.1 0.01")
    bodies = small.body("rod", center="0 -0.2 0") + small.body("tip")
    return small.model(bodies, joints, small.muscle("m", points), constraint)


def slid_lengths(values: Floats, angles: Floats = ANGLES) -> Floats:
    """Lengths, m, of the path of `slid` at angles, where the slide is at such values."""
    ends = [turned(2, q) @ (B + np.array([s, 0.0, 0.0])) for q, s in zip(angles, values, strict=True)]
    return np.linalg.norm(np.array(ends) - A, axis=1)


def coupled(name: str) -> tuple[str, Floats]:
    """A model of a coupler, and its path's lengths, m."""
    return slid(text_of(name)), slid_lengths(FUNCTIONS[name][1])


def custom(name: str) -> tuple[str, Floats]:
    """A model whose joint turns by q about z, by twice a function about x, and shifts by it; its path's lengths, m."""
    text, double = (one.replace(">", ' name="function">', 1) for one in (text_of(name), multiplied(text_of(name), 2.0)))
    still = '<Constant name="function"><value>0</value></Constant>'
    transform = small.axes(
        rotation1=("q", "0 0 1", small.LINE), rotation2=("q", "1 0 0", double), rotation3=("", "0 1 0", still),
        translation1=("q", "1 0 0", text), translation2=("", "0 1 0", still), translation3=("q", "0 0 1", text),
    )  # fmt: skip
    joint = small.joint("CustomJoint", "knee", "ground", "rod", small.coordinate("q"), transform)
    points = small.point("a", "ground", "0.05 0.2 0") + small.point("b", "rod", "0.04 -0.1 0.01")
    lengths = [
        np.linalg.norm(np.array([f, 0.0, f]) + turned(2, q) @ turned(0, 2.0 * f) @ B - A)
        for q, f in zip(ANGLES, FUNCTIONS[name][1], strict=True)
    ]
    return small.model(small.body("rod", center="0 -0.2 0"), joint, small.muscle("m", points)), np.array(lengths)


CASES = [(made, name) for made in (moved, coupled, custom) for name in FUNCTIONS]
every_case = pytest.mark.parametrize(("made", "name"), CASES, ids=[f"{made.__name__}-{name}" for made, name in CASES])


def lengths_here(file: Path, angles: Floats = ANGLES) -> Floats:
    """Lengths, m, of the path at angles."""
    stages = Stages(load(file, ignored=[]), len(angles), "cpu")
    coordinates = stages.state.coordinates.numpy()
    coordinates[:, stages.names.coordinate_start[stages.names.body_of_joint("q")]] = angles
    stages.state.coordinates.assign(coordinates)
    return stages.muscle_paths().length[:, 0]


def lengths_in_opensim(file: Path) -> Floats:
    """The same of OpenSim, which the test is skipped without."""
    opensim = pytest.importorskip("opensim", reason="no OpenSim: pip install opensim")
    opensim.Logger.setLevelString("off")
    theirs = opensim.Model(str(file))
    state, found = theirs.initSystem(), []
    for angle in ANGLES:
        theirs.getCoordinateSet().get("q").setValue(state, float(angle), True)
        theirs.realizePosition(state)
        found.append(theirs.getMuscles().get("m").getLength(state))
    return np.array(found)


@every_case
def test_lengths_beyond_ranges(tmp_path: Path, made: Made, name: str):
    text, expected = made(name)
    np.testing.assert_allclose(lengths_here(small.written(tmp_path, text)), expected, atol=2e-6)


@every_case
def test_lengths_beyond_ranges_are_those_of_opensim(tmp_path: Path, made: Made, name: str):
    text, expected = made(name)
    if (made, name) == (coupled, "constant"):  # see test_a_constant_coupler_holds_the_dependent_coordinate
        text = slid("<LinearFunction><coefficients>0 0.03</coefficients></LinearFunction>")
    np.testing.assert_allclose(lengths_in_opensim(small.written(tmp_path, text)), expected, atol=1e-6)


MOVING_ON = {-2.5: 0.035692677, -1.3: 0.086355993, 0.3: 0.044113651, 2.6: -0.010314697}  # q, rad: OpenSim's arm, m


def ahead(folder: Path) -> Path:
    """A model whose path goes from a point that moves on a rod to the ground."""
    text, _ = moved("simm")
    first, last = text.index('<PathPoint name="a"'), text.index('<PathPoint name="m"')
    end = text.index("</MovingPathPoint>") + len("</MovingPathPoint>")
    return small.written(folder, text[:first] + text[last:end] + text[first:last] + text[end:])


def test_arms_beyond_ranges_go_on_as_opensims_where_points_are_hard(tmp_path: Path):
    """The point stays, but OpenSim takes the rate of its function all the same; without hard points, the slope counts.

    OpenSim leaves out what the motion does within the rod, too.
    """
    file = ahead(tmp_path)
    angles = np.array(list(MOVING_ON))
    for hard in (True, False):
        scene = load(file, ignored=[], hard_points=hard)
        names = topology(scene.character)
        coordinates = np.repeat(start_coordinates(scene, names), len(angles) * 3, axis=0)
        place = names.coordinates_of(names.body_of_joint("q")).start
        coordinates[:, place] = (angles[:, None] + [-1e-3, 0.0, 1e-3]).ravel()
        length, arm = muscle_geometry(scene, coordinates)
        length, arm = length.reshape(-1, 3), arm.reshape(-1, 3)[:, 1]
        expected = np.array(list(MOVING_ON.values())) if hard else (length[:, 0] - length[:, 2]) / 2e-3
        np.testing.assert_allclose(arm, expected, atol=2e-6 if hard else 2e-4)


def test_typed_arms_beyond_ranges_are_those_of_opensim(tmp_path: Path):
    opensim = pytest.importorskip("opensim", reason="no OpenSim: pip install opensim")
    opensim.Logger.setLevelString("off")
    theirs = opensim.Model(str(ahead(tmp_path)))
    state, coordinate = theirs.initSystem(), theirs.getCoordinateSet().get("q")
    for angle, arm in MOVING_ON.items():
        coordinate.setValue(state, angle, True)
        theirs.realizePosition(state)
        assert theirs.getMuscles().get("m").computeMomentArm(state, coordinate) == pytest.approx(arm, abs=1e-8)


@pytest.mark.parametrize("function", [CONSTANT, multiplied(CONSTANT, 1.0)])
def test_a_constant_coupler_holds_the_dependent_coordinate(tmp_path: Path, function: str):
    """As `dependent = function(independent)` says; it is told that OpenSim 4.6 holds the independent one instead."""
    notes: list[Ignored] = []
    file = small.written(tmp_path, slid(function, "<scale_factor>2</scale_factor>"))
    scene = load(file, ignored=notes)
    assert scene.opensim.locked == {}
    assert scene.opensim.couplers["s"].value == 0.06
    assert sum("OpenSim 4.6 takes a Constant there otherwise, and holds q instead" in one.reason for one in notes) == 1
    np.testing.assert_allclose(lengths_here(file), slid_lengths(np.full(len(ANGLES), 0.06)), atol=2e-6)


def test_opensim_holds_the_other_coordinate_of_a_constant_coupler(tmp_path: Path):
    """A `Constant` takes no argument there, so that the first coordinate counts as the dependent one."""
    lengths = lengths_in_opensim(small.written(tmp_path, slid(CONSTANT)))
    np.testing.assert_allclose(lengths, np.linalg.norm(turned(2, 0.03) @ B - A), atol=1e-6)


def test_a_line_coupler_is_not_told(tmp_path: Path):
    notes: list[Ignored] = []
    load(small.written(tmp_path, slid(text_of("linear"))), ignored=notes)
    assert not [one for one in notes if "Constant" in one.reason]


@pytest.mark.parametrize("held", [False, True], ids=["alone", "beside a function that holds its ends"])
def test_polynomials_of_a_high_degree_go_on_as_far_beyond_a_range_as_half_its_width(tmp_path: Path, held: bool):
    """They are pieces of cubics, which would go on as the last cubic does; knots far away must not spread them thin."""
    angles, c = np.array([-3.9, -3.3, -2.5, -1.0, 0.4, 2.5, 3.3, 3.9]), [0.024, 0.08, 0.005, 0.02, 0.08]
    text = slid(f"<PolynomialFunction><coefficients>{' '.join(map(str, c))}</coefficients></PolynomialFunction>")
    expected = slid_lengths(np.polyval(c, angles), angles)
    if held:  # without a range, the knots from -1.5 to 1.8 are taken for it
        angles = 0.75 * angles
        axes = small.axes(rotation1=("q", "0 0 1", small.LINE), translation1=("q", "0 0 1", gcv(1).replace(
            "<GCVSpline>", '<GCVSpline name="function">')), translation2=("q", "1 0 0",
            '<PolynomialFunction name="function"><coefficients>0.024 0.08 0.005 0.02 0.08</coefficients>'
            "</PolynomialFunction>"))  # fmt: skip
        endless = '<Coordinate name="q"><range>-inf inf</range></Coordinate>'
        joint = small.joint("CustomJoint", "knee", "ground", "rod", endless, axes)
        points = small.point("a", "ground", "0.05 0.2 0") + small.point("b", "rod", "0.04 -0.1 0.01")
        text = small.model(small.body("rod", center="0 -0.2 0"), joint, small.muscle("m", points))
        x, y = (np.array(list(map(float, one.split()))) for one in MANY)
        shifts = np.stack([np.polyval(c, angles), np.zeros(len(angles)), np.interp(angles, x, y)], axis=1)
        ends = np.array([turned(2, q) @ B for q in angles]) + shifts
        expected = np.linalg.norm(ends - A, axis=1)
    np.testing.assert_allclose(lengths_here(small.written(tmp_path, text), angles), expected, rtol=1e-6, atol=2e-6)


def test_a_moving_point_without_a_location_is_at_0(tmp_path: Path):
    """As in OpenSim 4.6; where the location holds nothing, OpenSim does not open the model."""
    text, _ = moved("simm")
    whole = f"<y_location>{CONSTANT}</y_location>"
    scene = load(small.written(tmp_path, text.replace(whole, "")), ignored=[])
    at_zero = load(small.written(tmp_path, text.replace(whole, whole.replace("0.03", "0"))), ignored=[])
    assert scene.character.muscles["m"].path == at_zero.character.muscles["m"].path
    with pytest.raises(SceneError, match="no function in its <y_location>"):
        load(small.written(tmp_path, text.replace(whole, "<y_location/>")), ignored=[])
