"""What is asked of a gait besides: everything at once, hard pushes at each phase, commands, a run, noise of nerves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import msgspec
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.gait.cycles import steady_strides
from warpmuscle.gait.measures import feet_of, heading, measure, steps_of
from warpmuscle.gait.muscle_timing import active_windows
from warpmuscle.gait.quality import ACTIVE, LEAST_FLIGHT, VARIABILITY, Measures, gait_measures
from warpmuscle.gait.relative_to_belts import over_belts
from warpmuscle.gait.swing import ARMS, CALF
from warpmuscle.gait.table import human
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Robustness, Scene
from warpmuscle.scene.joints.symmetry import side_of
from warpmuscle.simulation.perturbations import Perturbations, drawn, none
from warpmuscle.studies.verdicts import (
    ACTIVATION,
    ALL_AT_ONCE,
    ASIDE,
    AT_RUNNING,
    MET,
    PUSH,
    RUNNING,
    RUNS,
    UNJUDGED,
    Finding,
)  # fmt: skip
from warpmuscle.studies.walkers import Nerves, Walker

NOISE, SHARE, SLOPE, FRICTION, SEED = 0.2, 0.2, float(np.radians(6.0)), 0.4, 17  # m/s, of mass and strength, rad
# People hear of their ankles 20 ms late (Geyer, Herr 2010). A hundredth or two of what is observed: one degree, 2 cm.
NERVES = Nerves(delay=0.02, noise=0.02)
PHASES, AFTER, EARLIEST, STRIDE = 10, 4.0, 5.0, 1.1  # pushes; s after and before them; s, of who takes no strides
REPEATS, START, SETTLED = 3, 0.05, 2.0  # runs of each command; m/s of noise at the start; s, until a speed counts
NEAR, FACING = 0.1, 15.0  # m/s, deg, of a command that is met
OFF = 0.1  # share of 3.5 m/s, by which a run may miss it
LACKING = {ARMS: "no arms", CALF: "no gastrocnemius"}  # why a walk has no such measure
COMMANDED = ("speed", "turning_rate")  # commands that are drawn


def trials(
    walker: Walker,
    undisturbed: Recording,
    measures: Measures,
    *,
    short: float,
    running: float,
    tell: Callable[[str], None] = lambda _: None,
) -> dict[str, Finding]:
    """What a walker withstands and does besides, by the names of rows.

    Args:
        undisturbed: its long run, of these `measures`. short, running: s, of disturbed runs and of a run that is
            measured. tell: is called with what is done next.
    """
    tell(f"{RUNS} runs of {short:g} s with everything at once")
    found = {ALL_AT_ONCE.name: all_at_once(walker, short)}
    tell(f"{RUNS} pushes of {PUSH:g} N s from the side")
    found[ASIDE.name] = pushed_aside(walker, undisturbed)
    tell(f"{RUNS} commands")
    found[MET.name] = commands_met(walker, short)
    return found | run(walker, running, measures, tell)


def all_at_once(walker: Walker, duration: float) -> Finding:
    """How many of 20 runs survive all of it at once, and how many without what hinders nerves."""
    conditions, slippery = conditions_at_once(walker), walker.on_ground(FRICTION)
    upright, easier = (
        int(one.walk(duration, conditions).upright.sum()) for one in (slippery.with_nerves(NERVES), slippery)
    )
    hindered = "delays and noise of nerves" if walker.senses else "delays of muscles; it observes without noise"
    return Finding(float(upright), f"{easier} without {hindered}")


def conditions_at_once(walker: Walker) -> Perturbations:
    """Twenty runs: noise at the start of 0.2 m/s, masses and, by side, strengths +-20 %, slopes within 6 degrees."""
    robustness = Robustness(runs=RUNS + 1, velocity_noise=NOISE, mass=SHARE, slope=SLOPE, seed=SEED)
    runs = drawn(robustness, EARLIEST, len(walker.scene().character.bodies)).part(slice(1, None))
    return replace(runs, push=np.zeros((RUNS, 3)), strength=strengths_of_sides(walker.muscles, SHARE))


def strengths_of_sides(muscles: Sequence[str], share: float) -> Floats | None:
    """Factors (20, muscles) on strengths, one for all muscles of each side and one for those of none; or no muscles."""
    if not muscles:
        return None
    sides = [("left", "right", "").index(side_of(name, muscles)) for name in muscles]
    factors = 1.0 + share * np.random.default_rng(SEED).uniform(-1.0, 1.0, (RUNS, 3))
    return np.asarray(factors[:, sides])


def pushed_aside(walker: Walker, undisturbed: Recording) -> Finding:
    """How many of 20 pushes of 80 N s are survived: from both sides, at ten phases of the left foot's stride."""
    begin, length = stride_to_push(undisturbed, walker.scene())
    start = np.repeat(begin + length * np.arange(PHASES) / PHASES, 2)
    push = np.zeros((RUNS, 3))
    push[:, 0] = np.tile([PUSH, -PUSH], PHASES)
    upright = walker.walk(float(start.max()) + AFTER, replace(none(RUNS), push=push, push_start=start)).upright
    fell = [
        f"to the {side} {_phases(~upright[first::2])}"
        for first, side in enumerate(("left", "right"))
        if not upright[first::2].all()
    ]
    return Finding(float(upright.sum()), "falls when pushed " + "; ".join(fell) if fell else "")


