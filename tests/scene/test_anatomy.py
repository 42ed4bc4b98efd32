"""Which joints of a leg are hip, knee and ankle."""

import math

import msgspec
import pytest

from warpmuscle import examples
from warpmuscle.formats import load, toml
from warpmuscle.scene import Body, Displacement, Joint, JointState, Scene
from warpmuscle.scene.anatomy import leg_joints, straight_legs

HINGES = {"flexion": (-1.0, 0.0, 0.0), "adduction": (0.0, 0.0, 1.0), "rotation": (0.0, 1.0, 0.0)}


def legs_of(order: list[str], mass_between: float = 0.0) -> Scene:
    """A pelvis on two legs whose hips are three hinges, one below the other, with such a mass between them."""
    lines = ['name = "legs"', "[character]", 'root = "pelvis"', 'feet = ["foot_l", "foot_r"]']
    lines += ["[character.bodies.pelvis]", "mass = 10.0", "inertia = [0.1, 0.1, 0.1]"]
    for side, x in (("l", 0.1), ("r", -0.1)):
        between = [f"{name}_{side}" for name in order[:-1]]
        chain = ["pelvis", *between, f"thigh_{side}", f"shank_{side}", f"foot_{side}"]
        joints = [(name, HINGES[name]) for name in order] + [("knee", HINGES["flexion"]), ("ankle", HINGES["flexion"])]
        for body in chain[1:]:
            mass = mass_between if body in between else 1.0
            lines += [f"[character.bodies.{body}]", f"mass = {mass}", f"inertia = [{mass / 9}, {mass / 9}, {mass / 9}]"]
        for (name, axis), parent, child in zip(joints, chain[:-1], chain[1:], strict=True):
            place = (x, 0.0, 0.0) if parent == "pelvis" else (0.0, -0.1, 0.0)
            lines += [f"[character.joints.{name}_{side}]", 'type = "hinge"', f'parent = "{parent}"']
            lines += [f'child = "{child}"', f"axes = [{list(axis)}]", f"position_in_parent = {list(place)}"]
            lines += ["position_in_child = [0.0, 0.0, 0.0]"]
    return toml.loads("\n".join(lines))


@pytest.mark.parametrize("order", [["flexion", "adduction", "rotation"], ["rotation", "adduction", "flexion"]])
def test_a_hip_of_three_hinges_bends_about_the_one_that_points_to_the_side(order):
    scene = legs_of(order)
    assert leg_joints(scene, 0) == ["flexion_l", "knee_l", "ankle_l"]
    assert leg_joints(scene, 1) == ["flexion_r", "knee_r", "ankle_r"]


def test_bodies_with_a_mass_between_hinges_make_joints_of_their_own():
    assert leg_joints(legs_of(["flexion", "adduction", "rotation"], 0.5), 0) == ["rotation_l", "knee_l", "ankle_l"]


def test_joints_that_hold_still_are_none_of_a_leg():
    scene = legs_of(["flexion"])
    joints = dict(scene.character.joints)
    joints["heel_l"] = Joint("fixed", "foot_l", "heel_l", (0.0, 0.0, -0.03), (0.0, 0.0, 0.0))
    bodies = scene.character.bodies | {"heel_l": Body(0.5, (0.01, 0.01, 0.01))}
    character = msgspec.structs.replace(scene.character, joints=joints, bodies=bodies, feet=("heel_l", "foot_r"))
    assert leg_joints(msgspec.structs.replace(scene, character=character), 0) == ["flexion_l", "knee_l", "ankle_l"]


def test_a_knee_that_rolls_is_taken_before_a_hinge_to_the_side_below_it():
    scene = legs_of(["flexion"])
    joints = dict(scene.character.joints)
    hinge = joints["knee_l"]
    rolling = msgspec.structs.replace(
        hinge, type="coupled", axes=[], rotations=[Displacement((-1.0, 0.0, 0.0), slope=1.0)], child="knee_l"
    )
    sideways = Joint("hinge", "knee_l", "shank_l", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), [(0.0, 0.0, 1.0)])
    joints |= {"knee_l": rolling, "knee_aside_l": sideways}
    bodies = scene.character.bodies | {"knee_l": Body(0.0, (0.0, 0.0, 0.0))}
    character = msgspec.structs.replace(scene.character, joints=joints, bodies=bodies)
    assert leg_joints(msgspec.structs.replace(scene, character=character), 0) == ["flexion_l", "knee_l", "ankle_l"]


def test_a_knee_below_a_massless_part_of_the_thigh_is_no_part_of_the_hip():
    """As in models of knee loads, whose condyles are welded to the thigh and have no mass of their own."""
    scene = legs_of(["flexion"])
    joints = dict(scene.character.joints)
    knee = msgspec.structs.replace(joints["knee_l"], parent="condyle_l", position_in_parent=(0.0, 0.0, 0.0))
    weld = Joint("fixed", "thigh_l", "condyle_l", (0.0, -0.1, 0.0), (0.0, 0.0, 0.0))
    bodies = scene.character.bodies | {"condyle_l": Body(0.0, (0.0, 0.0, 0.0))}
    character = msgspec.structs.replace(
        scene.character, joints={"weld_l": weld} | joints | {"knee_l": knee}, bodies=bodies
    )
    assert leg_joints(msgspec.structs.replace(scene, character=character), 0) == ["flexion_l", "knee_l", "ankle_l"]


@pytest.mark.parametrize("foot", ["talus", "calcn"])
def test_a_foot_below_a_subtalar_joint_has_the_same_hip_knee_and_ankle(foot: str):
    scene = load("gait2392")
    assert scene.simbicon is None
    character = msgspec.structs.replace(scene.character, feet=(f"{foot}_l", f"{foot}_r"))
    standing = msgspec.structs.replace(scene, character=character)
    assert leg_joints(standing, 0) == ["hip_l", "knee_angle_l", "ankle_angle_l"]
    assert leg_joints(standing, 1) == ["hip_r", "knee_angle_r", "ankle_angle_r"]


@pytest.mark.parametrize(("degrees", "straight"), [(0.0, True), (29.0, True), (31.0, False), (88.0, False)])
@pytest.mark.parametrize("side", "lr")
def test_legs_are_straight_by_their_pose_of_no_angles_wherever_they_start(degrees: float, straight: bool, side: str):
    scene = legs_of(["flexion"])
    joints = dict(scene.character.joints)
    turn = math.radians(degrees)
    ankle = (0.0, -0.1 * math.cos(turn), -0.1 * math.sin(turn))  # in the shank, whose axes are the thigh's
    joints[f"ankle_{side}"] = msgspec.structs.replace(joints[f"ankle_{side}"], position_in_parent=ankle)
    character = msgspec.structs.replace(scene.character, joints=joints)
    turned = JointState((math.sin(0.6), 0.0, 0.0, math.cos(0.6)))
    bent = {f"knee_{one}": turned for one in "lr"}
    for start in ({}, bent):
        state = msgspec.structs.replace(scene.initial_state, joints=start)
        posed = msgspec.structs.replace(scene, character=character, initial_state=state)
        assert straight_legs(posed) == straight


def test_a_scene_without_legs_has_none_that_are_bent():
    assert straight_legs(load("throw"))


def test_joints_that_are_called_so_are_hip_knee_and_ankle_where_toes_bend_below_them(tmp_path):
    examples.write("creatures", tmp_path)
    ostrich = load(tmp_path / "ostrich_found.toml")
    assert leg_joints(ostrich, 0) == ["lHip", "lKnee", "lAnkle"]
    assert leg_joints(ostrich, 1) == ["rHip", "rKnee", "rAnkle"]
