"""Numbers of bodies, joints, contact points and the ground as the device has them, against typed ones."""

import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.kernels import structs
from warpmuscle.model import bodies as model
from warpmuscle.model.joints import by_coordinate, compiled_skeleton, has_turned_axes, joint_number, root_number
from warpmuscle.scene import Body, Box, Character, ContactMaterial, Ground, Joint, Scene, Sphere
from warpmuscle.scene.number import Free
from warpmuscle.scene.topology import topology

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def scene_of(**changes: object) -> Scene:
    """A trunk on two feet of which one has toes; what is typed below is typed here."""
    character = Character(
        root="trunk",
        feet=("lFoot", "rFoot"),
        bodies={
            "trunk": Body(30.0, (1.0, 2.0, 3.0), [Sphere((0.1, 0.2, 0.3), 0.15)], friction=0.9),
            "lFoot": Body(2.0, (0.1, 0.2, 0.3), [Box((-0.05, -0.02, -0.1), (0.05, 0.02, 0.1))], friction=0.4),
            "rFoot": Body(2.5, (0.4, 0.5, 0.6), [Sphere((0.0, -0.1, 0.05), 0.03)]),
            "rToes": Body(0.5, (0.01, 0.02, 0.03)),
        },
        joints={
            "lHip": Joint(
                "universal", "trunk", "lFoot", (0.1, -0.3, 0.02), (0.01, 0.4, -0.03), [X, Z],
                [(-0.5, 1.1), (-0.2, 0.3)], limit_stiffness=70.0, limit_damping=3.0,
            ),
            "rHip": Joint("ball", "trunk", "rFoot", (-0.1, -0.3, 0.02), (0.0, 0.5, 0.0), [X, Y], [(-4.0, 4.0)] * 3),
            "rToe": Joint("hinge", "rFoot", "rToes", (0.0, -0.1, 0.12), (0.0, 0.0, -0.04), [X]),
        },
    )  # fmt: skip
    scene = Scene("typed", character, ground=Ground(friction=0.7, height=0.05))
    for name, value in changes.items():
        setattr(scene, name, value)
    return scene


def structures(scene: Scene) -> tuple[structs.Skeleton, structs.Contacts]:
    names = topology(scene.character)
    assert names.bodies == ("trunk", "lFoot", "rFoot", "rToes")
    contacts, points = model.contacts_struct(scene, names, "cpu")
    return model.skeleton_struct(scene, names, points, "cpu"), contacts


def test_the_tree_says_where_everything_of_a_body_is():
    skeleton, _ = structures(scene_of())
    plan = skeleton.plan.numpy()
    expected = {
        "parent": [plan["parent"][0], 0, 0, 2], "joint_type": [0, 2, 1, 3], "coordinate_start": [0, 7, 9, 13],
        "speed_start": [0, 6, 8, 11], "speed_end": [6, 8, 11, 12], "child_count": [2, 0, 1, 0],
        "has_limits": [0, 1, 1, 0], "foot_slot": [-1, 0, 1, 2], "first_point": [0, 1, 9, 10],
        "end_point": [1, 9, 10, 10],
    }  # fmt: skip
    for field, numbers in expected.items():
        np.testing.assert_array_equal(plan[field], numbers, err_msg=field)
    assert plan["first_child"][0] == 1
    assert plan["first_child"][2] == 3
    np.testing.assert_array_equal(skeleton.foot_side.numpy(), [structs.LEFT, structs.RIGHT, structs.RIGHT])
    np.testing.assert_allclose(skeleton.total_mass.numpy(), [[35.0]])


def test_frames_of_bodies_begin_at_their_joints():
    row = structures(scene_of())[0].row.numpy()[0]
    np.testing.assert_allclose(row["mass"], [30.0, 2.0, 2.5, 0.5])
    np.testing.assert_allclose(row["inertia"], [(1, 2, 3), (0.1, 0.2, 0.3), (0.4, 0.5, 0.6), (0.01, 0.02, 0.03)])
    np.testing.assert_allclose(row["com"], [(0, 0, 0), (-0.01, -0.4, 0.03), (0, -0.5, 0), (0, 0, 0.04)], atol=1e-7)
    anchors = [(0, 0, 0), (0.1, -0.3, 0.02), (-0.1, -0.3, 0.02), (0, -0.6, 0.12)]
    np.testing.assert_allclose(row["anchor"], anchors, atol=1e-7)
    np.testing.assert_allclose(row["axis_a"][1:], [X, X, X], atol=1e-7)
    np.testing.assert_allclose(row["axis_b"][1], Z, atol=1e-7)


def test_limits_have_their_middles_and_halves():
    limits = structures(scene_of())[0].limits.numpy()[0]
    np.testing.assert_allclose(limits["low"][1, :2], [-0.5, -0.2])
    np.testing.assert_allclose(limits["high"][1, :2], [1.1, 0.3])
    np.testing.assert_allclose(limits["cosine"][1, :2], np.cos([0.3, 0.05]), rtol=1e-6)
    np.testing.assert_allclose(limits["sine"][1, :2], np.sin([0.3, 0.05]), rtol=1e-6)
    np.testing.assert_allclose(limits["half_cosine"][1], [*np.cos([0.8, 0.25]), -2.0], rtol=1e-6)
    np.testing.assert_array_equal(limits["half_cosine"][2], -2.0)  # a full turn and more
    assert limits["low"][3, 0] < -1e8
    assert limits["high"][3, 2] > 1e8
    assert (limits["stiffness"][1], limits["damping"][1]) == (70.0, 3.0)


