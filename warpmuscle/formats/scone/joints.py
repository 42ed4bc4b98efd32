"""Joints of a model of Hyfydy: hinges about the axes that its limits leave free, and forces at the ends of ranges.

About an axis that a coordinate is named after it turns, too, against the spring of its limits, if these leave no range;
and where the root moves in three dimensions, about every axis whose limits have a spring.

One that turns about several axes is as many hinges, with bodies without mass between them: first about z, which is
flexion in its axes, then x, then y, as OpenSim's hips. Hyfydy has springs and dampers in place of them, about all axes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.placement import WORLD, direction, vector
from warpmuscle.formats.scone.zml import Node
from warpmuscle.scene import Body, Force, Joint, Scene

RANGE = re.compile(r"(?P<low>[^.]*(?:\.\d[^.]*)?)\.\.(?P<high>.*)")
DEGREE = math.pi / 180.0
ORDER = "zxy"  # of the axes of a joint
HERE = (0.0, 0.0, 0.0)


@dataclass
class Coordinate:
    """What a model calls a degree of freedom, and where it is."""

    name: str
    line: int
    owner: str  # body or joint
    kind: str  # r or t
    axis: str  # x, y or z
    sign: float


def put_joints(
    scene: Scene, coordinates: Mapping[str, Coordinate], joints: Mapping[str, Node], bodies: Mapping[str, Node],
    settings: Node, notes: Notes,
) -> None:  # fmt: skip
    """Put the joints of a model into its scene, each after that of its parent.

    Args:
        joints: by their child. settings: `model_options`.

    Raises:
        SceneError: one is not known, with file and line.
    """
    for child in _from_root(joints, bodies):
        node = joints[child]
        node.find("damping")
        if any(node.vector_of("ref_ori")):
            node.fail("a joint between bodies that are turned is not known here")
        limits = node.find("limits")
        ranges = {axis: None if limits is None else limits.find(axis) for axis in ORDER}
        bounds = {axis: None if one is None else read_range(one) for axis, one in ranges.items()}
        above, name = node.need("parent").text(), node.string_of("name") or f"{child}_joint"
        named = {axis: _of(coordinates, name, child, axis) for axis in ORDER}
        spring = [
            node.number_of(key, settings.number_of(f"joint_{key}", 0.0)) for key in ("limit_stiffness", "limit_damping")
        ]
        soft = scene.character.root_joint == "free" and spring[0] > 0.0
        free = [axis for axis, ends in bounds.items() if soft or ends != (0.0, 0.0) or named[axis] is not None]
        near, far = (vector(WORLD @ np.array(node.vector_of(key))) for key in ("pos_in_parent", "pos_in_child"))
        if not free:
            _put(scene, notes, node, name, Joint("fixed", above, child, near, far))
        for axis in free:
            own = named[axis]
            sign = own.sign if own else 1.0
            last = axis == free[-1]
            below = child if last else f"{child}_{axis}"
            if not last:
                scene.character.bodies[below] = Body(0.0, HERE)
            joint = Joint("hinge", above, below, near, far if last else HERE)
            joint.axes = [direction(sign * WORLD @ np.eye(3)["xyz".index(axis)])]
            called = own.name if own else name if len(free) == 1 else f"{name}_{axis}"
            _put(scene, notes, node, called, joint)
            _limit(scene, notes, node, called, bounds[axis], sign, spring)
            above, near = below, HERE
        node.tell_unused()


def read_range(node: Node) -> tuple[float, float]:
    """A value such as -40..120."""
    found = RANGE.fullmatch(node.text())
    if found is None:
        node.fail(f"{node.text()!r} is not a range such as -40..120")
    low, high = node.number_in(found["low"]), node.number_in(found["high"])
    if low > high:
        node.fail(f"runs down from {low:g} to {high:g}")
    return low, high


def _put(scene: Scene, notes: Notes, node: Node, name: str, joint: Joint) -> None:
    scene.character.joints[name] = joint
    notes.places[f"character.joints.{name}"] = (node.file, node.line)


def _of(coordinates: Mapping[str, Coordinate], joint: str, child: str, axis: str) -> Coordinate | None:
    """The coordinate that turns a joint about an axis, if there is one."""
    turns = (one for one in coordinates.values() if (one.kind, one.axis) == ("r", axis))
    return next((one for one in turns if one.owner in (joint, child)), None)


def _limit(
    scene: Scene, notes: Notes, node: Node, name: str, ends: tuple[float, float] | None, sign: float,
    spring: list[float],
) -> None:  # fmt: skip
    """The force of a hinge's limits, if it has any."""
    stiffness, damping = spring
    if ends is None or stiffness == 0.0:
        return
    low, high = sorted(sign * DEGREE * end for end in ends)
    values = {"low": low, "high": high, "stiffness": stiffness, "damping": damping}
    scene.forces[f"{name}_limit"] = Force("range_limit", joint=name, parameters=dict(values))
    notes.places[f"forces.{name}_limit"] = (node.file, node.line)


def _from_root(joints: Mapping[str, Node], bodies: Mapping[str, Node]) -> list[str]:
    """Children of all joints, each after its parent; those that hang in a circle are refused."""
    order: list[str] = []
    for name in bodies:
        chain: list[str] = []
        while name in joints and name not in order:
            if name in chain:
                joints[name].fail("its bodies hang on each other in a circle")
            chain.append(name)
            name = joints[name].need("parent").text()
        order += reversed(chain)
    return order
