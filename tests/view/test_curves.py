"""Curves come in an order in which one looks for them."""

import dataclasses
from pathlib import Path

import msgspec
import numpy as np
import pytest

from warpmuscle import examples
from warpmuscle.core.pose import from_rotation_vector, multiply, rotate
from warpmuscle.creatures.build import creature_scene, read_creature
from warpmuscle.formats import load
from warpmuscle.scene import Force, JointState
from warpmuscle.scene.initial_pose import initial_pose
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.parameters import at_start, start_values, substitute
from warpmuscle.view.curves import leg_curves, panels_of
from warpmuscle.view.waiting import first_pose

FILES = Path(examples.__file__).with_name("files")


def titles(name: str, group: str) -> list[str]:
    scene = load(name)
    plain = substitute(scene, start_values(scene))
    return [panel.title for panel in panels_of(first_pose(plain), plain) if panel.group == group]


@pytest.mark.parametrize("group", ["angles", "torques"])
def test_legs_come_first_from_the_hip_to_the_toes_then_the_trunk_arms_and_the_head(group: str):
    found = list(dict.fromkeys(title.rstrip("xyz ") for title in titles("walk56", group)))
    assert found == [
        "hip flexion", "hip rotation", "hip abduction", "knee flexion", "ankle dorsiflexion", "ankle inversion",
        "toe flexion", "trunk flexion", "trunk rotation to the left", "trunk bending to the right",
        "shoulder flexion", "shoulder rotation", "shoulder abduction from level", "elbow flexion",
        "neck flexion", "neck rotation to the left", "neck bending to the right",
    ]  # fmt: skip


def test_legs_come_first_also_where_nothing_says_which_bodies_walk():
    found = list(dict.fromkeys(title.rstrip("xyz ") for title in titles("gait2392", "angles")))
    assert found == ["hip", "knee angle", "ankle angle", "subtalar angle", "metatarsophalangeal angle", "back"]


@pytest.mark.parametrize(
    ("name", "title"),
    [
        ("r_shoulder_elev", "right shoulder elevation"),
        ("elbow_flex_l", "left elbow flexion"),
        ("armAdd", "arm adduction"),
        ("mtp_angle", "metatarsophalangeal angle"),
        ("r", "r"),
        ("TA", "TA"),
    ],
)
def test_short_names_of_joints_are_shown_in_full(name: str, title: str):
    scene = load("throw")
    plain = substitute(scene, start_values(scene))
    joints = plain.character.joints
    plain.character.joints = {{"elbow": name}.get(old, old): joint for old, joint in joints.items()}
    pose = first_pose(plain)
    assert title in [panel.title for panel in panels_of(pose, plain) if panel.group == "angles"]


def test_toes_flex_towards_the_sole():
    scene = load("walk56")
    assert leg_curves(scene)["lToeJoint"] == ("toe flexion", 1.0)
    character = scene.character
    assert character.joints["lToeJoint"].axes == [(1.0, 0.0, 0.0)]  # to the left: what lies ahead goes down
    character.joints["lToeJoint"].axes = [(-0.81, 0.0, 0.58)]
    assert leg_curves(scene)["lToeJoint"] == ("toe flexion", -1.0)


def test_an_arm_comes_from_the_shoulder_to_the_hand():
    assert titles("throw", "angles") == ["shoulder", "elbow", "wrist"]


def test_hips_abduct_and_rotate_inwards_with_a_positive_sign():
    scene = load("walk56")
    plain = substitute(scene, start_values(scene))
    pose = first_pose(plain)
    turned = {}
    for joint, outwards in (("lHip", 1.0), ("rHip", -1.0)):  # x is to the left, z ahead: about z a leg goes to the left
        orientation = np.array(pose.joint_orientation)
        number = pose.joint_names.index(joint)
        orientation[:, number] = from_rotation_vector(np.array([0.0, 0.0, 0.3 * outwards]))
        body = np.array(pose.body_orientation)
        child = pose.body_names.index(plain.character.joints[joint].child)
        parent = pose.body_names.index(plain.character.joints[joint].parent)
        body[:, child] = multiply(body[:, parent], orientation[:, number])
        moved = dataclasses.replace(pose, joint_orientation=orientation, body_orientation=body)
        (panel,) = (one for one in panels_of(moved, plain) if (one.group, one.title) == ("angles", "hip abduction"))
        turned[joint] = next(line.values[0] for line in panel.lines if line.name.startswith(joint))
    assert turned == pytest.approx({"lHip": np.degrees(0.3), "rHip": np.degrees(0.3)}, abs=1e-4)


@pytest.mark.parametrize("about_z", [0.3, -0.3])
def test_a_hip_of_two_axes_abducts_with_a_positive_sign(about_z: float):
    scene = at_start(creature_scene(read_creature(FILES / "spatial_walker.toml")))
    for side, outwards in (("l", 1.0), ("r", -1.0)):  # x is to the left
        joint = scene.character.joints[f"{side}Hip"]
        turned = JointState(tuple(from_rotation_vector(np.array([0.0, 0.0, about_z])).tolist()))
        state = msgspec.structs.replace(scene.initial_state, joints={f"{side}Hip": turned})
        poses, _ = initial_pose(msgspec.structs.replace(scene, initial_state=state))
        away = outwards * (poses[f"{side}Foot"][0] - poses[joint.child][0])[0]
        title, sign = leg_curves(scene)[f"{side}Hip b"]
        abducted = sign * joint_type(joint).start(joint, turned)[0][0, 1]
        assert title == "hip abduction"
        assert abducted == pytest.approx(np.copysign(0.3, away), abs=1e-6)


