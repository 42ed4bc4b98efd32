"""What a gait must reach and what it should, and how a measure of one compares with that."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from warpmuscle.gait.body_motion import CADENCE_AT_SPEED, FORCE_AT_SPEED
from warpmuscle.gait.muscle_effort import BHARGAVA_NET, BHARGAVA_STRICT
from warpmuscle.gait.quality import ACTIVE, INSIDE, TIMING, VARIABILITY
from warpmuscle.gait.swing import ARMS, CALF, CLEARANCE

RUNS = 20  # disturbed ones
NOTHING = 1e-9  # below which a value is rounding alone, as of a turn out of the plane that a body moves in
HUMPS = "force at peaks and valley"
COST, COST_STRICT, COST_WANG = BHARGAVA_NET, BHARGAVA_STRICT, "cost of transport, Wang"
ECONOMICAL, UPHILL, LOADED = "most economical speed", "5 degrees up against level", "loads, farthest from proportional"
OF_ENERGY = (COST, COST_STRICT, COST_WANG, "muscle mass", ECONOMICAL, UPHILL, LOADED)  # which only muscles have
ACTIVATION = "mean activation"
OF_MUSCLES = (*OF_ENERGY, TIMING, ACTIVE, ACTIVATION, CALF)


@dataclass(frozen=True)
class Bar:
    """What a gait must reach, and what it should: lowest and highest values, None where there is none."""

    name: str
    unit: str
    must: tuple[float | None, float | None]
    goal: tuple[float | None, float | None]

    def reached(self, value: float) -> str:
        """Which of the two a value reaches: goal, must or neither."""
        if _within(value, self.goal):
            return "goal"
        return "must" if _within(value, self.must) else "missed"


# People have the goals, or come near them: sources stand in docs/explanation/gaits.md.
UPRIGHT = Bar("upright, disturbed", f"of {RUNS}", (19, None), (20, None))
PUSHED = Bar("impulse that half survive", "N s", (60, None), (80, None))
APART = Bar(INSIDE, "cm", (None, 1.0), (None, 0.3))  # skin and flesh give way by as much
# Of moments: two clinical centres are 0.9, 0.6 and 0.1 SD from each other at hip, knee and ankle; at 15 % of the cycle
# their knees carry 0.34 and 0.43 N m/kg.
# Of powers they are 0.94, 0.85 and 0.56 SD from each other: goals are that, rounded up, and 0.6 more is enough.
# Of the trunk: one and two standard deviations about people's means (Chung 2010).
WALK = (
    APART,
    Bar("angles outside the norms", "SD", (None, 0.25), (None, 0.12)),
    Bar("hip moment from people", "SD", (None, 1.5), (None, 0.9)),
    Bar("knee moment from people", "SD", (None, 1.2), (None, 0.6)),
    Bar("ankle moment from people", "SD", (None, 0.6), (None, 0.3)),
    Bar("hip power from people", "SD", (None, 1.6), (None, 1)),
    Bar("knee power from people", "SD", (None, 1.5), (None, 0.9)),
    Bar("ankle power from people", "SD", (None, 1.2), (None, 0.6)),
    Bar("knee moment in loading", "N m/kg", (0.15, 0.6), (0.3, 0.45)),
    Bar(HUMPS, "half-widths", (None, 1.0), (None, 0.6)),
    Bar("maximum vertical force", "body weights", (None, 1.2), (None, 1.15)),
    Bar(FORCE_AT_SPEED, "body weights", (None, 0.1), (None, 0.06)),  # two studies differ by 0.04 and 0.07
    Bar("maximum braking force", "body weights", (0.1, 0.26), (0.14, 0.22)),
    Bar("maximum driving force", "body weights", (0.13, 0.28), (0.17, 0.24)),
    Bar("travel of the centre of pressure", "% of the foot", (65, 95), (75, 90)),
    Bar("stance", "% of the cycle", (59, 65), (61, 63)),
    Bar("double support", "% of the cycle", (18, 25), (20, 24)),
    Bar("step width", "m", (0.03, 0.16), (0.05, 0.13)),
    Bar(CADENCE_AT_SPEED, "%", (-10, 10), (-5, 5)),
    Bar("sway from people", "SD", (None, 2.0), (None, 1.0)),
    Bar("pelvis tilt, range", "deg", (None, 8), (None, 5)),
    Bar("pelvis obliquity from people", "SD", (None, 1.5), (None, 0.8)),  # two centres differ by 0.3
    Bar("pelvis rotation from people", "SD", (None, 1.5), (None, 0.8)),
    Bar("trunk tilt, range", "deg", (0.4, 7.6), (2.2, 5.8)),
    Bar("trunk obliquity, range", "deg", (0.5, 6.1), (1.9, 4.7)),
    Bar("trunk rotation, range", "deg", (1.1, 12.7), (4.0, 9.8)),
    Bar(TIMING, "% beyond chance", (40, None), (70, None)),
    Bar(COST, "J/(kg m)", (0.0, 3.6), (0.0, 3.3)),  # muscles that are pulled can take up more than they spend
    Bar(COST_STRICT, "J/(kg m)", (0.0, 4.2), (0.0, 3.5)),  # Falisse 2022 by such rules; people
    Bar(COST_WANG, "J/(kg m)", (0.0, 5.0), (0.0, 4.5)),
    Bar("muscle mass", "% of the body", (None, 40), (None, 40)),
    UPRIGHT,
    PUSHED,
    Bar(ECONOMICAL, "m/s", (1.1, 1.5), (1.2, 1.4)),
    Bar(UPHILL, "J/(kg m)", (2.4, 4.0), (2.8, 3.6)),
    Bar(LOADED, "%", (-10, 10), (-5, 5)),
)
# Rows whose norm is people's at a comfortable speed: at others they tell a difference, and judge nothing.
COMFORTABLE = (
    "hip moment from people", "knee moment from people", "ankle moment from people", "hip power from people",
    "knee power from people", "ankle power from people", "knee moment in loading", HUMPS,
    "maximum vertical force", "maximum braking force", "maximum driving force", "stance", "double support",
    "pelvis obliquity from people", "pelvis rotation from people",
    "trunk tilt, range", "trunk obliquity, range", "trunk rotation, range", "sway of the centre of mass",
    "likeness of the knee moment", "knee moment before push-off", "ankle moment, maximum", "ankle power, maximum",
)  # fmt: skip
RUN = (
    APART,
    Bar("toe-off", "% of the cycle", (36, 44), (39, 41)),
    Bar("angles outside the norms", "SD", (None, 1.5), (None, 1.0)),
    Bar("maximum vertical force", "body weights", (None, 2.9), (None, 2.6)),
    Bar("flight", "% of the cycle", (1, None), (10, None)),
    UPRIGHT,
    PUSHED,
)
# What is asked besides: a table of its own, so that the rows above can be compared with those of earlier judgements.
# The knee before push-off: people's mean and one standard deviation are 0.11 N m/kg in one centre; the knees' curves of
# two centres correlate by 0.93. Steps of people vary by 5 to 30 mm from one to the next.
RUNNING = 3.5  # m/s
PUSH = 80.0  # N s, from the side
AT_RUNNING = {  # rows of a run at that speed, and the measures that they are of
    f"flight at {RUNNING:g} m/s": "flight",
    f"maximum vertical force at {RUNNING:g} m/s": "maximum vertical force",
    f"knee in swing at {RUNNING:g} m/s": "knee, maximum in swing",
}
ALL_AT_ONCE = Bar("upright, all at once", f"of {RUNS}", (19, None), (20, None))
ASIDE = Bar(f"upright after {PUSH:g} N s from the side", f"of {RUNS}", (16, None), (19, None))
MET = Bar("commands met", f"of {RUNS}", (19, None), (20, None))
_FLIGHT, _FORCE, _KNEE = AT_RUNNING
_TRIALS = (
    ALL_AT_ONCE,
    ASIDE,
    MET,
    Bar(_FLIGHT, "% of the cycle", (20, None), (30, None)),
    Bar(_FORCE, "body weights", (2.0, 2.9), (2.2, 2.6)),
    Bar(_KNEE, "deg", (80, None), (95, None)),
)
_ACTIVATION = Bar(ACTIVATION, "0 to 1", (None, None), (None, None))  # nobody knows people's in these models
# Told, and asked by nobody, so that a gait shows what it does where nothing made it: people's stand in `REFERENCES`.
UNJUDGED = (
    Bar(CLEARANCE, "cm", (None, None), (None, None)),
    Bar("pelvis obliquity, range", "deg", (None, None), (None, None)),
    Bar("pelvis rotation, range", "deg", (None, None), (None, None)),
    Bar(ARMS, "deg", (None, None), (None, None)),
    Bar(CALF, "%", (None, None), (None, None)),
)
FURTHER_WALK = (
    Bar(ACTIVE, "share", (0.75, None), (0.9, None)),
    _ACTIVATION,
    Bar("sway of the centre of mass", "cm", (2.5, 5.5), (3, 5)),
    Bar("likeness of the knee moment", "correlation", (0.8, None), (0.95, None)),
    Bar("knee moment before push-off", "N m/kg", (None, 0.15), (None, 0.11)),
    Bar("ankle moment, maximum", "N m/kg", (1.1, 1.6), (1.1, 1.6)),
    Bar("ankle power, maximum", "W/kg", (2.0, 3.5), (2.4, 3.0)),
    Bar(VARIABILITY, "mm", (5, 30), (5, 30)),
    *UNJUDGED,
    *_TRIALS,
)
FURTHER_RUN = (_ACTIVATION, *_TRIALS)


class Finding(NamedTuple):
    """A value, or None; a note on it, whether the gait is too bad to have one, and whether its bar judges it at all."""

    value: float | None
    note: str = ""
    failed: bool = False
    judges: bool = True


@dataclass(frozen=True)
class Verdict:
    """A measure of a gait beside its bar; no value where it could not be measured, and why not."""

    bar: Bar
    value: float | None
    note: str = ""
    failed: bool = False  # the gait is too bad to have a value, as after a fall
    judges: bool = True  # else its bar is of people at another speed, and tells a difference only
    void: bool = False  # the gait is impossible, so that nothing that it reaches counts

    @property
    def shown(self) -> str:
        """The value in three digits; nothing where there is none, and rounding of a plane is no motion out of it."""
        if self.value is None:
            return ""
        return "0" if abs(self.value) < NOTHING else f"{self.value:.3g}"

    @property
    def reached(self) -> str:
        """Goal, must, missed, not measured; or that it does not count, or is no judge at this speed."""
        if self.value is None:
            return "missed" if self.failed else "not measured"
        if not self.judges:
            return "does not count" if self.void else "no judge"
        reached = self.bar.reached(self.value)
        return "does not count" if self.void and reached != "missed" else reached


def _within(value: float, ends: tuple[float | None, float | None]) -> bool:
    low, high = ends
    return (low is None or value >= low) and (high is None or value <= high)


def ends(interval: tuple[float | None, float | None]) -> str:
    """An interval in words; nothing where it has no ends."""
    low, high = interval
    if low is None:
        return "" if high is None else f"up to {high:g}"
    return f"{low:g} or more" if high is None else f"{low:g} to {high:g}"
