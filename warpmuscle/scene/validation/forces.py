"""Checks of the forces of a scene."""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Mapping
from functools import partial
from typing import Any

from warpmuscle.core.errors import SceneError, shortened
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene import Force, Scene
from warpmuscle.scene.expressions.parse import FUNCTIONS, BadExpression, parse
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.number import Number
from warpmuscle.scene.validation.checks import Checks, known, near

NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)


def check_forces(check: Checks) -> None:
    """Every force acts on one joint that moves, or on one body."""
    character = check.checked.character
    for name, force in check.checked.forces.items():
        key = f"forces.{name}"
        if bool(force.joint) == bool(force.body):
            raise SceneError("name either a joint or a body that it acts on", key=key)
        if force.joint:
            known(force.joint, character.joints, "joint", f"{key}.joint")
            if not joint_type(character.joints[force.joint]).moves:
                raise SceneError(f"joint {force.joint!r} does not move", key=f"{key}.joint")
        else:
            known(force.body, character.bodies, "body", f"{key}.body")
        if force.other_body:
            known(force.other_body, character.bodies, "body", f"{key}.other_body")
        if ":" not in force.type:
            _check_shipped(check, force, key)
        elif force.expressions or force.curves:
            raise SceneError(f"{force.type!r} takes no expressions", key=f"{key}.expressions")


def _check_shipped(check: Checks, force: Force, key: str) -> None:
    """There is such a kind of force, it acts on what is named, and it gets its parameters."""
    from warpmuscle.kernels.force.devices import FORCES  # with Warp, for which no scene without forces has to wait

    if force.type not in FORCES:
        there_are = f"there are {', '.join(FORCES)}"
        raise SceneError(f"no force is called {force.type!r}{near(force.type, FORCES)}; {there_are}", key=f"{key}.type")
    kind = FORCES[force.type]
    check_place(force, "joint" if kind.effort is not None else "body", key, kind.pair is not None)
    check_values(kind.parameters, force.parameters, f"{key}.parameters", kind.programs)
    _check_expressions(check, force, kind.programs, kind.variables, key)
    if kind.of_angle and not joint_type(check.checked.character.joints[force.joint]).scalars:
        raise SceneError(f"{force.type!r} is of an angle or a length, but {force.joint!r} has none", key=f"{key}.joint")
    if kind.of_leg:
        check_leg(check.checked, force.joint, f"{key}.joint")
    check_positive(check, kind.positive, force, key)


def check_positive(check: Checks, names: Iterable[str], force: Force, key: str) -> None:
    """Parameters that are divided by are greater than 0."""
    for name in names:
        least = check.interval(force.parameters[name])[0]
        if not least > 0.0:
            raise SceneError(f"must be greater than 0, is {least:g}", key=f"{key}.parameters.{name}")


def _check_expressions(
    check: Checks, force: Force, programs: tuple[str, ...], variables: tuple[str, ...], key: str
) -> None:
    """Expressions are of what they may be of, and curves have knots in order."""
    for name, curve in force.curves.items():
        place = f"{key}.curves.{name}"
        if not NAME.fullmatch(name) or name in (*variables, *FUNCTIONS):
            message = "the name of a curve has letters, digits and _, and is none of a variable or function"
            raise SceneError(message, key=place)
        if len(curve.x) < 2 or len(curve.x) != len(curve.y):
            counts = f"{number_of(len(curve.x), 'knot')} with {number_of(len(curve.y), 'value')}"
            raise SceneError(f"needs two knots at least, and a value for each; has {counts}", key=place)
        check_size("knots", len(curve.x), partial(SceneError, key=f"{place}.x"))
        check.increasing(f"{place}.x", curve.x, "knots")
    for name, text in force.expressions.items():
        place = f"{key}.expressions.{name}"
        if name not in programs:
            takes = f"it takes {', '.join(programs)}" if programs else f"{force.type!r} takes none"
            raise SceneError(f"no expression is called {name!r}{near(name, programs)}; {takes}", key=place)
        try:
            parse(text, variables, force.curves)
        except BadExpression as error:
            raise SceneError(shortened(f"{text[:60]!r}: {error}"), key=place) from None


def check_place(force: Force, place: str, key: str, pair: bool = False) -> None:
    """SceneError unless a force acts on a joint, on a body, or between two bodies, as its kind does."""
    if not getattr(force, place):
        other = "body" if place == "joint" else "joint"
        raise SceneError(f"{force.type!r} acts on a {place}: name it in place of the {other}", key=f"{key}.{other}")
    if pair != bool(force.other_body):
        message = f"{force.type!r} acts " + ("between two bodies: name the other one" if pair else "on one thing only")
        raise SceneError(message, key=f"{key}.other_body")
    if pair and force.body == force.other_body:
        raise SceneError(f"{force.type!r} acts between two different bodies", key=f"{key}.other_body")


def check_leg(scene: Scene, joint: str, key: str) -> None:
    """SceneError unless one foot, and no other, hangs on a joint."""
    carriers = {one.child: one.parent for one in scene.character.joints.values()}
    child, found = scene.character.joints[joint].child, 0
    for foot in scene.feet or ():
        body: str | None = foot
        while body is not None and body != child:
            body = carriers.get(body)
        found += body == child
    if found != 1:
        why = "both feet hang" if found else "no foot hangs"
        raise SceneError(f"must be a joint of one leg, whose gait cycle it is to follow; {why} on {joint!r}", key=key)


def check_values(
    struct: Any, given: Mapping[str, Number], key: str, others: tuple[str, ...] = (), given_else: Container[str] = ()
) -> None:
    """SceneError unless a scene gives all the parameters of a structure of Warp, and no others.

    Args:
        others: parameters that the scene does not give. given_else: those that it need not give.
    """
    names = [] if struct is None else [name for name in struct.vars if name not in others]
    for name in given:
        if name not in names:
            takes = f"takes {', '.join(names)}" if names else "takes none"
            raise SceneError(f"no parameter is called {name!r}{near(name, names)}; it {takes}", key=f"{key}.{name}")
    missing = [name for name in names if name not in given and name not in given_else]
    if missing:
        raise SceneError(f"there is no value of {', '.join(map(repr, missing))}", key=key)