def _phases(fell: NDArray[np.bool_]) -> str:
    """At which phases (10,) of the stride, in words."""
    return "at any phase" if fell.all() else f"at {', '.join(f'{100 * k // PHASES}' for k in np.flatnonzero(fell))} %"


def stride_to_push(undisturbed: Recording, scene: Scene) -> tuple[float, float]:
    """Begin and length, s, of the stride of the left foot that is pushed: the first steady one, or any 1.1 s."""
    try:
        begin, end = steady_strides(undisturbed, scene)["left"][0]
    except Error:
        return EARLIEST, STRIDE
    return begin, end - begin


def commands_met(walker: Walker, duration: float) -> Finding:
    """How many of 20 speeds and turning rates are met, drawn evenly from what it takes.

    A command is met if all of three runs, with noise of 0.05 m/s at the start, last, with a mean speed within 0.1 m/s
    of the wanted one after 2 s, and face within 15 degrees of the wanted heading at the end.
    """
    taken = {name: walker.commands[name] for name in COMMANDED if name in walker.commands}
    if not taken:
        return Finding(None, "takes no command")
    generator = np.random.default_rng(SEED)
    drawn = {name: generator.uniform(command.min, command.max, RUNS) for name, command in taken.items()}
    missed: dict[int, str] = {}
    for _ in range(REPEATS):
        velocity = generator.normal(0.0, START, (RUNS, 3))
        walks = walker.walk(duration, replace(none(RUNS), velocity=velocity), drawn, record=True)
        for k, (motion, lasted) in enumerate(zip(walks.recordings, walks.upright, strict=True)):
            wanted = {name: float(values[k]) for name, values in drawn.items()}
            if why := _off(motion, wanted) if lasted else "falls":
                missed.setdefault(k, f"{_words(wanted)} {why}")
    return Finding(float(RUNS - len(missed)), "; ".join(list(missed.values())[:3]))


def _off(motion: Recording, wanted: Mapping[str, float]) -> str:
    """How a motion does not what it was told; empty if it does."""
    rate, turned, time = wanted.get("turning_rate", 0.0), heading(motion), motion.time.astype(float)
    course = rate * time
    along = motion.com_velocity[:, 0] * np.sin(course) + motion.com_velocity[:, 2] * np.cos(course)
    settled = time >= min(SETTLED, 0.25 * float(time[-1]))
    speed, off = float(along[settled].mean()), float(np.degrees(turned[-1] - turned[0] - course[-1]))
    if "speed" in wanted and abs(speed - wanted["speed"]) > NEAR:
        return f"at {speed:.2f} m/s"
    return f"{off:+.0f} degrees off" if abs(off) > FACING else ""


