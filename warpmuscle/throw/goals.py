"""What a ball is to do, how it flies, and what of that it misses."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error

# By which a ball may miss its goal: m, m/s, rad, s; and by which joints may pass their limits, rad.
ALLOWED = {"distance": 0.05, "speed": 0.1, "angle": np.radians(2.0), "duration": 0.02}
PAST_LIMITS = np.radians(1.0)
UNITS = {"distance": 0.02, "speed": 0.05, "angle": np.radians(1.0), "duration": 0.01}  # errors that count as 1
LIMITS, LIMIT_UNIT = "limits", np.radians(1.0)
NAMES = {"distance": "distance", "speed": "speed", "angle": "angle", "duration": "time", LIMITS: "limits of joints"}
BEYOND = 50.0  # units; misses that are greater count by their logarithm, lest one swamps the others


@dataclass(frozen=True)
class Goal:
    """What a ball is to do; what is None may be anything."""

    distance: float | None = None  # m, forwards from below the shoulder's start to where it meets the height
    height: float = 0.0  # m, of the target above the ground
    speed: float | None = None  # m/s, at release
    angle: float | None = None  # rad, of the velocity above the horizontal at release
    duration: float | None = None  # s, of the flight from release to the height

    def __post_init__(self) -> None:
        if not self.named:
            raise Error("a throw needs a goal: a distance, a speed or an angle of release, or a time of flight")
        for name, most in (("distance", 100.0), ("speed", 100.0), ("duration", 10.0)):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < most:
                raise Error(
                    f"the {NAMES[name]} of a throw must be greater than 0 and less than {most:g}, not {value:g}"
                )
        if self.angle is not None and not abs(self.angle) <= np.pi / 2.0:
            raise Error(f"the angle of a throw must be from -90 to 90 deg, not {np.degrees(self.angle):g} deg")
        if not -10.0 <= self.height <= 100.0:
            raise Error(f"the height of a target must be from -10 to 100 m, not {self.height:g} m")

    @property
    def named(self) -> tuple[str, ...]:
        """What the goal is about: some of distance, speed, angle and duration."""
        return tuple(f.name for f in fields(self) if f.name in UNITS and getattr(self, f.name) is not None)

    def __str__(self) -> str:
        parts = [f"to {self.distance:g} m"] if self.distance is not None else []
        parts += [f"at {self.height:g} m of height"] if self.distance is not None and self.height else []
        parts += [f"with {self.speed:g} m/s"] if self.speed is not None else []
        parts += [f"at {np.degrees(self.angle):.3g} deg"] if self.angle is not None else []
        parts += [f"in {self.duration:g} s"] if self.duration is not None else []
        return " ".join(parts)


@dataclass(frozen=True)
class Flight:
    """A ball's release and landing, of throws of any shape (...); forwards and up."""

    position: Floats  # (..., 2) m, at release, from below the shoulder's start and above the ground
    velocity: Floats  # (..., 2) m/s, at release
    distance: Floats  # (...) m, where it meets the target's height on its way down; NaN if it never does
    duration: Floats  # (...) s
    short: Floats  # (...) m, by which it stays below the target's height

    @property
    def speed(self) -> Floats:
        return np.asarray(np.linalg.norm(self.velocity, axis=-1))

    @property
    def angle(self) -> Floats:
        """Above the horizontal, rad."""
        return np.asarray(np.arctan2(self.velocity[..., 1], self.velocity[..., 0]))

    def misses(self, goal: Goal) -> dict[str, float]:
        """What one throw misses by more than is allowed, and by how much; infinite if it does not land."""
        found = {}
        for name in goal.named:
            error = abs(float(np.ravel(getattr(self, name))[0]) - getattr(goal, name))
            if not error <= ALLOWED[name]:
                found[name] = error if np.isfinite(error) else np.inf
        return found


def fly(position: Floats, velocity: Floats, gravity: float, height: float | Floats) -> Flight:
    """Flights without drag of balls let go at positions (..., 2) with velocities (..., 2), to heights, m."""
    drop = velocity[..., 1] ** 2 + 2.0 * gravity * (position[..., 1] - height)
    duration = np.where(drop >= 0.0, (velocity[..., 1] + np.sqrt(np.maximum(drop, 0.0))) / gravity, np.nan)
    short = np.maximum(-drop, 0.0) / (2.0 * gravity)
    return Flight(position, velocity, position[..., 0] + velocity[..., 0] * duration, duration, short)


def misfit(flight: Flight, goal: Goal) -> Floats:
    """Squared misses (...) in their units, growing slower far from the goal."""
    apex = np.maximum(flight.velocity[..., 1], 0.0) / 9.81
    landed = np.isfinite(flight.duration)
    total = np.zeros(flight.short.shape)
    for name in goal.named:
        value = getattr(flight, name)
        if name == "duration":
            value = np.where(landed, value, apex)
        if name == "distance":  # of one that stays below the target, where it is highest
            value = np.where(landed, value, flight.position[..., 0] + flight.velocity[..., 0] * apex)
        total = total + tamed((value - getattr(goal, name)) / UNITS[name])
    return np.asarray(total + tamed(flight.short / UNITS["distance"]))


def tamed(error: Floats) -> Floats:
    """Squares of errors (...), in units of what may be missed; beyond 50 they grow as slowly as a logarithm."""
    size = np.abs(error)
    far = np.maximum(size / BEYOND, 1.0)
    return np.asarray(np.minimum(size, BEYOND) ** 2 * (1.0 + 2.0 * np.log(far)))
