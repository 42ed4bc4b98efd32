"""Curves come in an order in which one looks for them."""

import dataclasses

import numpy as np
import pytest

from warpmuscle.core.pose import from_rotation_vector, multiply
from warpmuscle.formats import load
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.view.curves import panels_of
from warpmuscle.view.waiting import first_pose


def titles(name: str, group: str) -> list[str]:
    scene = load(name)
    plain = substitute(scene, start_values(scene))
    return [panel.title for panel in panels_of(first_pose(plain), plain) if panel.group == group]


@pytest.mark.parametrize("group", ["angles", "torques"])
def test_legs_come_first_from_the_hip_to_the_toes_then_the_trunk_arms_and_the_head(group: str):
    found = list(dict.fromkeys(title.rstrip("xyz ") for title in titles("walk56", group)))
    assert found == [
        "hip flexion", "hip rotation", "hip abduction", "knee flexion", "ankle dorsiflexion", "Ankle b", "ToeJoint",
        "pelvis torso", "Shoulder", "Elbow", "torso head",
    ]  # fmt: skip


def test_legs_come_first_also_where_nothing_says_which_bodies_walk():
    found = list(dict.fromkeys(title.rstrip("xyz ") for title in titles("gait2392", "angles")))
    assert found == ["hip", "knee angle", "ankle angle", "subtalar angle", "mtp angle", "back"]


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
