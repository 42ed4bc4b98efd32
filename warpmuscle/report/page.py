"""What a result says as one HTML page that needs nothing but a browser; needs the extra `plot` of the package."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.core.extras import imported
from warpmuscle.core.plain_text import rounded
from warpmuscle.core.status import Status
from warpmuscle.gait.quality import gait_measures
from warpmuscle.gait.table import MeasureRow, gait_table
from warpmuscle.plots import KINDS, draw
from warpmuscle.plots.parameters import unit_values
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.report.images import data_uris
from warpmuscle.report.summary import AT_BOUND, Share, energy_accounting, heaviness, shares
from warpmuscle.results.records import Result
from warpmuscle.scene.accounting import accounting
from warpmuscle.view.packing import encodable

_SEARCH_FIGURES = ("convergence", "parameters")
_MOTION_FIGURES = ("sticks", "angles", "ground_force", "feet", "activation", "control", "joints")
_REPLAY_HEIGHT = 640  # px
_ROOM, _FIGURES_ROOM = 990_000, 500_000  # bytes of a page, and of that for figures
_ESCAPED = 1.03  # how much larger a page is within another one
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Figure:
    """A figure of the page."""

    title: str
    source: str  # data URI


@dataclass(frozen=True)
class Value:
    """A parameter's start and best value between its bounds."""

    name: str
    unit: str
    low: float
    high: float
    start: float
    best: float
    at_bound: bool


def report_html(subject: Subject, references: list[Subject] | None = None, tell: Tell | None = None) -> str:
    """The page of a result.

    Args:
        subject: the result, and which of its motions.
        references: other results, whose walks are put beside its own. tell: called with what is being made.

    Raises:
        Error: jinja2 or matplotlib are not installed, or a reference holds no walk.
    """
    page = template("report.html")
    tell = tell or (lambda what: None)
    result, others = subject.result, references or []
    figures = _figures(subject, tell)
    of, terms = shares(result) if result.best is not None and result.evaluations is not None else ("", [])
    rows = _rows(subject, others)

    def render(replay: str) -> str:
        return encodable(
            page.render(
                result=result,
                scene=subject.scene,
                source=subject.source,
                replay_number=subject.choices.replay,
                headline=_headline(subject),
                outcomes=_outcomes(result),
                terms=terms,
                greatest=max((abs(term.cost) for term in terms), default=0.0) or 1.0,
                rest=_rest(result, terms),
                stage=of,
                search_figures=[figures[kind] for kind in _SEARCH_FIGURES if kind in figures],
                motion_figures=[figures[kind] for kind in _MOTION_FIGURES if kind in figures],
                parameters=_parameters(result),
                walks=[subject.scene.name, *(f"{other.scene.name} ({other.source})" for other in others)],
                rows=rows,
                energy=energy_accounting(result, terms),
                costs=_costs((subject, *others)) if any(row.name == "cost of transport" for row in rows) else [],
                warnings=heaviness(result),
                replay=replay,
            )
        )

    tell("replay")
    return render(_replay(subject, int((_ROOM - len(render("").encode())) / _ESCAPED)))


def with_code(text: str) -> str:
    """Text as HTML, in which what stands between backticks is code."""
    parts = [html.escape(part) for part in text.split("`")]
    if len(parts) % 2 == 0:  # a backtick by itself
        return "`".join(parts)
    return "".join(f"<code>{part}</code>" if k % 2 else part for k, part in enumerate(parts))


def template(name: str) -> Any:
    """A template of this package by its name, which escapes what it is given and has the pages' `style`.

    Raises Error if jinja2 is missing.
    """
    jinja2 = imported("jinja2", "a report page needs")
    import markupsafe

    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    environment.filters["with_code"] = lambda text: markupsafe.Markup(with_code(text))
    environment.filters["number"] = lambda value: "" if value is None else f"{value:.4g}"
    folder = files("warpmuscle.report") / "templates"
    environment.globals["style"] = (folder / "report.css").read_text(encoding="utf-8")
    return environment.from_string((folder / name).read_text(encoding="utf-8"))


