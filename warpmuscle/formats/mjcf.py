"""Writes a scene's character as MuJoCo XML (MJCF), for viewers, other simulators and as an oracle in tests.

The world is MuJoCo's: z up, x forward, y left; `up="y"` keeps our own axes. A MuJoCo body frame is our body frame:
origin at the centre of mass, and the same axes, y up in the reference pose. Joints keep their names; a universal joint
becomes the hinges `<name>_b` and `<name>_a`, the root joint `<root>_free`, or `<root>_y`, `<root>_z` and `<root>_turn`
for a planar root. Bodies without mass are left out: the joints in a row through them are all of the body at its end.
Coupled joints become hinges and slides with equalities, see `mujoco/coupled.py`. Geoms collide with the ground only.
Controller and ground stiffness are not written. The keyframe `start` is the initial state; in MuJoCo's reference
configuration (qpos0) the root has its initial pose and all joints are in the reference pose.

A muscle becomes a spatial tendon of its name through the sites `<muscle>_0`, `<muscle>_1`, ... at its via points;
conditional ones, which MuJoCo does not know, are left out. Cylinders and spheres that it wraps around become geoms (see
`mjcf_wraps.py`). A path actuator becomes a motor on its tendon, and a straight ligament the tendon's spring. A muscle
that acts on the character also becomes a muscle actuator, whose control is its excitation: MuJoCo's own law with our
maximum force and speed, time constants, and fibre and tendon lengths. MuJoCo's curves are those of the type `mujoco`,
its tendon is rigid and its fibre has no pennation. Delays and excitations of their own are not written.

Shapes and bones have the colours of the viewer; bones are capsules that touch nothing. The default camera looks from
the right, and `side` goes along.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Literal, NamedTuple
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.core.files import replace_file
from warpmuscle.core.plain_text import xml_text
from warpmuscle.core.pose import conjugate, multiply, normalized, rotate, turned_to_heading
from warpmuscle.formats.mjcf_looks import BONE, SHORTEST_BONE, add_camera, add_defaults, add_looks, look_of
from warpmuscle.formats.mjcf_muscles import add_muscles
from warpmuscle.formats.mjcf_text import numbers, text, texts
from warpmuscle.formats.mujoco.coupled import add_equalities, motions_of, values_of
from warpmuscle.model.build import start_of
from warpmuscle.scene import Body, Capsule, Character, Ground, InitialState, Joint, Scene, Shape, Sphere
from warpmuscle.scene.anatomy import bone_lines
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.masses import massless
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import topology

Up = Literal["y", "z"]
_ROLLING = (0.005, 0.0001)  # MuJoCo's defaults of torsional and rolling friction, not used by condim 3


def write(scene: Scene, path: str | Path, limits: bool = False, up: Up = "z") -> None:
    """Write the scene's character to an MJCF file; see `dumps`.

    Raises:
        SceneError: the file cannot be written, or a number follows a parameter that is none.
    """
    replace_file(Path(path), dumps(scene, limits, up))


def dumps(scene: Scene, limits: bool = False, up: Up = "z") -> str:
    """The scene's character as MJCF text, in SI units and radians.

    Args:
        scene: checked scene; free parameters count with their start values.
        limits: also write joint limits: of a ball joint, for which MuJoCo knows only a cone, the widest of its angles.
        up: which axis of the world is the vertical.

    Raises:
        SceneError: a number follows a parameter that is none.
    """
    scene = at_start(scene)
    if scene.ground.terrain is not None:
        raise SceneError("MJCF files have the plane of the ground alone; leave terrain out", "ground.terrain")
    if scene.ground.treadmill is not None:
        raise SceneError("MJCF files have ground that stands still; leave the treadmill out", "ground.treadmill")
    if scene.water is not None:
        raise SceneError("MJCF files are written without water; leave it out", "water")
    if scene.objects:
        raise SceneError("MJCF files are written without objects; leave them out", "objects")
    model = Element("mujoco", model=scene.name)
    SubElement(model, "compiler", angle="radian", autolimits="true")
    world_of = _WORLDS[up]
    gravity = world_of.place((0.0, -plain_number(scene.gravity), 0.0))
    SubElement(model, "option", timestep=text(scene.time_step), integrator="implicitfast", gravity=texts(gravity))
    defaults = SubElement(model, "default")
    SubElement(defaults, "geom", contype="1", conaffinity="2", condim="3", priority="1")
    add_defaults(defaults)
    add_looks(model, scene, up)
    world = SubElement(model, "worldbody")
    light, down = world_of.place((0.0, 4.0, 2.0)), world_of.place((0.0, -1.0, -0.5))
    SubElement(world, "light", directional="true", pos=texts(light), dir=texts(down))
    _add_ground(world, scene.ground, world_of)
    root = _add_body(world, scene, scene.character.root, limits)
    _place_root(root, scene.character, scene.initial_state, world_of)
    add_camera(root, conjugate(_root_orientation(scene.initial_state)))
    muscles = add_muscles(model, scene)
    add_equalities(model, scene.character)
    qpos, qvel = _start(scene, world_of)
    key = SubElement(SubElement(model, "keyframe"), "key", name="start", qpos=texts(qpos), qvel=texts(qvel))
    if muscles:
        key.set("act", texts([plain_number(scene.muscle_model.initial_activation)] * muscles))
    ElementTree.indent(model)
    return xml_text(ElementTree.tostring(model, encoding="unicode")) + "\n"


class _World(NamedTuple):
    """How a vector and an orientation of our world are written."""

    axes: tuple[int, int, int]  # which of ours are the new x, y, z
    turn: tuple[float, float, float, float]  # quaternion xyzw

    def place(self, vector: Iterable[float]) -> tuple[float, ...]:
        components = tuple(vector)
        return tuple(components[axis] for axis in self.axes)

    def orientation(self, quaternion: Iterable[float]) -> tuple[float, ...]:
        return tuple(multiply(self.turn, tuple(quaternion)).tolist())


_WORLDS = {"y": _World((0, 1, 2), (0.0, 0.0, 0.0, 1.0)), "z": _World((2, 0, 1), (0.5, 0.5, 0.5, 0.5))}


def _add_ground(world: Element, ground: Ground, world_of: _World) -> None:
    """A plane whose z axis is the ground's normal. The friction of a contact is written with the body's geom."""
    normal = world_of.place(numbers(ground.normal))
    height = plain_number(ground.height) / math.hypot(*normal)
    attributes = {"contype": "2", "conaffinity": "1", "priority": "0"}
    position = texts(height * component for component in normal)
    plane = {"type": "plane", "size": "0 0 1", "material": "ground"}
    SubElement(world, "geom", attributes | plane, name="ground", pos=position, zaxis=texts(normal))


def _add_body(parent: Element, scene: Scene, name: str, limits: bool) -> Element:
    """Append a body with inertia, shapes and all that hangs on it; its place and joints are left to the caller."""
    body = scene.character.bodies[name]
    element = SubElement(parent, "body", name=name)
    if not massless(body):
        inertia, (x, y, z, w) = texts(numbers(body.inertia)), numbers(body.inertia_axes)
        inertial = SubElement(element, "inertial", pos="0 0 0", mass=text(plain_number(body.mass)), diaginertia=inertia)
        if (x, y, z) != (0.0, 0.0, 0.0):
            inertial.set("quat", texts((w, x, y, z)))
    look = look_of(scene, name)
    for shape in body.shapes:
        geom = SubElement(element, "geom", _shape(shape), friction=texts(_friction(body, scene.ground)), rgba=look)
        if massless(body):
            geom.set("mass", "0")
    for line in bone_lines(scene.character, name):
        if np.linalg.norm(line[1] - line[0]) > SHORTEST_BONE:
            SubElement(element, "geom", {"class": BONE}, fromto=texts(line.ravel().tolist()))
    for joint_name, joint in scene.character.joints.items():
        if joint.parent == name:
            chain = _chain(joint_name, scene.character)
            child = _add_body(element, scene, scene.character.joints[chain[-1]].child, limits)
            _place_child(child, {link: scene.character.joints[link] for link in chain}, limits)
    return element


def _chain(joint: str, character: Character) -> list[str]:
    """A joint and those beyond it as far as nothing that has mass or shapes is between them: one body of MuJoCo's.

    A body without mass that is held fast is one of its own.

    Raises:
        SceneError: something without mass moves that no chain can stand for.
    """
    chain = [joint]
    while massless(character.bodies[character.joints[chain[-1]].child]):
        if not any(joint_type(one).moves or one.follows for one in (character.joints[link] for link in chain)):
            break
        child = character.joints[chain[-1]].child
        beyond = [name for name, other in character.joints.items() if other.parent == child]
        if len(beyond) == 1 and not character.bodies[child].shapes:
            chain += beyond
        else:
            message = "MuJoCo takes a moving body without mass only with one joint on it and no shapes; give it mass"
            raise SceneError(message, key=f"character.bodies.{child}.mass")
    return chain


def _place_root(element: Element, character: Character, initial: InitialState, world_of: _World) -> None:
    """Give the root its initial pose and the joints between it and the world."""
    position = numbers(initial.root_position)
    element.set("pos", texts(world_of.place(position)))
    root = root_type(character)
    for place, (suffix, kind, axis) in enumerate(root.mujoco):
        joint = Element("freejoint" if kind == "free" else "joint", name=character.root + suffix)
        if kind != "free":
            joint.set("type", kind)
            joint.set("axis", " ".join("1" if k == axis else "0" for k in range(3)))
            joint.set("ref", text(position[axis] if kind == "slide" else 0.0))
        element.insert(place, joint)
    if root.placed or world_of.axes != (0, 1, 2):
        qx, qy, qz, qw = world_of.orientation(_root_orientation(initial) if root.placed else (0.0, 0.0, 0.0, 1.0))
        element.set("quat", texts((qw, qx, qy, qz)))


def _root_orientation(initial: InitialState) -> tuple[float, ...]:
    """Initial orientation xyzw of the root, turned about the vertical to the initial heading if there is one."""
    orientation = normalized(numbers(initial.root_orientation))
    if initial.heading is not None:
        orientation = multiply(turned_to_heading(orientation, plain_number(initial.heading)), orientation)
    return tuple(orientation.tolist())


def _start(scene: Scene, world_of: _World) -> tuple[list[float], list[float]]:
    """MuJoCo's qpos and qvel of the initial state: joints depth first, as the bodies are nested."""
    names = topology(scene.character)
    start, root = start_of(scene, names), root_type(scene.character)
    qpos: list[float] = []
    qvel: list[float] = []

    def visit(body: int) -> None:
        q = start.coordinates[0, names.joint_coordinates(body)].tolist()
        v = start.speeds[0, slice(*names.speed_start[body : body + 2])].tolist()
        if body > 0:
            name = names.joints[body - 1]
            joint, kind = scene.character.joints[name], joint_type(scene.character.joints[name])
            q, v = [q[k] for k in kind.mujoco_coordinates], [v[k] for k in kind.mujoco_speeds]
            if kind.displaced:
                at, speed = names.coordinates_of(body), names.speeds_of(body)
                q, v = values_of(joint, name, start.coordinates[0, at], start.speeds[0, speed])
        elif not v:
            q = []
        elif root.placed:
            turned = rotate(conjugate(q[3:]), v[3:]).tolist()  # MuJoCo turns a free body about its own axes
            x, y, z, w = world_of.orientation(q[3:])
            q, v = [*world_of.place(q[:3]), w, x, y, z], [*world_of.place(v[:3]), *turned]
        qpos.extend(q)
        qvel.extend(v)
        for child in range(names.first_child[body], names.first_child[body] + names.child_count[body]):
            visit(child)

    visit(0)
    return qpos, qvel


