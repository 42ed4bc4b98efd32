"""Constraints of OpenSim that close loops of bodies, as records."""

from __future__ import annotations

from typing import Literal

import numpy as np

from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.frames import Frames, on_body
from warpmuscle.formats.osim.properties import Properties
from warpmuscle.formats.osim.records import Loop, Model, Vec3

TYPES: dict[str, Literal["weld", "point", "point_on_line", "distance"]] = {
    "WeldConstraint": "weld",
    "PointConstraint": "point",
    "PointOnLineConstraint": "point_on_line",
    "ConstantDistanceConstraint": "distance",
}


def read_loop(element: Element, model: Model, frames: Frames, own: Properties) -> Loop:
    """A constraint of one of the classes in `TYPES`; its own frames are connected already.

    Raises:
        SceneError: it names no frames, both on one body, or a line or distance without length.
    """
    path = f"/constraintset/{element.name}"

    def end(socket: str, place: str) -> tuple[str, Vec3]:
        return frames.socket(element, path, socket), own.vector(element, place)

    axis, distance = (0.0, 1.0, 0.0), 0.0
    if element.tag == "WeldConstraint":
        first, second = ((frames.socket(element, path, f"frame{k}"), (0.0, 0.0, 0.0)) for k in (1, 2))
    elif element.tag == "PointOnLineConstraint":
        first, second = end("follower_body", "point_on_follower"), end("line_body", "point_on_line")
        axis = own.vector(element, "line_direction_vec", axis)
        if not np.linalg.norm(axis) > 1e-9:
            element.fail("its line has no direction")
    else:
        first, second = (end(f"body_{k}", f"location_body_{k}") for k in (1, 2))
    if element.tag == "ConstantDistanceConstraint":
        distance = own.number(element, "constant_distance", 0.0)
        if not distance > 0.0:
            element.fail(f"its distance must be greater than 0, not {distance:g}; a PointConstraint holds at none")
    if on_body(model, first[0])[0] == on_body(model, second[0])[0]:
        element.fail("must be between two different bodies")
    return Loop(element.tag, element.name, element.line, *first, *second, axis, distance)
