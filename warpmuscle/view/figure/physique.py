"""What a body of a character is like, from its joints, shapes and mass, and the pieces that are made of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Box, Capsule, Character, Shape, Sphere
from warpmuscle.scene.anatomy import Side, far_end, foot_bodies, joint_place, sides_of
from warpmuscle.scene.initial_pose import plain_number, plain_vector
from warpmuscle.scene.masses import TINY_MASS, body_mass
from warpmuscle.view.bones import skeleton
from warpmuscle.view.bones.girdle import rib_cage
from warpmuscle.view.bones.limbs import Limbs
from warpmuscle.view.bones.long_neck import LEAST, LongNeck
from warpmuscle.view.bones.low_trunk import LowTrunk, low_trunk
from warpmuscle.view.bones.named import named_neck
from warpmuscle.view.hulls import Mesh, Seeds, box_seeds
from warpmuscle.view.pieces import Hull, Layer, Limb, Piece

DENSITY = 1000.0  # kg/m^3
LOIN, LEAST_ERECT = 0.13, 0.4  # m, above the hips of a body of 75 kg, and how high a trunk with its head is, at least
HEAD_HEIGHT, UPRIGHT = 1.25, 0.9  # of a skull in the width of the capsule of a head; cosine of how that leans, at least
MIDDLE = 0.03  # m, joints this near to x = 0 are those of a neck rather than of arms


class Physique:
    """What is known of a character, and the pieces made so far."""

    def __init__(self, character: Character, feet: Sequence[str], body_names: Sequence[str], coarse: bool) -> None:
        self.character, self.names, self.coarse = character, body_names, coarse
        self.sides: Mapping[str, Side] = sides_of(character)
        self.mass = {name: plain_number(body.mass) for name, body in character.bodies.items()}
        self.total = max(body_mass(character), TINY_MASS)
        self.scale = float(np.clip((self.total / 75.0) ** (1.0 / 3.0), 0.3, 1.4))
        self.limbs = Limbs(character, feet)
        walking = [foot for foot in self.limbs.feet if foot in character.bodies]
        self.feet = {body for foot in walking for body in foot_bodies(character, foot)}
        cages = {name: rib_cage(character, name, self.sides) for name in character.bodies}
        self.cages = {name: cage for name, cage in cages.items() if cage is not None}
        self.heads: set[str] = set()
        self.made: list[Piece] = []

    def _start(self, name: str) -> Floats | None:
        """Where a body's own joint is, None for the root."""
        joints = self.character.joints.values()
        return next((plain_vector(joint.position_in_child) for joint in joints if joint.child == name), None)

    def _ends(self, name: str) -> list[Floats]:
        return [joint_place(joint) for joint in self.character.joints.values() if joint.parent == name]

    def _limb_end(self, start: Floats, ends: Sequence[Floats], shapes: Sequence[Shape]) -> Floats:
        """Where a limb from its joint ends: at the next joint, or where its shape or its mass does."""
        if shapes and not ends:
            return max((far_end(shape, start) for shape in shapes), key=lambda end: float(np.linalg.norm(end - start)))
        beyond = -0.9 * start  # as far behind the centre of mass
        if ends and np.linalg.norm(ends[0] - start) > np.linalg.norm(start):
            return ends[0]
        return beyond

    def _shoulders(self, ends: Sequence[Floats]) -> list[Floats]:
        """Ends of a body that arms hang on, to its left and its right."""
        beside = [end for end in ends if abs(end[0]) >= MIDDLE]
        return beside if len(beside) == 2 and beside[0][0] * beside[1][0] < 0.0 else []

    def _forelegs(self, ends: Sequence[Floats], hips: Sequence[Floats]) -> list[Floats]:
        """Where forelegs hang on a body that has hips, too: ahead of these rather than above."""
        shoulders = self._shoulders([end for end in ends if all(end is not hip for hip in hips)])
        ahead = np.mean(shoulders, axis=0) - np.mean(hips, axis=0) if shoulders else np.zeros(3)
        return shoulders if ahead[2] > abs(ahead[1]) else []

    def _upright(self, shapes: Sequence[Shape], start: Floats) -> tuple[Floats, float] | None:
        """Middle and radius of a skull, m, in a capsule that stands on its joint, as a person's head does."""
        if len(shapes) != 1 or not isinstance(shapes[0], Capsule):
            return None
        top, wide = far_end(shapes[0], start), plain_number(shapes[0].radius)
        up = (top - start) / max(float(np.linalg.norm(top - start)), 1e-9)
        radius = HEAD_HEIGHT * wide
        return (top + (wide - radius) * up, radius) if up[1] > UPRIGHT else None

    def _branches_below(self, name: str) -> bool:
        """Whether a body hangs on one that others hang on, too, as a trunk on a pelvis: a lone arm has no head."""
        joints = {joint.child: joint.parent for joint in self.character.joints.values()}
        while name in joints:
            name = joints[name]
            if len(self._ends(name)) > 1:
                return True
        return False

    def _is_one_of_two(self, name: str) -> bool:
        """Whether a forearm is an ulna or a radius, with the other one drawn beside it."""
        joints = self.character.joints.values()
        beside = [joint.child for joint in joints if joint.parent == name]
        beside += [joint.parent for joint in joints if joint.child == name]
        for other in (body for body in beside if self.limbs.role(body) == "forearm"):
            start = self._start(other)
            if start is not None:
                end = self._limb_end(start, self._ends(other), self.character.bodies[other].shapes)
                if np.linalg.norm(end - start) > skeleton.ARM:
                    return True
        return False

    def _erect_root(self, name: str) -> tuple[list[Floats], Floats, float] | None:
        """Hips, loin and height above it, m, of a root that is pelvis, trunk and head in one tall shape; else None."""
        ends, shapes = self._ends(name), self.character.bodies[name].shapes
        hips = [end for end in ends if self.limbs.leads_to_leg(name, end)]
        if self._start(name) is not None or len(ends) != 2 or len(hips) != 2 or len(shapes) != 1:
            return None
        if not isinstance(shapes[0], Capsule) or hips[0][0] * hips[1][0] >= 0.0:
            return None
        middle = 0.5 * (hips[0] + hips[1])
        top, radius = far_end(shapes[0], middle), plain_number(shapes[0].radius)
        up = top - middle
        loin = middle + np.array([0.0, LOIN * self.scale, 0.0])
        tall = float(top[1] + radius - loin[1])
        is_erect = up[1] > UPRIGHT * float(np.linalg.norm(up)) and tall > LEAST_ERECT * self.scale
        return (hips, loin, tall) if is_erect else None

    def _low_trunk(self, name: str) -> LowTrunk | None:
        """The trunk of an animal on two legs that lies or leans ahead of its hips, if a body is one."""
        ends, shapes = self._ends(name), self.character.bodies[name].shapes
        hips = [end for end in ends if self.limbs.leads_to_leg(name, end)]
        beside = [end for end in ends if abs(end[0]) >= MIDDLE]
        if self._start(name) is not None or len(hips) != 2 or len(beside) != 2 or len(shapes) != 1:
            return None
        if not isinstance(shapes[0], Capsule):
            return None
        middle = 0.5 * (hips[0] + hips[1])
        ahead = [end for end in ends if abs(end[0]) < MIDDLE and end[2] > middle[2]]
        end, radius = far_end(shapes[0], middle), plain_number(shapes[0].radius)
        return low_trunk(hips, ahead[0] if ahead else None, end, radius, self.scale)

    def _long_neck(self, name: str, start: Floats, end: Floats) -> LongNeck | None:
        """An animal's neck with its head: the last body there, by its name and its length."""
        length = float(np.linalg.norm(end - start))
        if self._ends(name) or not named_neck(name) or length < LEAST:
            return None
        return LongNeck(start, end, float(np.sqrt(self.mass[name] / (np.pi * DENSITY * length))))

    def _seeds(self, name: str) -> Seeds:
        found = Seeds(np.zeros((0, 3)), np.zeros(0))
        for shape in self.character.bodies[name].shapes:
            if isinstance(shape, Box):
                found = found.joined(box_seeds(shape))
            else:
                ends = [shape.center] if isinstance(shape, Sphere) else [shape.start, shape.end]
                places = np.array([plain_vector(end) for end in ends])
                found = found.joined(Seeds(places, np.full(len(places), plain_number(shape.radius))))
        return found

    def _add(
        self, kind: type[Limb], name: str, layer: Layer, start: Floats, end: Floats, radii: tuple[float, float]
    ) -> None:
        self.made.append(kind(self.names.index(name), self.sides[name], layer, start, end, radii))

    def _hull(self, name: str, mesh: Mesh | None, layer: Layer = "flesh") -> None:
        if mesh is not None:
            self.made.append(Hull(self.names.index(name), self.sides[name], layer, *mesh))
