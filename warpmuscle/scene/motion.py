"""Prescribed motion of a scene; units are SI and radians, see `scene.py`."""

from __future__ import annotations

from typing import Annotated

from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.part import Part


class Motion(Part):
    """How the kinematic degrees of freedom of a joint move over time, or the root if the motion is called `root`.

    Between its knots a motion is a spline of fifth degree, so that position, velocity and acceleration have no jump;
    fewer than six knots lie on one polynomial, and a single one holds still. The knots reach over the simulated time.
    A hinge or universal joint has `value`, a ball joint `rotation`, and the root `position` and `rotation`; a root that
    gives one of them only keeps the other one as in the initial state. A joint without kinematic degrees of freedom
    does not follow its motion, which then is what fits compare with.
    """

    time: Annotated[list[float], "s"]
    value: Annotated[list[Number | list[Number]], "rad"] = []  # of two kinematic angles a list for each
    rotation: Annotated[list[Vector], "rad"] = []  # vectors, of the child in its parent or of the root in the world
    position: Annotated[list[Vector], "m"] = []  # of the root's centre of mass
