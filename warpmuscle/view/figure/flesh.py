"""Flesh of a figure: limbs, trunk and head, as thick as their mass is at the density of water."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Box, Shape, Sphere
from warpmuscle.scene.anatomy import far_end
from warpmuscle.scene.initial_pose import plain_number, plain_vector
from warpmuscle.view.bones.head import skull
from warpmuscle.view.bones.long_neck import LongNeck
from warpmuscle.view.bones.named import named_head
from warpmuscle.view.figure.bones import SHORTEST, Bones
from warpmuscle.view.figure.physique import DENSITY, MIDDLE
from warpmuscle.view.hulls import box_seeds, pelvis_places, rounded_hull, sized_hull, trunk_places
from warpmuscle.view.pieces import Limb, exact_shape

# Radius of a limb along its way from joint to joint, in that of a cylinder of its mass.
PROFILE = ((0.0, 0.92), (0.3, 1.16), (1.0, 0.66))
CAGE = 0.02  # m^3, of a person's trunk above the loin, at least
HEAVY = 0.25  # of the whole mass, from which a body at the end of a chain is a trunk with its head
PELVIS = 0.2  # of such a body's mass, where it has legs and no pelvis below


class Flesh(Bones):
    """Draws flesh, and with heads and trunks of one body the bones in them."""

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
