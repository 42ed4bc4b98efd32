"""Forces other than muscles, and contact with the ground, from a model's records."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Literal

import numpy as np

from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim import records
from warpmuscle.formats.osim.actions.build import ANGLES, Unfit, bushing_of_texts, checked_text, made_action
from warpmuscle.formats.osim.actions.build import SHIFTS as DELTAS
from warpmuscle.formats.osim.actions.read import CONTROL
from warpmuscle.formats.osim.build_skeleton import Skeleton
from warpmuscle.formats.osim.expressions import NotStraight, straight
from warpmuscle.formats.osim.forces import EXPRESSIONS
from warpmuscle.formats.osim.frames import GROUND, note, on_body, refused, turned
from warpmuscle.formats.osim.functions import ZERO
from warpmuscle.formats.osim.moves import Coordinates
from warpmuscle.formats.osim.placement import rotation_vector, vector, world_axes
from warpmuscle.formats.osim.records import Contact, Model
from warpmuscle.scene import Actuation, ContactMaterial, Force, Ground, Scene, Sphere
from warpmuscle.scene.number import Number
from warpmuscle.scene.validation.paths import usual_drive

RELAXATION = 0.005  # s, damping over stiffness of a range, as of the scene's own joints
DEGREE = math.pi / 180.0
ROOT = "acts on the root, on whose coordinates forces do not act here; it is left out"
NOT_CONTROLLED = "no controller prescribes its control, which is 0 then, as in OpenSim; write one into `expressions`"
LOCKED = "acts on a coordinate that is locked or coupled; it is left out"

EFFORTS, SHIFTS = (
    ("mx", "my", "mz", "fx", "fy", "fz"),
    ("tx", "ty", "tz", "x", "y", "z"),
)  # see `kernels/force/bushing.py`
PLACES = tuple(f"{end}_{part}{axis}" for end in ("first", "second") for part in ("", "turn_") for axis in "xyz")

LEVEL = 1.0e-9  # of a unit normal upwards, up to which a plane bears nothing
LAWS: dict[str, Literal["hunt_crossley", "smooth_hunt_crossley"]] = {
    "HuntCrossleyForce": "hunt_crossley", "SmoothSphereHalfSpaceForce": "smooth_hunt_crossley",
}  # fmt: skip
MATERIAL = {  # tags of `ContactMaterial`'s fields
    **{tag: tag for tag in ContactMaterial.__struct_fields__ if tag != "constant_force"},
    "constant_force": "constant_contact_force",
}


class ForceBuilder:
    """Puts the forces of one model into a scene."""

    def __init__(
        self, model: Model, scene: Scene, skeleton: Skeleton, coordinates: Coordinates, notes: Notes
    ) -> None:  # fmt: skip
        self._model, self._scene, self._skeleton = model, scene, skeleton
        self._coordinates, self._notes = coordinates, notes

    def place(self, key: str, line: int) -> None:
        """Remember that a key of the scene was read from a line."""
        self._notes.places[key] = (self._model.file, line)

    def joint(self, force: records.OsimForce) -> str:
        """The joint whose coordinate a force acts on; empty, with a note, if it cannot act on it."""
        name = force.words["coordinate"]
        if name not in self._coordinates.by_name:
            raise refused(self._model, force.line, f"{force.kind} {force.name!r}: there is no coordinate {name!r}")
        if not self._coordinates.free(name):
            note(self._notes, self._model, force, LOCKED)
            return ""
        if name not in self._scene.character.joints:
            note(self._notes, self._model, force, ROOT)
            return ""
        return name

    def actuator(self, force: records.OsimForce) -> None:
        """A joint that an actuator drives takes torques, besides those of its muscles, or what a controller says."""
        if force.name in self._model.controls:
            self.action(replace(force, functions={CONTROL: (self._model.controls[force.name],)}))
            return
        name = self.joint(force)
        if name and name not in self._scene.actuation:
            crossed = usual_drive(name, self._scene.character) == "muscle"
            self._scene.actuation[name] = Actuation("assisted" if crossed else "torque")

    def limit(self, force: records.OsimForce) -> None:
        """Springs beyond the ends of a range, given in degrees where the coordinate is an angle."""
        name = self.joint(force)
        if not name:
            return
        unit = DEGREE if self.turns(name) else 1.0
        n = {key: value[0] for key, value in force.numbers.items()}
        if not n["transition"] > 0.0:
            message = f"<transition> must be greater than 0, is {n['transition']:g}"
            raise refused(self._model, force.line, f"{force.kind} {force.name!r}: {message}")
        values = {
            "low": n["lower_limit"] * unit, "high": n["upper_limit"] * unit,
            "stiffness_below": n["lower_stiffness"] / unit, "stiffness_above": n["upper_stiffness"] / unit,
            "damping": n["damping"] / unit, "transition": n["transition"] * unit,
        }  # fmt: skip
        self.add(force, Force("coordinate_limit", joint=name, parameters=dict(values)))

    def spring(self, force: records.OsimForce) -> None:
        """A spring and damper along a coordinate."""
        name = self.joint(force)
        if name:
            n = {key: value[0] for key, value in force.numbers.items()}
            values = {"rest": n["rest_length"], "stiffness": n["stiffness"], "damping": n["viscosity"]}
            self.add(force, Force("coordinate_spring", joint=name, parameters=dict(values)))

    def bushing(self, force: records.OsimForce) -> None:
        """Springs and dampers between two frames."""
        (first, place), (second, other_place) = (
            self._skeleton.placement.point(frame, (0.0, 0.0, 0.0)) for frame in force.frames
        )
        if first == second:
            reason = "both of its frames are on one body; it is left out, and holds nothing"
            note(self._notes, self._model, force, reason)
            return
        stiffness = np.zeros((6, 7))
        n = force.numbers
        if force.kind == "BushingForce":
            stiffness[:, 1:] = np.diag([*n["rotational_stiffness"], *n["translational_stiffness"]])
        else:
            try:
                stiffness[:] = [straight(force.words[tag]) for tag in EXPRESSIONS]
            except NotStraight:
                self._curved_bushing(force)
                return
        turns = [rotation_vector(self._skeleton.placement.axes(frame)) for frame in force.frames]
        values = dict(zip(PLACES, (*place, *turns[0], *other_place, *turns[1]), strict=True))
        values |= dict(zip(EFFORTS, stiffness[:, 0], strict=True))
        values |= {f"{a}_{q}": stiffness[i, k] for i, a in enumerate(EFFORTS) for k, q in enumerate(SHIFTS, 1)}
        damping = (*n["rotational_damping"], *n["translational_damping"])
        values |= {f"damping_{q}": number for q, number in zip(SHIFTS, damping, strict=True)}
        plain: dict[str, Number] = {name: float(value) for name, value in values.items()}
        self.add(force, Force("bushing", body=first, other_body=second, parameters=plain))

    def _curved_bushing(self, force: records.OsimForce) -> None:
        """A bushing of expressions that are not straight."""
        try:
            texts = [checked_text(force.words[tag], (*ANGLES, *DELTAS)) for tag in EXPRESSIONS]
            made = bushing_of_texts(force, self._skeleton.placement, texts, {})
        except Unfit as error:
            note(self._notes, self._model, force, str(error))
            lose(self._model, force, force.frames)
            return
        self.add(force, made)

    def action(self, force: records.OsimForce) -> None:
        """A force of functions or expressions, or an actuator with a told control."""
        joint = self.joint(force) if "coordinate" in force.words else ""
        if "coordinate" in force.words and not joint:
            return
        if force.kind.endswith("Actuator") and force.functions[CONTROL] == (ZERO,):
            note(self._notes, self._model, force, NOT_CONTROLLED)
        try:
            made = made_action(force, self._model, self._skeleton.placement, joint)
        except Unfit as error:
            note(self._notes, self._model, force, str(error))
            lose(self._model, force, force.frames)
            return
        self.add(force, made)

    def add(self, force: records.OsimForce, made: Force) -> None:
        """Put a force into the scene under its own name."""
        name = force.name or f"{force.kind}_{force.line}"
        while name in self._scene.forces:
            name += "_"
        self._scene.forces[name] = made
        self._notes.places[f"forces.{name}"] = (self._model.file, force.line)

    def turns(self, name: str) -> bool:
        """Whether OpenSim takes a coordinate as an angle: an axis turns by just as much as it."""
        joint = next(one for one in self._model.joints if any(c.name == name for c in one.coordinates))
        return any(
            axis.coordinates == (name,) and axis.function.line is not None and axis.function.line[1] == 1.0
            for axis in joint.rotations
        )


def build_forces(model: Model, scene: Scene, skeleton: Skeleton, coordinates: Coordinates, notes: Notes) -> None:
    """Put all forces into a scene.

    Raises:
        SceneError: a force acts on a coordinate that is not there.
    """
    builder = ForceBuilder(model, scene, skeleton, coordinates, notes)
    for force in model.forces:
        match force.kind:
            case "CoordinateActuator":
                builder.actuator(force)
            case "CoordinateLimitForce":
                builder.limit(force)
            case "SpringGeneralizedForce":
                builder.spring(force)
            case "HuntCrossleyForce":
                _contact(force, force.words["geometry"].split(), builder, model, scene, skeleton, notes)
            case "SmoothSphereHalfSpaceForce":
                names = [force.words["sphere"], force.words["half_space"]]
                _contact(force, names, builder, model, scene, skeleton, notes)
            case "BushingForce" | "ExpressionBasedBushingForce":
                builder.bushing(force)
            case _:
                builder.action(force)


def _contact(
    force: records.OsimForce, names: list[str], builder: ForceBuilder, model: Model, scene: Scene, skeleton: Skeleton,
    notes: Notes,
) -> None:  # fmt: skip
    """Spheres on bodies that touch the ground, which a half-space of the model gives its place."""
    unknown = [name for name in names if name not in model.contacts]
    strange = [name for name in unknown if name in model.lost_shapes]
    if strange:
        note(notes, model, force, f"shape {strange[0]!r} is of a class that is not known; left out")
        others = frozenset[str]().union(*(model.lost_shapes[name] for name in strange))
        lose(model, force, [model.contacts[name].frame for name in names if name not in unknown], others)
        return
    if unknown:
        raise refused(model, force.line, f"{force.kind} {force.name!r}: there is no shape {unknown[0]!r}")
    shapes = [model.contacts[name] for name in names]
    ground = _floor(force, shapes, model, notes)
    if ground is None:
        lose(model, force, [one.frame for one in shapes])
        return
    ground.law = LAWS[force.kind]
    if scene.ground not in (Ground(), ground):
        note(notes, model, force, "there is another ground, or law of contact, already; left out")
        return
    scene.ground = ground
    material = ContactMaterial(
        **{field: force.numbers[tag][0] for field, tag in MATERIAL.items() if tag in force.numbers}
    )
    for shape in shapes:
        if shape.kind != "ContactSphere":
            continue
        name, center = skeleton.placement.point(shape.frame, shape.location)
        if on_body(model, shape.frame)[0] == GROUND:
            note(notes, model, force, f"sphere {shape.name!r} is fixed to the ground itself; left out")
            continue
        body = scene.character.bodies[name]
        sphere = Sphere(center, shape.radius, material)
        if sphere not in body.shapes:
            builder.place(f"character.bodies.{name}.shapes.{len(body.shapes)}", shape.line)
            body.shapes = [*body.shapes, sphere]


def _floor(force: records.OsimForce, shapes: list[Contact], model: Model, notes: Notes) -> Ground | None:
    """The plane among the shapes of a contact; None, with a note, where none bears anything."""
    planes = [one for one in shapes if one.kind == "ContactHalfSpace"]
    if len(planes) != 1 or on_body(model, planes[0].frame)[0] != GROUND:
        reason = "only spheres touch a half-space, and that only if it is fixed to the ground; left out"
        note(notes, model, force, reason)
        return None
    ground = _ground(model, planes[0])
    if any(model.gravity) and ground.normal[1] <= LEVEL:  # type: ignore[operator]
        note(notes, model, force, f"half-space {planes[0].name!r} is a wall or a ceiling beside gravity; left out")
        return None
    return ground


def _ground(model: Model, half_space: Contact) -> Ground:
    """The plane of a half-space, whose matter is where x > 0 in its own axes."""
    _, rotation, origin = on_body(model, half_space.frame)
    world = world_axes(model.gravity)
    normal = -world @ rotation @ turned(half_space.orientation) @ np.array([1.0, 0.0, 0.0])
    place = world @ (origin + rotation @ np.array(half_space.location))
    height = float(normal @ place)
    rounded = vector(np.where(np.abs(normal) < 1e-12, 0.0, normal))
    return Ground(normal=rounded, height=0.0 if abs(height) < 1e-15 else height)


def lose(model: Model, force: records.OsimForce, frames: Iterable[str], others: frozenset[str] = frozenset()) -> None:
    """Remember that a force is left out, with the names of the bodies that it holds, see `tree.tell_loose`."""
    bodies = {on_body(model, frame)[0].rpartition("/")[2] for frame in frames}
    model.lost.append(records.Lost(force.kind, others | bodies))


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
        which = (
            f"the range of {some}"
            if len(names) == 1
            else f"the ranges of {number_of(len(names), 'coordinate')} ({some})"
        )
        reason = (
            f"as in OpenSim, {which} push{'es' if len(names) == 1 else ''} with no force, so that a free run leaves "
            f"{'it' if len(names) == 1 else 'them'}; --limit-stiffness 500 (N m/rad) pushes back"
        )
        notes.ignore(model.file, model.line, f"Model {model.name}", reason)
