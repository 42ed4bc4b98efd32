"""Spheres under the feet of a model, with which a simulated ground carries it.

Each foot has six, at the heel, the ball and the ends of the toes, of the radius and the material of the spheres that
predictive simulations of walking use (Falisse et al. 2019, J R Soc Interface 16: 20190402), but with less slip. All are
fixed to the body that carries the heel, as recorded forces act on it: muscles of the toes alone could not press them
down. A model that has shapes on its feet keeps them and its ground.
"""

from __future__ import annotations

from typing import NamedTuple

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.number_rows import rows
from warpmuscle.core.pose import rotate
from warpmuscle.inverse.body_model import BodyModel, Dynamics
from warpmuscle.inverse.recordings.motion import scene_with_feet
from warpmuscle.inverse.tracking.timed_forces import without_timed
from warpmuscle.inverse.without_plates.contact_points import heel_and_toes
from warpmuscle.scene import Ground, Scene, Sphere
from warpmuscle.scene.character.shapes import ContactMaterial
from warpmuscle.scene.objective import never_failing

RADIUS, STIFFNESS = 0.032, 1.0e6  # m and N/m^2
MATERIAL = ContactMaterial(transition_velocity=0.05)
LENGTH = 0.18  # m, from heel to ball of the foot that these are of, with which they are scaled:
HEEL, BALL, TOES = 0.02, 0.035, 0.03  # m, from the middle of the foot to either side
FORWARD, BEHIND = 0.055, 0.01  # m, from the joint of the toes to their end, and from that of the heel
HERTZ = (
    4.0 / 3.0 * np.sqrt(RADIUS) * (0.5 * STIFFNESS ** (2.0 / 3.0)) ** 1.5
)  # N/m^1.5, see `kernels.contact.hunt_crossley`


class Foot(NamedTuple):
    """P points of a foot below which spheres lie."""

    body: int  # number of the body they are fixed to
    points: Floats  # (P, 3) m, in its axes, from its centre of mass; inner ones before outer ones
    joint: Floats  # (3,) m, its joint, from there


def feet_of(body: BodyModel) -> tuple[Foot, Foot]:
    """Left and right foot; raises ArgumentError where names of bodies do not tell them, or one has no toes."""
    scene, names = scene_with_feet(body.scene), body.topology
    if scene.feet is None:
        raise ArgumentError("a model on the ground needs two feet: bodies called talus, calcn or foot with _l and _r")
    found = []
    for name, outwards in zip(scene.feet, (1.0, -1.0), strict=True):
        heel, toes = heel_and_toes(list(names.parents), names.bodies.index(name), name)
        joints = scene.character.joints
        own = rows(joints[names.joints[heel - 1]].position_in_child)[0].astype(np.float64)
        ball = rows(joints[names.joints[toes - 1]].position_in_parent)[0].astype(np.float64)
        size = float(np.linalg.norm(ball - own)) / LENGTH
        offsets = [(own, HEEL, -BEHIND), (ball, BALL, 0.0), (ball, TOES, FORWARD)]
        points = [
            at + size * np.array([side * outwards * wide, 0.0, ahead])
            for at, wide, ahead in offsets
            for side in (-1.0, 1.0)
        ]
        found.append(Foot(heel, np.array(points), own))
    return found[0], found[1]


def has_contact(body: BodyModel, feet: tuple[Foot, Foot]) -> bool:
    """Whether the model has shapes of its own on both feet, and a ground to carry them."""
    bodies, names = body.scene.character.bodies, body.topology
    hung = [{foot.body, *(k for k, parent in enumerate(names.parents) if parent == foot.body)} for foot in feet]
    return all(any(bodies[names.bodies[k]].shapes for k in own) for own in hung)


def places(foot: Foot, dynamics: Dynamics) -> Floats:
    """Where the points of a foot are (n, P, 3), m, world axes."""
    arm = foot.points - foot.joint
    turned = [rotate(dynamics.orientation[:, foot.body], np.tile(one, (len(dynamics.position), 1))) for one in arm]
    return dynamics.position[:, foot.body, None] + np.stack(turned, axis=1)


def scene_on_ground(body: BodyModel, feet: tuple[Foot, Foot], sole: Floats | None, firmness: float = 1.0) -> Scene:
    """The scene with nothing that ends it, whose feet touch the ground.

    Args:
        sole: (P,) m, from the points down to the spheres; None: the model has contact of its own.
        firmness: of the spheres, 1 as published.
    """
    scene, names = body.scene, body.topology
    bodies, ground = dict(scene.character.bodies), scene.ground
    if sole is not None:
        bodies = {name: msgspec.structs.replace(one, shapes=[]) for name, one in bodies.items()}
        ground = Ground(law="hunt_crossley", material=msgspec.structs.replace(MATERIAL, stiffness=STIFFNESS * firmness))
        for foot in feet:
            centres = foot.points + np.array([0.0, RADIUS, 0.0]) - sole[:, None] * np.array([0.0, 1.0, 0.0])
            shapes = [Sphere((float(x), float(y), float(z)), RADIUS) for x, y, z in centres]
            name = names.bodies[foot.body]
            bodies[name] = msgspec.structs.replace(bodies[name], shapes=shapes)
    own = tuple(names.bodies[foot.body] for foot in feet)
    character = msgspec.structs.replace(scene.character, bodies=bodies, feet=(own[0], own[1]))
    return msgspec.structs.replace(
        scene,
        character=character,
        ground=ground,
        failure=never_failing(scene.failure),
        controller=None,
        motion={},
        forces=without_timed(scene.forces),
    )
