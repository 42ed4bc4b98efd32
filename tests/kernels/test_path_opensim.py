"""Lengths, lengthening speeds and moment arms of muscle paths as OpenSim computes them."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from copy import copy
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from leg_paths import Geometry, geometry_of, gradient
from warpmuscle.scene import Body, Character, Condition, Joint, Scene, ViaPoint
from warpmuscle.scene.number import Free
from warpmuscle.simulation.stages import Stages

ZERO = (0.0, 0.0, 0.0)
BLEND = 1e-4  # rad; where a conditional point comes in, OpenSim's paths jump
STEP = 4e-3  # rad, of differences
CLOSE_KNOTS = 4e-4  # rad; three knots of the moving points' splines are at 0 to 0.00035, where their slopes change fast

Floats = NDArray[np.float64]
Point = tuple[float | Floats, ...]  # x, y, z; an array has one value a pose


class Osim:
    """What a path needs of an .osim file whose joints turn about one axis, and may move along splines of the angle."""

    def __init__(self, file: Path) -> None:
        self.root = ElementTree.parse(file).getroot()
        self.poses = np.load(file.with_name(f"{file.stem}_path_reference.npz"))
        names = [str(name) for name in self.poses["coordinate_names"]]
        self.column = {name: i for i, name in enumerate(names)}
        self.q = self.poses["q"]
        self.centers = {
            body.get("name"): numbers(body, "mass_center") for body in self.root.iterfind(".//BodySet/objects/Body")
        }

    def moved(self, coordinate: str, way: float) -> Osim:
        """The same model with one coordinate of all poses moved."""
        result = copy(self)
        result.q = self.q.copy()
        result.q[:, self.column[coordinate]] += way
        return result

    def value(self, function: ElementTree.Element, coordinate: str) -> float | Floats:
        """A constant, or the value of a spline of a coordinate in each pose."""
        if function.tag == "Constant":
            return float(function.findtext("value"))
        assert function.tag == "SimmSpline"
        knots, values = (np.array(numbers(function, tag)) for tag in "xy")
        return simm_spline(knots, values, self.q[:, self.column[coordinate]])

    def joint(self, name: str) -> tuple[str, Joint]:
        """A joint, its axis that of its only rotation, and the name of its coordinate."""
        (joint,) = self.root.iterfind(f".//JointSet/objects/*[@name='{name}']")
        frames = {}
        for which in ("parent", "child"):
            frame = joint.find(f"frames/PhysicalOffsetFrame[@name='{joint.findtext(f'socket_{which}_frame')}']")
            assert numbers(frame, "orientation") == ZERO
            body = frame.findtext("socket_parent").split("/")[-1]
            frames[which] = body, less(numbers(frame, "translation"), self.centers[body])
        (parent, in_parent), (child, in_child) = frames.values()
        coordinate = joint.find("coordinates/Coordinate")
        if coordinate is None:
            return "", Joint("fixed", parent, child, in_parent, in_child)
        turn = joint.find("SpatialTransform/TransformAxis[@name='rotation1']")
        axis = (0.0, 0.0, 1.0) if turn is None else numbers(turn, "axis")
        in_parent = tuple(x + along for x, along in zip(in_parent, self.translation(joint), strict=True))
        return coordinate.get("name"), Joint("hinge", parent, child, in_parent, in_child, [axis])

    def translation(self, joint: ElementTree.Element) -> Point:
        """How far a joint's child has moved along the axes of its parent in each pose."""
        along = [joint.find(f"SpatialTransform/TransformAxis[@name='translation{k}']") for k in (1, 2, 3)]
        if along == [None] * 3:
            return ZERO
        assert [numbers(axis, "axis") for axis in along] == [tuple(row) for row in np.eye(3)]
        return tuple(self.value(axis.find("*[@name='function']"), axis.findtext("coordinates")) for axis in along)

    def path(self, muscle: str) -> list[ViaPoint]:
        """A path of fixed, moving and conditional points without wrapping."""
        (owner,) = self.root.iterfind(f".//ForceSet/objects/*[@name='{muscle}']")
        assert owner.find("GeometryPath/PathWrapSet/objects/*") is None
        result = []
        for point in owner.iterfind("GeometryPath/PathPointSet/objects/*"):
            body, condition = point.findtext("socket_parent_frame").split("/")[-1], None
            if point.tag == "ConditionalPathPoint":
                joint = point.findtext("socket_coordinate").split("/")[-2]
                condition = Condition(joint, *numbers(point, "range"), blend=BLEND)
            location = self.moving_location(point) if point.tag == "MovingPathPoint" else numbers(point, "location")
            result.append(ViaPoint(body, less(location, self.centers[body]), condition))
        return result

    def moving_location(self, point: ElementTree.Element) -> Point:
        """Where a MovingPathPoint is in each pose."""
        coordinates = [point.findtext(f"socket_{axis}_coordinate").split("/")[-1] for axis in "xyz"]
        functions = [point.find(f"{axis}_location/*") for axis in "xyz"]
        return tuple(map(self.value, functions, coordinates))

    def moving(self, joints: list[str]) -> list[str]:
        """Coordinates of these joints, none for fixed ones."""
        return [coordinate for coordinate, _ in map(self.joint, joints) if coordinate]

    def solved(self, root: str, joints: list[str], muscles: list[str]) -> tuple[Stages, Geometry]:
        """Paths of muscles in the poses, on a character of these joints whose root is fixed."""
        tree = {name: self.joint(name)[1] for name in joints}
        bodies = {name: Body(1.0, (1.0, 1.0, 1.0)) for name in [root, *(joint.child for joint in tree.values())]}
        posed = Character(root, bodies, tree, root_joint="fixed")
        stages = posed_stages(posed, len(self.q))
        assert list(stages.names.joints) == joints
        state, column = stages.structs[1], [self.column[name] for name in self.moving(joints)]
        coordinates = state.coordinates.numpy().copy()
        coordinates[:, stages.names.coordinate_start[1] :] = self.q[:, column]
        state.coordinates.assign(coordinates)
        state.speeds.assign(self.poses["u"][:, column].astype(np.float32))
        return stages, geometry_of(stages, {muscle: self.path(muscle) for muscle in muscles}, posed)

    def geometry(self, root: str, joints: list[str], muscles: list[str]) -> tuple[Floats, Floats, Floats]:
        """Lengths, lengthening speeds (n, M) and moment arms (n, M, coordinates) in the poses."""
        stages, result = self.solved(root, joints, muscles)
        return result.length, result.speed, -gradient(stages, result)

    def arm_by_differences(self, coordinate: str, root: str, joints: list[str], muscles: list[str]) -> Floats:
        """Moment arms (n, M) of a coordinate that not only turns a joint, but also moves it and points of paths."""
        before, after = (self.moved(coordinate, way).solved(root, joints, muscles)[1].length for way in (-STEP, STEP))
        return -(after - before) / (2.0 * STEP)

    def expected(self, joints: list[str], muscles: list[str]) -> tuple[Floats, Floats, Floats]:
        """The same as `geometry` according to OpenSim, whose moment arms are -dl/dq."""
        row = [list(self.poses["muscle_names"]).index(name) for name in muscles]
        column, poses = [self.column[name] for name in self.moving(joints)], self.poses
        return poses["length"][:, row], poses["lengthening_speed"][:, row], poses["moment_arm"][:, row][:, :, column]

    def to_switch(self, muscles: list[str]) -> Floats:
        """How far each pose is from the nearest angle at which a point of each muscle comes in, (n, M), rad."""
        result = np.full((len(self.q), len(muscles)), np.inf)
        for i, muscle in enumerate(muscles):
            for condition in (point.condition for point in self.path(muscle) if point.condition is not None):
                angle = self.q[:, self.column[self.joint(condition.joint)[0]]]
                for end in (condition.low, condition.high):
                    result[:, i] = np.minimum(result[:, i], np.abs(angle - end))
        return result


