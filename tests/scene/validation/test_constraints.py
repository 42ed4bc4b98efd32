"""Doubts about constraints that are met at the start."""

import pytest

from warpmuscle.scene import Body, Character, Constraint, Joint, Scene
from warpmuscle.scene.validation.constraints import loop_warnings
from warpmuscle.scene.validation.start import doubts_of


def knee(plate: float, shank: float, kind: str = "hinge") -> Scene:
    """A shank that hangs on a thigh by two plates, with a foot of 1 kg behind it, and a ring in the thigh's hand."""

    def body(mass: float) -> Body:
        return Body(mass, (0.01 * mass,) * 3)

    bodies = {
        "thigh": body(8.0), "medial": body(plate), "lateral": body(plate), "shank": body(shank), "foot": body(1.0),
        "ring": body(1e-9),
    }  # fmt: skip
    origin = (0.0, 0.0, 0.0)
    joints = {
        "inner": Joint(kind, "thigh", "medial", (0.03, -0.3, 0.0), origin),
        "outer": Joint("hinge", "thigh", "lateral", (-0.03, -0.3, 0.0), origin),
        "tibia": Joint("ball", "medial", "shank", origin, (0.03, 0.3, 0.0)),
        "ankle": Joint("hinge", "shank", "foot", (0.0, -0.4, 0.0), origin),
        "hand": Joint("hinge", "thigh", "ring", (0.0, 0.4, 0.0), origin),
    }
    character = Character("thigh", bodies, joints)
    character.constraints = {"weld": Constraint("weld", "lateral", "shank", other_position=(-0.03, 0.3, 0.0))}
    return Scene("knee", character)


@pytest.mark.parametrize(("plate", "shank", "told"), [(1e-3, 40.0, False), (1e-4, 40.0, True), (5e-4, 49.5, True)])
def test_a_loop_of_very_unequal_masses_is_told(plate: float, shank: float, told: bool):
    found = [doubt for doubt in doubts_of(knee(plate, shank)) if "loop will open" in doubt.message]
    assert len(found) == told
    if told:
        assert found[0].key == "character.constraints.weld"
        assert "'medial'" in found[0].message
        assert f"{shank + plate + 1.0:.3g} kg" in found[0].message


def test_bodies_that_are_fixed_to_others_count_with_them():
    """The inner plate belongs to the thigh; the outer one does not."""
    scene = knee(1e-4, 40.0, "fixed")
    assert "'lateral'" in loop_warnings(scene)[0].message
    scene.character.bodies["lateral"] = scene.character.bodies["foot"]
    assert loop_warnings(scene) == []
    scene.character.constraints = {}
    assert loop_warnings(scene) == []
