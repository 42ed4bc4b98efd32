"""The controller that a creature begins a search with: SIMBICON (Yin, Loken, van de Panne 2007).

Its torques are shared out among the muscles by least effort. Both legs have the same numbers. A creature that moves in
space is balanced to its sides, too: legs in the air are placed where it drifts to.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from warpmuscle.creatures.description import Creature, CreatureGait, Place, joint_of, sided
from warpmuscle.creatures.skeleton import JOINT_AXIS, SIDE_AXIS, mass, rounded
from warpmuscle.scene import PD, Balance, Component, Controller, Curve, Feedback, MachineState, Trajectory
from warpmuscle.scene.number import Free, Number
from warpmuscle.scene.part import Side

FORWARD = (0.0, 0.0, 1.0)
LEFT = (1.0, 0.0, 0.0)
GRAVITY = 9.8  # m/s^2
ROOT_STIFFNESS = 4.0  # 1/rad, over weight times height of the hips, about that of SIMBICON's biped
JOINT_STIFFNESS = 0.4  # the same of joints
LEANING = 0.15  # rad, by which a search may change the lean, either way
TIMES = 3.0  # by which a search may change stiffnesses and times two ways
DAMPING = 0.1  # s, over stiffness
FEEDBACK = {"cd": (-0.3, -1.0, 0.3), "cv": (-0.25, -0.8, 0.1)}  # rad/m and rad s/m of the hip: value, lowest, highest
SIDE_FEEDBACK = {"cd": (0.5, 0.0, 1.5), "cv": (0.3, 0.0, 1.0)}  # the same of hips to the side, as of SIMBICON's biped
APART = 0.2  # rad, by which a search may change angles to the side, either way
FEET_FEEDBACK = {"cd": (0.1, -0.5, 0.7), "cv": (0.1, -0.5, 0.7)}  # of level feet


def controller(creature: Creature) -> Controller:
    """The controller of a creature."""
    gait = creature.gait
    states = list(_walk(creature) if creature.gait.kind == "walk" else _hop(creature))
    feet = (sided(gait.feet, "l"), sided(gait.feet, "r"))
    hips = (sided(gait.hips, "l"), sided(gait.hips, "r"))
    pairs = {name: (sided(name, "r"), sided(name, "l")) for name in gait.crossed}
    return Controller(states=states, pd=_gains(creature), feet=feet, hips=hips, pairs=pairs)


def moving_joints(creature: Creature) -> dict[str, bool]:
    """Joints that move by their names without a side, and whether they are paired."""
    return {
        joint_of(name, segment): segment.paired
        for name, segment in creature.segments.items()
        if segment.parent and segment.range is not None
    }


def side_joints(creature: Creature) -> set[str]:
    """Pairs of joints that carry a leg and turn to the side, too: what balances a body that moves in space."""
    return {
        joint_of(name, segment)
        for name, segment in creature.segments.items()
        if segment.side is not None and segment.paired and not creature.segments[segment.parent].paired
    }


def weight_height(creature: Creature) -> float:
    """Weight times height of the hips in the standing pose, N m: what stiffnesses grow with."""
    kilograms = sum(mass(creature, one) * (2 if one.paired else 1) for one in creature.segments.values())
    hip = next(one for name, one in creature.segments.items() if joint_of(name, one) == creature.gait.hips)
    return GRAVITY * kilograms * (hip.start if hip.at is None else hip.at)[1]


def _gains(creature: Creature) -> dict[str, PD]:
    """Stiffness and damping of the root and all joints that move; the right side follows the left."""
    unit, given = weight_height(creature), creature.gait.stiffness
    gains = {"root": _pd(given.get("root", ROOT_STIFFNESS * unit), "root")}
    for name, paired in moving_joints(creature).items():
        kp = given.get(name, JOINT_STIFFNESS * unit)
        first = sided(name, "l") if paired else name
        gains[first] = _pd(kp, first)
        if paired:
            key = f"controller.pd.{first}.kp"
            gains[sided(name, "r")] = PD(kp=Free(same_as=key), kd=Free(same_as=key, factor=DAMPING))
    return gains


def _pd(kp: float, name: str) -> PD:
    kp = rounded(kp)
    free = Free(kp, rounded(kp / TIMES), rounded(kp * TIMES), scale="log")
    return PD(kp=free, kd=Free(same_as=f"controller.pd.{name}.kp", factor=DAMPING))


def _walk(creature: Creature) -> Iterator[MachineState]:
    """One state, a step, in which legs change their roles at its end."""
    gait = creature.gait
    trajectories = {"root": _targets([gait.lean], LEANING)}
    for where, table in (("SWING", gait.swing), ("STANCE", gait.stance)):
        for name, angles in table.items():
            leg = _leg(gait, name, angles, where == "SWING")
            if where == "SWING" and name in side_joints(creature):
                outwards: Side = "right" if name in gait.crossed else "left"  # where outwards is to the right
                leg.components.append(_aside(gait, name, outwards, feedback=True))
            trajectories[f"{where}_{name}"] = leg
    trajectories |= {name: _targets(angles, gait.freedom) for name, angles in gait.steady.items()}
    yield MachineState(time=_time(gait.time), trajectories=trajectories, longest=1.5)


def _hop(creature: Creature) -> Iterator[MachineState]:
    """In the air until the feet are down, then on the ground for a time; both legs do the same."""
    gait = creature.gait
    for number, (time, table) in enumerate(((gait.time, gait.swing), (gait.ground_time, gait.stance))):
        trajectories = {"root": _targets([gait.lean], LEANING)}
        for name, angles in table.items():
            left = _leg(gait, name, angles, number == 0)
            if name in side_joints(creature):
                left.components.append(_aside(gait, name, "never", feedback=number == 0))
            trajectories[sided(name, "l")] = left
            key = f"controller.states.{number}.trajectories.{sided(name, 'l')}"
            trajectories[sided(name, "r")] = _following(left, key)
        trajectories |= {name: _targets(angles, gait.freedom) for name, angles in gait.steady.items()}
        yield MachineState(
            time=_time(time), trajectories=trajectories, next=1 - number, stance="left",
            transition="foot_down" if number == 0 else "time_up", longest=2.0 if number == 0 else 1.0,
            balance=_between_feet(creature),
        )  # fmt: skip


def _between_feet(creature: Creature) -> Balance | None:
    """What is fed back of a hopper to its sides: its distance from the middle, and not from its left foot."""
    if not creature.spatial:
        return None
    foot = creature.segments[creature.gait.feet]
    aside = 0.5 * (foot.start[0] + foot.end[0])
    return Balance(distance_x=Curve(phase=[0.0], value=[rounded(-aside)]))


def _time(seconds: float) -> Free:
    return Free(seconds, rounded(seconds / 2.0), rounded(seconds * 2.0))


def _leg(gait: CreatureGait, name: str, angles: list[float], swings: bool) -> Trajectory:
    """Targets of a joint of the legs: hips steer the foot that swings by balance feedback, level feet push."""
    feedback = None
    if name == gait.hips and swings:
        feedback = _feedback(FEEDBACK)
    elif name in gait.level and not swings:
        feedback = _feedback(FEET_FEEDBACK)
    in_space = name == gait.hips or name in gait.level
    return _targets(angles, gait.freedom, feedback, "character" if in_space else "parent")


def _aside(gait: CreatureGait, name: str, reverse_on: Side | Literal["never"], feedback: bool) -> Component:
    """The turn to the side of a joint that carries a leg, after its turn about x."""
    apart = gait.apart.get(name, 0.0)
    return Component(
        axis=SIDE_AXIS, phase=[0.0], angle=[Free(apart, rounded(apart - APART), rounded(apart + APART))],
        reverse_on=reverse_on, feedback=_feedback(SIDE_FEEDBACK, LEFT) if feedback else None,
    )  # fmt: skip


def _feedback(table: dict[str, tuple[float, float, float]], axis: Place = FORWARD) -> Feedback:
    return Feedback(axis=axis, cd=Free(*table["cd"]), cv=Free(*table["cv"]))


def _targets(
    angles: list[float], freedom: float, feedback: Feedback | None = None, frame: str = "parent"
) -> Trajectory:
    """Free targets that are evenly spread over the phase."""
    phase: list[Number] = [rounded(at) for at in np.linspace(0.0, 1.0, len(angles))]
    free: list[Number] = [Free(angle, rounded(angle - freedom), rounded(angle + freedom)) for angle in angles]
    component = Component(axis=JOINT_AXIS, phase=phase, angle=free, feedback=feedback)
    return Trajectory(components=[component], frame=frame)  # type: ignore[arg-type]


def _following(left: Trajectory, key: str) -> Trajectory:
    """The same targets of the right joint, which follow those of the left; outwards is the other way."""
    followers = []
    for number, component in enumerate(left.components):
        own = f"{key}.components.{number}"
        feedback = component.feedback
        if feedback is not None:
            cd, cv = (Free(same_as=f"{own}.feedback.{gain}") for gain in ("cd", "cv"))
            feedback = Feedback(axis=feedback.axis, cd=cd, cv=cv)
        sign = -1.0 if component.axis == SIDE_AXIS else 1.0
        angles: list[Number] = [Free(same_as=f"{own}.angle.{k}", factor=sign) for k in range(len(component.angle))]
        followers.append(Component(axis=component.axis, phase=component.phase, angle=angles, feedback=feedback))
    return Trajectory(components=followers, frame=left.frame)
