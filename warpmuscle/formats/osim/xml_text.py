"""Elements of OpenSim's files as text."""

from __future__ import annotations

import re
from collections.abc import Iterable
from xml.sax.saxutils import escape, quoteattr

from warpmuscle.core.number_rows import rows
from warpmuscle.scene import Displacement

NOT_IN_NAMES = re.compile(r"[^\w.\-+]")


def element(tag: str, inner: str, name: str = "") -> str:
    """An element; text within is taken as it is if it holds elements, and escaped if not."""
    attribute = f" name={quoteattr(name)}" if name else ""
    if inner.lstrip().startswith("<"):
        return f"<{tag}{attribute}>\n{inner}</{tag}>\n"
    return f"<{tag}{attribute}>{escape(inner)}</{tag}>\n"


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
