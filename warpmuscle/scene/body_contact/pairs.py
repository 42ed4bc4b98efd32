"""Pairs of bodies that may touch each other."""

from __future__ import annotations

from itertools import product

from warpmuscle.scene import Character, Scene
from warpmuscle.scene.anatomy import leg, sides_of
from warpmuscle.scene.body_contact.part import Pair


def touching_pairs(scene: Scene) -> list[Pair]:
    """The pairs of bodies that push each other in a scene; none if its `body_contact` does not say so."""
    contact = scene.body_contact
    if contact is None:
        return []
    if contact.pairs or scene.feet is None:
        return list(contact.pairs)
    return biped_pairs(scene.character, scene.feet)


def chain(character: Character, body: str) -> list[str]:
    """The bodies from the root to a body."""
    return [*(character.joints[name].parent for name in leg(character, body)), body]


def biped_pairs(character: Character, feet: tuple[str, str]) -> list[Pair]:
    """The pairs of bodies that push each other in a biped, see `BodyContact`; only of bodies with shapes."""
    trunk, left, right = _parted(*(chain(character, foot) for foot in feet))
    sides = sides_of(character)
    carried = {joint.parent for joint in character.joints.values()}
    trunk += [name for name in character.bodies if sides[name] == "middle" and name in carried and name not in trunk]
    pairs = _of_legs(left, right)
    for side, limb in (("left", left), ("right", right)):
        beside = [name for name in character.bodies if sides[name] == side and name not in limb]
        arm = [name for name in beside if not set(feet).intersection(chain(character, name))]
        pairs += product(trunk, arm)
        pairs += [(limb[0], name) for name in arm if name not in carried] if limb else []
    joined = {frozenset((joint.parent, joint.child)) for joint in character.joints.values()}
    shaped = {name for name, body in character.bodies.items() if body.shapes}
    return [pair for pair in pairs if frozenset(pair) not in joined and shaped.issuperset(pair)]


def _parted(left: list[str], right: list[str]) -> tuple[list[str], list[str], list[str]]:
    """What two chains of bodies have in common, and what each has for itself."""
    trunk = [name for name in left if name in right]
    return trunk, [name for name in left if name not in trunk], [name for name in right if name not in trunk]


def _of_legs(left: list[str], right: list[str]) -> list[Pair]:
    """The pairs of both legs: bodies as far from the hip, and the last with the last but one."""
    pairs = list(zip(left, right, strict=False))
    if len(left) == len(right) and len(left) > 1:
        pairs += [(left[-1], right[-2]), (left[-2], right[-1])]
    return pairs