def _figures(subject: Subject, tell: Tell) -> dict[str, Figure]:
    """Figures by their kinds, of what the result holds."""
    drawn = {}
    for kind in (*_SEARCH_FIGURES, *_MOTION_FIGURES):
        tell(kind)
        with suppress(Absent):
            drawn[kind] = draw(subject, kind)
    if "angles" in drawn:  # then the angles of all joints over time say little besides
        drawn.pop("joints", None)
    sources = data_uris(list(drawn.values()), _FIGURES_ROOM)
    return {kind: Figure(KINDS[kind].description, source) for kind, source in zip(drawn, sources, strict=True)}


def _headline(subject: Subject) -> list[tuple[str, str]]:
    """The numbers that are read first, and what they are."""
    result, found = subject.result, []
    if result.best is not None and result.evaluations is not None:
        found.append((f"{result.best.cost:.5g}", "lowest cost"))
        found.append((f"{result.evaluated}", "candidates"))
    if result.fit is not None:
        found += [
            (f"{np.median(r2):.4f}", f"r2 of {joint}")
            for joint, r2 in zip(result.fit.joints, result.fit.r2[-1].T, strict=True)
        ]
    try:
        recording, gait = subject.recording, subject.gait
    except Error:
        return found
    found.append((f"{recording.time[-1] - recording.time[0]:.3g} s", "motion"))
    if gait is not None:
        found.append((f"{rounded(gait.speed_forward, 2)} m/s", "speed forwards"))
        if gait.step_length is not None:
            found.append((f"{rounded(gait.step_length, 2)} m", "step length"))
        if gait.cadence is not None:
            found.append((f"{gait.cadence:.0f} /min", "steps"))
    return found


def _outcomes(result: Result) -> list[tuple[str, int, float]]:
    """How many candidates came to each end, and their part of all."""
    if result.evaluations is None or result.is_brief:
        return []
    status = np.asarray(result.evaluations.status)
    counts = {member.meaning: int((status == member).sum()) for member in Status}
    return [(meaning, count, count / max(len(status), 1)) for meaning, count in counts.items() if count]


def _rest(result: Result, terms: list[Share]) -> float:
    """What the cost has besides its terms: a failure's, or what several runs make of them."""
    if result.best is None:
        return 0.0
    rest = result.best.cost - sum(term.cost for term in terms)
    return rest if abs(rest) > 1e-4 * max(abs(result.best.cost), 1e-9) else 0.0


def _parameters(result: Result) -> list[Value]:
    """Start and best of every parameter."""
    if result.best is None:
        return []
    table, best = result.parameters, np.asarray(result.best.params, dtype=float)
    place = unit_values(table, best[None])[0]
    columns = (table.name, table.unit, table.min, table.max, table.value, best, place)
    return [
        Value(name, unit, float(low), float(high), float(start), float(value), bool(min(at, 1.0 - at) < AT_BOUND))
        for name, unit, low, high, start, value, at in zip(*columns, strict=True)
    ]


def _rows(subject: Subject, others: list[Subject]) -> list[MeasureRow]:
    """The walk beside human walking and the references; nothing for a motion that is no walk."""
    if not subject.result.replays or not subject.walks:
        return []
    walks = []
    for one in (subject, *others):
        try:
            walks.append(gait_measures(one.recording, one.scene))
        except Error as error:
            raise Error(f"{one.source}: {error}" if one.source not in str(error) else str(error)) from None
    return gait_table(walks, subject.runs)


def _costs(walks: Iterable[Subject]) -> list[tuple[str, str]]:
    """How the metabolic energy of each walk is counted: the scene's name, and words."""
    counted = [(walk.scene.name, accounting(walk.scene, walk.recording.muscle_names)) for walk in walks]
    return [(name, words) for name, words in counted if words]


def _replay(subject: Subject, room: int) -> str:
    """The motion to play, as an element of the page of at most `room` bytes; empty without one."""
    from warpmuscle.view.page import iframe, replay_html

    try:
        recording = subject.recording
    except Absent:
        return ""
    page = replay_html(recording, subject.scene, title=subject.scene.name, autoplay=False, largest=room)
    return iframe(page, _REPLAY_HEIGHT)
