"""A model file as records, and notes of all that is in it and is not used."""

from __future__ import annotations

import re
from pathlib import Path

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import readable
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.actions.controls import PRESCRIBED, read_controls
from warpmuscle.formats.osim.actions.read import READERS, taken
from warpmuscle.formats.osim.elements import Element, parse
from warpmuscle.formats.osim.forces import NUMBERS, lost_force, read_contact, read_force, read_marker, words_of
from warpmuscle.formats.osim.frames import FRAMES, Frames
from warpmuscle.formats.osim.loops.read import TYPES, read_loop
from warpmuscle.formats.osim.mesh_files import read_all
from warpmuscle.formats.osim.muscles.stand_ins import STOOD_FOR, stand_in
from warpmuscle.formats.osim.paths import CLASSES, read_muscle, read_surfaces
from warpmuscle.formats.osim.properties import Properties
from warpmuscle.formats.osim.records import Model
from warpmuscle.formats.osim.skeleton import read_bodies, read_constraint, read_joint
from warpmuscle.formats.osim.upgrade import rename_duplicates, upgraded
from warpmuscle.formats.osim.wraps.shortest import KINDS, MIXED, TAG, read_shortest, settle_mixed

NEWEST = 49999  # version of the format: later ones may mean other things by the same words
OLDEST = 10500  # of files that do not say it
LABELS = ("publications", "groups", "authors", "references", "assembly_accuracy", "comment", "inactive",
    "isInlined", "ObjectGroup")  # fmt: skip
GEOMETRY = ("FrameGeometry", "attached_geometry", "Appearance", "VisibleObject", "geometry", "display", "default_color",
    "ModelVisualPreferences", "display_preference", "preferences", "color", "GeometrySet")  # fmt: skip
DRAWN = "not read; bodies are drawn by their meshes, or by their joints, shapes and muscles"
REASONS = {
    **dict.fromkeys(GEOMETRY, DRAWN),
    "ProbeSet": "not read; the metabolic power is that of the scene's objective",
    "Umberger2010MuscleMetabolicsProbe": "not read; the metabolic power is that of the scene's objective",
    "AnalysisSet": "not read; it analyses motions in OpenSim",
    "ComponentSet": "not read; components of this class are not known",
    "components": "not read; components of this class are not known",
}
UNKNOWN = "not known here, and not used"
NO_FORCE = "forces of this class are not known; it is left out, and pulls on nothing"
NO_MUSCLE = (
    "muscles of this class are not known; make it a Millard2012EquilibriumMuscle or a Thelen2003Muscle; "
    "it is left out, and pulls on nothing"
)
NO_CONTROLLER = "only a PrescribedController is known; what it controls gets its excitation from the scene"
SWITCHED_OFF = "switched off in the model, and left out"

# A UnilateralConstraint's conditions are false until a program sets them (RollingOnSurfaceConstraint.cpp).
ROLLING = "OpenSim itself begins with it switched off, whatever the file says; so the bodies move without it"


def read(path: Path, notes: Notes) -> Model:
    """Read a model.

    Args:
        notes: gets what was not used, each with its line and what follows from leaving it out.

    Raises:
        SceneError: it is no model, or cannot be represented; with file and line.
    """
    document = parse(path)
    version = _version(document)
    top = document if document.tag == "Model" else document.child("Model")
    if top is None:
        document.fail("there is no <Model> in it; a model as OpenSim saves it is needed")
    top.used = True
    upgraded(top, version)
    rename_duplicates(top, notes)
    found = Model(path, top.name or readable(path.stem), top.line, version)
    found.credits = " ".join(own_text.words()) if (own_text := top.child("credits")) is not None else ""
    defaults = top.child("defaults")
    own = Properties(defaults)
    for element in defaults.all() if defaults is not None else ():
        element.used = True  # by those that have nothing else to say
    _check_units(top)
    found.gravity = own.vector(top, "gravity", found.gravity)
    found.gravity_line = gravity.line if (gravity := own.find(top, "gravity")) is not None else top.line
    frames = Frames(found)
    _skeleton(top, found, frames, own, notes)
    _forces(top, found, frames, own, notes)
    for element in _members(top, "ContactGeometrySet"):
        if element.tag in ("ContactSphere", "ContactHalfSpace"):
            read_contact(element, found, frames, own)
        elif element.tag in KINDS and element.name in found.obstacles:
            found.lost_shapes[element.name] = frozenset(words_of(element))
            _read(element)
        else:
            found.lost_shapes[element.name] = frozenset(words_of(element))
            _leave_out(notes, element, "shapes of this class are not known; it touches nothing")
    found.markers = [read_marker(element, frames, own) for element in _members(top, "MarkerSet")]
    _left_over(document, notes)
    return found


