"""Bones of a figure: those of a person where joints are, by what a body is, and lines for one of many."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.anatomy import bone_lines
from warpmuscle.scene.masses import massless
from warpmuscle.view.bones import skeleton
from warpmuscle.view.bones.barrel import barrel_bones
from warpmuscle.view.bones.girdle import rib_cage_bones, shoulder_blade
from warpmuscle.view.bones.hips import pelvis_bones
from warpmuscle.view.bones.long_neck import LongNeck
from warpmuscle.view.bones.low_trunk import LowTrunk
from warpmuscle.view.figure.feet import Feet
from warpmuscle.view.figure.physique import MIDDLE
from warpmuscle.view.pieces import Limb

BONE = 0.008  # m, radius of a bone that is a line, of a body of 75 kg
FOREARM = 0.64  # of a forearm with its hand, the part before it
USUAL = {"thigh": 0.42, "shank": 0.42, "upper arm": 0.3, "forearm": 0.3}  # m, lengths of a body of 75 kg
LEAST_OF_USUAL = 0.9  # thickness of bones in that of such a length, whatever a model of a part of a body weighs
SHORTEST = 0.02  # m, of what is drawn as a limb


class Bones(Feet):
    """Draws bones."""

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

    def _trunk_bones(self, name: str, start: Floats, neck: Floats, shoulders: Sequence[Floats]) -> None:
        if not self.coarse:
            self._hull(name, skeleton.trunk_bones(start, neck, shoulders, self.scale), "bone")
        elif len(self._ends(name)) < 2:
            self._add(Limb, name, "bone", start, neck, (BONE * self.scale,) * 2)

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
