"""Curves come in an order in which one looks for them."""

import pytest

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
    found = list(dict.fromkeys(title.rstrip("abxyz ") for title in titles("walk56", group)))
    assert found == ["Hip", "Knee", "Ankle", "ToeJoint", "pelvis torso", "Shoulder", "Elbow", "torso head"]


def test_legs_come_first_also_where_nothing_says_which_bodies_walk():
    found = list(dict.fromkeys(title.rstrip("xyz ") for title in titles("gait2392", "angles")))
    assert found == ["hip", "knee angle", "ankle angle", "subtalar angle", "mtp angle", "back"]


def test_an_arm_comes_from_the_shoulder_to_the_hand():
    assert titles("throw", "angles") == ["shoulder", "elbow", "wrist"]
