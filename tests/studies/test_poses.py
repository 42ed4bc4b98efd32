"""Poses of a scene as coordinates: those of its start, and those that its motion prescribes."""

import numpy as np
from msgspec.structs import replace
from scipy.interpolate import make_interp_spline

from warpmuscle.formats import load
from warpmuscle.scene import Actuation
from warpmuscle.scene.topology import coordinate_names, topology
from warpmuscle.studies.poses import initial_coordinates, prescribed_coordinates

TIMES = np.array([0.0, 0.137, 0.5, 1.499])  # s


def test_kinematic_joints_follow_splines_through_their_knots_and_others_stay():
    scene = load("throw")
    kinematic = dict.fromkeys(("shoulder", "elbow"), Actuation("kinematic"))
    found = prescribed_coordinates(replace(scene, actuation=scene.actuation | kinematic), TIMES)
    names = coordinate_names(topology(scene.character), scene.character)[0]
    for joint in kinematic:
        knots = scene.motion[joint]
        wanted = make_interp_spline(knots.time, knots.value, k=5)(TIMES)
        np.testing.assert_allclose(found[:, names.index(joint)], wanted, atol=1e-12)
    root = scene.motion["root"]  # of a planar one y, z and its turn about x
    knots = np.column_stack([np.array(root.position)[:, 1:], np.array(root.rotation)[:, 0]])
    np.testing.assert_allclose(found[:, :3], make_interp_spline(root.time, knots, k=5)(TIMES), atol=1e-12)
    wrist = names.index("wrist")  # its motion is given, but muscles drive it
    np.testing.assert_array_equal(found[:, wrist], initial_coordinates(scene)[wrist])


def test_without_motion_every_pose_is_the_start():
    scene = load("fwalk")
    np.testing.assert_array_equal(prescribed_coordinates(scene, TIMES), np.tile(initial_coordinates(scene), (4, 1)))
