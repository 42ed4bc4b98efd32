"""Coordinates that cannot move since others that are coupled to them are locked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.frames import refused
from warpmuscle.formats.osim.moves import finite_range
from warpmuscle.formats.osim.records import Coordinate, Coupler, Model

PLACES = 601  # of a range and as much on both sides, between which one is looked for
MET = 1.0e-9  # rad or m
HALVINGS = 60


def hold_drivers(model: Model, notes: Notes) -> None:
    """Lock every coordinate that a coupler of a locked one holds, where it meets that coupler.

    OpenSim keeps both constraints, and assembles the pose that meets them.

    Args:
        model: its coordinates are changed in place.
        notes: tells what is held, and of which locks several coordinates hold each other, which is not represented.

    Raises:
        SceneError: no place of a coordinate near its range meets its coupler.
    """
    couplers = [one for one in model.couplers if not one.constant]
    while True:
        known = model.coordinates
        for coupler in couplers:
            names = coupler.several or (coupler.independent,)
            if coupler.dependent not in known or not known[coupler.dependent].locked or set(names) - set(known):
                continue
            free = [name for name in names if not known[name].locked]
            if len(free) == 1:
                _hold(model, coupler, known, free[0], notes)
                break
        else:
            break
    for coupler in couplers:
        free = [name for name in coupler.several if name in known and not known[name].locked]
        if coupler.dependent in known and known[coupler.dependent].locked and free:
            reason = f"{coupler.dependent} is locked, and {', '.join(free)} move as if it were not coupled to them"
            notes.ignore(model.file, coupler.line, f"CoordinateCouplerConstraint {coupler.name}", reason)


def _hold(model: Model, coupler: Coupler, known: dict[str, Coordinate], name: str, notes: Notes) -> None:
    dependent, own = known[coupler.dependent], known[name]

    def off(q: float) -> float:
        if not coupler.terms:
            return coupler.function.at(q) - dependent.value
        at = [q if one == name else known[one].value for one in coupler.several]
        return sum(a * float(np.prod(np.power(at, powers))) for a, powers in coupler.terms) - dependent.value

    place = _nearest(off, own)
    what = f"is locked, and {name}, to which {coupler.name!r} couples it, is held, too"
    if place is None:
        message = f"coordinate {dependent.name!r} {what}; but no {name} near its range gives {dependent.value:g}"
        raise refused(model, coupler.line, message)
    held = replace(own, locked=True, value=place)
    for k, joint in enumerate(model.joints):
        if own in joint.coordinates:
            every = tuple(held if one is own else one for one in joint.coordinates)
            model.joints[k] = replace(joint, coordinates=every)
    notes.ignore(model.file, dependent.line, f"Coordinate {dependent.name}", f"{what}, at {place:.6g}, as in OpenSim")


def _nearest(off: Callable[[float], float], own: Coordinate) -> float | None:
    """The place nearest to a coordinate's own at which a function is 0; None if there is none near its range."""
    if abs(off(own.value)) < MET:
        return own.value
    low, high = finite_range(own)
    low, high = min(low, own.value), max(high, own.value)
    places = np.unique([*np.linspace(2.0 * low - high, 2.0 * high - low, PLACES), own.value])
    values = np.array([off(float(q)) for q in places])
    found = [float(q) for q, value in zip(places, values, strict=True) if abs(value) < MET]
    for k in np.flatnonzero(values[:-1] * values[1:] < 0.0):
        found.append(_between(off, float(places[k]), float(places[k + 1])))
    return min(found, key=lambda q: abs(q - own.value), default=None)


def _between(off: Callable[[float], float], low: float, high: float) -> float:
    """Where a function changes its sign."""
    rises = off(high) > 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if (off(middle) > 0.0) == rises:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)
