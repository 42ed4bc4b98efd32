"""Bodies that are known by their names, as models of OpenSim have them."""

import numpy as np
import pytest

from warpmuscle.scene import Body, Character, Joint
from warpmuscle.scene.topology import topology
from warpmuscle.view.bones.limbs import Limbs
from warpmuscle.view.bones.named import named_feet, named_role
from warpmuscle.view.figure import figure_of

NAMES = {
    "femur_r": "thigh", "r_humerus": "upper arm", "r_ulna_radius_hand": "forearm", "tibia_l": "shank", "hand_r": "hand",
    "lThigh": "thigh", "talus_l": "ankle bone", "patella_r": "knee cap", "torso": "", "pelvis": "", "handle": "",
    "femur_r_hip_flexion_r": "thigh", "radius": "forearm", "shoulder": "", "calcn_r": "", "footing": "",
}  # fmt: skip

ACROSS = [(1.0, 0.0, 0.0)]


@pytest.mark.parametrize("name", NAMES)
def test_names_say_what_bodies_are(name: str):
    assert named_role(name) == NAMES[name]


def test_feet_are_known_by_their_names():
    assert named_feet(["pelvis", "calcn_r", "toes_r", "rFoot", "footing", "talus_l"]) == ["calcn_r", "rFoot"]


def leg() -> Character:
    """A pelvis on a leg whose foot has no shapes, and whose thigh carries a knee cap, too."""
    bodies = {name: Body(mass, (0.1, 0.1, 0.1)) for name, mass in
              (("pelvis", 11.0), ("femur_r", 9.0), ("patella_r", 0.1), ("tibia_r", 3.7), ("talus_r", 0.1),
               ("calcn_r", 1.2), ("toes_r", 0.2))}  # fmt: skip
    places = {
        ("pelvis", "femur_r"): ((-0.08, -0.08, 0.0), (0.0, 0.17, 0.0)),
        ("femur_r", "tibia_r"): ((0.0, -0.24, 0.0), (0.0, 0.19, 0.0)),
        ("femur_r", "patella_r"): ((0.0, -0.24, 0.04), (0.0, 0.0, 0.0)),
        ("tibia_r", "talus_r"): ((0.0, -0.21, 0.0), (0.0, 0.0, 0.0)),
        ("talus_r", "calcn_r"): ((0.0, -0.042, -0.049), (0.0, -0.03, -0.1)),
        ("calcn_r", "toes_r"): ((0.0, -0.032, 0.079), (0.0, 0.0, -0.03)),
    }
    joints = {
        f"j{k}": Joint("hinge", parent, child, above, below, ACROSS)
        for k, ((parent, child), (above, below)) in enumerate(places.items())
    }
    return Character(bodies=bodies, joints=joints, root="pelvis")


def test_a_foot_without_shapes_has_bones_from_heel_to_toes():
    character = leg()
    names = topology(character).bodies
    bones = {names[p.body]: p.corners for p in figure_of(character, (), names) if p.layer == "bone"}
    limbs = Limbs(character, ())
    assert (limbs.role("femur_r"), limbs.role("tibia_r"), limbs.feet) == ("thigh", "shank", ("calcn_r",))
    assert "talus_r" not in bones  # the bones of the foot have one
    heel, ball = bones["calcn_r"][:, 2].min(), 0.079
    assert heel < -0.09 < ball < bones["calcn_r"][:, 2].max()
    assert np.ptp(bones["toes_r"][:, 2]) > 0.05
    assert np.ptp(bones["patella_r"], axis=0).max() < 0.06
    assert bones["femur_r"][:, 2].max() < 0.035  # no second knee cap


@pytest.mark.parametrize(("ground", "role"), [(0.0, ""), (0.3, "forearm")])
def test_a_forearm_that_stands_beside_the_feet_has_no_hand(ground: float, role: str):
    """The foot ends 0.6 m below the trunk, the forearm 0.6 or 0.3 m."""
    size = 0.3 - 0.5 * ground
    bodies = {name: Body(1.0, (0.1, 0.1, 0.1)) for name in ("trunk", "lFoot", "lUpperarm", "lForearm")}
    joints = {
        "ankle": Joint("hinge", "trunk", "lFoot", (0.1, 0.0, -0.3), (0.0, 0.3, 0.0), ACROSS),
        "shoulder": Joint("hinge", "trunk", "lUpperarm", (0.1, 0.0, 0.3), (0.0, 0.5 * size, 0.0), ACROSS),
        "elbow": Joint("hinge", "lUpperarm", "lForearm", (0.0, -0.5 * size, 0.0), (0.0, 0.5 * size, 0.0), ACROSS),
    }
    limbs = Limbs(Character(root="trunk", bodies=bodies, joints=joints), ("lFoot",))
    assert limbs.role("lUpperarm") == "upper arm"
    assert limbs.role("lForearm") == role
