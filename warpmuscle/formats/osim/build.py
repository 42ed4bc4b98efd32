"""A scene from an OpenSim model's records."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from warpmuscle.core.errors import SceneError, shortened
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.actions.controls import excitation_of, moments
from warpmuscle.formats.osim.balls import merge_balls
from warpmuscle.formats.osim.blends import blend_conditions, open_at_stops
from warpmuscle.formats.osim.build_forces import build_forces, hold_ranges, tell_ranges
from warpmuscle.formats.osim.build_muscles import MuscleBuilder, build_surfaces, controls_of, on_ground
from warpmuscle.formats.osim.build_skeleton import Skeleton, build_skeleton
from warpmuscle.formats.osim.frames import GROUND, note, on_body
from warpmuscle.formats.osim.loops.build import close_loops, put_loops
from warpmuscle.formats.osim.loops.cut import cut_loops
from warpmuscle.formats.osim.loops.locks import hold_drivers
from warpmuscle.formats.osim.mesh_files import build_meshes
from warpmuscle.formats.osim.moves import Coordinates
from warpmuscle.formats.osim.read import read
from warpmuscle.formats.osim.records import Coordinate, Model
from warpmuscle.formats.osim.tree import Branch, branches, joined, merge_welds, root_kind, tell_loose
from warpmuscle.formats.osim.wraps.idle import drop_idle_wraps
from warpmuscle.scene import Actuation, Character, Failure, Marker, Motion, Scene
from warpmuscle.scene.muscles.cables import LIGAMENTS
from warpmuscle.scene.validation.paths import is_route, usual_drive
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.scene.validation.skeleton import weightless

OUTSIDE = 1.0e-3  # rad or m, by which a coordinate may start outside of its range without a word


def load_model(
    path: Path, notes: Notes, ball_joints: bool = False, hard_points: bool = False, welds_merged: bool = False,
    limit_stiffness: float = 0.0,
) -> Scene:  # fmt: skip
    """A checked scene from a model file.

    Args:
        notes: gets what is not used, with its line and with what follows from that.
        ball_joints: three hinges through one point become a ball joint, see `balls.py`.
        hard_points: paths jump as OpenSim's, where conditional points come in (else see `blends.py`) and off surfaces.
        welds_merged: bodies that are welded to others, or locked, become part of them, see `tree.py`.
        limit_stiffness: N m/rad or N/m, of ranges that nothing holds, see `hold_ranges`.

    Raises:
        SceneError: it cannot be read or represented; with file and line.
    """
    try:
        model = read(path, notes)
        scene = build(model, notes, ball_joints, hard_points, welds_merged, limit_stiffness)
        check_scene(scene)
    except SceneError as error:
        placed = notes.placed(error)
        raise (placed if placed.file is not None else placed.at(path, 0)) from None
    return scene


def build(
    model: Model, notes: Notes, ball_joints: bool = False, hard_points: bool = False, welds_merged: bool = False,
    limit_stiffness: float = 0.0,
) -> Scene:  # fmt: skip
    """A scene from records.

    Raises:
        SceneError: the model cannot be represented.
    """
    for name in joined(model):
        line = next(body.line for body in model.bodies if body.name == name)
        reason = "no joint leads to it from the ground; it moves freely, as in OpenSim"
        notes.ignore(model.file, line, f"Body {name}", reason)
    cut_loops(model, notes)
    if not model.bodies:
        notes.ignore(model.file, model.line, f"Model {model.name}", "has no bodies: nothing in it moves")
    hold_drivers(model, notes)
    coordinates = Coordinates(model)
    tree = branches(model, coordinates)
    if welds_merged:
        tree = merge_welds(model, tree)
    skeleton = build_skeleton(model, tree, root_of(model, tree, coordinates), coordinates, notes)
    character = skeleton.character
    character.surfaces = build_surfaces(model, skeleton.placement)
    common, character.muscles = MuscleBuilder(model, skeleton.placement, coordinates, notes).build()
    scene = Scene(name=model.name, character=character, initial_state=skeleton.initial, muscle_model=common)
    scene.description = shortened(
        f"OpenSim model {model.file.name}" + (f"; credits: {model.credits}" if model.credits else "")
    )
    scene.opensim = skeleton.opensim
    scene.opensim.controls = controls_of(model, notes)
    notes.places |= {f"character.surfaces.{name}": (model.file, one.line) for name, one in model.surfaces.items()}
    notes.places["muscle_model"] = (model.file, model.muscles[0].line if model.muscles else model.line)
    _gravity(model, scene, notes)
    _prescribe(scene, coordinates)
    _hold_weightless(model, scene, coordinates, notes)
    put_loops(model, scene, skeleton.placement, notes)
    close_loops(model, scene, coordinates, notes)
    build_forces(model, scene, skeleton, coordinates, notes)
    _excite(model, scene, notes)
    _settle_drives(scene)
    hold_ranges(scene, limit_stiffness)
    tell_ranges(model, scene, notes)
    shortest = any(muscle.shortest and muscle.wraps for muscle in model.muscles)
    if shortest:
        character.wrapping = "mujoco"
    if not hard_points:
        if not shortest:
            drop_idle_wraps(character)
        open_at_stops(scene)
    jumps = {} if hard_points else blend_conditions(scene)
    if character.surfaces and not hard_points and not shortest:
        character.wrapping = "smooth"
    if hard_points and any(point.motion for muscle in character.muscles.values() for point in muscle.path):
        character.moving_points = "opensim"
    if ball_joints:
        merge_balls(scene, coordinates.joint_of)
    tell_loose(model, tree, notes)
    _tell_jumps(model, character, jumps, notes)
    _markers(model, skeleton, notes)
    skeleton.opensim.meshes = build_meshes(model, skeleton.placement, set(character.bodies))
    _tell(model, skeleton, coordinates, notes)
    if character.root_joint == "fixed":
        scene.failure = Failure(com_height=0.0, heading=0.0)
    return scene


def root_of(model: Model, tree: list[Branch], coordinates: Coordinates) -> str:
    """The type of the root: see `tree.root_kind`."""
    needed = {name for coupler in model.couplers for name in (coupler.independent, *coupler.several)}
    for muscle in model.muscles:
        for point in muscle.points:
            needed |= {point.coordinate, *(name for name, _ in point.motion)}
        needed |= set(muscle.polynomial.coordinates if muscle.polynomial is not None else ())
    needed |= {force.words["coordinate"] for force in model.forces if "coordinate" in force.words} - {
        force.words["coordinate"]
        for force in model.forces
        if force.kind == "CoordinateActuator" and force.name not in model.controls
    }
    return root_kind(model, tree, coordinates, needed, on_ground(model))


def _gravity(model: Model, scene: Scene, notes: Notes) -> None:
    """Gravity, which points down; noted where the ground is turned for it, see `placement.world_axes`."""
    x, y, z = model.gravity
    scene.gravity = math.hypot(x, y, z)
    if x != 0.0 or z != 0.0 or y > 0.0:
        reason = (
            f"is {x:g} {y:g} {z:g}; the model is turned so that it points along -y. Coordinates are the model's own; "
            "markers and ground forces have y up, here and where they are exported"
        )
        notes.ignore(model.file, model.gravity_line, "gravity", reason)


def _prescribe(scene: Scene, coordinates: Coordinates) -> None:
    """Coordinates with a prescribed function of time are kinematic, and the motion of the scene."""
    for name, coordinate in coordinates.by_name.items():
        function = coordinate.prescribed
        if function is None or not coordinates.free(name) or name not in scene.character.joints:
            continue
        scene.actuation[name] = Actuation("kinematic")
        time = np.zeros(1) if function.constant else moments(function, scene.duration)
        scene.motion[name] = Motion([*map(float, time)], [*map(float, function.values(time))])
        scene.initial_state.joints.pop(name, None)


def _excite(model: Model, scene: Scene, notes: Notes) -> None:
    """Muscles and path actuators get the controls that controllers prescribe."""
    for record in model.muscles:
        muscle = scene.character.muscles.get(record.name)
        if muscle is None or record.name not in model.controls or isinstance(muscle.curve_shape, LIGAMENTS):
            continue
        muscle.excitation, cut = excitation_of(model.controls[record.name], scene.duration)
        if cut:
            note(notes, model, record, "its control is cut to be from 0 to 1")


def _hold_weightless(model: Model, scene: Scene, coordinates: Coordinates, notes: Notes) -> None:
    """Hold coordinates that move nothing with mass where they start, since no force has an effect on them."""
    names = [name for name in weightless(scene.character) if name not in scene.actuation]
    for name in names:
        scene.actuation[name] = Actuation("kinematic")
        scene.motion[name] = Motion([0.0], [coordinates.value(name)])
        scene.initial_state.joints.pop(name, None)
    if names:
        some = ", ".join(names[:3]) + (", ..." if len(names) > 3 else "")
        reason = f"nothing that {some} would move has mass: OpenSim finds no accelerations; held where the model starts"
        notes.ignore(model.file, coordinates.by_name[names[0]].line, "Coordinate", reason)


def _settle_drives(scene: Scene) -> None:
    """Joints that neither a muscle crosses nor anything else drives are passive."""
    for name, joint in scene.character.joints.items():
        if joint.type == "fixed" or joint.follows or name in scene.actuation:
            continue
        if usual_drive(name, scene.character) == "torque":
            scene.actuation[name] = Actuation("passive")


def _odd(coordinate: Coordinate, free: bool, moves: bool) -> Iterator[str]:
    """What is to be said of a coordinate that moves nothing, has no range, or starts outside of it."""
    low, high = coordinate.range
    if free and not moves:
        yield "no axis turns or moves with it; it is left out"
    elif low > high:
        yield f"its range runs down from {low:g} to {high:g}; it has no limits"
    elif free and coordinate.prescribed is None and not low - OUTSIDE <= coordinate.value <= high + OUTSIDE:
        yield f"starts at {coordinate.value:g}, outside of its range from {low:g} to {high:g}"


def _markers(model: Model, skeleton: Skeleton, notes: Notes) -> None:
    """Markers on bodies; none stays on a ground that is no body here."""
    for marker in model.markers:
        if on_body(model, marker.frame)[0] == GROUND and skeleton.character.root != "ground":
            notes.ignore(model.file, marker.line, f"Marker {marker.name}", "is on the ground; left out")
            continue
        body, position = skeleton.placement.point(marker.frame, marker.location)
        skeleton.opensim.markers[marker.name] = Marker(body, position)


def _tell_jumps(model: Model, character: Character, jumps: Mapping[str, float], notes: Notes) -> None:
    """Note which paths jump where a point comes in, by so many metres, and why."""
    records = {muscle.name: muscle for muscle in model.muscles}
    for name, jump in jumps.items():
        muscle, record = character.muscles[name], records[name]
        if not is_route(muscle):
            continue
        why = "it wraps around a surface" if muscle.wraps else "it depends on angles of a ball joint"
        reason = f"its path jumps by {1e3 * jump:.0f} mm where a conditional point comes in, as in OpenSim: {why}"
        note(notes, model, record, reason)


def _tell(model: Model, skeleton: Skeleton, coordinates: Coordinates, notes: Notes) -> None:
    """Note what is otherwise than in OpenSim, or than one might think."""
    character = skeleton.character
    if character.root_joint != "fixed" and not any(body.shapes for body in character.bodies.values()):
        reason = 'nothing of it touches the ground, so that it falls; give feet `shapes`, or set root_joint = "fixed"'
        notes.ignore(model.file, model.line, f"Model {model.name}", reason)
    for joint in model.joints:
        if joint.kind == "BallJoint" and joint.coordinates[0].name in skeleton.character.joints:
            reason = "its coordinates are angles about x, the new y and the new z axis, as in OpenSim's files"
            note(notes, model, joint, reason)
    moving = {*character.joints, *skeleton.opensim.root_coordinates}
    moving.update(name for ball in skeleton.opensim.balls.values() for name in ball.names)
    for coordinate in coordinates.by_name.values():
        for reason in _odd(coordinate, coordinates.free(coordinate.name), coordinate.name in moving):
            notes.ignore(model.file, coordinate.line, f"Coordinate {coordinate.name}", reason)
    for coupler in model.couplers:
        if coupler.constant:
            value = coupler.function.at(0.0)
            reason = (
                f"holds {coupler.dependent} at {value:g}; OpenSim 4.6 takes a Constant there otherwise, and holds "
                f"{coupler.independent} instead. A LinearFunction with coefficients 0 {value:g} is the same in both"
            )
            notes.ignore(model.file, coupler.line, f"CoordinateCouplerConstraint {coupler.name}", reason)
    for name, error in coordinates.inexact.items():
        reason = f"a function of a function, taken at 401 places; it is off by {error:.1g} at most"
        notes.ignore(model.file, coordinates.by_name[name].line, f"Coordinate {name}", reason)
