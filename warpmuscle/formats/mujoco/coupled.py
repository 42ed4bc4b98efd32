"""Coupled joints in MuJoCo's files: hinges and slides, of which equalities make polynomials of one of them.

Each turn and shift that changes is a joint of MuJoCo's, `<joint>_turn1`, `<joint>_shift2`, ..., whose value is that of
its function; a coordinate that is itself a turn or shift is a joint of its own name. MuJoCo's polynomials are of the
fourth degree at most, and its equalities give way a little.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.mjcf_text import numbers, text, texts
from warpmuscle.scene import Character, Displacement, Joint
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.coupled import span_of
from warpmuscle.scene.joints.displacement import rates

DEGREE = 4  # of MuJoCo's polynomials
MISSED = 1.0e-6  # rad or m, by which one may miss a function within its span
PLACES = 201  # of the span, at which it is fitted


class Part(NamedTuple):
    """A joint of MuJoCo's that stands for a turn or shift of a coupled one."""

    name: str
    kind: str
    displacement: Displacement
    sign: float  # of its value over the coordinate, if it is that itself; else 0


def parts_of(name: str, joint: Joint) -> list[Part]:
    """The joints that stand for a coupled one, the outermost first: its shifts, then its turns."""
    found, own = [], joint.follows != ""
    for kind, word, given in (("slide", "shift", joint.translations), ("hinge", "turn", joint.rotations)):
        for number, one in enumerate(given, 1):
            plain = not one.x and not one.polynomial and plain_number(one.value) == 0.0
            sign = plain_number(one.slope) if plain and abs(plain_number(one.slope)) == 1.0 and not own else 0.0
            own = own or sign != 0.0
            found.append(Part(name if sign else f"{name}_{word}{number}", kind, one, sign))
    if not own:
        message = "MuJoCo takes a coupled joint of which one turn or shift is the coordinate itself, of slope 1 or -1"
        raise SceneError(message, key=f"character.joints.{name}")
    return found


def motions_of(name: str, joint: Joint, place: tuple[float, ...], limits: bool) -> Iterator[Element]:
    """MuJoCo's joints of a coupled one, at a place in its child.

    Raises:
        SceneError: none of its turns and shifts is its coordinate itself.
    """
    for part in parts_of(name, joint):
        axis = np.array(numbers(part.displacement.axis)) * (part.sign or 1.0)
        motion = Element("joint", name=part.name, type=part.kind, pos=texts(place), axis=texts(axis.tolist()))
        if part.sign and limits and joint.limits:
            motion.set("range", texts(numbers(joint.limits[0])))
        for field in ("armature", "damping"):
            resistance = plain_number(getattr(joint, field))
            if resistance != 0.0 and (part.sign or joint.follows):
                motion.set(field, text(resistance))
        yield motion


def values_of(joint: Joint, name: str, q: Floats, v: Floats) -> tuple[list[float], list[float]]:
    """Values and rates of these joints at the coordinate (1,) that moves a coupled one and its rate."""
    values, speeds = [], []
    for part in parts_of(name, joint):
        value, slope, _ = rates(part.displacement, q)
        values.append(float(value[0] * (part.sign or 1.0)))
        speeds.append(float(slope[0] * v[0] * (part.sign or 1.0)))
    return values, speeds


def add_equalities(model: Element, character: Character) -> None:
    """Append what couples these joints.

    Raises:
        SceneError: a function that no polynomial of MuJoCo's meets.
    """
    section: Element | None = None
    for name, joint in character.joints.items():
        if not joint_type(joint).displaced:
            continue
        driver = joint.follows or name
        for index, part in enumerate(parts_of(name, joint)):
            if part.sign:
                continue
            section = SubElement(model, "equality") if section is None else section
            key = f"character.joints.{name}.{'translations' if part.kind == 'slide' else 'rotations'}"
            c = _polynomial(part.displacement, joint, character.joints[driver], key)
            other = _coordinate(driver, character)
            SubElement(section, "joint", name=f"{name}_{index}", joint1=part.name, joint2=other, polycoef=texts(c))


def _coordinate(driver: str, character: Character) -> str:
    """The joint of MuJoCo's whose value is the coordinate of one of ours."""
    joint = character.joints[driver]
    if joint_type(joint).displaced:
        return next(part.name for part in parts_of(driver, joint) if part.sign)
    return driver + joint_type(joint).mujoco[0].suffix


def _polynomial(displacement: Displacement, joint: Joint, driver: Joint, key: str) -> list[float]:
    """The coefficients (DEGREE + 1,) of a function, the constant first."""
    if displacement.polynomial and len(displacement.polynomial) <= DEGREE + 1:
        given = [plain_number(c) for c in displacement.polynomial]
        return [*given, *[0.0] * (DEGREE + 1 - len(given))]
    if not displacement.x and not displacement.polynomial:
        return [plain_number(displacement.value), plain_number(displacement.slope), 0.0, 0.0, 0.0]
    q = np.linspace(*span_of(joint, driver), PLACES)
    value = rates(displacement, q)[0]
    fitted = np.polynomial.Polynomial.fit(q, value, DEGREE).convert()
    missed = float(np.abs(fitted(q) - value).max())
    if missed > MISSED:
        message = f"MuJoCo's polynomials of the fourth degree miss this function by {missed:.2g} rad or m"
        raise SceneError(message, key=key)
    return [float(c) for c in np.pad(fitted.coef, (0, DEGREE + 1 - len(fitted.coef)))]
