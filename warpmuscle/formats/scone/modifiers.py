"""Other numbers of a model that a SCONE scenario gives: of single muscles, of some that it names, of the whole mass."""

from __future__ import annotations

from warpmuscle.formats.scone.start import matches
from warpmuscle.formats.scone.zml import Node
from warpmuscle.scene import Muscle, Scene
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.masses import body_mass

PROPERTIES = {
    "max_isometric_force": "f_max", "optimal_fiber_length": "l_opt", "tendon_slack_length": "l_slack",
    "pennation_angle": "pennation",
}  # fmt: skip
HINT = f"muscles have {', '.join(PROPERTIES)}, each also with .factor"


def put_modifiers(node: Node, scene: Scene) -> None:
    """Change the numbers of a scene as the node of a model says.

    Raises:
        SceneError: something of it is not known, with file and line.
    """
    muscles = scene.character.muscles
    factor = node.number_of("muscle_force_multiplier", 1.0)
    for muscle in muscles.values():
        muscle.f_max = plain_number(muscle.f_max) * factor
    properties = node.find("Properties")
    for one in properties.children if properties is not None else ():
        one.used = True
        if one.key not in muscles:
            one.fail("there is no muscle of this name")
        _change(one, muscles[one.key])
        one.tell_unused(HINT)
    for one in node.every("MuscleModifier"):
        include, exclude = one.string_of("include", "*"), one.string_of("exclude")
        chosen = [name for name in muscles if matches(name, include) and not matches(name, exclude)]
        if not chosen:
            one.fail(f"no muscle is included: {include!r} without {exclude!r}")
        for name in chosen:
            _change(one, muscles[name])
        one.find("name")
        one.tell_unused(HINT)
    for one in node.every("ModelModifier"):
        _put_mass(one, scene)
        one.find("name")
        one.tell_unused("of models the mass can be given")


def _change(node: Node, muscle: Muscle) -> None:
    """Give a muscle numbers, as they are or as factors of its own."""
    for change in node.children:
        word, _, factor = change.key.partition(".")
        if word not in PROPERTIES or factor not in ("", "factor"):
            continue
        change.used = True
        given, times = (change, bool(factor)) if change.value is not None else (change.need("factor"), True)
        own = plain_number(getattr(muscle, PROPERTIES[word]))
        setattr(muscle, PROPERTIES[word], given.number() * (own if times else 1.0))
        change.tell_unused(HINT)


def _put_mass(node: Node, scene: Scene) -> None:
    """Let the body weigh so much in all, each part and its inertia by the same factor."""
    mass = node.need("mass").number()
    total = body_mass(scene.character)
    if not (mass > 0.0 and total > 0.0):
        node.fail(f"its mass must be greater than 0, is {mass:g}")
    for body in scene.character.bodies.values():
        body.mass = plain_number(body.mass) * mass / total
        x, y, z = (plain_number(value) * mass / total for value in body.inertia)
        body.inertia = (x, y, z)