def test_contact_points_are_where_shapes_are_and_the_ground_bounds_their_friction():
    contacts = structures(scene_of())[1]
    point = contacts.point.numpy()[0]
    assert len(point) == 10
    np.testing.assert_allclose(point["place"][0], (0.1, 0.2, 0.3), rtol=1e-6)
    corners = {(x, y, z) for x in (-0.06, 0.04) for y in (-0.42, -0.38) for z in (-0.07, 0.13)}
    assert {tuple(np.round(place, 6).tolist()) for place in point["place"][1:9].astype(float)} == corners
    np.testing.assert_allclose(point["place"][9], (0.0, -0.6, 0.05), rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(point["radius"], [0.15, *[0.0] * 8, 0.03], rtol=1e-6)
    usual = Body(1.0, (1.0, 1.0, 1.0)).friction
    np.testing.assert_allclose(point["friction"], [0.7, *[0.4] * 8, min(usual, 0.7)], rtol=1e-6)
    farthest = [
        np.sqrt(0.14) + 0.15, np.linalg.norm((0.06, 0.42, 0.13)), np.linalg.norm((0.6, 0.05)) + 0.03, 0.0,
    ]  # fmt: skip
    np.testing.assert_allclose(contacts.reach.numpy()[0], farthest, rtol=1e-6)
    np.testing.assert_allclose(contacts.height.numpy(), [[0.05]])
    soft = scene_of()
    soft.ground.law = "smooth_hunt_crossley"
    margin = model.material_columns(soft.ground.material, 0.15, soft.ground.law)["margin"]
    assert margin > 1e-3
    np.testing.assert_allclose(
        structures(soft)[1].reach.numpy()[0], farthest + np.array([1, 0, 1, 0]) * margin, rtol=1e-6
    )
    off = scene_of()
    off.ground.stiffness = 0.0
    np.testing.assert_array_equal(structures(off)[0].plan.numpy()["end_point"], 0)


def test_equal_sides_of_a_contact_give_half_in_the_power_of_hertz():
    """Hunt and Crossley 1975; Sherman 2011: k = 1/2 E^(2/3), f = 4/3 k sqrt(R k) d^(3/2)."""
    material = ContactMaterial(stiffness=8.0e6)
    columns = model.material_columns(material, 0.04, "hunt_crossley")
    half = 0.5 * 8.0e6 ** (2.0 / 3.0)
    assert half == pytest.approx(20000.0)
    np.testing.assert_allclose(columns["hertz"], 4.0 / 3.0 * 20000.0 * np.sqrt(0.04 * 20000.0), rtol=1e-9)
    assert columns["margin"] == 0.0
    smooth = model.material_columns(material, 0.04, "smooth_hunt_crossley")
    np.testing.assert_allclose(smooth["margin"] * material.hertz_smoothing, model.MARGIN, rtol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.1, -0.3])
def test_a_slope_lifts_the_ground_ahead(angle: float):
    normal = model.ground_normal(Ground(), np.array([angle, 0.2]))[0, 0]
    np.testing.assert_allclose(normal, [0.0, np.cos(angle), -np.sin(angle)], atol=1e-9)
    tilted = model.ground_normal(Ground(normal=(0.6, 0.8, 0.0)), np.array([angle, 0.2]))[0, 0]
    np.testing.assert_allclose(tilted, [0.6, 0.8 * np.cos(angle), -0.8 * np.sin(angle)], atol=1e-7)
    np.testing.assert_allclose(model.ground_normal(Ground(normal=(0.0, 3.0, 4.0)))[0, 0], [0.0, 0.6, 0.8])


def test_feet_have_room_for_few_bodies():
    scene = scene_of()
    for k in range(8):
        scene.character.bodies[f"toe{k}"] = Body(0.1, (0.01, 0.01, 0.01))
        scene.character.joints[f"joint{k}"] = Joint("hinge", "lFoot", f"toe{k}", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), [X])
    with pytest.raises(SceneError, match=r"the feet have 9 bodies hanging on them, more than there is room for"):
        model.foot_slots(scene, topology(scene.character))


def test_types_of_joints_have_the_numbers_of_the_device():
    character = scene_of().character
    assert root_number(character) == structs.ROOT_FREE
    character.root_joint = "planar"
    assert root_number(character) == structs.ROOT_PLANAR
    numbers = {name: joint_number(name, character) for name in character.joints}
    assert numbers == {"lHip": structs.UNIVERSAL, "rHip": structs.BALL, "rToe": structs.HINGE}
    assert not any(by_coordinate(name, character) for name in character.joints)
    kind = compiled_skeleton(character)
    assert (kind.joints, kind.turned) == ((), False)
    body = character.bodies["rFoot"]
    assert not has_turned_axes(body)
    for axes in ((0.0, 0.3, 0.0), (0.0, 0.0, Free(0.0, -1.0, 1.0))):
        body.inertia_axes = axes
        assert has_turned_axes(body)
        assert compiled_skeleton(character).turned