def _place_child(element: Element, chain: dict[str, Joint], limits: bool) -> None:
    """Give a child body its place in the parent's frame and the MuJoCo joints that stand for a chain of ours.

    In the reference pose all axes are parallel. A joint's place is summed up from the child's centre of mass.
    """
    motions: list[Element] = []
    place: tuple[float, ...] = (0.0, 0.0, 0.0)
    for name, joint in reversed(chain.items()):
        place = tuple(a + b for a, b in zip(place, numbers(joint.position_in_child), strict=True))
        motions = [*_motions(name, joint, place, limits), *motions]
        place = tuple(a - b for a, b in zip(place, numbers(joint.position_in_parent), strict=True))
    element.set("pos", texts(0.0 - coordinate for coordinate in place))
    for index, motion in enumerate(motions):
        element.insert(index, motion)


def _motions(name: str, joint: Joint, place: tuple[float, ...], limits: bool) -> Iterator[Element]:
    """The MuJoCo joints that stand for one of ours; the first one is the outermost, whose axis rides on the parent."""
    entry = joint_type(joint)
    if entry.displaced and not joint.beside:
        yield from motions_of(name, joint, place, limits)
        return
    if (entry.moves or entry.by_coordinate) and not entry.mujoco:
        message = f"MuJoCo has no {joint.type} joint, so that this scene cannot be written for it"
        raise SceneError(message, key=f"character.joints.{name}.type")
    for suffix, kind, index in entry.mujoco:
        motion = Element("joint", name=name + suffix, type=kind)
        motion.set("pos", texts(place))
        if kind != "ball":
            motion.set("axis", texts(numbers(joint.axes[index])))
        if limits and joint.limits:
            motion.set("range", texts(_range(joint, kind, index)))
        for field in ("armature", "damping"):
            if (resistance := plain_number(getattr(joint, field))) != 0.0:
                motion.set(field, text(resistance))
        yield motion


