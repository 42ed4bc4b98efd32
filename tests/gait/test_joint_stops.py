"""What the stops of joints do, against what the motion of a falling body needs."""

import numpy as np
import pytest

from small_result import with_arrays
from warpmuscle.core.pose import about, rotate
from warpmuscle.formats import load
from warpmuscle.gait.joint_moments import MOMENTS_AT, leg_moments
from warpmuscle.gait.joint_stops import stop_torques
from warpmuscle.gait.table import human
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import foot_bodies
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.ground_loads import ground_loads, step_accelerations
from warpmuscle.studies.inverse_dynamics import body_points, inverse_dynamics

KEPT = slice(20, -2)  # frames; accelerations of the first are not known well


@pytest.fixture(scope="module")
def fall() -> tuple[Scene, Recording]:
    """The biped on torques in the air, all joints driven into tight stops."""
    scene = load("fwalk")
    scene.implicit_pd, scene.duration = True, 0.1
    scene.ground.height, scene.failure.com_height, scene.failure.heading = -100.0, 0.0, 0.0
    for joint in scene.character.joints.values():
        joint.limits = [(-0.02 - 0.01 * k, 0.03) for k in range(len(joint.limits))]
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / float(scene.time_step))
    rollout.run()
    return scene, rollout.recording()


def test_drives_and_stops_give_what_the_motion_needs(fall: tuple[Scene, Recording]):
    scene, motion = fall
    names = topology(scene.character)
    accelerations = step_accelerations(motion, float(scene.time_step))
    assert accelerations is not None
    needed = inverse_dynamics(scene, motion.coordinate, motion.speed, accelerations)
    for number, name in enumerate(names.joints, start=1):
        joint, parent = scene.character.joints[name], names.parents[number]
        turned = np.asarray(motion.body_orientation[:, parent], float)
        axes = joint_type(joint).pulled_about(
            joint, np.asarray(motion.coordinate[:, names.coordinates_of(number)], float)
        )
        stopped = -rotate(turned, stop_torques(motion, scene, name))
        driven = -np.asarray(motion.joint_torque[:, number - 1], float)
        needed_here = needed[:, names.speeds_of(number)]
        peak = np.abs(needed_here[KEPT]).max()
        for axis, of_speed in zip(axes, needed_here.T, strict=True):
            found = np.sum((driven + stopped) * rotate(turned, axis), axis=1)
            assert np.abs(found - of_speed)[KEPT].max() < 0.002 * peak, name
    pushed = [np.abs(stop_torques(motion, scene, name)).max() for name in ("lHip", "lKnee", "lAnkle", "rHip", "rKnee")]
    assert min(pushed) > 5.0  # N m: all of them are at their stops


def test_moments_of_legs_have_their_stops_in_them(fall: tuple[Scene, Recording]):
    scene, motion = fall
    names = topology(scene.character)
    needed = inverse_dynamics(
        scene, motion.coordinate, motion.speed, step_accelerations(motion, float(scene.time_step))
    )
    knee = names.joints.index("lKnee") + 1
    moment = leg_moments(motion, scene)["Knee moment"]["left"] * body_mass(scene.character)
    axis = scene.character.joints["lKnee"].axes[0]
    assert abs(axis[0]) == 1.0
    expected = -axis[0] * needed[:, names.speeds_of(knee)][:, 0]  # of extensors positive: they turn about -x
    np.testing.assert_allclose(moment[KEPT], expected[KEPT], atol=1e-4 * np.abs(expected[KEPT]).max())


def test_few_frames_give_nearly_the_same(fall: tuple[Scene, Recording]):
    scene, motion = fall
    coarse = motion.at(slice(None, None, 10))
    for name in ("lHip", "lKnee", "lAnkle"):
        every = stop_torques(motion, scene, name)[::10]
        np.testing.assert_allclose(
            stop_torques(coarse, scene, name)[1:-1], every[1:-1], atol=0.1 * np.abs(every).max() + 0.5
        )


def test_where_not_every_step_was_recorded_a_joint_moves_over_a_step_by_half_of_its_change_more(
    fall: tuple[Scene, Recording],
):
    """A knee that turns ever faster into its stop: its mean rate over a step of h is that of its begin and h/2 more."""
    scene, motion = fall
    coarse = motion.at(slice(None, None, 10))
    joint, step, faster = scene.character.joints["lKnee"], float(scene.time_step), 4000.0  # rad/s^2
    number, axis = coarse.joint_names.index("lKnee"), np.asarray(joint.axes[0], float)
    since = coarse.time - coarse.time[0]
    rate, angle = 2.0 + faster * since, 0.05 + 2.0 * since + 0.5 * faster * since**2
    turned, turning = coarse.joint_orientation.copy(), coarse.joint_angular_velocity.copy()
    turned[:, number], turning[:, number] = about(axis, angle), rate[:, None] * axis
    seen = angle < 2.0  # rad, a knee that does not turn round
    moved = with_arrays(coarse, joint_orientation=turned, joint_angular_velocity=turning)
    found = stop_torques(moved, scene, "lKnee") @ axis
    stiffness, damping = float(joint.limit_stiffness), float(joint.limit_damping)
    expected = stiffness * (angle - 0.03) + (damping + step * stiffness) * (rate + 0.5 * step * faster)
    np.testing.assert_allclose(found[seen], expected[seen], rtol=1e-4)


def test_joints_without_limits_have_no_stops(fall: tuple[Scene, Recording]):
    scene, motion = fall
    free = load("fwalk")
    free.character.joints["lKnee"].limits = []
    assert not stop_torques(motion, free, "lKnee").any()
    assert stop_torques(motion, scene, "lKnee").any()


def test_moments_are_what_motion_and_ground_forces_need():
    """As people's are found: inverse dynamics of the leg, with the force of the ground at its centre of pressure."""
    scene = load("fwalk")
    scene.duration = 0.6
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / float(scene.time_step))
    rollout.run()
    motion, names = rollout.recording(), topology(scene.character)
    needed = inverse_dynamics(
        scene, motion.coordinate, motion.speed, step_accelerations(motion, float(scene.time_step))
    )
    points = body_points(scene, motion.coordinate)
    loads = {load.body: load for load in ground_loads(motion, scene)}
    for name in ("Knee", "Ankle"):
        for side, foot in (("left", "lFoot"), ("right", "rFoot")):
            joint = side[0] + name
            place = points[scene.character.joints[joint].child][0]
            pushed = [loads[body] for body in foot_bodies(scene.character, foot) if body in loads]
            of_ground = sum(np.cross(one.point - place, one.force) + one.torque for one in pushed)
            parent = motion.body_names.index(scene.character.joints[joint].parent)
            mediolateral = rotate(np.asarray(motion.body_orientation[:, parent], float), np.array([1.0, 0.0, 0.0]))
            number = names.joints.index(joint) + 1
            first = names.speeds_of(number).start
            flexing = needed[:, first] - np.sum(of_ground * mediolateral, axis=1)
            sign = 1.0 if name == "Ankle" else -1.0
            moment = sign * leg_moments(motion, scene)[f"{name} moment"][side] * body_mass(scene.character)
            assert np.abs(flexing[KEPT]).max() > 40.0
            assert np.abs(moment - flexing)[KEPT].max() < 0.01 * np.abs(flexing[KEPT]).max(), joint


def test_the_knee_before_push_off_is_that_at_half_of_the_cycle():
    assert MOMENTS_AT["knee moment before push-off"] == ("Knee moment", 50.0)
    assert human("knee moment before push-off")[0] == "-0.02 ± 0.13"
    assert human("knee moment in loading")[0] == "0.34 ± 0.22"