def _version(document: Element) -> int:
    """The version of the format, from 10500 for the first to 40600 and on."""
    if document.tag == "Model":
        return OLDEST
    if document.tag != "OpenSimDocument":
        document.fail("a file of OpenSim begins with <OpenSimDocument>")
    if not re.fullmatch(r"\d{5,6}", document.name, re.ASCII):
        document.fail(f"its version is a number such as 40000, not {document.name!r}")
    version = int(document.name)
    if version > NEWEST:
        document.fail(f"version {version} is newer than those known here, up to {NEWEST}")
    return version


def _check_units(top: Element) -> None:
    for tag, units in (
        ("length_units", ("meters", "meter", "metres", "metre", "m")), ("force_units", ("newtons", "newton", "n")),
    ):  # fmt: skip
        found = top.child(tag)
        if found is not None and found.word().lower() not in (*units, "", "unassigned"):
            said = f"lengths must be in metres and forces in newtons, not in {found.word()}"
            found.fail(f"{said}; if the numbers are (OpenSim takes them so), write {units[0]} here")


def _members(top: Element, tag: str) -> list[Element]:
    found = top.child(tag)
    return found.objects() if found is not None else []


def _skeleton(top: Element, found: Model, frames: Frames, own: Properties, notes: Notes) -> None:
    """Frames before joints, which hang on them, and surfaces, which are fixed to them."""
    bodies, ground = top.child("BodySet"), top.child("Ground")
    read_bodies(bodies, ground, found, frames, own)
    joints = _members(top, "JointSet")
    for element in joints:
        frames.add_owned(f"/jointset/{element.name}", element)
    for force in _members(top, "ForceSet"):
        frames.add_owned(f"/forceset/{force.name}", force)
    for constraint in _members(top, "ConstraintSet"):
        if own.applied(constraint):
            frames.add_owned(f"/constraintset/{constraint.name}", constraint)
    for component in _members(top, "ComponentSet"):
        if component.tag in (*FRAMES, "Station"):
            frames.add_component(f"/componentset/{component.name}", component)
        else:
            component.used = False
    frames.add_owned("", top)
    for marker in _members(top, "MarkerSet"):
        frames.add_station(f"/markerset/{marker.name}", marker)
    frames.connect()
    holders = [(f"/bodyset/{body.name}", body) for body in _members(top, "BodySet")]
    taken: dict[str, int] = {}
    for path, holder in (*((("/ground", ground),) if ground is not None else ()), *holders, *frames.offsets):
        read_surfaces(holder, path, found, own, taken, notes)
    read_all([*holders, *((("/ground", ground),) if ground is not None else ())], frames, found, own)
    names: dict[str, int] = {}
    for element in joints:
        joint = read_joint(element, found, frames, own)
        if joint.name in names:
            element.fail(f"there is a joint of this name already, in line {names[joint.name]}")
        names[joint.name] = element.line
        found.joints.append(joint)
    for element in _members(top, "ConstraintSet"):
        if element.tag in TYPES and own.applied(element):
            found.loops.append(read_loop(element, found, frames, own))
        elif element.tag == "RollingOnSurfaceConstraint" and own.applied(element):
            _leave_out(notes, element, ROLLING)
        elif (coupler := read_constraint(element, own)) is not None:
            found.couplers.append(coupler)


