"""Bones are closed, look outwards, lie between the joints, and are mirror images on both sides."""

import numpy as np
import pytest

from closed_meshes import check, volume
from warpmuscle.formats import load
from warpmuscle.scene.anatomy import joint_place
from warpmuscle.scene.initial_pose import plain_vector
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.topology import topology
from warpmuscle.view.bones.directions import AHEAD, ASIDE, DOWN, perpendicular
from warpmuscle.view.bones.head import skull
from warpmuscle.view.bones.limbs import Limbs
from warpmuscle.view.bones.meshes import ellipsoid, merged, tube
from warpmuscle.view.bones.skeleton import forearm_bones, hand_bones, upper_arm_bone
from warpmuscle.view.bones.spine import vertebrae
from warpmuscle.view.figure import figure_of
from warpmuscle.view.pieces import Hull

ROLES = {
    "walk56": {"lUpperleg": "thigh", "rLowerleg": "shank", "lFoot": "", "torso": "", "rUpperarm": "upper arm",
               "lLowerarm": "forearm", "pelvis": "", "head": ""},
    "gait2392_walk": {"femur_r": "thigh", "tibia_l": "shank", "talus_r": "ankle bone", "torso": "", "pelvis": ""},
    "throw18": {"upper_arm": "upper arm", "forearm": "forearm", "hand": "hand", "trunk": ""},
}  # fmt: skip


def bones(name: str) -> dict[str, list[Hull]]:
    scene = load(name)
    plain = substitute(scene, start_values(scene))
    names = topology(plain.character).bodies
    found = figure_of(plain.character, plain.feet or (), names)
    return {
        body: [p for p in found if isinstance(p, Hull) and p.layer == "bone" and names[p.body] == body]
        for body in names
    }


def test_a_tube_and_an_ellipsoid_have_the_volume_of_theirs():
    straight = tube(np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), 0.1, 64)
    caps = 2.0 * np.pi * 0.1**3 * (0.7 * (1 + 0.72 + 0.72**2) + 0.3 * 0.72**2) / 3.0
    assert volume(straight) == pytest.approx(np.pi * 0.01 + caps, rel=0.01)
    assert volume(ellipsoid(np.array([1.0, 2.0, 3.0]), (0.1, 0.2, 0.3), None, 64)) == pytest.approx(
        4.0 / 3.0 * np.pi * 0.006, rel=0.01
    )
    assert volume(merged([straight, straight])) == pytest.approx(2.0 * volume(straight))


@pytest.mark.parametrize("name", ROLES)
def test_limbs_are_known_by_how_they_hang_on_one_another(name: str):
    scene = load(name)
    plain = substitute(scene, start_values(scene))
    limbs = Limbs(plain.character, plain.feet or ())
    assert {body: limbs.role(body) for body in ROLES[name]} == ROLES[name]


@pytest.mark.parametrize("name", ["walk56", "gait2392_walk", "throw18", "bigbird_walk", "reflex_walk"])
def test_bones_are_closed_and_look_outwards(name: str):
    found = [bone for pieces in bones(name).values() for bone in pieces]
    assert found
    for bone in found:
        check(bone.corners, bone.normals, bone.faces)
        assert volume((bone.corners, bone.normals, bone.faces)) > 0.0


def test_long_bones_reach_from_joint_to_joint():
    scene = load("walk56")
    character, found = substitute(scene, start_values(scene)).character, bones("walk56")
    for above, below, body in (
        ("lHip", "lKnee", "lUpperleg"),
        ("lKnee", "lAnkle", "lLowerleg"),
        ("rShoulder", "rElbow", "rUpperarm"),
    ):
        (bone,) = found[body]
        ends = plain_vector(character.joints[above].position_in_child), joint_place(character.joints[below])
        for end in ends:
            assert np.linalg.norm(bone.corners - end, axis=1).min() < 0.04, (body, end)
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        reach = (bone.corners - ends[0]) @ along
        assert -0.05 < reach.min() < reach.max() < np.linalg.norm(ends[1] - ends[0]) + 0.05


@pytest.mark.parametrize("part", ["Upperleg", "Lowerleg", "Foot", "Toes", "Upperarm", "Lowerarm"])
def test_both_sides_are_mirror_images(part: str):
    found, left, right = bones("walk56"), f"l{part}", f"r{part}"
    for one, other in zip(found[left], found[right], strict=True):
        low, high = one.corners.min(axis=0), one.corners.max(axis=0)
        mirrored = other.corners * [-1.0, 1.0, 1.0]
        np.testing.assert_allclose([low, high], [mirrored.min(axis=0), mirrored.max(axis=0)], atol=2e-3)


def test_a_skull_is_as_high_as_its_sphere_and_looks_ahead():
    bone, hollow = skull(np.zeros(3), np.array([0.0, 0.2, 0.0]), 0.1)
    assert bone[0][:, 1].max() == pytest.approx(0.3, abs=0.01)
    assert hollow[0][:, 2].min() > 0.0


@pytest.mark.parametrize("wanted", [ASIDE, DOWN, AHEAD])
@pytest.mark.parametrize("axis", [ASIDE, DOWN, AHEAD, -AHEAD, np.array([0.6, 0.0, 0.8])])
def test_a_direction_across_an_axis_is_found_wherever_that_points(axis: np.ndarray, wanted: np.ndarray):
    found = perpendicular(axis, wanted)
    assert np.linalg.norm(found) == pytest.approx(1.0)
    assert found @ axis == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("bone", [upper_arm_bone, forearm_bones, hand_bones])
def test_bones_of_an_arm_that_points_ahead_are_as_thick_as_those_of_one_that_hangs(bone):
    ahead, down = (np.sort(np.ptp(bone(np.zeros(3), 0.3 * along, 1.0)[0], axis=0)) for along in (AHEAD, DOWN))
    np.testing.assert_allclose(ahead, down, atol=0.012)


def test_a_spine_may_lie_along_any_axis():
    for along in (ASIDE, DOWN, AHEAD):
        assert np.isfinite(vertebrae(np.array([np.zeros(3), 0.3 * along]), 1.0)[0]).all()
