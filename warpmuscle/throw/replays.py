"""Fitted and new throws as motions of the usual layout, with the recorded motion as what the joints were to do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.results.recording import Recording
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.throw.fit import Fitted
from warpmuscle.throw.follow import Follower
from warpmuscle.throw.published import Published, without_dynamics
from warpmuscle.throw.simulator import Simulator
from warpmuscle.throw.synthesis import Throw


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
    own = np.concatenate([fitted.own, *(made.own[None] for made in throws)])
    values = follower.arm.values(fitted.unknowns)
    excitation, start = follower.excitation(own), follower.start(own)
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
    character = substitute(arm.scene, start_values(arm.scene)).character
    target = simulated.joint_orientation.copy()
    for column, name in enumerate(arm.joints):
        joint, place = character.joints[name], simulated.joint_names.index(name)
        q, rate = joint_type(joint).nearest(joint, target[:, place], np.zeros((len(target), 3)))
        q[:, arm.axes[name]] = motions.angles[0][motion, : simulated.frames, column]
        target[:, place] = joint_type(joint).motion(joint, q, rate).orientation
    return replace(simulated, joint_target=target).window(0.0, float(simulated.time[frames - 1]))