def test_arms_that_are_lifted_ahead_flex_and_elbows_bend_with_a_positive_sign():
    scene = load("walk56")
    plain = substitute(scene, start_values(scene))
    pose = first_pose(plain)
    for side, outwards in (("l", 1.0), ("r", -1.0)):  # in the reference pose arms point aside
        hanging = from_rotation_vector(np.array([0.0, 0.0, -0.5 * np.pi * outwards]))
        lifted = multiply(from_rotation_vector(np.array([-0.3, 0.0, 0.0])), hanging)
        assert rotate(lifted, np.array([outwards, 0.0, 0.0])) == pytest.approx([0.0, -np.cos(0.3), np.sin(0.3)])
        bent = from_rotation_vector(np.array([0.0, -0.5 * outwards, 0.0]))  # which brings the hand ahead
        assert rotate(multiply(hanging, bent), np.array([outwards, 0.0, 0.0]))[2] > 0.0
        joint, body = np.array(pose.joint_orientation), np.array(pose.body_orientation)
        for name, turn in ((f"{side}Shoulder", lifted), (f"{side}Elbow", bent)):
            parts = plain.character.joints[name]
            parent, child = (pose.body_names.index(one) for one in (parts.parent, parts.child))
            joint[:, pose.joint_names.index(name)] = turn
            body[:, child] = multiply(body[:, parent], turn)
        moved = dataclasses.replace(pose, joint_orientation=joint, body_orientation=body)
        found = {one.title: line.values[0] for one in panels_of(moved, plain) if one.group == "angles"
                 for line in one.lines if line.name.startswith(side)}  # fmt: skip
        assert found["shoulder flexion"] == pytest.approx(np.degrees(0.3), abs=1e-4)
        assert found["shoulder abduction from level"] == pytest.approx(-90.0, abs=1e-4)
        assert found["elbow flexion"] == pytest.approx(np.degrees(0.5), abs=1e-4)


def test_a_trunk_that_leans_ahead_flexes_and_turns_to_the_left_with_a_positive_sign():
    scene = load("walk56")
    plain = substitute(scene, start_values(scene))
    pose = first_pose(plain)
    parent, child = (pose.body_names.index(name) for name in ("pelvis", "torso"))
    for axis, title in enumerate(("trunk flexion", "trunk rotation to the left", "trunk bending to the right")):
        turn = from_rotation_vector(0.3 * np.eye(3)[axis])
        body = np.array(pose.body_orientation)
        body[:, child] = multiply(body[:, parent], turn)
        joint = np.array(pose.joint_orientation)
        joint[:, pose.joint_names.index("pelvis_torso")] = turn
        moved = dataclasses.replace(pose, joint_orientation=joint, body_orientation=body)
        (panel,) = (one for one in panels_of(moved, plain) if (one.group, one.title) == ("angles", title))
        assert panel.lines[0].values[0] == pytest.approx(np.degrees(0.3), abs=1e-4)
        top = rotate(turn, np.array([0.0, 1.0, 0.0]))  # x to the left, z ahead
        ahead = rotate(turn, np.array([0.0, 0.0, 1.0]))
        assert (top[2] > 0.2, ahead[0] > 0.2, top[0] < -0.2)[axis]


def test_an_elbow_that_bends_past_180_degrees_goes_on():
    scene = load("throw")
    plain = substitute(scene, start_values(scene))
    pose = first_pose(plain)
    angle = np.linspace(2.8, 3.6, 9)
    frames = len(angle)
    again = {f.name: np.repeat(np.asarray(v), frames, axis=0) for f in dataclasses.fields(pose)
             if isinstance(v := getattr(pose, f.name), np.ndarray) and v.ndim and len(v) == 1}  # fmt: skip
    moved = dataclasses.replace(pose, **again | {"time": 0.01 * np.arange(frames)})
    elbow = pose.joint_names.index("elbow")
    axis = np.asarray(plain.character.joints["elbow"].axes[0], dtype=float)
    joint, body = np.array(moved.joint_orientation), np.array(moved.body_orientation)
    child = pose.body_names.index(plain.character.joints["elbow"].child)
    parent = pose.body_names.index(plain.character.joints["elbow"].parent)
    joint[:, elbow] = [from_rotation_vector(one * axis) for one in angle]
    body[:, child] = multiply(body[:, parent], joint[:, elbow])
    moved = dataclasses.replace(moved, joint_orientation=joint, body_orientation=body)
    (panel,) = (one for one in panels_of(moved, plain) if (one.group, one.title) == ("angles", "elbow"))
    assert np.diff(panel.lines[0].values) == pytest.approx(np.degrees(0.1), abs=0.01)


def test_the_torque_of_a_device_is_its_power_over_the_speed_of_its_joint():
    scene = load("walk56")
    plain = substitute(scene, start_values(scene))
    plain.forces = {"brace": Force("bilinear_spring", joint="lAnkle"), "harness": Force("weight_support", body="torso")}
    pose = first_pose(plain)
    speed = np.array([[5.0, -2.0]])
    moved = dataclasses.replace(
        pose, speed=speed, speed_names=("root.x", "lAnkle.0"), speed_units=("m/s", "rad/s"),
        recorded=np.array([[6.0, 4.0]]), recorded_units=("W", "W"),
        recorded_names=("forces.brace.power", "forces.harness.power"),
    )  # fmt: skip
    found = {(one.title, one.unit): one.lines[0].values[0] for one in panels_of(moved, plain) if one.group == "devices"}
    sign = leg_curves(plain)["lAnkle a"][1]
    assert found == {("brace torque", "N m"): sign * -3.0, ("brace power", "W"): 6.0, ("harness power", "W"): 4.0}
    still = dataclasses.replace(moved, speed=0.0 * speed)  # says nothing of torques
    assert [one.unit for one in panels_of(still, plain) if one.group == "devices"] == ["W", "W"]
