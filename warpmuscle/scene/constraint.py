"""What holds two bodies to each other that no joint joins."""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.part import Part


class Constraint(Part):
    """Closes a loop of bodies by forces that do no work.

    weld: two frames, one on each body, stay one on the other, as if a fixed joint were between them.
    point: two points, one on each body, stay in one place.
    point_on_line: a point of the body stays on a line of the other one, through its point along `axis`.
    distance: two points stay at a distance.
    The bodies must be so at the start, and what else holds them must leave them free to be.
    """

    type: Literal["weld", "point", "point_on_line", "distance"]
    body: str
    other_body: str
    position: Annotated[Vector, "m"] = (0.0, 0.0, 0.0)  # of the point, in the body's frame
    other_position: Annotated[Vector, "m"] = (0.0, 0.0, 0.0)  # of that of the other body, in its frame
    orientation: Annotated[tuple[Number, Number, Number, Number], "1"] = (0.0, 0.0, 0.0, 1.0)  # of a weld's frame
    other_orientation: Annotated[tuple[Number, Number, Number, Number], "1"] = (0.0, 0.0, 0.0, 1.0)
    axis: Annotated[Vector, "1"] = (0.0, 1.0, 0.0)  # of a line, in the other body's frame
    distance: Annotated[Number, "m"] = 0.0
