"""What is wrong with massless bodies and with joints that follow others is said in a sentence."""

import re

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Actuation, Body, Character, Displacement, Joint, Scene
from warpmuscle.scene.validation.scene import check_scene

X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
NOTHING = Body(0.0, ORIGIN)


def hinge(parent: str, child: str, axis=X) -> Joint:
    return Joint("hinge", parent, child, ORIGIN, ORIGIN, [axis])


def follower(parent: str, child: str, follows: str) -> Joint:
    return Joint("coupled", parent, child, ORIGIN, ORIGIN, rotations=[Displacement(X, slope=0.5)], follows=follows)


def leg() -> Scene:
    """A thigh on three hinges, a shank, and a patella that follows the knee."""
    heavy = Body(1.0, (0.1, 0.1, 0.1))
    bodies = {"ground": NOTHING, "a": NOTHING, "b": NOTHING, "thigh": heavy, "shank": heavy, "patella": heavy}
    joints = {
        "flex": hinge("ground", "a"),
        "tilt": hinge("a", "b", Z),
        "turn": hinge("b", "thigh", Y),
        "knee": hinge("thigh", "shank"),
        "kneecap": follower("thigh", "patella", "knee"),
    }
    return Scene("leg", Character("ground", bodies, joints, "fixed"))


def test_a_leg_of_three_hinges_with_a_patella_is_sound():
    check_scene(leg())


def change_joint(name: str, **fields):
    return lambda c: [setattr(c.joints[name], field, value) for field, value in fields.items()]


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        (lambda c: c.bodies.update(a=Body(0.0, (0.0, 1.0, 0.0))), "bodies.a.mass", "or 0 along with all"),
        (lambda c: setattr(c, "root_joint", "free"), "bodies.ground.mass", "a root that moves has mass"),
        (change_joint("turn", axes=[Z]), "bodies.a.mass", "the joints 'flex', 'tilt', 'turn', with nothing"),
        (lambda c: c.bodies.update(shank=NOTHING, patella=NOTHING), "bodies.shank.mass", "moves nothing that has mass"),
        (change_joint("kneecap", follows="nee"), "joints.kneecap.follows", "did you mean 'knee'"),
        (change_joint("kneecap", follows="kneecap"), "joints.kneecap.follows", "'kneecap' follows 'kneecap' itself"),
        (change_joint("knee", follows="turn"), "joints.knee.follows", "a hinge joint cannot"),
        (change_joint("kneecap", limits=[(0.0, 1.0)]), "joints.kneecap.limits", "limit the joint 'knee'"),
        (change_joint("knee", type="universal", axes=[X, Y]), "joints.kneecap.follows", "no single coordinate"),
        (lambda c: setattr(c.bodies["thigh"], "inertia_axes", (0.0,) * 4), "bodies.thigh.inertia_axes", "no length"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(change, key: str, words: str):
    scene = leg()
    change(scene.character)
    with pytest.raises(SceneError, match=re.escape(words)) as caught:
        check_scene(scene)
    assert caught.value.key == f"character.{key}"


def test_a_joint_may_follow_one_far_from_it():
    scene = leg()
    scene.character.joints["kneecap"].follows = "tilt"
    check_scene(scene)


def test_a_joint_whose_motion_is_prescribed_may_move_nothing_heavy():
    scene = leg()
    scene.character.bodies.update(shank=NOTHING, patella=NOTHING)
    scene.actuation["knee"] = Actuation("kinematic")
    check_scene(scene)


def test_a_follower_may_move_all_the_mass_and_lie_on_what_its_joint_moves():
    scene = leg()
    scene.character.bodies["shank"] = NOTHING
    check_scene(scene)
    scene.character.joints["kneecap"].parent = "shank"
    check_scene(scene)
