"""Constraints that close loops, in a scene that starts where they are met."""

from __future__ import annotations

import math

import numpy as np

from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.build_skeleton import state_at
from warpmuscle.formats.osim.chain import name_beside
from warpmuscle.formats.osim.frames import refused
from warpmuscle.formats.osim.loops.read import TYPES
from warpmuscle.formats.osim.moves import Coordinates
from warpmuscle.formats.osim.placement import Placement, direction, quaternion
from warpmuscle.formats.osim.records import Model
from warpmuscle.scene import Constraint, Scene
from warpmuscle.scene.constraints.pose import (
    MISSED,
    is_kinematic,
    meeting_speeds,
    met_pose,
    movers,
    nearest_pose,
    start_coordinates,
)
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.topology import topology

ENDLESS = (-1.0e3, 1.0e3)  # rad or m, of coordinates without a range
NOTED = 1.0e-6  # rad or m, by which a coordinate is moved without a word


def put_loops(model: Model, scene: Scene, placement: Placement, notes: Notes) -> None:
    """Put constraints into a scene; one between bodies that have been merged holds nothing any more."""
    for loop in model.loops:
        name = name_beside(loop.name or f"{loop.kind}_{loop.line}", scene.character.constraints)
        body, place = placement.point(loop.frame, loop.location)
        other, other_place = placement.point(loop.other_frame, loop.other_location)
        if body == other:
            continue
        axes, other_axes = placement.axes(loop.frame), placement.axes(loop.other_frame)
        made = Constraint(TYPES[loop.kind], body, other, place, other_place)
        if made.type == "weld":
            made.orientation, made.other_orientation = quaternion(axes), quaternion(other_axes)
        made.axis, made.distance = direction(other_axes @ np.array(loop.axis)), loop.distance
        scene.character.constraints[name] = made
        notes.places[f"character.constraints.{name}"] = (model.file, loop.line)


def close_loops(model: Model, scene: Scene, coordinates: Coordinates, notes: Notes) -> None:
    """Let a scene start in the nearest pose in which its constraints are met, at speeds that keep them met.

    As OpenSim assembles a model: the sum of squares of the changes of coordinates is least, and those that are clamped
    stay within their ranges. Where constraints cannot be met so, OpenSim starts with some of them missed; here
    coordinates start outside of their ranges, with a note, since a motion has to meet the constraints all the same.

    Raises:
        SceneError: there is no such pose near by.
    """
    character, start = scene.character, scene.initial_state.joints
    if not character.constraints:
        return
    names = topology(character)
    free = [name for name in movers(character, names) if _is_free(scene, name)]
    chosen = [names.coordinates_of(names.body_of_joint(name)).start for name in free]
    own = [coordinates.by_name[name] for name in free]
    bounds = np.array([one.range if one.clamped and _is_range(one.range) else ENDLESS for one in own]).reshape(-1, 2)
    before = start_coordinates(scene, names)
    q, missing = nearest_pose(character, names, before, chosen, bounds[:, 0], bounds[:, 1])
    beyond = missing > MISSED
    if beyond:
        wide = np.broadcast_to(ENDLESS, bounds.shape)
        q, missing = met_pose(character, names, before, chosen, wide[:, 0], wide[:, 1])
    if missing > MISSED:
        raise refused(model, model.loops[0].line, _missed(model, missing, coordinates))
    speeds = meeting_speeds(character, names, q, chosen, np.array([one.speed for one in own]))
    for name, value, speed in zip(free, q[0, chosen], speeds, strict=True):
        start[name] = state_at(character.joints[name], float(value), float(speed))
    far = np.abs(q[0, chosen] - before[0, chosen]) > NOTED
    moved = [(name, float(q[0, k])) for name, k, is_far in zip(free, chosen, far, strict=True) if is_far]
    if moved:
        listed = ", ".join(f"{name} {value:.4g}" for name, value in moved[:4]) + (", ..." if len(moved) > 4 else "")
        reason = f"their coordinates start where constraints are met, as near as can be to the model's: {listed}"
        reason += "; within the ranges they cannot be met" if beyond else ""
        notes.ignore(model.file, model.loops[0].line, "ConstraintSet", reason)


def _missed(model: Model, missing: float, coordinates: Coordinates) -> str:
    """That constraints cannot be met, and which coordinates are locked, as this may be why."""
    first = model.loops[0]
    locked = [name for name, one in coordinates.by_name.items() if one.locked]
    some = ", ".join(locked[:4]) + (", ..." if len(locked) > 4 else "")
    return (
        f"<{first.kind}> {first.name!r}: the constraints cannot be met near the pose that the model starts in; "
        f"{missing:.2g} (m or rad) are missing" + (f", with {some} locked" if locked else "")
    )


def _is_free(scene: Scene, name: str) -> bool:
    joint = scene.character.joints[name]
    return not joint.follows and joint_type(joint).scalars == 1 and not is_kinematic(scene, name)


def _is_range(span: tuple[float, float]) -> bool:
    return span[0] < span[1] and math.isfinite(span[0]) and math.isfinite(span[1])
