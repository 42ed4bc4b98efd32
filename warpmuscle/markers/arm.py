"""Angles of an arm from markers, as `warpmuscle throw fit` reads them.

The trunk's axes are up (from the middle of the hips to that of the shoulders), right (the line of the shoulders made
orthogonal to it) and forwards. Angles, as hinges one behind the other, zero where a straight arm hangs down with the
thumb forwards: `shoulder` forwards, `shoulder_abduction` away from the trunk, `shoulder_rotation` inwards, `elbow`
flexion, `forearm_rotation` pronation, `wrist_deviation` to the thumb's side, `wrist` to the palm's side.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from pathlib import Path
from typing import Literal

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.core.files import replace_file
from warpmuscle.core.pose import normalized
from warpmuscle.markers.files import UNITS, Markers

Side = Literal["right", "left"]
AXES = {f"{sign}{name}": k for k, name in enumerate("xyz") for sign in ("", "+", "-")}
ROLES = {  # what markers are needed for, and how MLSE's open data call them; S is R or L, and O the other one
    "shoulder": "S_SHOULDER",
    "elbow": "S_ELBOW",
    "wrist": "S_WRIST",
    "hand_thumb": "S_1STFINGER",
    "hand_little": "S_5THFINGER",
    "other_shoulder": "O_SHOULDER",
    "hip": "S_HIP",
    "other_hip": "O_HIP",
}
ANGLES = (
    "shoulder", "shoulder_abduction", "shoulder_rotation", "elbow", "forearm_rotation", "wrist_deviation", "wrist",
)  # fmt: skip
# Roles that are places of their own; only the hips may be one. "hand" is the middle of its markers.
SPANS = (*(pair for pair in combinations(ROLES, 2) if pair != ("hip", "other_hip")), ("wrist", "hand"))
UPPER_ARM = 0.1, 0.8  # m, between which all are
FACING = 0.25  # of a chest that faces forwards, the least
LONGEST_GAP = 0.2  # s, in which a marker may be lost
SIDEWAYS = np.radians(10.0)  # of the upper arm from the line of the shoulders, below which no angle forwards is given
SAME = 1e-9  # in any unit, of one marker under two names
MOST_RATE = 10_000.0  # Hz, of what is written
APART = 0.005  # m, between markers of two roles, the least
ASIDE = 0.2  # of the shoulders' width, by which one marker of both hips may lie beside their middle
STRAIGHT = np.radians(5.0)  # of the elbow, below which the forearm tells nothing of the upper arm's rotation
TINY = 1e-12  # m, below which a vector has no direction


@dataclass(frozen=True)
class Choices:
    """How markers are read.

    `markers`: the marker of a role, where it is not that of MLSE's open data. `up`, `forward`: axes of the file.
    `low_pass`: Hz, of positions, by Butterworth's filter of second order, forwards and backwards; 0 takes nothing.
    `before`, `after`: s, of what is kept about the fastest extension of the elbow; None keeps all.
    """

    side: Side = "right"
    markers: Mapping[str, str] = field(default_factory=dict)
    up: str = "z"
    forward: str = "x"
    rate: float = 100.0
    low_pass: float = 8.0
    before: float | None = 1.0
    after: float = 0.5

    def __post_init__(self) -> None:
        unknown = [role for role in self.markers if role not in ROLES]
        if unknown:
            raise SignalError(f"unknown role {unknown[0]!r}; there are {', '.join(ROLES)}")
        for axis in (self.up, self.forward):
            if axis not in AXES:
                raise SignalError(f"axis {axis!r} is none of x, y, z, -x, -y, -z")
        if AXES[self.up] == AXES[self.forward]:
            raise SignalError(f"up and forward must be two axes, not both {self.up!r}")
        if not 0.0 < self.rate <= MOST_RATE:
            raise SignalError(f"a rate must be greater than 0 and at most {MOST_RATE:g} Hz, not {self.rate:g}")
        if not 0.0 <= self.low_pass < 0.5 * self.rate:
            raise SignalError(
                f"a low-pass must be 0 or lie below half the rate, {0.5 * self.rate:g} Hz, not {self.low_pass:g}"
            )
        if (self.before is not None and not self.before > 0.0) or not self.after >= 0.0:
            raise SignalError("the time before the throw must be greater than 0, that after it 0 or more")


@dataclass(frozen=True)
class ArmAngles:
    """Angles (T, 7) in the order of `ANGLES`, rad, and the trunk, at times (T,), s."""

    time: Floats
    angles: Floats
    lean: Floats  # (T,) rad, of the trunk, forwards
    place: Floats  # (T, 2) m, of the shoulder, forwards and up
    release: float  # s, of the fastest extension of the elbow

    def columns(self) -> dict[str, Floats]:
        """What a file for `warpmuscle throw fit` holds, by name."""
        found = {"time_s": self.time}
        found |= {f"{name}_deg": np.degrees(column) for name, column in zip(ANGLES, self.angles.T, strict=True)}
        found["trunk_pitch_deg"] = np.degrees(self.lean)
        return found | {"shoulder_forward_m": self.place[:, 0], "shoulder_up_m": self.place[:, 1]}


def arm_angles(markers: Markers, choices: Choices | None = None) -> ArmAngles:
    """The angles of an arm that throws.

    Raises:
        SignalError: a marker is missing or lost for long, one stands for two roles, the elbow never extends, or the
            upper arm points so far sideways that no angle forwards can be determined.
    """
    choices = choices or Choices()
    points = _points(markers, choices)
    _check_apart(markers, choices, points, SAME)
    _check_body(markers, points, upright=choices.before is not None)
    _check_apart(markers, choices, points, APART)
    _check_hips(markers, points)
    time = np.arange(round(np.floor(markers.time[-1] * choices.rate + 1e-6)) + 1) / choices.rate
    points = {role: _smooth(markers, choices, time, values) for role, values in points.items()}
    forward, up = points["shoulder"][:, 0], points["shoulder"][:, 2]
    angles, lean = _angles(points, 1.0 if choices.side == "right" else -1.0)
    elbow, above = ANGLES.index("elbow"), points["wrist"][:, 2] > points["shoulder"][:, 2]
    rate = np.gradient(angles[:, elbow], time)
    if choices.before is not None and not np.any(above & (rate < 0.0)):
        raise SignalError("the wrist never rises above the shoulder while the elbow extends: there is no throw; "
                          "--whole keeps all", file=markers.path)  # fmt: skip
    release = float(time[np.argmin(np.where(above, rate, np.inf) if above.any() else rate)])
    keep = np.ones(len(time), dtype=bool)
    if choices.before is not None:
        _check_facing(markers, points, round(release * choices.rate), choices.side)
        keep = (time >= release - choices.before - 1e-9) & (time <= release + choices.after + 1e-9)
    _check_distinct(markers, time[keep], angles[keep])
    found = np.column_stack([forward, up])[keep]
    return ArmAngles(
        (time - (release if choices.before is not None else 0.0))[keep], angles[keep], lean[keep], found, release
    )


def _points(markers: Markers, choices: Choices) -> dict[str, Floats]:
    """Positions (T, 3) by role, forwards, to the left and up, m, gaps filled."""
    letter, other = ("R", "L") if choices.side == "right" else ("L", "R")
    up, forward = (_axis(axis) for axis in (choices.up, choices.forward))
    turn = np.stack([forward, np.cross(up, forward), up])
    found = {}
    for role, usual in ROLES.items():
        name = choices.markers.get(role, usual.replace("S_", f"{letter}_").replace("O_", f"{other}_"))
        try:
            values = markers.of(name)
        except SignalError as error:
            message = f"{error.message}; say which is the {role.replace('_', ' ')} by --marker {role}=NAME"
            message += ", or take the other arm by --side" if role == "elbow" and role not in choices.markers else ""
            raise SignalError(message, file=markers.path) from None
        found[role] = _filled(markers, name, values @ turn.T)
    return found


def _check_body(markers: Markers, points: Mapping[str, Floats], upright: bool) -> None:
    """SignalError unless the arm is about as long as arms are, and the trunk upright rather than not, if it should."""
    long = float(np.median(np.linalg.norm(points["elbow"] - points["shoulder"], axis=1)))
    if not UPPER_ARM[0] < long < UPPER_ARM[1]:
        fits = [unit for unit, size in UNITS.items() if UPPER_ARM[0] < size * long < UPPER_ARM[1]]
        what = f", for instance --unit {fits[0]}" if fits else ""
        raise SignalError(f"the upper arm is {long:.3g} m long; name the unit of positions{what}", file=markers.path)
    trunk = np.median(points["shoulder"] - points["hip"], axis=0)
    if upright and trunk[2] < 0.5 * np.linalg.norm(trunk):
        raise SignalError(
            "the shoulder is not above the hip; name the axis that points up, for instance --up y", file=markers.path
        )


def _check_apart(markers: Markers, choices: Choices, points: Mapping[str, Floats], least: float) -> None:
    """SignalError if markers of two roles are one and the same, or lie on each other."""
    hand = 0.5 * (points["hand_thumb"] + points["hand_little"])
    for first, second in SPANS:
        places = [hand if role == "hand" else points[role] for role in (first, second)]
        if float(np.median(np.linalg.norm(places[1] - places[0], axis=1))) >= least:
            continue
        names = " and ".join(role.replace("_", " ") for role in (first, second))
        used = {choices.markers[role] for role in (first, second) if role in choices.markers}
        which = f" ({' and '.join(sorted(used))})" if used else ""
        raise SignalError(
            f"{names} are at the same place{which}, so no angle follows from them; give each a marker of its "
            "own by --marker ROLE=NAME", file=markers.path,
        )  # fmt: skip


def _check_hips(markers: Markers, points: Mapping[str, Floats]) -> None:
    """SignalError if one marker stands for both hips, but lies under one shoulder rather than in the middle."""
    if float(np.median(np.linalg.norm(points["other_hip"] - points["hip"], axis=1))) >= APART:
        return
    across = points["shoulder"] - points["other_shoulder"]
    width = np.linalg.norm(across, axis=1)
    beside = np.sum((points["hip"] - 0.5 * (points["shoulder"] + points["other_shoulder"])) * across, axis=1) / width
    if abs(float(np.median(beside))) > ASIDE * float(np.median(width)):
        raise SignalError(
            f"one marker stands for both hips, and lies {100.0 * abs(float(np.median(beside))):.0f} cm to one side of "
            "the middle of the shoulders; name both hips, or one in the middle, by --marker ROLE=NAME",
            file=markers.path,
        )


def _check_distinct(markers: Markers, time: Floats, angles: Floats) -> None:
    """SignalError where the upper arm points straight sideways, and any angle forwards would do."""
    abduction = np.abs(angles[:, ANGLES.index("shoulder_abduction")])
    worst = int(abduction.argmax())
    if abduction[worst] > 0.5 * np.pi - SIDEWAYS:
        raise SignalError(
            f"the upper arm points sideways, {np.degrees(abduction[worst]):.0f} deg out of the trunk's sagittal plane "
            f"at {time[worst]:.3g} s, so its angle forwards cannot be determined; keep another part: --before, --after",
            file=markers.path,
        )  # fmt: skip


def _check_facing(markers: Markers, points: Mapping[str, Floats], frame: int, side: Side) -> None:
    """SignalError if the chest does not face where the throw goes when the elbow extends fastest."""
    across = (points["shoulder"] - points["other_shoulder"])[frame]
    chest = np.cross([0.0, 0.0, 1.0], across if side == "right" else -across)
    if chest[0] < FACING * np.linalg.norm(across):
        raise SignalError(
            "the chest does not face forwards when the arm throws; are --forward and --side right, and the axes of the "
            "file right-handed? --whole takes any motion", file=markers.path,
        )  # fmt: skip


def _axis(name: str) -> Floats:
    return np.asarray((-1.0 if name[0] == "-" else 1.0) * np.eye(3)[AXES[name]])


def _filled(markers: Markers, name: str, values: Floats) -> Floats:
    """Positions without gaps, which straight lines bridge."""
    seen = np.isfinite(values).all(axis=1)
    if not seen.any():
        raise SignalError(f"marker {name} is never seen", file=markers.path)
    times = markers.time[seen]
    gaps = np.diff(np.concatenate([[markers.time[0]], times, [markers.time[-1]]]))
    longest = int(np.argmax(gaps))
    step = float(np.median(np.diff(markers.time)))
    if gaps[longest] > LONGEST_GAP + step:
        begin = np.concatenate([[markers.time[0]], times])[longest]
        raise SignalError(
            f"marker {name} is lost for {gaps[longest]:.2g} s from {begin:.3g} s on; at most {LONGEST_GAP:g} s can be "
            "bridged", file=markers.path,
        )  # fmt: skip
    return np.stack([np.interp(markers.time, times, column) for column in values[seen].T], axis=1)


def _smooth(markers: Markers, choices: Choices, time: Floats, values: Floats) -> Floats:
    """Positions at other times, by a cubic spline, without what is faster than the low-pass."""
    from scipy.interpolate import make_interp_spline  # takes a second, which only recordings of arms cost
    from scipy.signal import butter, sosfiltfilt

    degree = min(3, len(markers.time) - 1)
    sampled = make_interp_spline(markers.time, values, k=degree)(time)
    if choices.low_pass == 0.0:
        return np.asarray(sampled)
    if len(time) < 16:
        raise SignalError(f"{time[-1]:.3g} s are too short for a low-pass; --low-pass 0 takes none", file=markers.path)
    sections = butter(2, choices.low_pass, fs=choices.rate, output="sos")
    return np.asarray(sosfiltfilt(sections, sampled, axis=0))


def _angles(points: Mapping[str, Floats], side: float) -> tuple[Floats, Floats]:
    """Angles (T, 7) of `ANGLES` and the trunk's lean forwards (T,); `side`: 1 of a right arm, -1 of a left one."""
    shoulders = 0.5 * (points["shoulder"] + points["other_shoulder"])
    up = normalized(shoulders - 0.5 * (points["hip"] + points["other_hip"]), TINY)
    across = points["shoulder"] - points["other_shoulder"]  # outwards
    outward = normalized(across - np.sum(across * up, axis=1, keepdims=True) * up, TINY)
    forward = np.cross(up, side * outward)
    trunk = np.stack([outward, up, forward], axis=1)  # rows
    upper = normalized(points["elbow"] - points["shoulder"], TINY)
    fore = normalized(points["wrist"] - points["elbow"], TINY)
    hand = normalized(0.5 * (points["hand_thumb"] + points["hand_little"]) - points["wrist"], TINY)
    width = points["hand_thumb"] - points["hand_little"]
    thumb = normalized(width - np.sum(width * hand, axis=1, keepdims=True) * hand, TINY)
    u, v, h, k = (np.einsum("tij,tj->ti", trunk, x) for x in (upper, fore, hand, thumb))
    flexion = np.unwrap(np.arctan2(u[:, 2], -u[:, 1]))
    abduction = np.arcsin(np.clip(u[:, 0], -1.0, 1.0))
    v, h, k = (_turned(_turned(x, 0, flexion), 2, -abduction) for x in (v, h, k))
    elbow = np.arccos(np.clip(-v[:, 1], -1.0, 1.0))
    rotation = _where_bent(np.unwrap(np.arctan2(-v[:, 0], v[:, 2])), elbow)
    h, k = (_turned(_turned(x, 1, rotation), 0, elbow) for x in (h, k))
    axes = np.stack([np.cross(-h, k), -h, k], axis=2)  # to the back of the hand, against the fingers, to the thumb
    pronation = np.unwrap(np.arctan2(-axes[:, 0, 2], axes[:, 2, 2]))
    deviation = np.arcsin(np.clip(axes[:, 1, 2], -1.0, 1.0))
    wrist = np.unwrap(np.arctan2(-axes[:, 1, 0], axes[:, 1, 1]))
    angles = np.column_stack([flexion, abduction, rotation, elbow, pronation, deviation, wrist])
    return angles, np.unwrap(np.arctan2(up[:, 0], up[:, 2]))


def _turned(x: Floats, axis: int, angle: Floats) -> Floats:
    """Vectors (T, 3), outwards, up and forwards, turned by an angle (T,) about one of these axes."""
    a, b = ((1, 2), (2, 0), (0, 1))[axis]
    out, cosine, sine = x.copy(), np.cos(angle), np.sin(angle)
    out[:, a], out[:, b] = cosine * x[:, a] - sine * x[:, b], sine * x[:, a] + cosine * x[:, b]
    return out


def _where_bent(rotation: Floats, elbow: Floats) -> Floats:
    """A rotation that goes on straight where the elbow is too straight to tell it."""
    bent = elbow > STRAIGHT
    if not bent.any():
        return np.zeros_like(rotation)
    index = np.arange(len(rotation))
    return np.asarray(np.interp(index, index[bent], rotation[bent]))


def write_angles(path: Path, found: ArmAngles) -> None:
    """Write a table that `warpmuscle throw fit` reads."""
    columns = found.columns()
    lines = [",".join(columns)]
    lines += [",".join(f"{value:.6f}" for value in row) for row in np.column_stack(list(columns.values()))]
    replace_file(path, "\n".join(lines) + "\n")
