"""Fitted and new throws as motions of the usual layout, with the recorded motion as what the joints were to do.

And what new throws were to do and did, a row a throw.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.hdf5_writing import store
from warpmuscle.results.recording import Recording
from warpmuscle.scene.joints import joint_type
from warpmuscle.throw.fit import Fitted
from warpmuscle.throw.follow import Follower
from warpmuscle.throw.published import Published, without_dynamics
from warpmuscle.throw.simulator import Simulator
from warpmuscle.throw.synthesis import Throw

GOALS = {
    "distance": "distance at which the ball is to land",
    "height": "height of the target above the ground",
    "speed": "speed at which the ball is to leave the hand",
    "angle": "angle above the horizontal at which it is to",
    "duration": "time from the release to the height of the target",
}
GOAL_UNITS = {"distance": "m", "height": "m", "speed": "m/s", "angle": "rad", "duration": "s"}
Column = tuple[str, str, Callable[[Throw], Any]]  # unit, description, and the value of a throw
OF_THROWS: dict[str, Column] = {
    "met": ("", "whether the throw does what its goal asks for", lambda made: made.met),
    "release_time": (
        "s", "when the ball leaves the hand, from the begin of the motion", lambda made: made.release,
    ),
    "release_speed": ("m/s", "speed of the ball as it leaves the hand", lambda made: float(made.flight.speed[0])),
    "release_angle": (
        "rad", "angle of its velocity above the horizontal", lambda made: float(made.flight.angle[0]),
    ),
    "flight_time": (
        "s", "from the release to the landing, not a number if there is none",
        lambda made: float(made.flight.duration[0]),
    ),
    "ground": ("m", "height of the ground in the scene", lambda made: made.ground),
    "clearance": ("m", "of the hand above the shoulder at the release", lambda made: made.clearance),
    "effort": ("", "mean square of the excitations", lambda made: made.effort),
    "change": ("", "root mean square of the change of the signals", lambda made: made.change),
    "simulations": ("", "motions that were simulated to find the throw", lambda made: made.simulations),
}  # fmt: skip
POINTS: dict[str, Column] = {
    "release_position": ("m", "where the ball leaves the hand", lambda made: made.flight.position.reshape(2)),
    "release_velocity": (
        "m/s", "velocity of the ball as it leaves the hand", lambda made: made.flight.velocity.reshape(2),
    ),
    "landing_position": (
        "m", "where the ball comes to the height of the target, not a number if nowhere", lambda made: made.landing,
    ),
}  # fmt: skip
MAY_LACK = ("flight_time", "landing_position", "clearance")  # NaN where there is none


@dataclass(frozen=True)
class Replays:
    """Motions with their names, simulated with the same parameters (P,) of the scene."""

    names: tuple[str, ...]
    motions: tuple[Recording, ...]
    parameters: Floats


def fitted_replays(follower: Follower, fitted: Fitted, throws: Sequence[Throw] = ()) -> Replays:
    """Every motion as it was fitted, and behind them the throws that were made out of the first."""
    motions = follower.motions
    which = np.array([*range(len(motions)), *(0 for _ in throws)], dtype=np.intp)
    individual = np.concatenate([fitted.individual, *(made.individual[None] for made in throws)])
    values = follower.arm.values(fitted.unknowns)
    excitation, start = follower.excitation(individual), follower.start(individual)
    found = follower.simulator.recordings(which, follower.knots.time, excitation, values, start)
    names = (*motions.names, *(_name(made) for made in throws))
    recorded = zip(found, which, strict=True)
    return Replays(names, tuple(_beside_recorded(one, follower, int(row)) for one, row in recorded), values)


def published_replay(follower: Follower, published: Published) -> Replays:
    """The first motion after the published procedure, which gives every motion parameters of its own."""
    arm, first = follower.arm, follower.motions.rows([0])
    plain = replace(arm, scene=without_dynamics(arm))
    values = arm.values(published.unknowns[0])
    excitation = follower.synergies.excitation(published.signals[:1]).transpose(0, 2, 1)
    simulator = Simulator(plain, first, device=follower.simulator.device, threads=follower.simulator.threads)
    found = simulator.recordings(np.zeros(1, dtype=np.intp), first.time, excitation, values)
    return Replays(first.names, (_beside_recorded(found[0], follower, 0),), values)


def _name(made: Throw) -> str:
    goal = made.goal
    if goal.distance is not None:
        return f"throw at {goal.distance:g} m"
    parts = [f"{goal.speed:g} m/s"] if goal.speed is not None else []
    parts += [f"{np.degrees(goal.angle):.3g} deg"] if goal.angle is not None else []
    parts += [f"{goal.duration:g} s"] if goal.duration is not None else []
    return f"throw of {', '.join(parts)}"


def _beside_recorded(simulated: Recording, follower: Follower, motion: int) -> Recording:
    """The frames that the recorded motion has, with its angles as targets; other joints have none but what they did."""
    arm, motions = follower.arm, follower.motions
    frames = min(simulated.frames, int(motions.valid[motion].sum()))
    character = arm.plain.character
    target = simulated.joint_orientation.copy()
    for column, name in enumerate(arm.joints):
        joint, place = character.joints[name], simulated.joint_names.index(name)
        q, rate = joint_type(joint).nearest(joint, target[:, place], np.zeros((len(target), 3)))
        q[:, arm.axes[name]] = motions.angles[0][motion, : simulated.frames, column]
        target[:, place] = joint_type(joint).motion(joint, q, rate).orientation
    return replace(simulated, joint_target=target).window(0.0, float(simulated.time[frames - 1]))


def put_throws(group: Any, throws: Sequence[Throw], joints: Sequence[str]) -> None:
    """Write n throws; what a goal does not name, and a landing that there is none of, is NaN.

    Places are forwards from below the shoulder's start and above the ground; angles are above the horizontal.
    """
    goals = group.create_group("goal", track_order=True)
    for name, unit in GOAL_UNITS.items():
        values = [getattr(made.goal, name) for made in throws]
        store(goals, name, np.array([np.nan if value is None else value for value in values]), units=unit, axes="throw",
              finite=False, description=GOALS[name])  # fmt: skip
    texts = {
        "goal_text": ([str(made.goal) for made in throws], "the goal of each new throw in words"),
        "missed": ([", ".join(made.missed) for made in throws], "what it does not meet, empty if all"),
    }
    for name, (words, description) in texts.items():
        store(group, name, tuple(words), axes="throw", description=description)
    for name, (unit, description, of) in OF_THROWS.items():
        store(group, name, np.array([of(made) for made in throws]), unit, "throw", description=description,
              finite=name not in MAY_LACK)  # fmt: skip
    for name, (unit, description, of) in POINTS.items():
        store(group, name, np.stack([of(made) for made in throws]), unit, "throw, forwards and up",
              description=description, finite=name not in MAY_LACK)  # fmt: skip
    for name, when in (("past_limits", "up to the release"), ("past_after", "behind the release")):
        past = [[getattr(made, name).get(joint, 0.0) for joint in joints] for made in throws]
        store(group, name, np.array(past), "rad", "throw, joint",
              description=f"by which a joint passes its limits at most, {when}")  # fmt: skip
