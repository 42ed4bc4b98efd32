"""Surfaces that muscles wrap around as MuJoCo's geoms of spatial tendons.

MuJoCo knows cylinders without end and spheres, one between two sites of a tendon; the half of a surface that a path
must stay on is said by a site beside it. Which segment of a path goes round a surface is fixed there: the one that
passes it most closely in the reference pose. What MuJoCo does not know is named in a comment.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from xml.etree.ElementTree import Comment, Element, SubElement

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import from_rotation_vector, rotate
from warpmuscle.formats.mjcf_text import texts
from warpmuscle.scene import Character, CylinderSurface, Muscle, SphereSurface, Surface
from warpmuscle.scene.initial_pose import plain_number, plain_vector
from warpmuscle.scene.topology import topology
from warpmuscle.scene.wrapping.route import half_of

BESIDE = 1.5  # radii, from the middle of a surface to the site that tells its half


def wrap_geoms(tendons: Element, name: str, muscle: Muscle, character: Character) -> dict[int, Surface]:
    """Which surface the path goes round behind which of its points, by their numbers from 0.

    A comment among the tendons names what is left out.
    """
    sites = [k for k, point in enumerate(muscle.path) if point.condition is None]
    places = _reference_places(character)
    points = {k: places[muscle.path[k].body] + plain_vector(muscle.path[k].place()) for k in sites}
    found: dict[int, Surface] = {}
    missing = ["a point's motion"] * any(point.motion for point in muscle.path)
    for wrap in muscle.wraps:
        surface = character.surfaces[wrap.surface]
        first, last = (wrap.first or 1) - 1, (wrap.last or len(muscle.path)) - 1
        pairs = [(a, b) for a, b in itertools.pairwise(sites) if a >= first and b <= last and a not in found]
        if not isinstance(surface, CylinderSurface | SphereSurface) or not pairs:
            missing.append(f"the surface {wrap.surface}")
            continue
        center = places[surface.body] + plain_vector(surface.position)
        found[min(pairs, key=lambda pair: _distance(center, points[pair[0]], points[pair[1]]))[0]] = surface
    if missing:
        tendons.append(Comment(f" {name.replace('--', '__')}: {', '.join(missing).replace('--', '__')} left out "))
    return found


def add_geom(tendon: Element, surface: Surface, name: str, bodies: Mapping[str | None, Element]) -> None:
    """Let a tendon go round a surface, which its body gets when it is first needed."""
    body = bodies[surface.body]
    point = getattr(surface, "side_point", None)
    side = f"{name}_side" if surface.side or point is not None else ""
    if body.find(f"geom[@name='{name}']") is None:
        turn = from_rotation_vector(plain_vector(surface.orientation))
        place = plain_vector(surface.position)
        length = [0.5 * plain_number(surface.length)] if isinstance(surface, CylinderSurface) else []
        radius = plain_number(surface.radius)  # type: ignore[union-attr]
        attributes = {"contype": "0", "conaffinity": "0", "group": "3", "mass": "0", "rgba": "0.5 0.6 0.8 0.3"}
        SubElement(
            body, "geom", attributes, name=name, type="cylinder" if length else "sphere",
            pos=texts(place), quat=texts(np.roll(turn, 1)), size=texts([radius, *length]),
        )  # fmt: skip
        if side:
            axis, sign = half_of(surface)
            own = BESIDE * radius * sign * np.eye(3)[axis] if point is None else plain_vector(point)
            beside = place + rotate(turn, own)
            SubElement(body, "site", name=side, pos=texts(beside), size="0.005")
    around = SubElement(tendon, "geom", geom=name)
    if side:
        around.set("sidesite", side)


def _reference_places(character: Character) -> dict[str, Floats]:
    """Centres of mass of all bodies in the reference pose, m, from that of the root."""
    names = topology(character)
    places: dict[str, Floats] = {character.root: np.zeros(3)}
    for name in names.joints:
        joint = character.joints[name]
        offset = plain_vector(joint.position_in_parent) - plain_vector(joint.position_in_child)
        places[joint.child] = places[joint.parent] + offset
    return places


def _distance(point: Floats, start: Floats, end: Floats) -> float:
    """From a point to a segment, m."""
    along = end - start
    part = np.clip(float((point - start) @ along) / max(float(along @ along), 1e-12), 0.0, 1.0)
    return float(np.linalg.norm(start + part * along - point))
