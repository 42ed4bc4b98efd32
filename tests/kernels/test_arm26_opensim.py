"""OpenSim's arm26: paths of all six muscles where no surface bends them, and the dynamics of its two joints."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from test_path_opensim import Osim, numbers

from warpmuscle.core.pose import about, multiply, rotate
from warpmuscle.scene import Body, Character, Scene
from warpmuscle.simulation.stages import Stages

JOINTS = ["r_shoulder", "r_elbow"]
ON_CYLINDER = ["TRIlat", "TRImed", "BRA"]  # which wraps wherever the straight path meets it, from any side
OTHERS = ["TRIlong", "BIClong"]  # also on surfaces that they wrap from one side only
MARGIN = 1e-4  # m, to a surface

Floats = NDArray[np.float64]


class Arm26(Osim):
    """The model without its wrapping surfaces, and the cylinder at the elbow."""

    def __init__(self, file: Path) -> None:
        super().__init__(file)
        self.cylinder = self.root.find(".//WrapCylinder[@name='TRI']")
        for path in self.root.iter("GeometryPath"):
            wraps = path.find("PathWrapSet")
            if wraps is not None:
                path.remove(wraps)

    def misses_cylinder(self, muscle: str) -> NDArray[np.bool_]:
        """Poses (n,) in which no straight part of the path comes into the cylinder."""
        stages, _ = self.solved("base", JOINTS, [muscle])
        kinematics = stages.forward_kinematics()
        position, orientation = (kinematics[name].astype(float) for name in ("position", "orientation"))
        names = list(stages.names.bodies)

        def world(body: str, place: Floats) -> Floats:
            k = names.index(body)
            return position[:, k] + rotate(orientation[:, k], place)

        center = np.array(numbers(self.cylinder, "translation")) - self.centers["r_humerus"]
        turns = [
            about(axis, angle)
            for axis, angle in zip(np.eye(3), numbers(self.cylinder, "xyz_body_rotation"), strict=True)
        ]
        axis = rotate(multiply(turns[0], multiply(turns[1], turns[2])), np.array([0.0, 0.0, 1.0]))
        humerus = orientation[:, names.index("r_humerus")]
        middle, along = world("r_humerus", center), rotate(humerus, axis)
        radius = float(self.cylinder.findtext("radius")) + MARGIN
        points = [world(point.body, np.array(point.position)) for point in self.path(muscle)]
        missed = np.ones(len(self.q), dtype=bool)
        for start, end in pairwise(points):
            missed &= distance_across(start - middle, end - middle, along) > radius
        return missed


def distance_across(start: Floats, end: Floats, axis: Floats) -> Floats:
    """Least distance of segments (n, 3) from lines through the origin along unit axes (n, 3)."""
    a, d = (v - np.sum(v * axis, axis=1, keepdims=True) * axis for v in (start, end - start))
    part = np.clip(-np.sum(a * d, axis=1) / np.maximum(np.sum(d * d, axis=1), 1e-12), 0.0, 1.0)
    return np.linalg.norm(a + part[:, None] * d, axis=1)


@pytest.fixture(scope="module")
def arm26(reference_data: Path) -> Arm26:
    file = reference_data / "opensim_reference" / "arm26.osim"
    if not file.is_file():
        pytest.skip(f"no {file}")
    return Arm26(file)


def compared(arm26: Arm26, muscle: str) -> tuple[Floats, Floats, Floats, Floats]:
    """Lengths (n,) and moment arms (n, 2), ours and theirs."""
    length, _, arm = arm26.geometry("base", JOINTS, [muscle])
    their_length, _, their_arm = arm26.expected(JOINTS, [muscle])
    return length[:, 0], arm[:, 0], their_length[:, 0], their_arm[:, 0]


def assert_equal(mine: Floats, theirs: Floats, tolerance: float) -> None:
    np.testing.assert_allclose(mine, theirs, atol=tolerance * np.abs(theirs).max())


@pytest.mark.parametrize("muscle", ON_CYLINDER)
def test_paths_that_miss_the_cylinder_are_those_of_opensim(arm26: Arm26, muscle: str):
    """Within 1e-4 m and 1e-3 of the largest moment arm; in all other poses OpenSim's path is the longer one."""
    length, arm, their_length, their_arm = compared(arm26, muscle)
    straight = arm26.misses_cylinder(muscle)
    assert straight.mean() > 0.5
    np.testing.assert_allclose(length[straight], their_length[straight], atol=1e-6)
    assert_equal(arm[straight], their_arm[straight], 1e-5)
    assert np.all(their_length[~straight] > length[~straight] - 1e-6)


@pytest.mark.parametrize("muscle", OTHERS)
def test_long_heads_are_those_of_opensim_where_no_surface_lengthens_them(arm26: Arm26, muscle: str):
    length, arm, their_length, their_arm = compared(arm26, muscle)
    straight = np.abs(their_length - length) < 1e-6
    assert straight.sum() > 40
    assert_equal(arm[straight], their_arm[straight], 1e-3)
    assert np.all(their_length > length - 1e-6)


def test_path_through_points_alone_is_that_of_opensim_in_all_poses(arm26: Arm26):
    length, arm, their_length, their_arm = compared(arm26, "BICshort")
    np.testing.assert_allclose(length, their_length, atol=1e-6)
    assert_equal(arm, their_arm, 1e-5)


# Dynamics.


def whole_arm(arm26: Arm26, q: Floats, u: Floats) -> Stages:
    """The arm with its masses at angles and rates (n, 2)."""
    tree = {name: arm26.joint(name)[1] for name in JOINTS}
    bodies = {"base": Body(1.0, (1.0, 1.0, 1.0))}
    for joint in tree.values():
        element = arm26.root.find(f".//BodySet/objects/Body[@name='{joint.child}']")
        moments = numbers(element, "inertia")
        assert moments[3:] == (0.0, 0.0, 0.0)
        bodies[joint.child] = Body(float(element.findtext("mass")), moments[:3])
    gravity = -numbers(arm26.root.find("Model"), "gravity")[1]
    stages = Stages(Scene("arm26", Character("base", bodies, tree, root_joint="fixed"), gravity=gravity), len(q), "cpu")
    coordinates = stages.state.coordinates.numpy().copy()
    coordinates[:, -2:] = q
    stages.state.coordinates.assign(coordinates)
    stages.state.speeds.assign(u.astype(np.float32))
    return stages


def test_dynamics_of_arm26_are_those_of_opensim(arm26: Arm26, reference_data: Path):
    """Mass matrix, what holds the arm against gravity, and inverse dynamics within 1e-3 of the greatest of each."""
    t = np.load(reference_data / "opensim_reference" / "arm26_dynamics_reference.npz")
    assert list(t["coordinate_to_mobility_index"]) == [0, 1]
    moving, still = (whole_arm(arm26, t["q"], speed) for speed in (t["u"], np.zeros_like(t["u"])))
    matrix = moving.mass_matrix().astype(float)
    assert_equal(matrix, t["mass_matrix_mobility_order"], 1e-5)

    def needed(stages: Stages, acceleration: Floats) -> Floats:
        lacking = acceleration - stages.forward_dynamics()["speed_rate"].astype(float)
        return np.einsum("nij,nj->ni", matrix, lacking)

    assert_equal(needed(still, np.zeros_like(t["q"])), t["tau_gravity_static_mobility_order"], 1e-5)
    assert_equal(needed(moving, t["udot_mobility_order"]), t["tau_mobility_order"], 1e-5)
