"""A character as a figure to look at: limbs, trunk, feet and a head, bones, and exact shapes; numbers only.

Bones of a person (`skeleton`) are put where joints are; of a figure that is one of many they are lines.

Limbs are as thick as their mass is at the density of water (1000 kg/m^3), and so is the trunk; feet and boxes are the
shapes that touch the ground, with round edges, drawn up to the ankle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Box, Capsule, Character, Joint, Shape, Sphere
from warpmuscle.scene.anatomy import Side, bone_lines, far_end, foot_bodies, joint_place, sides_of
from warpmuscle.scene.initial_pose import plain_number, plain_vector
from warpmuscle.scene.masses import TINY_MASS, body_mass, massless
from warpmuscle.view.bones import skeleton
from warpmuscle.view.bones.barrel import barrel_bones
from warpmuscle.view.bones.girdle import rib_cage, rib_cage_bones, shoulder_blade
from warpmuscle.view.bones.head import skull
from warpmuscle.view.bones.hips import pelvis_bones
from warpmuscle.view.bones.limbs import Limbs
from warpmuscle.view.bones.long_neck import LEAST, LongNeck
from warpmuscle.view.bones.low_trunk import LowTrunk, low_trunk
from warpmuscle.view.bones.named import named_head, named_neck
from warpmuscle.view.hulls import Mesh, Seeds, box_seeds, pelvis_places, rounded_hull, sized_hull, trunk_places
from warpmuscle.view.pieces import Hull, Layer, Limb, Piece, exact_shape

DENSITY = 1000.0  # kg/m^3
# Radius of a limb along its way from joint to joint, in that of a cylinder of its mass.
PROFILE = ((0.0, 0.92), (0.3, 1.16), (1.0, 0.66))
BONE = 0.008  # m, radius of a bone that is a line, of a body of 75 kg
FOREARM = 0.64  # of a forearm with its hand, the part before it
CAGE = 0.02  # m^3, of a person's trunk above the loin, at least
HEAVY = 0.25  # of the whole mass, from which a body at the end of a chain is a trunk with its head
PELVIS = 0.2  # of such a body's mass, where it has legs and no pelvis below
LOIN, LEAST_ERECT = 0.13, 0.4  # m, above the hips of a body of 75 kg, and how high a trunk with its head is, at least
HEAD_HEIGHT, UPRIGHT = 1.25, 0.9  # of a skull in the width of the capsule of a head; cosine of how that leans, at least
MIDDLE = 0.03  # m, joints this near to x = 0 are those of a neck rather than of arms
ANKLE = 0.036  # m, radius of an ankle, of a body of 75 kg
USUAL = {"thigh": 0.42, "shank": 0.42, "upper arm": 0.3, "forearm": 0.3}  # m, lengths of a body of 75 kg
LEAST_OF_USUAL = 0.9  # thickness of bones in that of such a length, whatever a model of a part of a body weighs
TOES, SOLE = 0.065, 0.012  # m, length of toes, and of what is below their joint, of a body of 75 kg
SHORTEST = 0.02  # m, of what is drawn as a limb


def figure_of(
    character: Character, feet: Sequence[str], body_names: Sequence[str], coarse: bool = False
) -> list[Piece]:
    """The figure of a character without free parameters: flesh, bones and exact shapes.

    Args:
        feet: names of the bodies that walk. coarse: whether it is small in the picture, one of many.
    """
    return _Figure(character, feet, body_names, coarse).pieces()


class _Figure:
    """Collects the pieces of all bodies."""

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

    def pieces(self) -> list[Piece]:
        for name, body in self.character.bodies.items():
            if name in self.feet and body.shapes:
                self._foot(name)
            elif name in self.cages or body.shapes or not massless(body):
                self._body(name)
            if self.coarse:
                self._bone_lines(name)
            elif name in self.cages or not massless(body):
                self._bones(name)
            number, side = self.names.index(name), self.sides[name]
            self.made += [exact_shape(shape, number, side) for shape in body.shapes]
        return self.made

    def _body(self, name: str) -> None:
        """Flesh of a body that is no foot."""
        start, ends, shapes = self._start(name), self._ends(name), self.character.bodies[name].shapes
        if self.cages and not shapes and self.limbs.role(name) in ("collar bone", "shoulder blade"):
            return  # they lie in the flesh of the trunk
        if self._trunk_at_the_root(name) or self._trunk_or_pelvis(name, start, ends, shapes):
            return
        if start is None:
            self._blocks(name, shapes)
        elif ends or not self._end_with_head(name, start, shapes):
            end = self._limb_end(start, ends, shapes)
            self._limb(name, start, end)
            if (long := self._long_neck(name, start, end)) is not None:
                self._snout(name, long)

    def _trunk_at_the_root(self, name: str) -> bool:
        """Flesh of a root that is all from hips to head, of a person or of an animal on two legs; whether it is one."""
        if (erect := self._erect_root(name)) is not None:
            hips, loin, tall = erect
            volume = self.mass[name] / DENSITY
            self._hull(name, sized_hull(pelvis_places(loin, hips), PELVIS * volume, self.coarse))
            self._upper_body(name, loin, np.array([0.0, 1.0, 0.0]), tall)
            return True
        if (low := self._low_trunk(name)) is not None and low.headless:
            self._hull(name, rounded_hull(self._seeds(name), self.coarse))
            neck = low.neck()
            self._add(Limb, name, "flesh", neck.joint, neck.end, (neck.radius, 0.8 * neck.radius))
            self._snout(name, neck)
            return True
        return False

    def _snout(self, name: str, neck: LongNeck) -> None:
        """Flesh of a head on a long neck, from its middle to its tip."""
        self._add(Limb, name, "flesh", neck.middle, neck.tip, (0.25 * neck.size, 0.08 * neck.size))

    def _trunk_or_pelvis(
        self, name: str, start: Floats | None, ends: Sequence[Floats], shapes: Sequence[Shape]
    ) -> bool:
        """Flesh of a body with ribs, or between three joints or more, or two of a root; whether it is one."""
        points = ends if start is None else [start, *ends]
        volume = self.mass[name] / DENSITY
        if (cage := self.cages.get(name)) is not None and not shapes:
            trunk = np.array([cage.neck, *trunk_places(cage.loin, cage.shoulders)])
            self._hull(name, sized_hull(trunk, max(volume, CAGE * cage.scale**3), self.coarse))
            return True
        if len(points) > 2 or (start is None and len(points) == 2):
            self._hull(name, sized_hull(self._round(name, start, ends, points), volume, self.coarse))
            self._missing_head(name, start, ends)
            return True
        return False

    def _end_with_head(self, name: str, start: Floats, shapes: Sequence[Shape]) -> bool:
        """Flesh of a last body that is a head, or a trunk with its head; whether it is one."""
        if len(shapes) == 1 and isinstance(shapes[0], Sphere):
            self._head(name, start, plain_vector(shapes[0].center), plain_number(shapes[0].radius))
            return True
        if named_head(name) and (upright := self._upright(shapes, start)) is not None:
            self._head(name, start, *upright)
            return True
        if self.mass[name] > HEAVY * self.total and self._branches_below(name):
            top = far_end(shapes[0], start) if shapes else -start
            reach = top - start
            tall = float(np.linalg.norm(reach)) + (plain_number(getattr(shapes[0], "radius", 0.0)) if shapes else 0.0)
            self._upper_body(name, start, reach / max(float(np.linalg.norm(reach)), 1e-9), tall)
            return True
        return False

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

    def _round(self, name: str, start: Floats | None, ends: Sequence[Floats], points: Sequence[Floats]) -> Floats:
        """Middles of the spheres that a trunk or a pelvis is made of; its joints, if it is neither."""
        if start is not None and (shoulders := self._shoulders(ends)):
            above = [end for end in ends if abs(end[0]) < MIDDLE]
            return np.array([*above, *trunk_places(start, shoulders)])
        hips = [end for end in ends if self.limbs.leads_to_leg(name, end)]
        above = [point for point in points if abs(point[0]) < MIDDLE and all(point is not hip for hip in hips)]
        if len(hips) != 2 or not above:
            return np.array(points)
        return np.array([*pelvis_places(above[0], hips), *self._forelegs(ends, hips)])

    def _limb_end(self, start: Floats, ends: Sequence[Floats], shapes: Sequence[Shape]) -> Floats:
        """Where a limb from its joint ends: at the next joint, or where its shape or its mass does."""
        if shapes and not ends:
            return max((far_end(shape, start) for shape in shapes), key=lambda end: float(np.linalg.norm(end - start)))
        beyond = -0.9 * start  # as far behind the centre of mass
        if ends and np.linalg.norm(ends[0] - start) > np.linalg.norm(start):
            return ends[0]
        return beyond

    def _limb(self, name: str, start: Floats, end: Floats) -> None:
        length = float(np.linalg.norm(end - start))
        if length < SHORTEST:
            radius = float(np.cbrt(0.75 * self.mass[name] / (np.pi * DENSITY)))
            self._add(Limb, name, "flesh", start, end, (min(radius, 0.03),) * 2)
            return
        radius = min(float(np.sqrt(self.mass[name] / (np.pi * DENSITY * length))), 0.4 * length)
        profile = PROFILE[::2] if self.coarse else PROFILE
        places = [start + part * (end - start) for part, _ in profile]
        radii = [factor * radius for _, factor in profile]
        for k in range(len(profile) - 1):
            self._add(Limb, name, "flesh", places[k], places[k + 1], (radii[k], radii[k + 1]))

    def _upright(self, shapes: Sequence[Shape], start: Floats) -> tuple[Floats, float] | None:
        """Middle and radius of a skull, m, in a capsule that stands on its joint, as a person's head does."""
        if len(shapes) != 1 or not isinstance(shapes[0], Capsule):
            return None
        top, wide = far_end(shapes[0], start), plain_number(shapes[0].radius)
        up = (top - start) / max(float(np.linalg.norm(top - start)), 1e-9)
        radius = HEAD_HEIGHT * wide
        return (top + (wide - radius) * up, radius) if up[1] > UPRIGHT else None

    def _head(self, name: str, joint: Floats, center: Floats, radius: float) -> None:
        """A skull with a jaw, as high as the sphere, on a neck; the face looks along z."""
        self.heads.add(name)
        up = center - joint
        up = up / max(float(np.linalg.norm(up)), 1e-9)
        ahead = np.array([0.0, 0.0, 1.0]) - up[2] * up
        crown, chin = center + 0.28 * radius * up, center - 0.42 * radius * up + 0.22 * radius * ahead
        self._add(Limb, name, "flesh", crown, chin, (0.72 * radius, 0.54 * radius))
        self._add(Limb, name, "flesh", joint, center - 0.3 * radius * up, (0.48 * radius, 0.44 * radius))
        if not self.coarse:
            bone, hollow = skull(joint, center, radius)
            self._hull(name, bone, "bone")
            self._hull(name, hollow, "hollow")

    def _upper_body(self, name: str, joint: Floats, up: Floats, tall: float) -> None:
        """Trunk, neck and head in one body, so tall, m, from its joint upwards; the shoulders are along x."""
        aside = np.array([1.0, 0.0, 0.0]) - up[0] * up
        shoulder, neck = joint + 0.60 * tall * up, joint + 0.68 * tall * up
        shoulders = [shoulder + sign * 0.2 * tall * aside for sign in (1.0, -1.0)]
        seeds = np.array([neck, *trunk_places(joint, shoulders)])
        self._hull(name, sized_hull(seeds, 0.75 * self.mass[name] / DENSITY, self.coarse))
        radius = 0.155 * tall
        self._head(name, neck, joint + (tall - radius) * up, radius)
        self._trunk_bones(name, joint, neck, shoulders)

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

    def _branches_below(self, name: str) -> bool:
        """Whether a body hangs on one that others hang on, too, as a trunk on a pelvis: a lone arm has no head."""
        joints = {joint.child: joint.parent for joint in self.character.joints.values()}
        while name in joints:
            name = joints[name]
            if len(self._ends(name)) > 1:
                return True
        return False

    def _missing_head(self, name: str, joint: Floats | None, ends: Sequence[Floats]) -> None:
        """The head of a heavy trunk on which arms hang, and no other body in the middle."""
        if joint is None or self.mass[name] <= HEAVY * self.total or min(abs(end[0]) for end in ends) < MIDDLE:
            return
        reach = np.mean(ends, axis=0) - joint
        length = float(np.linalg.norm(reach))
        self._head(name, joint + 1.08 * reach, joint + 1.55 * reach, 0.3 * length)

    def _blocks(self, name: str, shapes: Sequence[Shape]) -> None:
        """Shapes as they are, boxes with round edges; a sphere over a box is its head."""
        tops = [plain_vector(shape.high) for shape in shapes if isinstance(shape, Box)]
        bottom = min((plain_vector(shape.low)[1] for shape in shapes if isinstance(shape, Box)), default=0.0)
        for shape in shapes:
            if isinstance(shape, Box):
                self._hull(name, rounded_hull(box_seeds(shape), self.coarse))
            elif isinstance(shape, Sphere) and tops and plain_vector(shape.center)[1] > tops[0][1]:
                center = plain_vector(shape.center)
                neck = np.array([center[0], tops[0][1] - 0.02, center[2]])
                self._head(name, neck, center, plain_number(shape.radius))
                loin = neck * [1.0, 0.45, 1.0] + [0.0, 0.55 * bottom, 0.0]
                beside = [end * [sign, 1.0, 1.0] for end in self._ends(name) for sign in (1.0, -1.0)]
                self._trunk_bones(name, loin, neck, beside)
            else:
                piece = exact_shape(shape, self.names.index(name), self.sides[name])
                self.made.append(piece._replace(layer="flesh"))

    def _foot(self, name: str) -> None:
        """Shapes of a foot and its ankle in one piece; toes begin with the front of what they hang on."""
        start = self._start(name)
        seeds = self._seeds(name)
        if start is not None:
            joint = next(j for j in self.character.joints.values() if j.child == name)
            if joint.parent in self.feet and self.character.bodies[joint.parent].shapes:
                seeds = seeds.joined(self._front(joint).moved(start - joint_place(joint)))
            else:
                radius, sole = ANKLE * self.scale, float(np.min(seeds.places[:, 1] - seeds.radii))
                ankle = np.array([start[0], max(start[1], sole + radius), start[2]])
                seeds = seeds.joined(Seeds(ankle[None], np.array([radius])))
        self._hull(name, rounded_hull(seeds, self.coarse))

    def _front(self, joint: Joint) -> Seeds:
        """Of what the toes hang on, the seeds that are farthest towards them, and no higher than the joint."""
        seeds, place = self._seeds(joint.parent), joint_place(joint)
        along = (seeds.places - seeds.places.mean(axis=0)) @ (place - seeds.places.mean(axis=0))
        chosen = along >= along.max() - 0.25 * max(float(np.ptp(along)), 1e-12)
        return Seeds(seeds.places[chosen], seeds.radii[chosen])

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

    def _bones(self, name: str) -> None:
        """Bones of a person, by what a body is; a trunk that ends in a head has its own."""
        start, ends = self._start(name), self._ends(name)
        hips = [end for end in ends if self.limbs.leads_to_leg(name, end)]
        if name in self.feet:
            self._foot_bones(name, start, ends)
        elif len(hips) == 2:
            self._bones_over_hips(name, start, ends, hips)
        elif (cage := self.cages.get(name)) is not None:
            self._hull(name, rib_cage_bones(cage), "bone")
        elif start is not None and (shoulders := self._shoulders(ends)):
            above = [end for end in ends if abs(end[0]) < MIDDLE]
            neck = above[0] if above else start + 1.08 * (np.mean(shoulders, axis=0) - start)
            self._trunk_bones(name, start, neck, shoulders)
        elif name not in self.heads and start is not None:
            self._bones_by_role(name, start, ends)

    def _bones_over_hips(self, name: str, start: Floats | None, ends: Sequence[Floats], hips: Sequence[Floats]) -> None:
        """A pelvis, and the ribs of an animal whose trunk lies ahead of it in the same body."""
        others = [start] if start is not None else [end for end in ends if abs(end[0]) < MIDDLE]
        hip, tall = 0.5 * (hips[0] + hips[1]), np.array([0.0, 0.16 * self.scale, 0.0])
        low = self._low_trunk(name)
        top = low.front if low is not None else others[0] if others else hip + tall
        self._hull(name, pelvis_bones(hips, top, self.scale), "bone")
        if low is not None:
            self._low_bones(name, low)
        if others and (shoulders := self._forelegs(ends, hips)):
            self._hull(name, barrel_bones(hips, others[0], shoulders, self.scale), "bone")

    def _bones_by_role(self, name: str, start: Floats, ends: Sequence[Floats]) -> None:
        """Bones of a body that is neither foot nor trunk; an ankle bone is drawn with its foot."""
        role = self.limbs.role(name)
        if role == "ankle bone":
            return
        if role == "shoulder blade" and (blade := shoulder_blade(self.character, name)) is not None:
            self._hull(name, blade, "bone")
        elif role == "knee cap":
            self._hull(name, skeleton.knee_cap(np.zeros(3), self.scale), "bone")
        else:
            end = self._limb_end(start, ends, self.character.bodies[name].shapes)
            if np.linalg.norm(end - start) >= SHORTEST:
                self._limb_bones(name, start, end)

    def _low_bones(self, name: str, low: LowTrunk) -> None:
        """Ribs, and a head where there is none."""
        self._hull(name, low.ribs(self.scale), "bone")
        if low.headless:
            self._neck_bones(name, low.neck())

    def _neck_bones(self, name: str, neck: LongNeck) -> None:
        """A long neck and the skull on it."""
        bone, eyes = neck.bones()
        self._hull(name, bone, "bone")
        self._hull(name, eyes, "hollow")

    def _limb_bones(self, name: str, start: Floats, end: Floats) -> None:
        """Bones of a body between two places, by its role."""
        length, role = float(np.linalg.norm(end - start)), self.limbs.role(name)
        size = max(min(self.scale, 2.9 * length), LEAST_OF_USUAL * length / USUAL.get(role, np.inf))
        sign = -1.0 if self.sides[name] == "right" else 1.0
        if role == "thigh":
            below = [joint.child for joint in self.character.joints.values() if joint.parent == name]
            capped = all(self.limbs.role(child) != "knee cap" for child in below)
            self._hull(name, skeleton.thigh_bone(start, end, sign, size, capped), "bone")
        elif role == "shank":
            self._hull(name, skeleton.shank_bones(start, end, sign, size), "bone")
        elif role == "upper arm":
            self._hull(name, skeleton.upper_arm_bone(start, end, size), "bone")
        elif role == "forearm" and self._is_one_of_two(name):
            self._hull(name, skeleton.plain_bone(start, end, 0.75 * size), "bone")
        elif role == "forearm" and self._ends(name):
            self._hull(name, skeleton.forearm_bones(start, end, size), "bone")
        elif role == "forearm":  # with its hand
            wrist = start + FOREARM * (end - start)
            self._hull(name, skeleton.forearm_bones(start, wrist, size), "bone")
            self._hull(name, skeleton.hand_bones(wrist, end, size), "bone")
        elif role == "hand":
            self._hull(name, skeleton.hand_bones(start, end, self.scale), "bone")
        elif (neck := self._long_neck(name, start, end)) is not None:
            self._neck_bones(name, neck)
        else:
            self._hull(name, skeleton.plain_bone(start, end, size), "bone")

    def _long_neck(self, name: str, start: Floats, end: Floats) -> LongNeck | None:
        """An animal's neck with its head: the last body there, by its name and its length."""
        length = float(np.linalg.norm(end - start))
        if self._ends(name) or not named_neck(name) or length < LEAST:
            return None
        return LongNeck(start, end, float(np.sqrt(self.mass[name] / (np.pi * DENSITY * length))))

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

    def _shoulders(self, ends: Sequence[Floats]) -> list[Floats]:
        """Ends of a body that arms hang on, to its left and its right."""
        beside = [end for end in ends if abs(end[0]) >= MIDDLE]
        return beside if len(beside) == 2 and beside[0][0] * beside[1][0] < 0.0 else []

    def _forelegs(self, ends: Sequence[Floats], hips: Sequence[Floats]) -> list[Floats]:
        """Where forelegs hang on a body that has hips, too: ahead of these rather than above."""
        shoulders = self._shoulders([end for end in ends if all(end is not hip for hip in hips)])
        ahead = np.mean(shoulders, axis=0) - np.mean(hips, axis=0) if shoulders else np.zeros(3)
        return shoulders if ahead[2] > abs(ahead[1]) else []

    def _trunk_bones(self, name: str, start: Floats, neck: Floats, shoulders: Sequence[Floats]) -> None:
        if not self.coarse:
            self._hull(name, skeleton.trunk_bones(start, neck, shoulders, self.scale), "bone")
        elif len(self._ends(name)) < 2:
            self._add(Limb, name, "bone", start, neck, (BONE * self.scale,) * 2)

    def _foot_bones(self, name: str, start: Floats | None, ends: Sequence[Floats]) -> None:
        """Bones of a foot, or of toes, whose shapes say where they end."""
        seeds = self._seeds(name)
        if start is None or not len(seeds.radii):
            return self._foot_bones_by_joints(name, start, ends)
        sole, tip = float(np.min(seeds.places[:, 1] - seeds.radii)), float(np.max(seeds.places[:, 2] + seeds.radii))
        heel, sign = float(np.min(seeds.places[:, 2] - seeds.radii)), -1.0 if self.sides[name] == "right" else 1.0
        joint = next(j for j in self.character.joints.values() if j.child == name)
        if joint.parent in self.feet and self.character.bodies[joint.parent].shapes:
            under = self._seeds(joint.parent)
            sole = float(np.min(under.places[:, 1] - under.radii)) + float(start[1] - joint_place(joint)[1])
            self._hull(name, skeleton.toe_bones(start, tip, sole, sign, self.scale), "bone")
            return
        ball = ends[0] if ends else np.array([start[0], sole, heel + 0.72 * (tip - heel)])
        self._hull(name, skeleton.foot_bones(start, ball, heel, sole, sign, self.scale), "bone")
        if not ends:
            self._hull(name, skeleton.toe_bones(ball, tip, sole, sign, self.scale), "bone")

    def _foot_bones_by_joints(self, name: str, start: Floats | None, ends: Sequence[Floats]) -> None:
        """The same without shapes: from heel to toes, on ground just below the lower one of the joints."""
        if start is None:
            return
        s, sign = self.scale, -1.0 if self.sides[name] == "right" else 1.0
        joint = next(one for one in self.character.joints.values() if one.child == name)
        if joint.parent in self.feet:
            self._hull(name, skeleton.toe_bones(start, start[2] + TOES * s, start[1] - SOLE * s, sign, s), "bone")
            return
        ball = ends[0] if ends else start + s * np.array([0.0, -0.06, 0.13])
        sole = float(min(start[1], ball[1])) - SOLE * s
        at_heel = start[1] - ball[1] < 0.04 * s  # such as the joint of an ankle bone on a calcaneus
        ankle, heel = (start + s * np.array([0.0, 0.042, 0.049]), start[2]) if at_heel else (start, start[2] - 0.05 * s)
        self._hull(name, skeleton.foot_bones(ankle, ball, float(heel), sole, sign, s), "bone")
        if not ends:
            self._hull(name, skeleton.toe_bones(ball, float(ball[2]) + TOES * s, sole, sign, s), "bone")

    def _bone_lines(self, name: str) -> None:
        """Lines between joints; feet and heads have none."""
        if name in self.heads or name in self.feet:
            return
        shaft, ends = BONE * self.scale, [*self._ends(name)]
        if (start := self._start(name)) is not None:
            ends.append(start)
        lines = bone_lines(self.character, name)
        if not self.character.bodies[name].shapes and not massless(self.character.bodies[name]) and len(ends) == 1:
            lines = [np.stack([ends[0], self._limb_end(ends[0], [], [])])] if start is not None else []
        for a, b in lines:
            if np.linalg.norm(b - a) > SHORTEST:
                self._add(Limb, name, "bone", a, b, (shaft, shaft))

    def _start(self, name: str) -> Floats | None:
        """Where a body's own joint is, None for the root."""
        joints = self.character.joints.values()
        return next((plain_vector(joint.position_in_child) for joint in joints if joint.child == name), None)

    def _ends(self, name: str) -> list[Floats]:
        return [joint_place(joint) for joint in self.character.joints.values() if joint.parent == name]

    def _add(
        self, kind: type[Limb], name: str, layer: Layer, start: Floats, end: Floats, radii: tuple[float, float]
    ) -> None:
        self.made.append(kind(self.names.index(name), self.sides[name], layer, start, end, radii))

    def _hull(self, name: str, mesh: Mesh | None, layer: Layer = "flesh") -> None:
        if mesh is not None:
            self.made.append(Hull(self.names.index(name), self.sides[name], layer, *mesh))
