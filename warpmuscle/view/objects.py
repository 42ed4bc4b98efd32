"""Objects beside a character as the viewer shows them: bodies that hang on nothing, behind those of the character."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized
from warpmuscle.results.recording import Recording
from warpmuscle.scene import BoxObject, Scene
from warpmuscle.scene.initial_pose import plain_vector
from warpmuscle.scene.objects.motion import ObjectMotion, is_recorded, object_motion
from warpmuscle.scene.objects.part import AnyObject
from warpmuscle.scene.objects.shape import rounded
from warpmuscle.scene.treadmill.belt_motion import mean_shift
from warpmuscle.view.pieces import Block, Limb, Piece


def motion_of(recording: Recording, scene: Scene, name: str) -> ObjectMotion:
    """Where an object was, on a treadmill relative to the belts; its start if a recording has nothing of it."""
    shift = mean_shift(scene.ground, recording.time)
    if is_recorded(recording, name):
        found = object_motion(recording, name)
        return found._replace(position=found.position - shift)
    solid, frames = scene.objects[name], recording.frames
    still = np.zeros((frames, 3))
    turn = normalized(np.array([float(np.asarray(number)) for number in solid.orientation]))
    return ObjectMotion(plain_vector(solid.position) - shift, np.tile(turn, (frames, 1)), still, still)


def motions_of(recording: Recording, scene: Scene) -> tuple[ObjectMotion, ...]:
    """The motions of all objects of a scene without free parameters, in its order."""
    return tuple(motion_of(recording, scene, name) for name in scene.objects)


def object_piece(solid: AnyObject, body: int) -> Piece:
    """An object without free parameters as a piece of a figure, on a body of this number."""
    half, radius = rounded(solid)
    if isinstance(solid, BoxObject):
        return Block(body, "middle", "object", np.zeros(3), half[0])
    return Limb(body, "middle", "object", -half[0], half[0], (float(radius[0]),) * 2)


def object_pieces(scene: Scene) -> list[Piece]:
    """The pieces of all objects of a scene without free parameters, whose numbers follow those of its bodies."""
    first = len(scene.character.bodies)
    return [object_piece(solid, first + number) for number, solid in enumerate(scene.objects.values())]


def with_objects(orientation: Floats, objects: tuple[ObjectMotion, ...]) -> Floats:
    """Orientations (F, B, 4) of bodies, and of objects behind them."""
    if not objects:
        return orientation
    return np.concatenate([orientation, np.stack([one.orientation for one in objects], axis=1)], axis=1)
