"""Devices are drawn where they act: beside their joints, at the ends of cords, and on the body that is held up."""

import numpy as np
from msgspec.structs import replace

from warpmuscle.formats import load
from warpmuscle.scene import Force
from warpmuscle.scene.drawing.devices import ASIDE, BAR, DRUM, HUB, Rod, device_rods
from warpmuscle.scene.parameters import start_values, substitute


def rods_of(**forces: Force) -> list[Rod]:
    scene = load("walk56")
    return device_rods(replace(substitute(scene, start_values(scene)), forces=forces))


def test_a_brace_has_a_hub_outwards_of_its_joint_and_a_bar_along_each_segment():
    joints = load("walk56").character.joints
    for joint, outwards in (("lAnkle", 1.0), ("rAnkle", -1.0)):
        above, below, hub = rods_of(brace=Force("bilinear_spring", joint=joint))
        place = np.array(joints[joint].position_in_parent) + np.array([outwards * ASIDE, 0.0, 0.0])
        assert (above.body, below.body) == (joints[joint].parent, joints[joint].child)
        assert (above.radius, below.radius, hub.radius) == (BAR, BAR, HUB)
        np.testing.assert_allclose(hub.start, place)
        np.testing.assert_array_equal(hub.start, hub.end)
        np.testing.assert_allclose(above.start, place)
        assert above.end[1] > above.start[1] + 0.1  # up the shank
        assert below.end[2] > below.start[2] + 0.05  # along the foot


def test_a_motor_has_a_flat_drum_about_the_axis_of_its_joint():
    *_, drum = rods_of(motor=Force("cycle_torque", joint="rKnee"))
    assert (drum.flat, drum.radius) == (True, DRUM)
    along = drum.end - drum.start
    assert along[0] < 0.0 == along[1] == along[2]  # to the right


def test_straps_and_the_ends_of_cords_are_fixed_to_their_bodies():
    ends = {"first_x": 0.1, "first_y": -0.2, "second_z": 0.3}
    strap, first, second = rods_of(
        harness=Force("weight_support", body="torso"),
        cord=Force("point_spring", body="pelvis", other_body="lUpperleg", parameters=dict(ends)),
        drag=Force("air_drag", body="torso"),
    )
    assert strap.body == "torso"
    assert strap.end[1] > 0.3
    assert (first.body, first.start.tolist()) == ("pelvis", [0.1, -0.2, 0.0])
    assert (second.body, second.start.tolist()) == ("lUpperleg", [0.0, 0.0, 0.3])


def test_a_motor_between_bodies_has_its_drum_where_the_second_one_hangs_on_the_first():
    (drum,) = rods_of(motor=Force("joint_motor", body="pelvis", other_body="lLowerleg"))
    joint = next(one for one in load("walk56").character.joints.values() if one.child == "lUpperleg")
    assert (drum.body, drum.flat, drum.radius) == ("pelvis", True, DRUM)
    np.testing.assert_allclose(0.5 * (drum.start + drum.end), joint.position_in_parent)
    assert rods_of(motor=Force("joint_motor", body="lLowerleg", other_body="pelvis")) == []