def _range(joint: Joint, kind: str, index: int) -> tuple[float, ...]:
    """Limits of MuJoCo's hinge, or the cone of its ball joint, rad."""
    if kind == "ball":
        return 0.0, max(abs(angle) for pair in joint.limits for angle in numbers(pair))
    return numbers(joint.limits[index])


def _shape(shape: Shape) -> dict[str, str]:
    """Attributes of the geom for a collision shape."""
    if isinstance(shape, Sphere):
        return {"type": "sphere", "pos": texts(numbers(shape.center)), "size": text(plain_number(shape.radius))}
    if isinstance(shape, Capsule):
        ends = (*numbers(shape.start), *numbers(shape.end))
        return {"type": "capsule", "fromto": texts(ends), "size": text(plain_number(shape.radius))}
    corners = list(zip(numbers(shape.low), numbers(shape.high), strict=True))
    center, half = ((low + high) / 2.0 for low, high in corners), ((high - low) / 2.0 for low, high in corners)
    return {"type": "box", "pos": texts(center), "size": texts(half)}


def _friction(body: Body, ground: Ground) -> tuple[float, ...]:
    """Friction of a geom: the smaller one of body and ground decides, and the geom's priority over the ground's."""
    return (min(plain_number(body.friction), plain_number(ground.friction)), *_ROLLING)
