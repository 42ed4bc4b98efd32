"""What is wrong with objects is said with its key."""

import pytest

from small_scene import sound_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import toml
from warpmuscle.scene import BallObject, BoxObject, CapsuleObject, Held, Hinge
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.objects import object_warnings
from warpmuscle.scene.validation.scene import check_scene


def checked(**objects) -> None:
    scene = sound_scene()
    scene.objects = objects
    check_scene(scene)


def test_objects_of_all_kinds_are_sound_and_written_as_they_are_read():
    scene = sound_scene()
    scene.objects = {
        "ball": BallObject(radius=Free(0.1, 0.05, 0.2), velocity=(1.0, 0.0, Free(0.0, -1.0, 1.0))),
        "seat": BoxObject(size=(0.4, 0.4, 0.4), fixed=True, bodies=["pelvis"]),
        "plank": BoxObject(hinge=Hinge((1.0, 0.0, 1.0), damping=Free(1.0, 0.0, 2.0)), touches=["ball", "seat"]),
        "bell": CapsuleObject(mass=4.0, held=Held("rFoot", (0.0, 0.1, 0.0), until=Free(1.0, 0.0, 2.0))),
    }
    check_scene(scene)
    assert toml.loads(toml.dumps(scene)).objects == scene.objects


@pytest.mark.parametrize(
    ("solid", "key", "says"),
    [
        (BallObject(radius=0.0), "radius", "greater than 0"),
        (BallObject(mass=Free(1.0, -1.0, 2.0)), "mass", "greater than 0"),
        (BoxObject(size=(0.1, 0.0, 0.1)), "size.1", "greater than 0"),
        (CapsuleObject(length=-1.0), "length", "greater than 0"),
        (BallObject(restitution=1.1), "restitution", "within 0 and 1"),
        (BallObject(friction=-0.1), "friction", "not be negative"),
        (BallObject(stiffness=-1.0), "stiffness", "not be negative"),
        (BallObject(orientation=(0.0, 0.0, 0.0, 0.0)), "orientation", "no length"),
        (BallObject(position=(float("nan"), 0.0, 0.0)), "position.0", "finite"),
        (BallObject(bodies=["pelvs"]), "bodies.0", "did you mean 'pelvis'"),
        (BallObject(bodies=["rFoot"]), "bodies.0", "no shape"),
        (BallObject(bodies=["pelvis", "pelvis"]), "bodies.1", "twice"),
        (BallObject(fixed=True, velocity=(1.0, 0.0, 0.0)), "fixed", "does not move"),
        (BallObject(held=Held("hand")), "held.body", "no body"),
        (BallObject(held=Held("pelvis"), fixed=True), "held", "both fixed and held"),
        (BallObject(held=Held("pelvis"), position=(1.0, 0.0, 0.0)), "position", "leave this out"),
        (BallObject(held=Held("pelvis", until=-1.0)), "held.until", "not be negative"),
        (BallObject(touches=["box"]), "touches.0", "no object"),
        (BallObject(touches=["one"]), "touches.0", "itself"),
        (BallObject(touches=["wall", "wall"]), "touches.1", "twice"),
        (BallObject(touches=["wall"], fixed=True), "touches.0", "neither"),
        (BoxObject(hinge=Hinge(), fixed=True), "hinge", "fixed"),
        (BoxObject(hinge=Hinge(), held=Held("pelvis")), "hinge", "held"),
        (BoxObject(hinge=Hinge(), velocity=(0.0, 1.0, 0.0)), "velocity", "can only turn"),
        (BoxObject(hinge=Hinge(axis=(0.0, 0.0, 0.0))), "hinge.axis", "no length"),
        (BoxObject(hinge=Hinge(damping=-1.0)), "hinge.damping", "not be negative"),
        (BoxObject(hinge=Hinge(position=(float("inf"), 0.0, 0.0))), "hinge.position.0", "finite"),
        (BallObject(held=Held("pelvis", orientation=(0.0, 0.0, 0.0, 0.0))), "held.orientation", "no length"),
    ],
)
def test_what_is_wrong_is_said_with_its_key(solid, key: str, says: str):
    with pytest.raises(SceneError, match=says) as error:
        checked(one=solid, wall=BoxObject(fixed=True))
    assert error.value.key == f"objects.one.{key}"


@pytest.mark.parametrize("name", ["a.b", "\0", "\ud800"])
def test_a_name_that_no_recording_could_have_is_refused(name: str):
    with pytest.raises(SceneError, match="no name of an object") as error:
        checked(**{name: BallObject()})
    assert error.value.key == "objects"


def test_objects_that_touch_nothing_where_one_expects_it_are_doubted():
    scene = sound_scene()
    table = BoxObject(size=(1.0, 0.7, 0.6), position=(0.0, 0.35, 2.0), fixed=True)
    cup = BallObject(radius=0.05, position=(0.3, 0.8, 2.1))
    scene.objects = {"table": table, "cup": cup, "far": BallObject(position=(3.0, 1.0, 0.0))}
    shaped = any(body.shapes for body in scene.character.bodies.values())
    (doubt,) = [one for one in object_warnings(scene) if one.key.endswith("touches")]
    assert doubt.key == "objects.table.touches"
    assert "'table' and 'cup' lie one above the other" in doubt.message
    table.touches = ["cup"]
    assert shaped
    assert object_warnings(scene) == []
    for body in scene.character.bodies.values():
        body.shapes = []
    (doubt,) = object_warnings(scene)
    assert "no body has shapes" in doubt.message
