"""A judged gait as a clinic reports one, on a page: indices, both sides, angles, moments, powers, forces, muscles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import NamedTuple

from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import rounded
from warpmuscle.gait.curves import gait_curves
from warpmuscle.gait.cycles import steady_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.muscle_effort import BHARGAVA_NET
from warpmuscle.gait.muscle_timing import ActiveWindow, active_windows
from warpmuscle.gait.profile_score import DEVIATION, LEAST_DIFFERENCE, Scores, profile_scores, variable_scores
from warpmuscle.gait.sides import PROFILE, OfSides, measures_of_sides
from warpmuscle.gait.table import human
from warpmuscle.plots import KINDS, Subject, draw
from warpmuscle.plots.subject import Absent, of_recording
from warpmuscle.report.images import data_uris
from warpmuscle.report.page import Figure, template
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.people.emg import SOURCE as EMG_SOURCE
from warpmuscle.studies.judge import Judgement
from warpmuscle.studies.verdicts import RUNS, Verdict, ends

FIGURES = ("angles", "moments", "ground_force", "body", "activation", "sticks")
HEADLINE = {  # measures that are read first: unit and decimals
    "speed": ("m/s", 2), "cadence": ("steps/min", 0), "step length": ("m", 2), "step width": ("m", 2),
    "stance": ("% of the cycle", 0), "double support": ("% of the cycle", 0), "flight": ("% of the cycle", 0),
    BHARGAVA_NET: ("J/(kg m)", 1),
}  # fmt: skip
NONE_OF = {True: "double support", False: "flight"}  # what a run, or a walk, does not have


class VerdictRow(NamedTuple):
    """A verdict as text."""

    name: str
    value: str
    unit: str
    must: str
    goal: str
    reached: str
    note: str


class Score(NamedTuple):
    """A variable's score of both sides, deg, and how long its bars are, % of the greatest."""

    name: str
    values: tuple[float, float]
    bars: tuple[float, float]


def clinic_html(name: str, judgement: Judgement, tell: Callable[[str], None] = lambda _: None) -> str:
    """The page of a judged gait.

    Args:
        name: of the gait. tell: called with what is being made.

    Raises:
        Error: jinja2 or matplotlib are not installed, or the judgement holds no motion.
    """
    page, motion, scene = template("clinic.html"), judgement.motion, judgement.scene
    if motion is None or scene is None:
        raise Error("this judgement holds no motion to report")
    sides, scores, windows, why = _of_cycles(motion, scene, judgement.running)
    totals = profile_scores(scores)
    return str(
        page.render(
            name=name, description=scene.description, judgement=judgement, why=why,
            headline=_headline(judgement, totals), scores=_scores(scores),
            totals=totals, least=LEAST_DIFFERENCE, deviation=DEVIATION, sides=sides, windows=windows,
            emg=EMG_SOURCE, tables=[("Judged", _rows(judgement.verdicts)), ("Besides", _rows(judgement.further))],
            runs=RUNS, figures=_figures(motion, scene, tell),
        )
    )  # fmt: skip


def _of_cycles(
    motion: Recording, scene: Scene, running: bool
) -> tuple[dict[str, OfSides], Scores, list[ActiveWindow], str]:
    """What is known where there are whole gait cycles, or why there is nothing; people's, of walking, not of a run."""
    try:
        cycles = steady_strides(motion, scene)
    except Error as error:
        return {}, {}, [], str(error)
    scores = {} if running else variable_scores(gait_curves(motion, scene, cycles))
    windows = [] if running else active_windows(motion, cycles)
    sides = measures_of_sides(motion, scene)
    if running:
        sides.pop(PROFILE, None)
    return sides, scores, windows, ""


def _headline(judgement: Judgement, totals: dict[str, float]) -> list[tuple[str, str]]:
    """The numbers that are read first, and what they are, people's behind them."""
    found = []
    untold = {one.bar.name for one in judgement.verdicts if one.value is None}  # as the cost where torques help
    untold.add(NONE_OF[judgement.running])
    for name, (unit, decimals) in HEADLINE.items():
        if name not in untold and (value := judgement.measures.get(name)) is not None:
            people = human(name, judgement.running)[0]
            found.append((rounded(value, decimals), f"{name}, {unit}{f' (people {people})' if people else ''}"))
    if totals:
        found.append((f"{totals['both']:.1f}", "gait profile score, degrees"))
    return found


def _scores(scores: Scores) -> list[Score]:
    greatest = max((value for of_sides in scores.values() for value in of_sides.values()), default=0.0) or 1.0
    return [
        Score(name, (left, right), (100.0 * left / greatest, 100.0 * right / greatest))
        for name, (left, right) in ((name, [of_sides[side] for side in SIDES]) for name, of_sides in scores.items())
    ]


def _rows(verdicts: Sequence[Verdict]) -> list[VerdictRow]:
    return [
        VerdictRow(
            one.bar.name, one.shown, one.bar.unit, ends(one.bar.must),
            ends(one.bar.goal), one.reached, one.note,
        )
        for one in verdicts
    ]  # fmt: skip


def _figures(motion: Recording, scene: Scene, tell: Callable[[str], None]) -> dict[str, Figure]:
    """Figures of what the motion has, by what links to them are called."""
    subject, drawn = Subject(of_recording(motion, scene)), {}
    for kind in FIGURES:
        tell(f"drawing: {kind}")
        with suppress(Absent):
            drawn[kind] = draw(subject, kind)
    sources = data_uris(list(drawn.values()))
    return {
        kind.replace("_", " ").capitalize(): Figure(KINDS[kind].description, source)
        for kind, source in zip(drawn, sources, strict=True)
    }
