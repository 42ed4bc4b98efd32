"""How a SCONE scenario starts: values and speeds of coordinates, offsets to them, and the load on the ground."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import about, multiply, rotate
from warpmuscle.formats.lines import NUMBER, Notes, read_text
from warpmuscle.formats.osim.build_skeleton import state_at
from warpmuscle.formats.osim.placement import WORLD, vector
from warpmuscle.formats.scone.joints import Coordinate
from warpmuscle.formats.scone.zml import parse
from warpmuscle.scene import InitialState, Scene, Sphere
from warpmuscle.scene.initial_pose import plain_number, plain_vector, world_poses
from warpmuscle.scene.parameters import at_start

LIFT_STEPS = 60  # of a bisection, of 2 m


class Start(NamedTuple):
    """Values and speeds of coordinates, rad or m and per s, and activations of muscles where there are any."""

    values: dict[str, float]
    speeds: dict[str, float]
    activations: dict[str, float]


def read_states(path: Path, notes: Notes) -> Start:
    """The start that a .zml gives, or the first row of a .sto.

    Raises:
        SceneError: it cannot be read; with file and line.
    """
    if path.suffix.lower() != ".sto":
        top = parse(path, notes)
        groups = [top.find("values"), top.find("velocities"), top.find("activations")]
        if groups[0] is None:
            raise SceneError("there are no `values` in it", file=path)
        return Start(*({one.key: one.number() for one in group.children} if group else {} for group in groups))
    lines = read_text(path).splitlines()
    end = next((k for k, line in enumerate(lines) if line.strip() == "endheader"), None)
    if end is None or len(lines) < end + 3:
        raise SceneError("there is no `endheader` with names and a row after it", file=path)
    degrees = any(line.replace(" ", "").lower() == "indegrees=yes" for line in lines[:end])
    names, words = lines[end + 1].split(), lines[end + 2].split()
    if len(words) < len(names):
        given, wanted = number_of(len(words), "number"), number_of(len(names), "name")
        raise SceneError(f"a row has {given} for {wanted}", file=path, line=end + 3)
    row: dict[str, float] = {}
    for name, word in zip(names, words, strict=False):
        value = float(word) if NUMBER.fullmatch(word) else math.nan
        if not math.isfinite(value):
            raise SceneError(f"{name}: {word!r} is not a finite number", file=path, line=end + 3)
        row[name] = math.radians(value) if degrees and "_t" not in name[-4:] and "." not in name else value
    speeds = {name[:-2]: value for name, value in row.items() if name.endswith("_u")}
    ending = ".activation"
    return Start(row, speeds, {n.removesuffix(ending): value for n, value in row.items() if n.endswith(ending)})


def matches(name: str, patterns: str) -> bool:
    """Whether a name is one of some patterns with * and ?, which semicolons separate."""
    return any(fnmatchcase(name, pattern.strip()) for pattern in patterns.split(";") if pattern.strip())


def put_start(
    scene: Scene, coordinates: Mapping[str, Coordinate], values: Mapping[str, float], speeds: Mapping[str, float]
) -> None:
    """Let a scene start from values and speeds of its coordinates; others start at rest at 0."""
    character = scene.character
    initial = InitialState()
    place, velocity, spin = np.zeros(3), np.zeros(3), np.zeros(3)
    turn = np.array([0.0, 0.0, 0.0, 1.0])
    for name, one in coordinates.items():
        value, speed = values.get(name, 0.0), speeds.get(name, 0.0)
        if name in character.joints:
            if value != 0.0 or speed != 0.0:
                initial.joints[name] = state_at(character.joints[name], value, speed)
        elif one.owner == character.root:
            axis = one.sign * WORLD @ np.eye(3)["xyz".index(one.axis)]
            if one.kind == "r":
                spin = spin + rotate(turn, axis) * speed
                turn = np.asarray(multiply(turn, about(axis, value)))  # body-fixed, in the order of the coordinates
            else:
                place, velocity = place + axis * value, velocity + axis * speed
    x, y, z, w = (float(number) for number in turn)
    initial.root_orientation = (x, y, z, w)
    initial.root_position, initial.root_velocity = vector(place), vector(velocity)
    initial.root_angular_velocity = vector(spin)
    scene.initial_state = initial


def put_load(scene: Scene, load: float) -> None:
    """Lift or lower the start until the ground pushes so much, body weights, on spheres at rest.

    Where the feet hang more than 2 m above the ground, or under it, it stays as it is.
    """
    numbers = at_start(scene)
    poses = world_poses(numbers)
    weight = sum(plain_number(body.mass) for body in numbers.character.bodies.values()) * plain_number(numbers.gravity)
    normal, height = plain_vector(numbers.ground.normal), plain_number(numbers.ground.height)
    spheres: list[tuple[float, float, float]] = []
    for name, body in numbers.character.bodies.items():
        position, orientation = poses[name]
        for shape in body.shapes:
            if isinstance(shape, Sphere) and shape.material is not None:
                center = position + rotate(orientation, plain_vector(shape.center))
                above, stiffness = float(normal @ center) - height, plain_number(shape.material.stiffness)
                spheres.append((above, plain_number(shape.radius), stiffness))
    if not spheres or load <= 0.0:
        return

    def force(lift: float) -> float:
        depths = [(max(radius - above - lift, 0.0), radius, e) for above, radius, e in spheres]
        return float(sum(4.0 / 3.0 * math.sqrt(r) * (e ** (2.0 / 3.0) / 2.0 * d) ** 1.5 for d, r, e in depths))

    low, high = -2.0, 2.0
    if not force(high) < load * weight < force(low):
        return
    for _ in range(LIFT_STEPS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if force(middle) > load * weight else (low, middle)
    x, y, z = scene.initial_state.root_position
    scene.initial_state.root_position = (x, plain_number(y) + round(0.5 * (low + high), 9), z)
