"""What the muscles of an arm lack for motions, joint by joint, and in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import number_of
from warpmuscle.synergy.static_optimization import StaticOptimization
from warpmuscle.throw.arm import Arm, needed_torques
from warpmuscle.throw.motion import ArmMotions

SPIKE = 0.01  # part of the frames in which muscles may fall short without a word: noise of twice differentiated angles
HOPELESS = 1.5  # times what muscles make, beyond which it is not their strength alone that an arm lacks


@dataclass(frozen=True)
class Lack:
    """What the muscles lack for a motion."""

    motion: str
    explanation: str  # of `StaticOptimization.explanation`
    frames: float  # part of the frames in which they do not suffice
    joint: str  # where most is missing, in parts of what it needs, and when
    time: float  # s
    needed: float  # N m
    missing: float  # N m
    least: float  # N m that the muscles make there at least, by passive forces too, and at most
    most: float
    others: tuple[str, ...] = ()  # joints that need torque at the same time, where this one's could be had alone

    @property
    def bound(self) -> float:
        """N m, of those that the muscles make the nearest to what is needed."""
        return float(np.clip(self.needed, self.least, self.most))

    @property
    def weak(self) -> bool:
        """Whether the muscles pull the right way, but not enough; else their passive forces pull too much."""
        return not self.others and self.needed * self.bound >= 0.0 and abs(self.needed) > abs(self.bound)

    @property
    def made(self) -> str:
        """What the muscles make there."""
        if self.others:
            others = " and ".join(name.replace("_", " ") for name in self.others)
            return f"which they do not make together with the torques of {others}"
        if self.weak:
            return f"and they make at most {self.bound:.3g}"
        if self.needed * self.bound >= 0.0:
            return f"and stretched as they are they make at least {self.bound:.3g}"
        return f"and stretched as they are they make {self.bound:.3g} or more the other way"


def lacking(arm: Arm, motions: ArmMotions, found: StaticOptimization, unknowns: Floats) -> list[Lack]:
    """Motions for which the muscles do not suffice in more than a spike.

    Args:
        found: what `computed_activation` found with the parameters `unknowns` (P,).
    """
    samples = len(motions.time)
    lacks = []
    for row in range(len(motions)):
        part = slice(row * samples, (row + 1) * samples)
        individual = StaticOptimization(
            found.activation[part], found.needed[part], found.torque_error[part], found.unreachable[part],
            found.feasible[part],
        )  # fmt: skip
        missing = float((~individual.feasible).sum() / motions.valid[row].sum())
        if missing > SPIKE:
            text = individual.explanation(arm.muscles, arm.driven, motions.time)
            lacks.append(_worst(arm, motions, row, individual.torque_error, unknowns, text, missing))
    return lacks


def _worst(arm: Arm, motions: ArmMotions, row: int, error: Floats, unknowns: Floats, text: str, frames: float) -> Lack:
    """The joint and the time where most of what a motion needs of a joint is missing."""
    needed = needed_torques(arm, motions.rows([row]))[0][:, arm.free]
    part = np.abs(error) / np.maximum(np.abs(needed).max(axis=0), 1e-9)
    frame, joint = (int(k) for k in np.unravel_index(part.argmax(), part.shape))
    table = arm.muscle_table(unknowns[None])
    angle, speed = (motions.angles[order][row, frame : frame + 1] for order in (0, 1))
    passive, full = (table.torques(level, angle, speed)[0, 0][:, arm.free] for level in (0.0, 1.0))
    least, most = (passive + bound(full - passive, 0.0) for bound in (np.minimum, np.maximum))
    low, high, at = float(least.sum(axis=0)[joint]), float(most.sum(axis=0)[joint]), float(needed[frame, joint])
    others = tuple(name for k, name in enumerate(arm.driven) if k != joint) if low <= at <= high else ()
    return Lack(
        motions.names[row], text, frames, arm.driven[joint], float(motions.time[frame]), at,
        float(abs(error[frame, joint])), low, high, others,
    )  # fmt: skip


def shortcoming(arm: Arm, lacks: Sequence[Lack], count: int, whose: str) -> str:
    """One sentence about what an arm lacks for some of `count` motions; empty if nothing.

    Args:
        whose: what the muscles are called.
    """
    if not lacks:
        return ""
    worst = max(lacks, key=lambda lack: lack.missing / max(abs(lack.needed), 1e-9))
    which = worst.motion if count == 1 else f"{len(lacks)} of {number_of(count, 'motion')}"
    text = (
        f"{whose} cannot make {which}: the {worst.joint.replace('_', ' ')} needs {worst.needed:.3g} N m"
        f"{f' in {worst.motion}' if count > 1 else ''} at {worst.time:.2f} s, {worst.made}"
    )
    turning = any("rotation" in name for name in arm.joints)
    if not turning and worst.weak and abs(worst.needed) > HOPELESS * max(abs(worst.bound), 1e-9):
        text += (
            "; pitches and serves get their speed from turning trunk, upper arm and forearm about themselves, which "
            f"an arm of {', '.join(arm.driven)} does not do"
        )
    return text
