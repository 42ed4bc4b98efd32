"""Which bodies of a character are parts of legs and arms, by how they hang on one another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Character
from warpmuscle.scene.anatomy import foot_bodies, joint_place, leg
from warpmuscle.scene.initial_pose import plain_vector
from warpmuscle.view.bones.named import Role, named_feet, named_role

LEAST = 0.05  # m, between the joints of what is a part of a limb
BESIDE = 0.03  # m, from the middle on, where arms hang
LEG: tuple[Role, ...] = ("thigh", "shank")
ARM: tuple[Role, ...] = ("upper arm", "forearm", "hand")
LEVEL = 0.05  # m, by which a foreleg may end above or below the feet


class Limbs:
    """Roles of bodies."""

    def __init__(self, character: Character, feet: Sequence[str]) -> None:
        """Take over a character without free parameters and the names of the bodies that walk.

        Where none of these have shapes, bodies whose names say that they are feet end the legs.
        """
        if not any(character.bodies[body].shapes for foot in feet if foot in character.bodies
                   for body in foot_bodies(character, foot)):  # fmt: skip
            feet = named_feet(character.bodies) or feet
        self.feet = tuple(feet)
        self._joints = character.joints
        self._above = {joint.child: joint for joint in character.joints.values()}
        chains = [[character.joints[name].child for name in leg(character, foot)] for foot in feet]
        self._in_legs = {body for chain in chains for body in chain}
        self._roles: dict[str, Role] = {}
        for chain in chains:
            long = [body for body in chain[:-1] if self._length(body) > LEAST and self._ends(body) < 2]
            self._roles |= dict(zip(long, LEG, strict=False))
        for body in character.bodies:
            if body not in self._in_legs and (role := self._role_in_arm(body)):
                self._roles[body] = role
        self._roles |= {body: named_role(body) for body in character.bodies if named_role(body)}
        forelegs = [body for body, role in self._roles.items() if role == "forearm" and self._is_foreleg(body)]
        self._roles |= dict.fromkeys(forelegs, "")

    def role(self, body: str) -> Role:
        """What a body is, by its name or else by how it hangs on others; empty for trunks, heads, feet and all else."""
        return self._roles.get(body, "")

    def leads_to_leg(self, body: str, place: Floats) -> bool:
        """Whether a leg hangs on a body where one of its joints is."""
        return any(
            joint.parent == body and joint.child in self._in_legs and np.allclose(joint_place(joint), place)
            for joint in self._joints.values()
        )

    def _role_in_arm(self, body: str) -> Role:
        chain = [body]
        while chain[0] in self._above and self._ends(self._above[chain[0]].parent) < 2:
            parent = self._above[chain[0]].parent
            if parent not in self._above:
                break
            chain.insert(0, parent)
        joint = self._above.get(chain[0])
        if joint is None or abs(joint_place(joint)[0]) < BESIDE:
            return ""
        long = [one for one in chain if self._length(one) > LEAST or one == body]
        return ARM[len(long) - 1] if len(long) <= len(ARM) else ""

    def _is_foreleg(self, body: str) -> bool:
        """Whether a forearm ends where the feet do: an animal has a hoof or a paw there, and no hand."""
        feet = [self._lowest(foot) for foot in self.feet if foot in self._above]
        return bool(feet) and not self._ends(body) and abs(self._lowest(body) - min(feet)) < LEVEL

    def _lowest(self, body: str) -> float:
        """Height of the end of a body at angles of 0, over its root, m: as far beyond its centre as its joint is."""
        height = -float(plain_vector(self._above[body].position_in_child)[1])
        while body in self._above:
            joint = self._above[body]
            height += float((plain_vector(joint.position_in_parent) - plain_vector(joint.position_in_child))[1])
            body = joint.parent
        return height

    def _ends(self, body: str) -> int:
        return sum(joint.parent == body for joint in self._joints.values())

    def _length(self, body: str) -> float:
        """Between a body's own joint and the next one, or twice as far as its centre of mass."""
        if body not in self._above:
            return 0.0
        start = plain_vector(self._above[body].position_in_child)
        ends = [joint_place(joint) for joint in self._joints.values() if joint.parent == body]
        return float(np.linalg.norm((ends[0] if ends else -start) - start))