def numbers(element: ElementTree.Element, tag: str) -> tuple[float, ...]:
    return tuple(float(word) for word in element.findtext(tag).split())


def less(a: Point, b: Point) -> Point:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def posed_stages(posed: Character, count: int) -> Stages:
    """Instances of a character in which the positions of joints in their parents may have one value an instance.

    A scene holds a free parameter in place of such a number.
    """
    values, joints = [], {}
    for name, joint in posed.joints.items():
        position = joint.position_in_parent
        values += [number for number in position if isinstance(number, np.ndarray)]
        free = (Free(0.0, -1.0, 1.0) if isinstance(number, np.ndarray) else number for number in position)
        joints[name] = replace(joint, position_in_parent=tuple(free))
    stages = Stages(Scene("osim", replace(posed, joints=joints)), count, "cpu")
    stages.set_parameters(np.reshape(values, (len(values), count)).T)
    return stages


def simm_spline(x: Floats, y: Floats, at: Floats) -> Floats:
    """OpenSim's SimmSpline (OpenSim/Common/SimmSpline.cpp): the cubic spline of Forsythe, Malcolm and Moler.

    The third derivatives of the first and the last piece are those of the cubics through the first and the last four
    points; two points give a line. The pieces at the ends go on beyond the points, where OpenSim goes on along a line.
    """
    h, slope, n = np.diff(x), np.diff(y) / np.diff(x), len(x)
    bend = np.zeros(n)  # a sixth of the second derivatives
    if n > 2:
        rows, right = np.zeros((n, n)), np.zeros(n)
        for i in range(1, n - 1):
            rows[i, i - 1 : i + 2] = h[i - 1], 2.0 * (h[i - 1] + h[i]), h[i]
            right[i] = slope[i] - slope[i - 1]
        rows[0, :2] = rows[-1, -2:] = -1.0, 1.0
        right[0], right[-1] = h[0] * third_difference(x[:4], y[:4]), h[-1] * third_difference(x[-4:], y[-4:])
        bend = np.linalg.solve(rows, right)
    i = np.clip(np.searchsorted(x, at) - 1, 0, n - 2)
    t, start = at - x[i], slope[i] - h[i] * (2.0 * bend[i] + bend[i + 1])
    return y[i] + t * (start + t * (3.0 * bend[i] + t * (bend[i + 1] - bend[i]) / h[i]))


