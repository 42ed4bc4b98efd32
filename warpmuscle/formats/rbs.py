"""`.rbs` files of the Simbicon Controller Editor Framework: bodies, joints and the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from warpmuscle.core.limits import GREATEST_NUMBER
from warpmuscle.formats.lines import Line, Lines, Notes
from warpmuscle.formats.rbs_blocks import (
    JOINTS,
    MISPLACED,
    OPENINGS,
    UNKNOWN,
    Contents,
    Triple,
    attributes_of,
    triple_of,
)
from warpmuscle.formats.rbs_joints import read_joint
from warpmuscle.scene import Body, Box, Capsule, Character, Ground, InitialState, Joint, Muscle, Shape, Sphere, ViaPoint

# In the order in which a line is compared with them. No other keyword may come before one that it begins with.
KEYWORDS = (
    "RigidBody", "/End", "A_RigidBody", "ArticulatedFigure", "/ArticulatedFigure", "hingeJoint", "universalJoint",
    "ballInSocketJoint", "stiffJoint", "/Joint", "Muscle", "/Muscle", "name", "mesh", "mass", "moi", "colour",
    "CDP_Sphere", "CDP_Capsule", "CDP_Box", "CDP_Plane", "static", "position", "orientation", "velocity",
    "angularVelocity", "frictionCoefficient", "restitutionCoefficient", "ODEGroundParameters", "planar", "root",
    "parent", "child", "jointPPos", "jointCPos", "jointLimits", "actuationType", "maxForce", "optimalLength",
    "slackLength", "delay",
)  # fmt: skip
PROPERTIES = {"maxForce": "f_max", "optimalLength": "l_opt", "slackLength": "l_slack", "delay": "delay"}
GRAPHICS = "graphics are not used"
CONTACTS = "contacts have the numbers of the scene's ground, and bounce by its law soft_constraint only"
CROSSED = "muscles drive all joints that they cross, marked or not (`convert --keyword-rule` obeys the marks)"
DEFAULT_FRICTION = 1.5


@dataclass
class _Block:
    """A body as it stands in the file."""

    opening: Line
    name: str = ""
    mass: float = 1.0
    inertia: Triple = (1.0, 1.0, 1.0)
    shapes: list[Shape] = field(default_factory=list)
    planes: list[tuple[Line, Triple, Triple]] = field(default_factory=list)  # normal, point
    friction: float = DEFAULT_FRICTION
    static: Line | None = None
    planar: Line | None = None
    initial: InitialState = field(default_factory=InitialState)
    initial_lines: list[Line] = field(default_factory=list)
    field_lines: dict[str, Line] = field(default_factory=dict)  # by field of a scene's body


def read(path: str | Path, notes: Notes) -> Contents:
    """Read a character, the ground, or both.

    Joint limits: the file bounds the original's motor angles of a ball joint, which are (-theta1, theta2, -theta3) for
    a child turned by theta1 about swing, theta2 about swing x twist and theta3 about twist; limits in a scene bound
    the thetas. (The original takes the upper limit of theta2 from the first axis by mistake; the one written in the
    file is used here.)

    Args:
        path: the file.
        notes: gets the lines that were ignored, and the place of every key.

    Raises:
        SceneError: with file and line.
    """
    lines = Lines(Path(path), KEYWORDS, notes)
    contents = Contents()
    bodies: dict[str, _Block] = {}
    figure: tuple[Line, str, dict[str, Joint], dict[str, Muscle]] | None = None
    for line in lines:
        if line.keyword == "RigidBody":
            _read_prop(_read_body(line, lines), contents, notes)
        elif line.keyword == "A_RigidBody":
            body = _read_body(line, lines)
            if body.name in bodies:
                raise body.opening.error(f"there are two bodies called {body.name!r}")
            bodies[body.name] = body
        elif line.keyword == "ArticulatedFigure":
            if figure is not None:
                raise line.error("there is more than one ArticulatedFigure; a scene has one character")
            figure = (line, *_read_figure(line, lines, contents))
        else:
            line.ignore(notes, MISPLACED if line.keyword else UNKNOWN)
    if figure is None and bodies:
        raise next(iter(bodies.values())).opening.error("an A_RigidBody needs an ArticulatedFigure, which is missing")
    if figure is not None:
        _assemble(contents, bodies, *figure, notes)
    return contents


def _assemble(
    contents: Contents, bodies: dict[str, _Block], opening: Line, root: str, joints: dict[str, Joint],
    muscles: dict[str, Muscle], notes: Notes,
) -> None:  # fmt: skip
    """Put the character together; what only a root may have is taken from the root."""
    opening.mark(notes, "character")
    for name, body in bodies.items():
        body.opening.mark(notes, f"character.bodies.{name}")
        for key, line in body.field_lines.items():
            line.mark(notes, f"character.bodies.{name}.{key}")
        for line, _, _ in body.planes:
            line.ignore(notes, "only static bodies can be planes")
        if name != root:
            for line in [*body.initial_lines, *filter(None, (body.static, body.planar))]:
                line.ignore(notes, "only the root's counts")
    kind: dict[str, _Block] = {root: bodies[root]} if root in bodies else {}
    root_joint = "fixed" if kind and kind[root].static else "planar" if kind and kind[root].planar else "free"
    contents.initial = kind[root].initial if kind else InitialState()
    contents.character = Character(
        root=root,
        bodies={
            name: Body(body.mass, body.inertia, shapes=body.shapes, friction=body.friction)
            for name, body in bodies.items()
        },
        joints=joints,
        muscles=muscles,
        root_joint=root_joint,  # type: ignore[arg-type]
    )


def _read_body(opening: Line, lines: Lines) -> _Block:
    """Read one body up to `/End`."""
    body, notes = _Block(opening), lines.notes
    for line in attributes_of(opening, "/End", lines):
        match line.keyword:
            case "name":
                body.name = line.word("a name")
            case "mass":
                body.mass = line.quantity("kg", notes)
                body.field_lines["mass"] = line
            case "moi":
                body.inertia = line.triple("principal moments, kg m^2", notes)
                body.field_lines["inertia"] = line
            case "CDP_Sphere" | "CDP_Capsule" | "CDP_Box":
                body.field_lines[f"shapes.{len(body.shapes)}"] = line
                body.shapes.append(_read_shape(line, notes))
            case "CDP_Plane":
                plane = line.numbers(6, "normal and point", notes)
                body.planes.append((line, plane[0:3], plane[3:6]))  # type: ignore[arg-type]
            case "frictionCoefficient":
                body.friction = min(line.quantity("coefficient", notes), GREATEST_NUMBER)  # 1e30: no slip
                body.field_lines["friction"] = line
            case "static":
                body.static = line
            case "planar":
                body.planar = line
            case "position" | "orientation" | "velocity" | "angularVelocity":
                _read_motion(line, body.initial, notes)
                body.initial_lines.append(line)
            case "mesh" | "colour":
                line.ignore(notes, GRAPHICS)
            case "restitutionCoefficient" | "ODEGroundParameters":
                line.ignore(notes, CONTACTS)
            case _:
                line.ignore(notes, MISPLACED)
    if not body.name and opening.keyword == "A_RigidBody":
        raise opening.error("this body has no name")
    return body


def _read_shape(line: Line, notes: Notes) -> Shape:
    """A collision primitive in body coordinates."""
    if line.keyword == "CDP_Sphere":
        *center, radius = line.numbers(4, "centre and radius, m", notes)
        return Sphere(triple_of(center), radius)
    if line.keyword == "CDP_Capsule":
        *ends, radius = line.numbers(7, "two ends and radius, m", notes)
        return Capsule(triple_of(ends[:3]), triple_of(ends[3:]), radius)
    corners = line.numbers(6, "two corners, m", notes)
    low, high = zip(*map(sorted, zip(corners[:3], corners[3:], strict=True)), strict=True)
    return Box(triple_of(low), triple_of(high))


def _read_motion(line: Line, initial: InitialState, notes: Notes) -> None:
    """Initial state of a body in the world."""
    if line.keyword == "position":
        initial.root_position = line.triple("m", notes)
    elif line.keyword == "velocity":
        initial.root_velocity = line.triple("m/s", notes)
    elif line.keyword == "angularVelocity":
        initial.root_angular_velocity = line.triple("rad/s", notes)
    else:
        angle, x, y, z = line.numbers(4, "angle in rad and axis", notes)
        length = math.hypot(x, y, z)
        if length == 0.0:
            raise line.error("the axis has no length")
        s = math.sin(0.5 * angle) / length
        initial.root_orientation = (s * x, s * y, s * z, math.cos(0.5 * angle))


def _read_prop(body: _Block, contents: Contents, notes: Notes) -> None:
    """A body that belongs to no figure: the ground if it is a static plane, else ignored."""
    if body.static is None or not body.planes or contents.ground is not None:
        body.opening.ignore(notes, f"prop {body.name!r}: only one static plane, the ground, is supported")
        return
    line, normal, point = body.planes[0]
    length = math.hypot(*normal)
    if length == 0.0:
        raise line.error("the normal has no length", key="ground.normal")
    height = sum(n * p for n, p in zip(normal, point, strict=True)) / length
    contents.ground = Ground(normal=normal, height=height, friction=body.friction)
    body.opening.mark(notes, "ground")
    line.mark(notes, "ground.normal")
    for extra, _, _ in body.planes[1:]:
        extra.ignore(notes, "there is a ground already")
    if body.shapes:
        body.opening.ignore(notes, "shapes on the ground are not supported")


def _read_figure(opening: Line, lines: Lines, contents: Contents) -> tuple[str, dict[str, Joint], dict[str, Muscle]]:
    """Name of the root, joints and muscles in the order of the file."""
    notes = lines.notes
    root, joints, muscles = "", dict[str, Joint](), dict[str, Muscle]()
    for line in lines.block(opening, "/ArticulatedFigure"):
        if line.keyword == "root":
            root = line.word("a body")
            line.mark(notes, "character.root")
        elif line.keyword in JOINTS:
            name, joint = read_joint(line, lines, contents)
            if name in joints:
                raise line.error(f"there are two joints called {name!r}", key=f"character.joints.{name}")
            joints[name] = joint
        elif line.keyword == "Muscle":
            name, muscle = _read_muscle(line, lines)
            if name in muscles:
                raise line.error(f"there are two muscles called {name!r}", key=f"character.muscles.{name}")
            muscles[name] = muscle
        elif line.keyword in OPENINGS:
            raise line.error(f"`{line.keyword}` within an ArticulatedFigure; is `/ArticulatedFigure` missing?")
        else:
            line.ignore(notes, MISPLACED if line.keyword else UNKNOWN)
    if not root:
        raise opening.error("this ArticulatedFigure has no root")
    return root, joints, muscles


def _read_muscle(opening: Line, lines: Lines) -> tuple[str, Muscle]:
    """Name and muscle up to `/Muscle`."""
    notes = lines.notes
    name, body = "", ""
    path: list[tuple[ViaPoint, Line]] = []
    numbers: dict[str, tuple[float, Line]] = {}
    for line in lines.block(opening, "/Muscle"):
        match line.keyword:
            case "name":
                name = line.word("a name")
            case keyword if keyword in PROPERTIES:
                numbers[PROPERTIES[keyword]] = line.quantity("a value", notes), line
            case "A_RigidBody":
                body = line.word("a body")
            case "position":
                if not body:
                    raise line.error("`position` of a muscle must follow `A_RigidBody <body>`")
                path.append((ViaPoint(body, line.triple("m", notes)), line))
                body = ""
            case "":
                line.ignore(notes, UNKNOWN)
            case keyword if keyword in OPENINGS or keyword.startswith("/"):
                raise line.error(f"`{keyword}` within a Muscle; is `/Muscle` missing?")
            case _:
                line.ignore(notes, MISPLACED)
    if not name:
        raise opening.error("this muscle has no name")
    key = f"character.muscles.{name}"
    for keyword, field_name in PROPERTIES.items():
        if field_name not in numbers and field_name != "delay":
            raise opening.error(f"muscle {name!r} has no {keyword}", key=f"{key}.{field_name}")
    opening.mark(notes, key)
    for field_name, (_, line) in numbers.items():
        line.mark(notes, f"{key}.{field_name}")
    for index, (_, line) in enumerate(path):
        line.mark(notes, f"{key}.path.{index}")
    properties: dict[str, Any] = {field_name: value for field_name, (value, _) in numbers.items()}
    return name, Muscle(path=[point for point, _ in path], **properties)
