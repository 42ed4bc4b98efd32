"""The muscles of the throwing arm through points, over bones as long as the subject's.

For docs/explanation/throwing.md.

Points are (forwards, up, to the right), m, of a right arm that hangs down with its thumb forwards, from the joint that
a letter names: `shoulder` on the trunk, `S` the same on the humerus, `G` on what is raised with the humerus but does
not turn with it about itself, `E` the elbow on the humerus, `F` on the ulna, `R` on the radius from the elbow, `W` on
the radius from the wrist, `H` on the hand from the wrist.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from warpmuscle.core.pose import about, multiply
from warpmuscle.scene import CylinderSurface, Muscle, Surface, ViaPoint, Wrap
from warpmuscle.scene.anthropometry import Segment
from warpmuscle.scene.number import Free

Point = tuple[str, float, float, float]
HEAD = "humeral_head"  # its centre of mass is at the joint
STRENGTH = (0.3, 3.0)  # of f_max: factors within which a fit may change it
SLACK = 0.2  # of l_opt, by which a fit may change l_slack


@dataclass(frozen=True)
class Architecture:
    """A muscle and where it runs."""

    f_max: float  # N
    l_opt: float  # m
    pennation: float  # degrees
    fibre: float  # l_opt, in the pose with the shoulder at 75 and the elbow at 70 degrees
    path: list[Point]
    wraps: list[tuple[str, int, int]] = field(default_factory=list)  # surface, first and last point


RADIAL_TUBEROSITY: Point = ("F", 0.0075, -0.0484, 0.0132)
LOWER_BICEPS: Point = ("E", 0.019, 0.115, 0.001)
LOWER_TRICEPS: list[Point] = [("E", -0.037, 0.064, -0.003), ("E", -0.023, 0.023, -0.001), ("F", -0.022, 0.0105, 0.001)]
MUSCLES = {
    "DELT1": Architecture(
        1218.9, 0.0976, 22, 1.15, [("shoulder", -0.012, 0.035, -0.02), ("S", 0.012, -0.119, 0.006)],
        [("deltoid_bursa", 1, 2)],
    ),
    "DELT2": Architecture(
        1103.5, 0.1078, 15, 1.1, [("shoulder", -0.015, 0.03, 0.02), ("S", 0.005, -0.136, 0.008)],
    ),
    "DELT3": Architecture(
        201.6, 0.1367, 18, 1.0, [("shoulder", -0.046, 0.035, -0.034), ("S", 0.0, -0.09, 0.012)],
    ),
    "PECM1": Architecture(
        444.3, 0.1442, 17, 0.85, [("shoulder", 0.045, 0.035, -0.12), ("S", 0.012, -0.042, 0.008)],
    ),
    "LAT": Architecture(
        797.0, 0.2324, 19, 1.0,
        [("shoulder", -0.094, -0.2, -0.141), ("shoulder", -0.1, -0.12, -0.093), ("S", 0.01, -0.041, -0.006)],
        [("armpit_front", 2, 3)],
    ),
    "BIClong": Architecture(
        525.1, 0.1157, 0, 0.83,
        [("shoulder", -0.022, 0.022, -0.015), ("S", 0.013, -0.028, 0.003), ("S", 0.009, -0.077, 0.002),
         ("S", 0.0145, -0.121, 0.005), LOWER_BICEPS, RADIAL_TUBEROSITY], [("humeral_head", 1, 2)],
    ),
    "BICshort": Architecture(
        316.8, 0.1321, 0, 0.98,
        [("shoulder", 0.018, 0.025, -0.035), ("S", 0.0096, -0.0758, -0.008), ("S", 0.0145, -0.121, -0.006),
         LOWER_BICEPS, RADIAL_TUBEROSITY],
    ),
    "BRA": Architecture(
        1177.4, 0.0858, 0, 0.88, [("E", 0.003, 0.1165, 0.004), ("F", -0.0032, -0.0239, -0.003)],
        [("elbow_front", 1, 2)],
    ),
    "BRD": Architecture(
        276.0, 0.1726, 0, 1.0, [("E", -0.014, 0.091, 0.011), ("R", 0.026, -0.139, 0.0185), ("W", 0.025, 0.021, 0.001)],
    ),
    "TRIlong": Architecture(
        771.8, 0.134, 12, 1.0, [("shoulder", -0.036, -0.007, -0.023), ("S", -0.0295, -0.114, -0.002), *LOWER_TRICEPS],
        [("armpit", 1, 2), ("elbow_back", 4, 5)],
    ),
    "TRIlat": Architecture(
        717.5, 0.1138, 9, 0.85, [("S", -0.009, -0.1265, 0.01), ("S", -0.0265, -0.145, 0.0155), *LOWER_TRICEPS],
        [("elbow_back", 4, 5)],
    ),
    "TRImed": Architecture(
        717.5, 0.1138, 9, 0.85, [("S", -0.011, -0.137, -0.003), ("S", -0.029, -0.151, -0.004), *LOWER_TRICEPS],
        [("elbow_back", 4, 5)],
    ),
    "FCR": Architecture(
        407.9, 0.0628, 3, 1.0,
        [("E", 0.002, 0.012, -0.025), ("W", 0.003, 0.022, -0.0205), ("H", 0.008, -0.032, -0.008)],
    ),
    "FCU": Architecture(
        479.8, 0.0509, 12, 1.0,
        [("E", -0.004, 0.013, -0.027), ("W", -0.007, 0.019, -0.0155), ("H", -0.012, -0.012, -0.0165)],
    ),
    "ECRL": Architecture(
        337.3, 0.081, 0, 1.0,
        [("E", -0.013, 0.0295, 0.02), ("R", 0.022, -0.146, 0.022), ("W", 0.024, 0.005, 0.011),
         ("H", 0.016, -0.036, 0.01)],
    ),
    "ECRB": Architecture(
        252.2, 0.0585, 9, 1.0,
        [("E", 0.007, 0.0, 0.029), ("R", 0.019, -0.142, 0.0185), ("W", 0.0175, 0.014, 0.0145),
         ("H", 0.006, -0.036, 0.012)],
    ),
    "ECU": Architecture(
        192.9, 0.0622, 4, 1.0,
        [("E", -0.005, 0.001, 0.031), ("F", -0.025, -0.096, 0.016), ("W", -0.03, 0.015, 0.006),
         ("H", -0.02, -0.034, 0.004)],
    ),
    "FDS": Architecture(
        667.8, 0.0736, 5, 1.0,
        [("E", -0.001, 0.013, -0.026), ("W", 0.001, 0.055, -0.019), ("W", 0.0, 0.012, -0.014),
         ("H", 0.0, -0.045, -0.012), ("H", 0.0, -0.095, -0.012)],
    ),
}  # fmt: skip
# Beside those: what turns a humerus about itself and holds it to the side, and a forearm about itself. In a body the
# scapula follows a raised arm, so that infraspinatus keeps its moment arm of rotation; here a point of it does so.
SPATIAL = {
    "SUPSP": Architecture(
        499.2, 0.0682, 7, 1.0,
        [("shoulder", -0.034, 0.019, -0.068), ("shoulder", 0.0025, 0.04, 0.0025), ("S", 0.0025, 0.0105, 0.026)],
    ),
    "INFSP": Architecture(
        1075.8, 0.0755, 19, 1.0,
        [("shoulder", -0.064, -0.021, -0.057), ("G", -0.022, 0.0, 0.0), ("S", -0.009, 0.005, 0.0245)],
    ),
    "SUBSC": Architecture(
        1306.9, 0.0873, 20, 1.0,
        [("shoulder", -0.063, -0.005, -0.074), ("shoulder", -0.009, -0.018, -0.034), ("S", 0.014, 0.0085, -0.0135)],
    ),
    "PT": Architecture(
        557.2, 0.0492, 10, 1.0,
        [("E", -0.002, 0.0145, -0.025), ("R", 0.021, -0.105, 0.006), ("R", 0.022, -0.12, 0.01)],
    ),
    "SUP": Architecture(
        379.6, 0.033, 0, 1.0, [("F", -0.016, -0.034, 0.014), ("R", 0.005, -0.0725, 0.008)],
    ),
}  # fmt: skip
TURNING_TUBEROSITY: Point = ("R", 0.004, -0.048, -0.004)  # where the biceps turns the radius as well
# Joint, forwards, up, right, radius, and the direction in which a path runs past the axis, degrees from up to forwards:
# cylinders about the axes of flexion.
SURFACES: dict[str, tuple[str, float, float, float, float, float]] = {
    "deltoid_bursa": ("shoulder", 0.0, 0.0, 0.0, 0.03, 37.0),
    "humeral_head": ("shoulder", 0.0, 0.0, 0.0, 0.0215, 37.0),
    "armpit_front": ("shoulder", 0.0, 0.0, 0.0, 0.018, 150.0),
    "armpit": ("shoulder", 0.0, 0.0, 0.0, 0.0225, 180.0),
    "elbow_front": ("E", -0.0033, -0.0015, 0.0, 0.016, 90.0),
    "elbow_back": ("E", -0.0033, -0.0015, 0.0, 0.016, -90.0),
}
LENGTH = 0.2  # m, of the cylinders
AXES = np.eye(3)


Place = Callable[[Point], ViaPoint]


def planar(parts: dict[str, Segment], shoulder: np.ndarray) -> tuple[dict[str, Muscle], dict[str, Surface]]:
    """Muscles and surfaces of the planar arm, its forearm pronated; `l_slack` is still 0.

    Args:
        parts: the segments of the arm. shoulder: its place on the trunk.
    """

    def placed(point: Point) -> ViaPoint:
        joint, forwards, up, right = point
        if joint in "RWH":  # what turns with the thumb, which points to the left
            forwards, right = right, -forwards
        body = {"shoulder": "trunk", "S": "upper_arm", "E": "upper_arm", "H": "hand"}.get(joint, "forearm")
        return _place(body, joint, np.array([-right, up, forwards]), shoulder, parts.get(body))

    return _muscles(MUSCLES, placed), _surfaces(placed)


def spatial(parts: dict[str, Segment], shoulder: np.ndarray) -> tuple[dict[str, Muscle], dict[str, Surface]]:
    """The same of the arm in three dimensions, with those that turn humerus and forearm about themselves."""
    bodies = {"shoulder": "trunk", "G": HEAD, "S": "upper_arm", "E": "upper_arm", "F": "ulna", "H": "hand"}

    def placed(point: Point) -> ViaPoint:
        joint, forwards, up, right = TURNING_TUBEROSITY if point is RADIAL_TUBEROSITY else point
        body = bodies.get(joint, "radius")
        part = parts.get("forearm" if body in ("ulna", "radius") else body)
        return _place(body, joint, np.array([-right, up, forwards]), shoulder, part)

    return _muscles(MUSCLES | SPATIAL, placed), _surfaces(placed)


def _place(body: str, joint: str, offset: np.ndarray, shoulder: np.ndarray, part: Segment | None) -> ViaPoint:
    """A point of a body, at an offset from a joint."""
    origin = np.zeros(3) if body == HEAD else shoulder if part is None else -np.array(part.com)
    if part is not None and joint in ("E", "W"):
        origin = origin - [0.0, part.length, 0.0]
    return ViaPoint(body, tuple(np.round(origin + offset, 4).tolist()))


def _surfaces(placed: Place) -> dict[str, Surface]:
    found: dict[str, Surface] = {}
    for name, (joint, forwards, up, right, radius, towards) in SURFACES.items():
        center = placed((joint, forwards, up, right))
        assert center.position is not None
        turn = multiply(about(AXES[0], np.radians(towards)), about(AXES[1], 0.5 * np.pi))
        size = float(np.linalg.norm(turn[:3]))
        vector = turn[:3] / size * 2.0 * np.arctan2(size, turn[3])
        found[name] = CylinderSurface(
            center.body, center.position, radius, LENGTH, tuple(np.round(vector, 6).tolist()), "+y"
        )  # fmt: skip
    return found


def _muscles(table: dict[str, Architecture], placed: Place) -> dict[str, Muscle]:
    return {
        name: Muscle(
            path=[placed(point) for point in own.path], wraps=[Wrap(*wrap) for wrap in own.wraps], f_max=own.f_max,
            l_opt=own.l_opt, l_slack=0.0, pennation=round(float(np.radians(own.pennation)), 4),
        )
        for name, own in table.items()
    }  # fmt: skip


def with_tendons(muscles: dict[str, Muscle], lengths: dict[str, float]) -> None:
    """Give muscles the slack length with which their fibres are as long as they should be, and what a fit may change.

    Args:
        lengths: of the paths in the pose that `Architecture.fibre` is meant in, m.
    """
    for name, muscle in muscles.items():
        own = (MUSCLES | SPATIAL)[name]
        fibre, width = own.fibre * own.l_opt, own.l_opt * np.sin(np.radians(own.pennation))
        slack = lengths[name] - float(np.sqrt(fibre**2 - width**2))
        spare = SLACK * own.l_opt
        muscle.l_slack = Free(*np.round([slack, max(slack - spare, 0.0), slack + spare], 4).tolist())
        muscle.f_max = Free(*np.round([own.f_max, own.f_max * STRENGTH[0], own.f_max * STRENGTH[1]], 1).tolist())
