"""Feet and toes of a figure: flesh from the shapes that touch the ground, drawn up to the ankle, and their bones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Joint
from warpmuscle.scene.anatomy import joint_place
from warpmuscle.view.bones import skeleton
from warpmuscle.view.figure.physique import Physique
from warpmuscle.view.hulls import Seeds, rounded_hull

ANKLE = 0.036  # m, radius of an ankle, of a body of 75 kg
TOES, SOLE = 0.065, 0.012  # m, length of toes, and of what is below their joint, of a body of 75 kg


class Feet(Physique):
    """Draws bodies that walk."""

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
