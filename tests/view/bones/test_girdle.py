"""Rib cages and shoulder blades of models whose bodies are called so."""

from __future__ import annotations

import numpy as np
import pytest

from warpmuscle.scene import Body, Character, Joint, Muscle, ViaPoint
from warpmuscle.scene.anatomy import sides_of
from warpmuscle.view.bones.girdle import rib_cage, shoulder_blade
from warpmuscle.view.figure import figure_of
from warpmuscle.view.pieces import Hull

NOTCH = np.array([0.0, 0.14, 0.06])  # m, in the thorax's frame
BLADE = [(-0.05, 0.03, 0.02), (0.05, 0.05, -0.03), (0.03, -0.1, -0.03), (-0.02, 0.05, 0.0), (0.04, 0.0, -0.03)]


def shoulder(upper_arm: float = 0.3, collar: str = "clavicle_r") -> Character:
    """A right arm on a collar bone and a shoulder blade, on a thorax without mass; muscles end on the blade."""
    still, hinge = (0.0, 0.0, 0.0), [(1.0, 0.0, 0.0)]
    masses = {"ground": 0.0, "thorax": 0.0, collar: 0.2, "scapula_r": 0.7, "humerus_r": 2.0, "forearm_r": 1.5}
    bodies = {name: Body(mass, (0.01 * mass,) * 3) for name, mass in masses.items()}
    joints = {
        "trunk": Joint("hinge", "ground", "thorax", (0.0, 1.0, 0.0), still, hinge),
        "sternum": Joint("hinge", "thorax", collar, tuple(NOTCH - [0.025, 0.0, 0.0]), (0.07, 0.0, 0.0), hinge),
        "ac": Joint("hinge", collar, "scapula_r", (-0.07, 0.01, -0.03), (-0.03, 0.05, 0.01), hinge),
        "glenoid": Joint("hinge", "scapula_r", "humerus_r", (-0.05, 0.0, 0.04), (0.0, 0.5 * upper_arm, 0.0), hinge),
        "elbow": Joint("hinge", "humerus_r", "forearm_r", (0.0, -0.5 * upper_arm, 0.0), (0.0, 0.12, 0.0), hinge),
    }
    path = [
        [ViaPoint("scapula_r", place), ViaPoint("humerus_r", (0.01 * k, 0.0, 0.0))] for k, place in enumerate(BLADE)
    ]
    muscles = {f"m{k}": Muscle(path=points, f_max=500.0, l_opt=0.1, l_slack=0.1) for k, points in enumerate(path)}
    return Character(root="ground", bodies=bodies, joints=joints, muscles=muscles)


@pytest.mark.parametrize("upper_arm", [0.3, 0.21])
def test_the_breastbone_ends_where_the_collar_bone_begins(upper_arm: float):
    character, scale = shoulder(upper_arm), upper_arm / 0.3
    names = list(character.bodies)
    (ribs,) = (
        piece for piece in figure_of(character, (), names)
        if isinstance(piece, Hull) and piece.layer == "bone" and names[piece.body] == "thorax"
    )  # fmt: skip
    corners = np.asarray(ribs.corners)
    front = corners[corners[:, 2] > NOTCH[2] - 0.01]
    assert front[:, 1].max() == pytest.approx(NOTCH[1], abs=0.035)
    assert corners[:, 2].max() > NOTCH[2] - 0.02
    assert np.ptp(corners[:, 1]) == pytest.approx(0.45 * scale, rel=0.15)
    missing, there = corners[:, 0].max(), -corners[:, 0].min()  # the left shoulder has no bodies of its own
    assert missing > there + 0.02 * scale


def test_what_is_no_rib_cage_or_has_no_collar_bones_gets_no_ribs():
    character = shoulder()
    sides = sides_of(character)
    assert rib_cage(character, "thorax", sides) is not None
    assert rib_cage(character, "humerus_r", sides) is None
    other = shoulder(collar="strut")
    assert rib_cage(other, "thorax", sides_of(other)) is None


def test_a_shoulder_blade_spans_its_joint_and_the_ends_of_its_muscles():
    character = shoulder()
    blade = shoulder_blade(character, "scapula_r")
    assert blade is not None
    places = np.array([*BLADE, (-0.05, 0.0, 0.04)])
    corners = np.asarray(blade[0])
    np.testing.assert_allclose(corners.min(axis=0), places.min(axis=0) - 0.004, atol=1e-3)
    np.testing.assert_allclose(corners.max(axis=0), places.max(axis=0) + 0.004, atol=1e-3)
    assert shoulder_blade(character, "clavicle_r") is None


def lone_arm(mass: float = 0.0, muscled: bool = True) -> Character:
    """A right arm that hangs on a base, as in arm26, with a muscle from there."""
    still, hinge, place = (0.0, 0.0, 0.0), [(1.0, 0.0, 0.0)], (-0.17, -0.007, -0.02)
    masses = {"base": mass, "r_humerus": 1.9, "r_ulna": 1.5}
    bodies = {name: Body(one, (0.01 * one,) * 3) for name, one in masses.items()}
    joints = {
        "shoulder": Joint("hinge", "base", "r_humerus", place, (0.0, 0.18, 0.0), hinge),
        "elbow": Joint("hinge", "r_humerus", "r_ulna", (0.0, -0.11, 0.0), (0.0, 0.18, 0.0), hinge),
    }
    points = [ViaPoint("base" if muscled else "r_humerus", still), ViaPoint("r_ulna", still)]
    muscle = Muscle(path=points, f_max=500.0, l_opt=0.1, l_slack=0.1)
    return Character(root="base", bodies=bodies, joints=joints, muscles={"triceps": muscle})


def test_an_arm_alone_hangs_on_a_shoulder_where_its_muscles_begin():
    character = lone_arm()
    names, sides = list(character.bodies), sides_of(character)
    cage = rib_cage(character, "base", sides)
    assert cage is not None
    np.testing.assert_allclose(cage.shoulders[1], (-0.17, -0.007, -0.02), atol=1e-9)
    assert cage.shoulders[0][0] > cage.neck[0] > -0.17  # the other one is to the left of the neck
    corners = np.concatenate([
        piece.corners for piece in figure_of(character, (), names)
        if isinstance(piece, Hull) and piece.layer == "bone" and names[piece.body] == "base"
    ])  # fmt: skip
    assert np.linalg.norm(corners - [-0.17, -0.007, -0.02], axis=1).min() < 0.03
    assert rib_cage(lone_arm(mass=20.0), "base", sides) is None
    assert rib_cage(lone_arm(muscled=False), "base", sides) is None
    assert rib_cage(character, "r_humerus", sides) is None
