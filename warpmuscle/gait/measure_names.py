"""Names that measures of a walk can have, by which a wrong one is found before anything has walked."""

from __future__ import annotations

from collections.abc import Collection
from fnmatch import fnmatchcase
from functools import cache

from warpmuscle.gait.device_work import POSITIVE, WORK
from warpmuscle.gait.pelvis_and_trunk import TURNS
from warpmuscle.gait.quality import KEY_POINTS, TIMING
from warpmuscle.gait.table import UNITS
from warpmuscle.scene.norms import RUNNING, WALKING
from warpmuscle.scene.people.emg import WINDOWS
from warpmuscle.scene.people.pinzone import MOMENTS, PELVIS, POWERS

OPEN = (WORK, POSITIVE)  # before names that scenes give their devices
_JOINTS = ("hip", "knee", "ankle")


@cache
def measure_names() -> tuple[str, ...]:
    """All names that `gait_measures` gives, but those of devices, of percents of the cycle and of norm bands."""
    angles = (*(f"{joint} outside the norms" for joint in _JOINTS), "angles outside the norms")
    parts = (*_JOINTS, "three angles", "ground force")
    turns = [f"{body} {turn}, range" for body in ("pelvis", "trunk") for turn in TURNS]
    people = [*MOMENTS, *POWERS, *(name for name in PELVIS if not name.endswith("tilt")), "sway", "bobbing"]
    names = (
        *(name for name in UNITS if name != "target speed"),
        *KEY_POINTS,
        "knee, minimum",
        *angles,
        "angles outside the norms as published",
        *(f"angles from {norm.source}" for norm in (*WALKING, *RUNNING)),
        *(f"deviation of the {part}" for part in parts),
        *(f"{name.lower()} from people" for name in people),
        *(f"likeness of the {name.lower()}" for name in MOMENTS),
        *turns,
        TIMING,
        *(f"timing of {muscle}" for muscle in WINDOWS),
        "drift of the heading",
        "maximum error of the heading",
    )
    return tuple(dict.fromkeys(names))


def can_be_measured(pattern: str, more: Collection[str] = ()) -> bool:
    """Whether a name, or a pattern of names, fits a measure of some walk, or one of these besides."""
    if any(fnmatchcase(name, pattern) for name in (*more, *measure_names())):
        return True
    ends = [place for place in map(pattern.find, "*?[") if place >= 0]
    if not ends:
        return pattern.startswith(OPEN)
    begin = pattern[: min(ends)]
    return any(one.startswith(begin) or begin.startswith(one) for one in OPEN)
