"""A gait judged: how like a person's it is, what it costs and what it bears, beside what it must and what it should.

One run of 60 s, twenty disturbed ones of 10 s, pushes, and, where a scene has commands of these names, walks at several
speeds (m/s), up a slope (deg) and with loads (kg).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.core.status import Status
from warpmuscle.gait.muscle_effort import LEAST_SPEED, spent
from warpmuscle.gait.quality import Measures, gait_measures
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Robustness, Scene
from warpmuscle.scene.accounting import FORMULAS
from warpmuscle.scene.masses import body_mass, total_mass
from warpmuscle.scene.norms import FORCE, NORMS
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.multi_device import make_rollout
from warpmuscle.simulation.perturbations import drawn
from warpmuscle.studies.robustness import IMPULSES, push_trials

LONG, SHORT, COMMANDED = 60.0, 10.0, 30.0  # s, of the run that is measured, of disturbed ones, of those at a command
RUNS, NOISE, MASS, SLOPE, SEED = 20, 0.1, 0.1, float(np.radians(3.0)), 3  # of disturbed runs: m/s, part, rad
DISTURBED = (
    f"{SHORT:g} s, {NOISE:g} m/s of noise at the start, masses of bodies +-{100.0 * MASS:g} %, "
    f"slopes of +-{np.degrees(SLOPE):.0f} degrees"
)
PUSHES = 20  # of each impulse
RATE = 200.0  # frames/s
SPEEDS = 7  # commanded, evenly over the range
UP = 5.0  # deg
LOADS = (0.18, 0.31)  # of the body weight


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
_UPRIGHT = Bar("upright, disturbed", f"of {RUNS}", (19, None), (20, None))
_PUSHED = Bar("impulse that half survive", "N s", (60, None), (80, None))
WALK = (
    Bar("angles outside the norms", "SD", (None, 0.25), (None, 0.12)),
    Bar("force at peaks and valley", "half-bands", (None, 1.0), (None, 0.6)),
    Bar("maximum vertical force", "body weights", (None, 1.2), (None, 1.15)),
    Bar("stance", "% of the cycle", (59, 65), (61, 63)),
    Bar("double support", "% of the cycle", (18, 25), (20, 24)),
    Bar("cost of transport, Bhargava net", "J/(kg m)", (None, 3.6), (None, 3.3)),
    Bar("cost of transport, Wang", "J/(kg m)", (None, 5.0), (None, 4.5)),
    Bar("muscle mass", "% of the body", (None, 40), (None, 40)),
    _UPRIGHT,
    _PUSHED,
    Bar("most economical speed", "m/s", (1.1, 1.5), (1.2, 1.4)),
    Bar("5 degrees up against level", "J/(kg m)", (2.4, 4.0), (2.8, 3.6)),
    Bar("loads, farthest from proportional", "%", (-10, 10), (-5, 5)),
)
RUN = (
    Bar("toe-off", "% of the cycle", (36, 44), (39, 41)),
    Bar("angles outside the norms", "SD", (None, 1.5), (None, 1.0)),
    Bar("maximum vertical force", "body weights", (None, 2.9), (None, 2.6)),
    Bar("flight", "% of the cycle", (1, None), (10, None)),
    _UPRIGHT,
    _PUSHED,
)


@dataclass(frozen=True)
class Verdict:
    """A measure of a gait beside its bar; no value where it could not be measured, and why not."""

    bar: Bar
    value: float | None
    note: str = ""

    @property
    def reached(self) -> str:
        """Goal, must, missed, or not measured."""
        return "not measured" if self.value is None else self.bar.reached(self.value)


@dataclass(frozen=True)
class Judgement:
    """All verdicts on a gait.

    Attributes:
        running: whether it is judged as a run. end: how the long run ended. measures: all of it.
        commanded: measures at each command, beside the command.
    """

    verdicts: list[Verdict]
    running: bool
    end: str
    measures: Measures
    commanded: list[tuple[dict[str, float], Measures]]


def judge(
    scene: Scene,
    *,
    pushes: int = PUSHES,
    device: str | None = None,
    threads: int | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> Judgement:
    """Judge the gait of a scene as it is commanded, its free parameters at their start values.

    Args:
        pushes: of each impulse; 0 leaves them out. tell: is called with what is done next.

    Raises:
        Error: it has no feet, or no whole gait cycle.
    """
    plain = substitute(scene, start_values(scene))
    tell(f"walking {LONG:g} s")
    (recording,), (status,), _ = _recorded(scene, LONG, [{}], device, threads)
    measures = gait_measures(recording, plain)
    running = scene.objective.gait == "run" or (not scene.objective.gait and (measures.get("flight") or 0.0) > 1.0)
    values: dict[str, float | None] = dict(measures) | _of_force(measures) | energies(recording, plain)
    values["toe-off"] = measures.get("stance")
    notes: dict[str, str] = {}
    tell(f"{RUNS} disturbed runs of {SHORT:g} s")
    values[_UPRIGHT.name] = float(disturbed_upright(scene, device=device, threads=threads))
    if pushes > 0:
        tell(f"{pushes} pushes of each of {len(IMPULSES)} impulses")
        trials = push_trials(plain, IMPULSES, pushes, device=device, threads=threads)
        values[_PUSHED.name] = float(min(trials.half, trials.impulses[-1]))
        low, high = (min(end, trials.impulses[-1]) for end in trials.range)
        notes[_PUSHED.name] = f"{low:.0f} to {high:.0f}" + (" or more" if np.isinf(trials.half) else "")
    else:
        values[_PUSHED.name], notes[_PUSHED.name] = None, "not asked for"
    commanded: list[tuple[dict[str, float], Measures]] = []
    if not running and scene.commands:
        commanded = at_commands(scene, device=device, threads=threads, tell=tell)
        found, why = _over_commands(commanded, plain)
        values, notes = values | found, notes | why
    bars = RUN if running else WALK
    shown = [bar for bar in bars if bar.name in values]
    verdicts = [Verdict(bar, values[bar.name], notes.get(bar.name, "")) for bar in shown]
    return Judgement(verdicts, running, status.meaning, measures, commanded)


def disturbed_upright(scene: Scene, *, device: str | None = None, threads: int | None = None) -> int:
    """How many of 20 runs of 10 s survive noise of 0.1 m/s, masses of each body +-10 %, slopes within +-3 degrees."""
    lasting = msgspec.structs.replace(scene, duration=SHORT)
    robustness = Robustness(runs=RUNS + 1, velocity_noise=NOISE, mass=MASS, slope=SLOPE, seed=SEED)
    runs = drawn(robustness, SHORT, len(scene.character.bodies)).part(slice(1, None))  # the first is not disturbed
    batch = make_rollout(lasting, RUNS, device, threads=threads)
    batch.disturb(replace(runs, push=np.zeros((RUNS, 3))))
    batch.run()
    return int((batch.status() == Status.COMPLETED).sum())


def energies(recording: Recording, plain: Scene) -> dict[str, float | None]:
    """Costs of transport by two formulas, the walking part of the power, and the share of muscles in the body."""
    found: dict[str, float | None] = {}
    muscles = [plain.character.muscles[name] for name in recording.muscle_names]
    gone = recording.window(min(5.0, 0.25 * float(recording.time[-1])))
    speed = float(np.hypot(*gone.com_velocity[:, [0, 2]].mean(axis=0)))
    for model, name in (("bhargava", "cost of transport, Bhargava net"), ("wang", "cost of transport, Wang")):
        objective = msgspec.structs.replace(
            plain.objective, metabolic_model=model, metabolic_work=None, basal_rate=None
        )  # fmt: skip
        effort = spent(gone, msgspec.structs.replace(plain, objective=objective))
        if effort is None:
            return {}
        found[name] = effort.power / speed if speed >= LEAST_SPEED else None
        if model == "bhargava":
            found["walking power"] = effort.power - FORMULAS[model].basal_rate
    found["muscle mass"] = 100.0 * total_mass(muscles, plain.muscle_model) / body_mass(plain.character)
    return found


def at_commands(
    scene: Scene,
    *,
    device: str | None = None,
    threads: int | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> list[tuple[dict[str, float], Measures]]:
    """Measures of the gait at speeds over the range, up and down 5 degrees, and with loads, of commands that it has.

    Measures are empty where it falls. The first one is of the scene as commanded.
    """
    commands, mass = scene.commands, body_mass(substitute(scene, start_values(scene)).character)
    asked: list[dict[str, float]] = [{}]
    if "speed" in commands:
        asked += [{"speed": float(v)} for v in np.linspace(commands["speed"].min, commands["speed"].max, SPEEDS)]
    if "slope" in commands:
        asked += [{"slope": v} for v in (UP, -UP) if commands["slope"].min <= v <= commands["slope"].max]
    if "load" in commands:
        asked += [{"load": part * mass} for part in LOADS if part * mass <= commands["load"].max]
    tell(f"{len(asked)} walks of {COMMANDED:g} s at other commands")
    recordings, statuses, numerics = _recorded(scene, COMMANDED, asked, device, threads)
    return [
        (one, _measures_of(recording, numeric) if status == Status.COMPLETED else {})
        for one, recording, status, numeric in zip(asked, recordings, statuses, numerics, strict=True)
    ]


def _recorded(
    scene: Scene, duration: float, asked: Sequence[dict[str, float]], device: str | None, threads: int | None
) -> tuple[list[Recording], list[Status], list[Scene]]:
    """Motions at some commands, how they ended, and the scenes in numbers."""
    lasting = msgspec.structs.replace(scene, duration=duration)
    count = len(asked)
    batch = make_rollout(lasting, count, device, record=range(count), record_rate=RATE, threads=threads)
    if scene.commands:
        batch.set_commands(
            {name: [one.get(name, command.asked) for one in asked] for name, command in scene.commands.items()}
        )
    batch.run()
    numerics = [substitute(scene, start_values(scene), one) for one in asked]
    return [batch.recording(i) for i in range(count)], [Status(s) for s in batch.status()], numerics


def _measures_of(recording: Recording, plain: Scene) -> Measures:
    try:
        return gait_measures(recording, plain) | energies(recording, plain)
    except Error:
        return {}


def _of_force(measures: Mapping[str, float | None]) -> dict[str, float | None]:
    """How far both peaks and the valley of the vertical force are from people's, in half-bands;."""
    norm = NORMS[FORCE]
    found: dict[str, float | None] = {}
    names = ("first hump of the force", "valley of the force", "second hump of the force")
    off = [
        abs(value - norm.points[index][1]) / norm.half_band
        for index, name in enumerate(names, 1)
        if (value := measures.get(name)) is not None
    ]
    found["force at peaks and valley"] = float(np.mean(off)) if len(off) == len(names) else None
    return found