def third_difference(x: Floats, y: Floats) -> float:
    """A sixth of the third derivative of the cubic through four points."""
    return float(np.polyfit(x - x[0], y, 3)[0])


def test_spline_goes_through_its_points_and_gives_back_a_cubic():
    x = np.array([-2.0, -1.7, -0.4, 0.1, 0.2, 1.5])
    at = np.linspace(-2.0, 1.5, 50)
    np.testing.assert_allclose(simm_spline(x, np.sin(9.0 * x), x), np.sin(9.0 * x), atol=1e-12)
    np.testing.assert_allclose(simm_spline(x, np.polyval([3, -2, 1, 5], x), at), np.polyval([3, -2, 1, 5], at))
    np.testing.assert_allclose(simm_spline(x[:2], np.array([1.0, 4.0]), np.array([-1.9])), 2.0)


def model(reference_data: Path, name: str) -> Osim:
    file = reference_data / "opensim_reference" / f"{name}.osim"
    if not file.is_file():
        pytest.skip(f"no {file}")
    return Osim(file)


WITHOUT_KNEES = {
    "hips": (
        "gait10dof18musc",
        "pelvis",
        ["hip_r", "hip_l"],
        ["glut_max_r", "iliopsoas_r", "glut_max_l", "iliopsoas_l"],
    ),
    "right ankle": ("gait10dof18musc", "tibia_r", ["ankle_r", "subtalar_r"], ["soleus_r", "tib_ant_r"]),
    "left ankle": ("gait10dof18musc", "tibia_l", ["ankle_l", "subtalar_l"], ["soleus_l", "tib_ant_l"]),
    "arm": ("arm26", "base", ["r_shoulder", "r_elbow"], ["BICshort"]),
}


@pytest.mark.parametrize("case", WITHOUT_KNEES)
def test_paths_without_wrapping_are_those_of_opensim(reference_data: Path, case: str):
    """Lengths, lengthening speeds and moment arms of all muscles that cross pin joints only, in all poses."""
    name, root, joints, muscles = WITHOUT_KNEES[case]
    osim = model(reference_data, name)
    got, expected = osim.geometry(root, joints, muscles), osim.expected(joints, muscles)
    for mine, theirs, tolerance in zip(got, expected, (1e-6, 1e-5, 1e-6), strict=True):
        assert np.abs(theirs).max() > 0.01
        np.testing.assert_allclose(mine, theirs, atol=tolerance)


@pytest.mark.parametrize("side", ["r", "l"])
def test_paths_over_a_knee_are_those_of_opensim(reference_data: Path, side: str):
    """Lengths and moment arms of the muscles that cross a knee, which moves as it turns, as the ends of two of them do.

    No joint of ours moves along its parent: each pose is an instance with its own place of the knee and of the moving
    points. Compared in all poses are the lengths, and our moment arms about hip and ankle. Ours about the knee leave
    out the motion of knee and points, which -dl/dq includes: compared are differences of our lengths, in all poses but
    those within a step of where a conditional point comes in or of close knots of a spline. Lengthening speeds are not
    compared.
    """
    osim, knee = model(reference_data, "gait10dof18musc"), f"knee_angle_{side}"
    joints = [f"{name}_{side}" for name in ("hip", "knee", "ankle", "subtalar")]
    muscles = [f"{name}_{side}" for name in ("hamstrings", "bifemsh", "rect_fem", "vasti", "gastroc")]
    length, _, arm = osim.geometry("pelvis", joints, muscles)
    their_length, _, their_arm = osim.expected(joints, muscles)
    np.testing.assert_allclose(length, their_length, atol=1e-6)
    np.testing.assert_allclose(arm[:, :, [0, 2]], their_arm[:, :, [0, 2]], atol=1e-6)
    at_knee = osim.arm_by_differences(knee, "pelvis", joints, muscles)
    compared = osim.to_switch(muscles) > STEP + BLEND
    compared &= np.abs(osim.q[:, osim.column[knee], None]) > STEP + CLOSE_KNOTS
    assert compared.mean() > 0.95
    np.testing.assert_allclose(at_knee[compared], their_arm[:, :, 1][compared], atol=1e-4)
