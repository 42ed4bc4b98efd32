"""Ranges of coordinates: in OpenSim they hold nothing, unless a force of the model or a stiffness of ours does."""

from __future__ import annotations

from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.records import Model
from warpmuscle.scene import Scene

RELAXATION = 0.005  # s, damping over stiffness of a range, as of the scene's own joints


def hold_ranges(scene: Scene, stiffness: float) -> None:
    """Let ranges push with a stiffness, N m/rad or N/m, where no CoordinateLimitForce of the model holds a coordinate.

    A stiffness of 0 leaves all as it is.
    """
    for name in unheld(scene) if stiffness > 0.0 else ():
        joint = scene.character.joints[name]
        joint.limit_stiffness, joint.limit_damping = stiffness, RELAXATION * stiffness


def unheld(scene: Scene) -> list[str]:
    """Joints that have a range and nothing that pushes at its ends, but for those whose motion is prescribed."""
    held = {force.joint for force in scene.forces.values() if force.type == "coordinate_limit"}
    driven = {name for name, actuation in scene.actuation.items() if actuation.drive == "kinematic"}
    return [
        name
        for name, joint in scene.character.joints.items()
        if joint.limits and not joint.limit_stiffness and not joint.follows and name not in held | driven
    ]


def tell_ranges(model: Model, scene: Scene, notes: Notes) -> None:
    """Note once that a free run leaves the ranges, and what holds it there."""
    names = unheld(scene)
    if names:
        some = ", ".join(names[:3]) + (", ..." if len(names) > 3 else "")
        which = f"the range of {some}" if len(names) == 1 else f"the ranges of {len(names)} coordinates ({some})"
        reason = (
            f"as in OpenSim, {which} push{'es' if len(names) == 1 else ''} with no force, so that a free run leaves "
            f"{'it' if len(names) == 1 else 'them'}; --limit-stiffness 500 (N m/rad) holds the joints within"
        )
        notes.ignore(model.file, model.line, f"Model {model.name}", reason)