def _words(wanted: Mapping[str, float]) -> str:
    units = {"speed": "m/s", "turning_rate": "rad/s"}
    return ", ".join(f"{value:.2f} {units[name]}" for name, value in wanted.items())


def run(
    walker: Walker, duration: float, own: Measures, tell: Callable[[str], None] = lambda _: None
) -> dict[str, Finding]:
    """A run at 3.5 m/s: flight, greatest force, and the knee in swing; `own`, at its own speed, where that flies.

    Who comes to another speed has missed them.
    """
    command = walker.commands.get("speed")
    if command is None or not command.min <= RUNNING <= command.max:
        if not (own.get("flight") or 0.0) > LEAST_FLIGHT:
            return dict.fromkeys(AT_RUNNING, Finding(None, "takes no such speed"))
        note = f"takes no such speed; this is at {own['speed']:.2f} m/s"
        return {row: Finding(own.get(name), note, judges=False) for row, name in AT_RUNNING.items()}
    tell(f"running at {RUNNING:g} m/s")
    walks = walker.walk(duration, none(1), {"speed": np.array([RUNNING])}, record=True)
    if not walks.upright[0]:
        return dict.fromkeys(AT_RUNNING, Finding(None, "falls", failed=True))
    scene = walker.scene({"speed": RUNNING})
    scene = msgspec.structs.replace(scene, objective=msgspec.structs.replace(scene.objective, gait="run"))
    try:
        measures = gait_measures(walks.recordings[0], scene)
    except Error as error:
        return dict.fromkeys(AT_RUNNING, Finding(None, str(error), failed=True))
    note = f"at {measures['speed']:.2f} m/s"
    if abs((measures["speed"] or 0.0) - RUNNING) > OFF * RUNNING:
        return dict.fromkeys(AT_RUNNING, Finding(None, note, failed=True))
    return {row: Finding(measures.get(name), note) for row, name in AT_RUNNING.items()}


def variability(walker: Walker, duration: float, without: float | None) -> Finding:
    """Standard deviation of the length of steps, mm, with noise in what is observed; `without`, mm, is without it."""
    if not walker.senses:
        return Finding(without, "its controller has no noise of nerves", judges=False)
    walks = walker.with_nerves(Nerves(noise=NERVES.noise)).walk(duration, none(1), record=True)
    if not walks.upright[0]:
        return Finding(None, "falls with noise of nerves", failed=True)
    scene = walker.scene()
    motion = over_belts(walks.recordings[0], scene)
    deviation = steps_of(motion, scene, measure(motion, *feet_of(scene)).start).length_deviation
    if deviation is None:
        return Finding(None, "too few steps")
    return Finding(1000.0 * deviation, "" if without is None else f"{without:.2g} without noise of nerves")


def of_measures(measures: Measures, recording: Recording, scene: Scene) -> dict[str, Finding]:
    """Rows that a motion tells by itself: which windows of muscles are empty, and what is no judge."""
    found: dict[str, Finding] = {}
    if (share := measures.get(ACTIVE)) is not None:
        windows = active_windows(recording, steady_strides(recording, scene))
        idle = [f"{one.muscle} {one.begin:g} to {one.end:g} %" for one in windows if not one.is_met]
        muscles = number_of(len({one.muscle for one in windows}), "muscle")
        found[ACTIVE] = Finding(share, f"{muscles}; idle: {', '.join(idle)}" if idle else muscles)
    if (activation := measures.get(ACTIVATION)) is not None:
        found[ACTIVATION] = Finding(activation, judges=False)
    for bar in UNJUDGED:
        if (value := measures.get(bar.name)) is not None:
            known, source = human(bar.name)
            found[bar.name] = Finding(value, f"people {known} ({source})" if known else "", judges=False)
        elif measures and bar.name in LACKING:
            found[bar.name] = Finding(None, LACKING[bar.name])
    if (deviation := measures.get(VARIABILITY)) is not None:
        found[VARIABILITY] = Finding(deviation)
    return found