def _over_commands(
    commanded: Sequence[tuple[dict[str, float], Measures]], plain: Scene
) -> tuple[dict[str, float | None], dict[str, str]]:
    """The most economical speed, what a slope costs, how loads are borne; and why, where it cannot be told."""
    cost = "cost of transport, Bhargava net"
    level, mass = commanded[0][1], body_mass(plain.character)
    values: dict[str, float | None] = {}
    notes: dict[str, str] = {}
    speeds = [(one["speed"], found.get(cost)) for one, found in commanded if "speed" in one]
    if speeds:
        known = [(speed, value) for speed, value in speeds if value is not None]
        values["most economical speed"] = _economical(known)
        notes["most economical speed"] = ", ".join(
            f"{speed:.2g} m/s {'falls' if value is None else f'{value:.2f}'}" for speed, value in speeds
        )
    up = [found.get(cost) for one, found in commanded if one.get("slope") == UP]
    if up and (flat := level.get(cost)) is not None:
        values["5 degrees up against level"] = None if up[0] is None else up[0] - flat
        notes["5 degrees up against level"] = "falls" if up[0] is None else f"{up[0]:.2f} against {flat:.2f}"
    loads = [(one["load"], found.get("walking power")) for one, found in commanded if "load" in one]
    if loads and (unloaded := level.get("walking power")) is not None:
        off = [None if power is None else 100.0 * (power / unloaded - 1.0) for _, power in loads]
        borne = [part for part in off if part is not None]
        values["loads, farthest from proportional"] = max(borne, key=abs) if len(borne) == len(off) else None
        notes["loads, farthest from proportional"] = ", ".join(
            f"{100.0 * load / mass:.0f} % {'falls' if part is None else f'{part:+.1f} %'}"
            for (load, _), part in zip(loads, off, strict=True)
        )
    return values, notes


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


def _within(value: float, ends: tuple[float | None, float | None]) -> bool:
    low, high = ends
    return (low is None or value >= low) and (high is None or value <= high)
