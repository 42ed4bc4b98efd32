"""Paths of a scene from tendons: spatial ones as points and surfaces, others as sums of coordinates."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.formats.mujoco.reference import HINGE, SLIDE, WORLD, Reference
from warpmuscle.formats.osim.placement import rotation_vector, vector
from warpmuscle.scene import Branch, CylinderSurface, PolynomialPath, SphereSurface, Surface, ViaPoint, Wrap

JOINT, PULLEY, SITE, SPHERE, CYLINDER = 1, 2, 3, 4, 5  # mjtWrap
EXACT = 1.0e-9  # m or rad, by which a surface may lie beside a hinge and yet stay where it is
Element = tuple[int, int, float]  # type, number of the object, and its parameter


@dataclass
class Route:
    """Where a tendon runs: points, wraps and branches, or a polynomial."""

    path: list[ViaPoint] = field(default_factory=list)
    wraps: list[Wrap] = field(default_factory=list)
    branches: list[Branch] = field(default_factory=list)
    polynomial: PolynomialPath | None = None


class Tendons:
    """Makes routes of tendons, and surfaces as these want them."""

    def __init__(self, reference: Reference) -> None:
        self._reference = reference
        self._model = reference.model
        self.surfaces: dict[str, Surface] = {}

    def name(self, tendon: int) -> str:
        """The name of a tendon, or one made of its number."""
        return self._model.tendon(tendon).name or f"tendon{tendon}"

    def on_world(self) -> bool:
        """Whether some tendon is fixed to what does not move."""
        elements = [element for tendon in range(self._model.ntendon) for element in self._elements(tendon)]
        bodies = [self._body(*element) for element in elements if element[0] in (SITE, SPHERE, CYLINDER)]
        return WORLD in map(self._reference.lead, bodies)

    def route(self, tendon: int) -> Route | str:
        """The route of a tendon, or why there is none."""
        elements = self._elements(tendon)
        if elements[0][0] == JOINT:
            return self.sum_of([(number, factor) for _, number, factor in elements])
        route = Route()
        for kind, number, parameter in elements:
            if kind == PULLEY:
                route.branches.append(Branch(len(route.path) + 1, parameter))
            elif kind == SITE:
                body = self._body(kind, number, parameter)
                route.path.append(ViaPoint(*self._reference.on(body, self._site(number))))
            else:
                count = len(route.path)
                route.wraps.append(Wrap(self._surface(kind, number, int(parameter)), count, count + 1))
        return route

    def sum_of(self, terms: list[tuple[int, float]]) -> Route | str:
        """The sum of joints' coordinates, each times a factor, or why there is none."""
        reference = self._reference
        if any(self._model.jnt_type[joint] not in (HINGE, SLIDE) for joint, _ in terms):
            return "is of a joint that is neither a hinge nor a slide"
        exponents = [[int(k == other) for other in range(len(terms))] for k in range(len(terms))]
        joints = [reference.name("joint", joint) for joint, _ in terms]
        return Route(polynomial=PolynomialPath(joints, exponents, [factor for _, factor in terms]))

    def _elements(self, tendon: int) -> list[Element]:
        model, start = self._model, int(self._model.tendon_adr[tendon])
        span = range(start, start + int(model.tendon_num[tendon]))
        return [(int(model.wrap_type[k]), int(model.wrap_objid[k]), float(model.wrap_prm[k])) for k in span]

    def _body(self, kind: int, number: int, parameter: float) -> int:
        """The body that a site or surface is on: that of a side site, if the surface lies there as well."""
        if kind == SITE:
            return int(self._model.site_bodyid[number])
        own, side = int(self._model.geom_bodyid[number]), int(parameter)
        other = int(self._model.site_bodyid[side]) if side >= 0 else own
        return other if all(self._stays(kind, number, joint) for joint in self._between(own, other)) else own

    def _between(self, one: int, other: int) -> list[int]:
        """The joints between two bodies."""
        found: list[int] = []
        while one != other:
            one, other = min(one, other), max(one, other)  # a parent comes before its children
            start = int(self._model.body_jntadr[other])
            found += range(start, start + int(self._model.body_jntnum[other]))
            other = int(self._model.body_parentid[other])
        return found

    def _stays(self, kind: int, geom: int, joint: int) -> bool:
        """Whether a surface, without ends, is where it was when a joint has turned it."""
        data = self._reference.data
        axis, aside = data.xaxis[joint], data.geom_xpos[geom] - data.xanchor[joint]
        along = data.geom_xmat[geom].reshape(3, 3)[:, 2]
        turned = kind == CYLINDER and np.linalg.norm(np.cross(axis, along)) > EXACT
        hinge = self._model.jnt_type[joint] == HINGE
        return bool(hinge and not turned and np.linalg.norm(np.cross(axis, aside)) < EXACT)

    def _site(self, number: int) -> Floats:
        return np.asarray(self._reference.data.site_xpos[number])

    def _surface(self, kind: int, geom: int, side: int) -> str:
        """The name of the surface of a geom with a site on its side; -1: none."""
        model, data, reference = self._model, self._reference.data, self._reference
        name = reference.name("geom", geom)
        if side >= 0:
            name += f"_{reference.name('site', side)}"
        if name in self.surfaces:
            return name
        turn, center = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
        holder = self._body(kind, geom, side)
        body, position = reference.on(holder, center)
        orientation = rotation_vector(reference.axes @ turn)
        radius, half = (float(size) for size in model.geom_size[geom, :2])
        surface: SphereSurface | CylinderSurface = SphereSurface(body, position, radius, orientation)
        if kind == CYLINDER:
            surface = CylinderSurface(body, position, radius, 2.0 * half, orientation)
        if side >= 0:
            surface.side_point = vector(turn.T @ (self._site(side) - center))
            if reference.lead(int(model.site_bodyid[side])) != reference.lead(holder):
                reference.lose(f"geom {name}", "its side site is on another body; taken where the model starts")
        self.surfaces[name] = surface
        return name
