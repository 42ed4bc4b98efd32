"""Times and coordinates of a motion that cannot well be: holes, jumps, rows out of order, angles beyond ranges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import few_of

SLOW = 0.1  # s between frames, from which on nobody knows the speeds
FAST = 5.0e-5  # s between frames, below which the times may well be in another unit
NEAR = 0.05  # of the usual distance: frames of which one may be of another time
HOLE = 2.5  # times the usual distance of frames
LEAP = {"rad": 0.5, "m": 0.15}  # from one frame to the next
UNUSUAL = 8.0  # times what nine of ten steps stay below
MOVING = {"rad": 0.1, "m": 0.05}  # range of a coordinate, below which its changes do not matter
TO_AND_FRO = 1.25  # median of second differences by that of first ones; of white noise 1.73
BEYOND = 0.1  # rad, out of a range
LEAST_ANGLE = 3.2  # degrees, which angles in rad stay below
UNIT = (20.0, 200.0)  # times that one side moves more than the other, about the 57.3 degrees of 1 rad
LISTED = 4
STAYS = 0.02  # rad or m, by which a motion may miss where a model locks a coordinate


def time_notes(what: str, times: Floats) -> list[str]:
    """Holes between frames (F,), and frames that are far apart."""
    if len(times) < 2:
        return []
    steps = np.diff(times)
    usual = float(np.median(steps))
    if usual < FAST:
        return [
            f"{what}: frames are {usual:.2g} s apart; are its times in seconds? Speeds and moments are wrong if not"
        ]
    if usual > 0.99 * SLOW:
        return [f"{what}: frames are {usual:.3g} s apart; what is between them, and all speeds, are guessed"]
    notes = []
    least = int(steps.argmin())
    if steps[least] < NEAR * usual:
        notes.append(
            f"{what}: two frames at {times[least]:.4g} s are only {steps[least]:.2g} s apart; speeds there are wrong"
        )
    holes = np.flatnonzero(steps > max(HOLE * usual, 0.02))
    for k in holes[:LISTED].tolist():
        between = f"{times[k]:.4g} and {times[k + 1]:.4g} s"
        notes.append(f"{what}: there are no frames between {between}; what is found there follows a curve")
    return notes


def value_notes(names: Sequence[str], units: Sequence[str], times: Floats, values: Floats) -> list[str]:
    """Coordinates (F, K) that jump, or go to and fro from frame to frame."""
    if len(values) < 6:
        return []
    first = np.diff(values, axis=0)
    second = np.diff(first, axis=0)
    swing = np.median(np.abs(second), axis=0) > TO_AND_FRO * np.median(np.abs(first), axis=0)
    moving = np.ptp(values, axis=0) > [MOVING.get(unit, np.inf) for unit in units]
    shaking = [name for name, there in zip(names, (swing & moving).tolist(), strict=True) if there]
    notes = []
    if shaking:
        go = "go" if len(shaking) > 1 else "goes"
        notes.append(
            f"{few_of(shaking, LISTED)} {go} to and fro from frame to frame: rows out of order, swapped markers or "
            "noise; speeds and moments are wrong"
        )
    size = np.abs(first)
    usual = np.quantile(size, 0.9, axis=0)
    for k, name in enumerate(names):
        most = int(size[:, k].argmax())
        if name not in shaking and size[most, k] > max(LEAP.get(units[k], np.inf), UNUSUAL * usual[k]):
            far = f"{np.degrees(size[most, k]):.0f} degrees" if units[k] == "rad" else f"{size[most, k]:.2g} m"
            notes.append(f"there is a jump of {far} in {name} at {times[most + 1]:.4g} s: moments around it are wrong")
    return notes[: LISTED + 1]


def range_notes(names: Sequence[str], values: Floats, ranges: Mapping[str, tuple[float, float]]) -> list[str]:
    """Angles (F, K) that leave the ranges of a model by far."""
    notes = []
    least, most = values.min(axis=0).tolist(), values.max(axis=0).tolist()
    for name, lowest, highest in zip(names, least, most, strict=True):
        low, high = ranges.get(name, (-np.inf, np.inf))
        beyond = max(low - lowest, highest - high)
        if beyond > BEYOND:
            span = f"{np.degrees(low):.0f} to {np.degrees(high):.0f} degrees, by {np.degrees(beyond):.0f}"
            notes.append(f"{name} leaves its range, {span}: is its name, sign or unit another?")
    return notes[:LISTED]


def locked_notes(names: Sequence[str], values: Floats, locked: Mapping[str, float]) -> list[str]:
    """Columns (F, K) that move what a model locks."""
    moved = [
        name for name, column in zip(names, values.T, strict=True)
        if name in locked and np.abs(column - locked[name]).max(initial=0.0) > STAYS
    ]  # fmt: skip
    if not moved:
        return []
    stay = "stay" if len(moved) > 1 else "stays"
    return [f"the motion moves {few_of(moved, LISTED)}, locked in the model, which {stay} there: unlock it for moments "
            "with it"]  # fmt: skip


def side_notes(names: Sequence[str], values: Floats) -> list[str]:
    """Coordinates (F, K) of one side that move as those of the other one would in the other unit of angles."""
    if not len(values):
        return []
    least, most = values.min(axis=0), values.max(axis=0)
    spans = dict(zip(names, (most - least).tolist(), strict=True))
    sizes = dict(zip(names, np.maximum(-least, most).tolist(), strict=True))
    notes = []
    for name, span in spans.items():
        for end, other in (("_r", "_l"), ("_l", "_r")):
            whole = spans.get(name.removesuffix(end) + other, 0.0) if name.endswith(end) else 0.0
            small = sizes[name] < np.radians(LEAST_ANGLE)
            if small and whole > MOVING["rad"] and UNIT[0] < whole / max(span, 1e-9) < UNIT[1]:
                notes.append(
                    f"{name} moves by {np.degrees(span):.2g} degrees where that of the other side moves by "
                    f"{np.degrees(whole):.2g}: are its numbers rad?"
                )
    return notes[:LISTED]


def unit_notes(angles: Floats) -> list[str]:
    """Angles (F, K), degrees, that may well be rad."""
    if angles.shape[1] < 3 or len(angles) < 2:
        return []
    most, moved = float(np.abs(angles).max()), float(np.ptp(angles, axis=0).max())
    if most < LEAST_ANGLE and moved > 0.1:
        return [f"no angle comes to more than {most:.2g} degrees: are they radians? Then say inDegrees=no"]
    return []
