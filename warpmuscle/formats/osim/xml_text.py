"""Elements of OpenSim's files as text, and points and frames on bodies among them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import rows
from warpmuscle.core.plain_text import xml_text
from warpmuscle.formats.osim.placement import WORLD, vector
from warpmuscle.scene import Displacement

NOT_IN_NAMES = re.compile(r"[^\w.\-+]")


def element(tag: str, inner: str, name: str = "") -> str:
    """An element; text within is taken as it is if it holds elements, and escaped if not."""
    attribute = f" name={quoteattr(xml_text(name))}" if name else ""
    if inner.lstrip().startswith("<"):
        return f"<{tag}{attribute}>\n{inner}</{tag}>\n"
    return f"<{tag}{attribute}>{escape(xml_text(inner))}</{tag}>\n"


def objects(tag: str, members: Iterable[str], name: str = "") -> str:
    """A set of objects."""
    inner = f"<objects>\n{''.join(members)}</objects>\n<groups />\n"
    return element(tag, inner, name or tag.lower())


def numbers(values: Iterable[float]) -> str:
    """Numbers with all their digits."""
    return " ".join(format(value, ".17g") for value in values)


def name_of(name: str) -> str:
    """A name as OpenSim's paths bear it: without blanks, slashes and the like."""
    return NOT_IN_NAMES.sub("_", name)


def function_xml(displacement: Displacement, name: str = "") -> str:
    """The function of a displacement."""
    value, slope = (float(rows(number).flat[0]) for number in (displacement.value, displacement.slope))
    if displacement.x:
        kind = {"simm": "SimmSpline", "linear": "PiecewiseLinearFunction", "natural": "GCVSpline"}[displacement.ends]
        inner = element("x", numbers(displacement.x)) + element("y", numbers(rows(displacement.y)[0]))
        if kind == "GCVSpline":  # of this order it is a natural cubic one
            inner = element("half_order", "2") + element("error_variance", "0") + inner
        return element(kind, inner, name)
    if displacement.polynomial:
        coefficients = reversed(list(rows(displacement.polynomial)[0]))
        return element("PolynomialFunction", element("coefficients", numbers(coefficients)), name)
    if slope == 0.0:
        return element("Constant", element("value", numbers([value])), name)
    return element("LinearFunction", element("coefficients", numbers([slope, value])), name)


def angles_of(matrix: Floats) -> tuple[float, float, float]:
    """Angles, rad, about x, the new y and the newer z axis, of a matrix (3, 3)."""
    if abs(matrix[0, 2]) > 1.0 - 1e-12:  # x and z turn about one axis; as much as they should together
        return vector(np.array([0.0, np.pi / 2.0 * np.sign(matrix[0, 2]), np.arctan2(matrix[1, 0], matrix[1, 1])]))
    x = np.arctan2(-matrix[1, 2], matrix[2, 2])
    y = np.arcsin(np.clip(matrix[0, 2], -1.0, 1.0))
    return vector(np.array([x, y, np.arctan2(-matrix[0, 1], matrix[0, 0])]))


def placed(socket: str, path: str, position: Floats, tag: str = "location") -> str:
    """A point on a body: the socket that names it, and its place (3,), m, in our axes of it."""
    return element(socket, path) + element(tag, numbers(vector(WORLD.T @ position)))


def frame_xml(name: str, parent: str, place: Floats, turn: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> str:
    """An offset frame at a place (3,), m, of another one, turned by angles, rad, in OpenSim's axes."""
    inner = element("socket_parent", parent) + element("translation", numbers(vector(place)))
    return element("PhysicalOffsetFrame", inner + element("orientation", numbers(turn)), name=name)