def _forces(top: Element, found: Model, frames: Frames, own: Properties, notes: Notes) -> None:
    """Muscles and forces; what is switched off or not known is noted."""
    names: dict[str, int] = {}
    _controls(top, found, own, notes)
    solids = {shape.name: shape for shape in _members(top, "ContactGeometrySet")}
    shapes = {name: words_of(shape) for name, shape in solids.items()}
    for element in _members(top, "ForceSet"):
        if not own.applied(element):
            _leave_out(notes, element, SWITCHED_OFF)
            continue
        old = None
        if element.tag in STOOD_FOR:
            text = f"{element.tag} {element.name}"
            note, old = stand_in(element, own)
            notes.ignore(element.file, element.line, text, note)
        if element.tag in CLASSES:
            if element.name in names or not element.name:
                element.fail("a muscle needs a name that no other one has")
            route = None
            if (path := own.find(element, TAG)) is not None:
                made = read_shortest(path, element.name, solids, found, frames, own)
                if isinstance(made, str):
                    _leave_out(notes, element, made)
                    continue
                route = made
            names[element.name] = element.line
            found.muscles.append(read_muscle(element, frames, own, old, route))
        elif element.tag in NUMBERS:
            found.forces += read_force(element, frames, own)
        elif element.tag in READERS:
            action = taken(element, frames, own, found.controls.get(element.name))
            if isinstance(action, str):
                found.lost.append(lost_force(element, shapes))
                _leave_out(notes, element, action)
            else:
                found.forces.append(action)
        else:
            if "Muscle" not in element.tag:
                found.lost.append(lost_force(element, shapes))
            _leave_out(notes, element, NO_MUSCLE if "Muscle" in element.tag else NO_FORCE)
    for kind, name, line in settle_mixed(found):
        notes.ignore(found.file, line, f"{kind} {name}", MIXED)


def _controls(top: Element, found: Model, own: Properties, notes: Notes) -> None:
    """What controllers prescribe; others are noted."""
    actuators = [element.name for element in _members(top, "ForceSet")]
    for controller in _members(top, "ControllerSet"):
        if controller.tag == PRESCRIBED and own.truth(controller, "enabled", True):
            try:
                found.controls |= read_controls([controller], actuators)
            except SceneError as error:
                _leave_out(notes, controller, f"{error.message}; what it controls gets no excitation from it")
        elif not own.truth(controller, "enabled", True):
            _leave_out(notes, controller, SWITCHED_OFF)
        else:
            _leave_out(notes, controller, NO_CONTROLLER)


def _leave_out(notes: Notes, element: Element, reason: str) -> None:
    """Note that an element is left out, with all that is in it."""
    notes.ignore(element.file, element.line, f"{element.tag} {element.name}".strip(), reason)
    _read(element)


def _read(element: Element) -> None:
    """Take all that is in an element as used."""
    for inner in element.all():
        inner.used = True


def _left_over(document: Element, notes: Notes) -> None:
    """One note for each kind of what nobody has asked for, with the line of the first one."""
    found: dict[str, list[Element]] = {}
    rest: list[Element] = [document]
    while rest:
        for child in reversed(rest.pop().children):
            if child.used:
                rest.append(child)
            elif child.tag not in LABELS and not _says_nothing(child):
                found.setdefault(child.tag, []).append(child)
    for tag, elements in found.items():
        first = min(elements, key=lambda one: one.line)
        notes.ignore(first.file, first.line, f"{tag} {first.name}".strip(), REASONS.get(tag, UNKNOWN))


def _says_nothing(element: Element) -> bool:
    """Whether an element is empty, or a set without members."""
    if not element.children:
        return not element.text.strip()
    return all(one.tag in ("objects", "groups") and not one.children for one in element.children)
