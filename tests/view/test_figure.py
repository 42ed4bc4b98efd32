"""Figures: limbs as thick as their mass, trunks of their volume, feet in one piece over their soles."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from warpmuscle.formats import load
from warpmuscle.scene import Body, Box, Character, Joint
from warpmuscle.scene.anatomy import joint_place
from warpmuscle.scene.initial_pose import plain_number, plain_vector
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.topology import topology
from warpmuscle.view.figure import figure_of
from warpmuscle.view.hulls import Seeds, rounded_hull, sized_hull
from warpmuscle.view.pieces import Hull, Limb, Piece


def figure(name: str) -> tuple[Character, dict[str, list[Piece]]]:
    """A numeric character and the flesh of its bodies."""
    scene = load(name)
    scene = substitute(scene, start_values(scene))
    names = topology(scene.character).bodies
    pieces = figure_of(scene.character, scene.feet or (), names)
    return scene.character, {
        body: [p for p in pieces if p.layer == "flesh" and names[p.body] == body] for body in names
    }


@pytest.mark.parametrize("scene", ["walk56", "gait2392_walk", "bigbird_walk", "throw", "elbow_simplified"])
def test_every_body_with_mass_has_flesh_and_all_numbers_are_finite(scene: str):
    character, flesh = figure(scene)
    for name, body in character.bodies.items():
        assert flesh[name] or plain_number(body.mass) == 0.0, name
    for piece in (p for pieces in flesh.values() for p in pieces):
        assert all(np.all(np.isfinite(part)) for part in piece if isinstance(part, np.ndarray))


def test_limbs_weigh_what_their_bodies_do_and_run_from_joint_to_joint():
    character, flesh = figure("walk56")
    for name in ("lUpperleg", "rLowerleg", "lUpperarm"):
        pieces = flesh[name]
        assert all(isinstance(piece, Limb) for piece in pieces)
        volume = 0.0
        for piece in pieces:  # frusta between the spheres, which stand in for one another at the ends
            a, b = piece.radii
            volume += np.pi / 3.0 * np.linalg.norm(piece.end - piece.start) * (a * a + a * b + b * b)
        assert 1000.0 * volume == pytest.approx(plain_number(character.bodies[name].mass), rel=0.12)
    knee = next(joint for joint in character.joints.values() if joint.child == "lLowerleg")
    np.testing.assert_allclose(flesh["lUpperleg"][-1].end, joint_place(knee))
    np.testing.assert_allclose(flesh["lLowerleg"][0].start, plain_vector(knee.position_in_child))
    assert flesh["lLowerleg"][-1].radii[1] < 0.7 * flesh["lLowerleg"][0].radii[1]  # tapers to the ankle


@pytest.mark.parametrize("name", ["pelvis", "torso"])
def test_trunks_have_the_volume_of_their_mass(name: str):
    character, flesh = figure("walk56")
    (hull,) = flesh[name]
    assert 1000.0 * ConvexHull(hull.corners).volume == pytest.approx(
        plain_number(character.bodies[name].mass), rel=0.01
    )


@pytest.mark.parametrize(
    ("scene", "foot", "toes"), [("walk56", "lFoot", "lToes"), ("gait2392_walk", "calcn_r", "toes_r")]
)
def test_a_foot_is_one_piece_up_to_the_ankle_and_no_lower_than_its_sole(scene: str, foot: str, toes: str):
    character, flesh = figure(scene)
    (hull,), (front,) = flesh[foot], flesh[toes]
    box = next(shape for shape in character.bodies[foot].shapes if isinstance(shape, Box))
    low, high = plain_vector(box.low), plain_vector(box.high)
    assert hull.corners[:, 1].min() == pytest.approx(low[1], abs=1e-6)
    assert hull.corners[:, 2].max() == pytest.approx(high[2], abs=1e-3)
    ankle = next(joint for joint in character.joints.values() if joint.child == foot)
    assert holds(hull, plain_vector(ankle.position_in_child))
    ball = next(joint for joint in character.joints.values() if joint.child == toes)
    shift = joint_place(ball) - plain_vector(ball.position_in_child)
    overlap = [corner for corner in front.corners if holds(hull, corner + shift)]
    assert len(overlap) > 3  # so that no gap shows where the toes bend


def holds(hull: Hull, point: np.ndarray) -> bool:
    equations = ConvexHull(hull.corners).equations
    return bool(np.all(equations[:, :3] @ point + equations[:, 3] < 1e-6))


def test_hulls_look_outwards_and_degenerate_ones_are_none():
    seeds = Seeds(np.array([[0.0, 0.0, 0.0], [0.3, 0.1, 0.0], [0.0, 0.2, 0.4]]), np.array([0.1, 0.05, 0.08]))
    corners, normals, faces = rounded_hull(seeds)
    a, b, c = (corners[faces[:, k]] for k in range(3))
    signed = np.sum(a * np.cross(b, c)) / 6.0
    assert signed == pytest.approx(ConvexHull(corners).volume)
    assert np.all(np.sum(np.cross(b - a, c - a) * (normals[faces].sum(axis=1)), axis=1) > 0.0)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert rounded_hull(Seeds(np.zeros((2, 3)), np.zeros(2))) is None
    assert sized_hull(np.zeros((3, 3)), 1.0) is None


def test_a_trunk_without_a_head_of_its_own_is_drawn_with_one():
    _, flesh = figure("gait2392_walk")
    kinds = [type(piece).__name__ for piece in flesh["torso"]]
    assert sorted(kinds) == ["Hull", "Limb", "Limb"]  # trunk, skull and neck


def test_a_head_that_is_a_capsule_has_a_skull_within_its_height():
    scene = load("throw_body")
    names = topology(scene.character).bodies
    look = figure_of(scene.character, (), names)
    (hollow,) = (piece for piece in look if piece.layer == "hollow")
    assert hollow.body == names.index("head")
    skull = next(
        piece for piece in look if isinstance(piece, Hull) and piece.layer == "bone" and piece.body == hollow.body
    )
    assert skull.corners[:, 1].max() == pytest.approx(0.0983 + 0.09, abs=0.01)  # of the capsule, m
    assert skull.corners[:, 1].max() - skull.corners[:, 1].min() > 0.15


def test_a_root_that_is_a_whole_trunk_over_two_legs_has_pelvis_ribs_and_skull():
    character, flesh = figure("walker16")
    look = figure_of(character, ("lFoot", "rFoot"), topology(character).bodies)
    assert [piece.body for piece in look if piece.layer == "hollow"] == [0]  # of eyes
    bones = [piece.corners for piece in look if piece.layer == "bone" and piece.body == 0]
    assert len(bones) == 3
    top = max(float(corners[:, 1].max()) for corners in bones)
    assert top == pytest.approx(0.27 + 0.13, abs=0.02)  # m, of the capsule
    assert min(float(corners[:, 1].min()) for corners in bones) < -0.33  # below the hips
    kinds = [type(piece).__name__ for piece in flesh["trunk"]]
    assert sorted(kinds) == ["Hull", "Hull", "Limb", "Limb"]  # pelvis and trunk, skull and neck


def test_the_head_of_a_bird_is_no_skull_of_a_person():
    scene = load("bigbird_walk")
    look = figure_of(scene.character, scene.feet or (), topology(scene.character).bodies)
    assert not [piece for piece in look if piece.layer == "hollow"]


def test_the_forearm_of_a_lone_arm_is_no_trunk_with_a_head():
    humerus = Body(1.9, (0.01, 0.003, 0.01))
    forearm = Body(1.5, (0.01, 0.002, 0.01))
    joints = {
        "shoulder": Joint("hinge", "ground", "humerus", (-0.17, 0.8, 0.0), (0.0, 0.18, 0.0), [(1.0, 0.0, 0.0)]),
        "elbow": Joint("hinge", "humerus", "forearm", (0.0, -0.11, 0.0), (0.0, 0.18, 0.0), [(1.0, 0.0, 0.0)]),
    }
    bodies = {"ground": Body(0.0, (0.0, 0.0, 0.0)), "humerus": humerus, "forearm": forearm}
    arm = Character(root="ground", bodies=bodies, joints=joints)
    bones = [piece for piece in figure_of(arm, (), list(bodies)) if piece.layer in ("bone", "hollow")]
    assert bones
    assert not any(piece.layer == "hollow" for piece in bones)  # of eyes
