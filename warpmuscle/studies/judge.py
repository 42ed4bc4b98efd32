"""A gait judged: its likeness to people's, cost and robustness, beside required and desired values.

One run of 60 s, twenty disturbed ones of 10 s, pushes, walks up a slope (deg) and with loads (kg), and at several
speeds (m/s) where it takes a speed; then what `hard_trials` ask. The same is asked of a scene's own controller and of a
policy, see `walkers`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import msgspec
import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of, rounded
from warpmuscle.core.status import Status
from warpmuscle.gait.cycles import NO_CYCLE
from warpmuscle.gait.measures import feet_of
from warpmuscle.gait.muscle_effort import LEAST_SPEED, spent
from warpmuscle.gait.penetration import penetration
from warpmuscle.gait.quality import LEAST_FLIGHT, VARIABILITY, Measures, gait_measures
from warpmuscle.model.muscles import driven
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Robustness, Scene
from warpmuscle.scene.accounting import FORMULAS
from warpmuscle.scene.controller import Command
from warpmuscle.scene.masses import body_mass, total_mass
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.perturbations import drawn, none
from warpmuscle.studies.hard_trials import of_measures, trials, variability
from warpmuscle.studies.people_comparison import of_force, of_norms
from warpmuscle.studies.robustness import IMPULSES, push_trials
from warpmuscle.studies.single_disturbances import MASS, NOISE, SEED, felled_by
from warpmuscle.studies.verdicts import (
    APART,
    COST,
    COST_STRICT,
    COST_WANG,
    ECONOMICAL,
    FURTHER_RUN,
    FURTHER_WALK,
    HUMPS,
    LOADED,
    OF_ENERGY,
    OF_MUSCLES,
    PUSHED,
    RUN,
    UPHILL,
    UPRIGHT,
    WALK,
    Bar,
    Finding,
    Verdict,
)  # fmt: skip
from warpmuscle.studies.verdicts import RUNS as RUNS
from warpmuscle.studies.walkers import Walker, loaded, under

LONG, SHORT, COMMANDED = 60.0, 10.0, 30.0  # s, of the run that is measured, of disturbed ones, of those at a command
SLOPE = float(np.radians(3.0))  # rad, of disturbed runs, whose noise and masses are those of `single_disturbances`
DISTURBED = (
    f"{SHORT:g} s, {NOISE:g} m/s of noise at the start, masses of bodies +-{100.0 * MASS:g} %, "
    f"slopes of +-{np.degrees(SLOPE):.0f} degrees"
)
PUSHES = 20  # of each impulse
SPEEDS = 7  # commanded, evenly over the range
UP = 5.0  # deg
LOADS = (0.18, 0.31)  # of the body weight
FAST = 2.0  # m/s: where people begin to run (Hreljac 1993: 2.07)
POWER = "walking power"  # W/kg, above that at rest


@dataclass(frozen=True)
class Asked:
    """A walk that a judgement asks for: commands of these names, or what a slope and a load are without such."""

    speed: float | None = None  # m/s
    slope: float | None = None  # deg
    load: float | None = None  # kg

    @property
    def numbers(self) -> dict[str, float]:
        """What is asked for, by name."""
        return {name: value for name, value in vars(self).items() if value is not None}


class Walked(NamedTuple):
    """A walk that was asked for: its measures, or why it has none, as that it falls."""

    asked: dict[str, float]
    measures: Measures
    why: str = ""


@dataclass(frozen=True)
class Judgement:
    """All verdicts on a gait.

    Attributes:
        running: whether it is judged as a run. end: how the long run ended. measures: all of it; none if it has no
            whole gait cycle.
        commanded: the walks at other speeds, on slopes and with loads. impossible: bodies are too deep inside each
            other for anything else to count. felled_by: of 20 runs with one disturbance each, how many fall.
        further: verdicts on what is asked besides. motion: the long run, of `scene`. impaired: what impairs its
            muscles, in words.
    """

    verdicts: list[Verdict]
    running: bool
    end: str
    measures: Measures
    commanded: list[Walked]
    impossible: bool = False
    felled_by: Mapping[str, int] = field(default_factory=dict)
    further: list[Verdict] = field(default_factory=list)
    motion: Recording | None = None
    scene: Scene | None = None
    impaired: tuple[str, ...] = ()


def judge(walker: Walker, *, pushes: int = PUSHES, tell: Callable[[str], None] = lambda _: None) -> Judgement:
    """Judge the gait of a walker as it is commanded.

    Args:
        pushes: of each impulse; 0 leaves them out. tell: is called with what is done next.

    Raises:
        Error: it has no feet.
    """
    scene = walker.scene()
    feet_of(scene)
    tell(f"walking {LONG:g} s")
    walks = walker.walk(LONG, none(1), record=True)
    end = Status(walks.status[0])
    gait = gait_of(walks.recordings[0], scene)
    running = gait == "run"
    measures, why = measured(walks.recordings[0], scene, gait)
    found: dict[str, Finding] = {}
    if measures:
        found = {name: Finding(value) for name, value in (measures | of_force(measures)).items()}
        found["toe-off"] = Finding(measures.get("stance"))
        if found[HUMPS].value is None:
            found[HUMPS] = Finding(None, "no valley between two peaks", failed=True)
    tell(f"{RUNS} disturbed runs of {SHORT:g} s")
    found[UPRIGHT.name] = Finding(float(disturbed_upright(walker)))
    found[PUSHED.name] = _pushed(walker, pushes, tell)
    commanded: list[Walked] = []
    drives = driven(scene, topology(scene.character))
    if drives.muscles and drives.torques_help:
        found |= dict.fromkeys(OF_ENERGY, Finding(None, "torques help to drive it"))
    elif drives.muscles and measures and not running:
        commanded = at_conditions(walker, tell=tell)
        found |= _over_conditions(commanded, scene)
    without = Finding(None, why, failed=end != Status.COMPLETED or NO_CYCLE in why)  # who drags both feet misses, too
    motion = walks.recordings[0]
    found |= bodies_and_norms(motion, scene, measures | of_force(measures), running)
    found |= of_measures(measures, motion, scene)
    found |= trials(walker, motion, measures, short=SHORT, running=COMMANDED, tell=tell)
    if measures and not running:
        found[VARIABILITY] = variability(walker, COMMANDED, measures.get(VARIABILITY))
    impossible = APART.reached(found[APART.name].value or 0.0) == "missed"
    verdicts, further = (
        [Verdict(bar, *found.get(bar.name, without), void=impossible) for bar in bars_of(rows, bool(drives.muscles))]
        for rows in ((RUN, FURTHER_RUN) if running else (WALK, FURTHER_WALK))
    )
    tell(f"{RUNS} runs of {SHORT:g} s with each disturbance by itself")
    felled = felled_by(walker, SHORT)
    return Judgement(
        verdicts, running, ended(end, walks.end_time[0]), measures, commanded, impossible, felled, further, motion,
        scene, walker.impaired,
    )  # fmt: skip


def ended(status: Status, time: float) -> str:
    """How a run ended, in words, and when if that was too early."""
    return f"{status.meaning}{'' if status == Status.COMPLETED else f', after {rounded(time, 2)} s'}"


def bars_of(rows: Sequence[Bar], muscles: bool) -> list[Bar]:
    """Rows of a judgement, those of muscles only where there are some."""
    return [bar for bar in rows if muscles or bar.name not in OF_MUSCLES]


def bodies_and_norms(recording: Recording, scene: Scene, measures: Measures, running: bool) -> dict[str, Finding]:
    """How deep bodies are inside each other, also of who falls; and by which norms angles are judged."""
    deepest = penetration(recording, scene)
    if deepest is None:
        found = {APART.name: Finding(None, "no two bodies that are apart have shapes")}
    else:
        between = "" if deepest.pair is None else f"{' and '.join(deepest.pair)} at {deepest.time:.2f} s; "
        note = f"{between}{100.0 * deepest.share:.0f} % of the time" if deepest.pair else ""
        found = {APART.name: Finding(100.0 * deepest.depth, note)}
    return found | ({} if running else of_norms(measures))


def gait_of(recording: Recording, plain: Scene) -> str:
    """Walk or run, by which a motion is judged: as the scene says, else a run is fast, and has a flight."""
    if plain.objective.gait:
        return plain.objective.gait
    try:
        measures = gait_measures(recording, plain)
    except Error:
        return "walk"
    flies, fast = ((measures.get(name) or 0.0) > least for name, least in (("flight", LEAST_FLIGHT), ("speed", FAST)))
    return "run" if flies and fast else "walk"


def disturbed_upright(walker: Walker) -> int:
    """How many of 20 runs of 10 s survive noise of 0.1 m/s, masses of each body +-10 %, slopes within +-3 degrees."""
    robustness = Robustness(runs=RUNS + 1, velocity_noise=NOISE, mass=MASS, slope=SLOPE, seed=SEED)
    runs = drawn(robustness, SHORT, len(walker.scene().character.bodies)).part(slice(1, None))  # one is not disturbed
    return int(walker.walk(SHORT, replace(runs, push=np.zeros((RUNS, 3)))).upright.sum())


def _pushed(walker: Walker, pushes: int, tell: Callable[[str], None]) -> Finding:
    """Impulse that half of the pushes survive, at most the greatest one, N s, and its range."""
    if pushes == 0:
        return Finding(None, "not asked for")
    tell(f"{number_of(pushes, 'push')} of each of {number_of(len(IMPULSES), 'impulse')}")
    trials = push_trials(walker, IMPULSES, pushes)
    low, high = (min(end, trials.impulses[-1]) for end in trials.range)
    more = " or more" if np.isinf(trials.half) else ""
    return Finding(float(min(trials.half, trials.impulses[-1])), f"{low:.0f} to {high:.0f}{more}")


def energies(recording: Recording, plain: Scene) -> dict[str, float | None]:
    """Costs of transport by two formulas, the walking part of the power, and the share of muscles in the body."""
    found: dict[str, float | None] = {}
    muscles = [plain.character.muscles[name] for name in recording.muscle_names]
    gone = recording.window(min(5.0, 0.25 * float(recording.time[-1])))
    speed = float(np.hypot(*gone.com_velocity[:, [0, 2]].mean(axis=0)))
    for model, name in (("bhargava", COST), ("wang", COST_WANG)):
        objective = msgspec.structs.replace(
            plain.objective, metabolic_model=model, metabolic_work=None, basal_rate=None
        )  # fmt: skip
        effort = spent(gone, msgspec.structs.replace(plain, objective=objective))
        if effort is None:
            return {}
        found[name] = effort.power / speed if speed >= LEAST_SPEED else None
        if model == "bhargava":
            found[POWER] = effort.power - FORMULAS[model].basal_rate
    found["muscle mass"] = 100.0 * total_mass(muscles, plain.muscle_model) / body_mass(plain.character)
    return found


def at_conditions(walker: Walker, *, tell: Callable[[str], None] = lambda _: None) -> list[Walked]:
    """Walks at speeds over the range that a walker takes, up and down 5 degrees, and with loads.

    A slope or a load that it has no command for is there without its being told. The first one is as it is commanded.
    """
    every = asked_of(walker)
    tell(f"{number_of(len(every), 'walk')} of {COMMANDED:g} s at other speeds, on slopes, with loads")
    commands = {
        name: np.array([one.numbers.get(name, command.asked) for one in every])
        for name, command in walker.commands.items()
    }
    conditions, level = none(len(every)), walker.scene()
    if "slope" not in walker.commands:
        conditions = replace(conditions, slope=np.radians([one.slope or 0.0 for one in every]))
    if "load" not in walker.commands:
        conditions = loaded(level, conditions, np.array([one.load or 0.0 for one in every]))
    walks = walker.walk(COMMANDED, conditions, commands, record=True)
    found = []
    for number, (one, recording, lasted) in enumerate(zip(every, walks.recordings, walks.upright, strict=True)):
        given = {name: value for name, value in one.numbers.items() if name in walker.commands}
        scene = under(walker.scene(given), conditions, number)
        measures = measured(recording, scene, "walk")[0] if lasted else {}
        why = "" if measures else "has no gait cycle" if lasted else "falls"
        found.append(Walked(one.numbers, measures, why))
    return found


def asked_of(walker: Walker) -> list[Asked]:
    """The walks that a walker is asked for, within the ranges of its commands; the first is as it is commanded."""
    commands, mass = walker.commands, body_mass(walker.scene().character)
    asked = [Asked()]
    if "speed" in commands:
        asked += [Asked(speed=float(v)) for v in np.linspace(commands["speed"].min, commands["speed"].max, SPEEDS)]
    asked += [Asked(slope=slope) for slope in (UP, -UP) if _takes(commands.get("slope"), slope)]
    return asked + [Asked(load=part * mass) for part in LOADS if _takes(commands.get("load"), part * mass)]


def _takes(command: Command | None, value: float) -> bool:
    """Whether a value is in the range of a command, if there is one."""
    return command is None or command.min <= value <= command.max


def measured(recording: Recording, plain: Scene, gait: str) -> tuple[Measures, str]:
    """All measures of a motion as of a walk or a run, its energy among them; or none, and why."""
    plain = msgspec.structs.replace(plain, objective=msgspec.structs.replace(plain.objective, gait=gait))
    try:
        return gait_measures(recording, plain) | energies(recording, plain), ""
    except Error as error:
        return {}, str(error)


def _over_conditions(walks: Sequence[Walked], plain: Scene) -> dict[str, Finding]:
    """The most economical speed, what a slope costs, how loads are borne; or why it cannot be told."""
    speeds, slopes, loads = ([one for one in walks if name in one.asked] for name in ("speed", "slope", "load"))
    up = [one for one in slopes if one.asked["slope"] == UP]
    return {
        ECONOMICAL: _over_speeds(speeds),
        UPHILL: _up_against(walks[0], up[0]) if up else Finding(None, "takes no such slope"),
        LOADED: _under_loads(walks[0], loads, body_mass(plain.character)),
    }


def _over_speeds(walks: Sequence[Walked]) -> Finding:
    """The speed, m/s, at which walking costs least."""
    if not walks:
        return Finding(None, "takes no speed")
    known = [(one.asked["speed"], cost) for one in walks if (cost := one.measures.get(COST)) is not None]
    note = "; ".join(f"{one.asked['speed']:.2g} m/s {_cost_of(one)}" for one in walks)
    return Finding(_economical(known), note, failed=any(one.why for one in walks))


def _up_against(level: Walked, up: Walked) -> Finding:
    """What walking up costs more than walking on the level, J/(kg m)."""
    one, other = up.measures.get(COST), level.measures.get(COST)
    note = f"{_cost_of(up)} against {_cost_of(level)}"
    return Finding(None if one is None or other is None else one - other, note, failed=bool(up.why or level.why))


def _under_loads(level: Walked, walks: Sequence[Walked], mass: float) -> Finding:
    """How far the walking part of the power is from being proportional to the mass, at worst, %."""
    if not walks:
        return Finding(None, "takes no such load")
    unloaded, off, words = level.measures.get(POWER), [], []
    for one in walks:
        power, text = one.measures.get(POWER), one.why or "no power"
        if power is not None and unloaded is not None:
            off.append(100.0 * (power / unloaded - 1.0))
            text = f"{off[-1]:+.1f} %"
        words.append(f"{100.0 * one.asked['load'] / mass:.0f} % {text}")
    worst = max(off, key=abs) if len(off) == len(walks) else None
    return Finding(worst, ", ".join(words), failed=any(one.why for one in walks))


def _cost_of(walk: Walked) -> str:
    """The cost of transport as a text: net, by which it is judged, and strict."""
    net, strict = (walk.measures.get(name) for name in (COST, COST_STRICT))
    return walk.why or ("stands" if net is None or strict is None else f"{net:.2f} net, {strict:.2f} strict")


def _economical(known: Sequence[tuple[float, float]]) -> float | None:
    """Speed at which a parabola through the least cost and its neighbours is least; an end if it is there."""
    if len(known) < 3:
        return None
    at = int(np.argmin([value for _, value in known]))
    if at in (0, len(known) - 1):
        return known[at][0]
    near = np.array(known[at - 1 : at + 2])
    a, b, _ = np.polyfit(near[:, 0], near[:, 1], 2)
    return float(-0.5 * b / a)
