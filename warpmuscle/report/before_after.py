"""A walk before a search and after it: both in one table beside people's, and side by side on one page."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.core.status import Status
from warpmuscle.gait.muscle_effort import BHARGAVA_NET, BHARGAVA_STRICT
from warpmuscle.gait.quality import Measures, gait_measures
from warpmuscle.gait.table import human, unit_of
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.report.tables import aligned
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result
from warpmuscle.scene import Failure, Scene
from warpmuscle.scene.accounting import accounting
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.multi_device import make_rollout
from warpmuscle.studies import judge
from warpmuscle.studies.walkers import SceneWalker
from warpmuscle.view.access import POLICY, POLICY_OF_FILES
from warpmuscle.view.crowd import Facts
from warpmuscle.view.page import drawn_meanwhile, iframe, replay_html

LASTING = 10.0  # s, of the walk that is measured
RATE = 200.0  # frames/s, for what happens when a foot lands
FALLING = 2.0  # s, that are shown of what fails, until it lies
WALKED = "walks on its own"
# Decimals of the measures that are printed.
MEASURES = {
    "speed": 2,
    "cost of transport": 1,
    BHARGAVA_NET: 1,
    BHARGAVA_STRICT: 1,
    "angles outside the norms": 2,
    "deviation of the three angles": 2,
    "deviation of the ground force": 2,
    "stance": 0,
    "double support": 0,
}
_STYLE = """body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; } th, td { padding: .2rem .9rem; border-bottom: 1px solid #ccc; text-align: left; }
@media (max-width: 40rem) { body { margin: 1rem auto; padding: 0 .5rem; } h1 { font-size: 1.4rem; }
th, td { padding: .2rem .3rem; } }
td.number { text-align: right; font-variant-numeric: tabular-nums; } @media (prefers-color-scheme: dark) {
body { background: #16181c; color: #e6e6e6; } th, td { border-color: #444; } }"""
_HEIGHT = 620  # px


@dataclass(frozen=True)
class Walked:
    """How a walk went, alone and disturbed."""

    scene: Scene  # without free parameters
    motion: Recording
    shown: Recording  # the same, and where it failed how it goes on, to the ground
    status: Status
    falls: int  # of the disturbed runs of a judgement
    measures: Measures  # none of a motion without whole gait cycles


def watch(scene: Scene, *, device: str | None = None, threads: int | None = None) -> Walked:
    """Let a scene without free parameters walk, once undisturbed and as often disturbed as it is judged."""
    lasting = msgspec.structs.replace(scene, duration=LASTING)
    rollout = make_rollout(lasting, 1, device, record=[0], record_rate=RATE, threads=threads)
    rollout.run()
    motion, status = rollout.recording(), Status(rollout.status()[0])
    try:
        measures = gait_measures(motion, scene)
    except Error:
        measures = {}
    falls = judge.RUNS - judge.disturbed_upright(SceneWalker(scene, device, threads))
    shown = motion if status == Status.COMPLETED else _to_the_ground(scene, motion, device, threads)
    return Walked(scene, motion, shown, status, falls, measures)


def _to_the_ground(scene: Scene, motion: Recording, device: str | None, threads: int | None) -> Recording:
    """The motion of a walk that failed, and how it goes on where nothing ends it but the ground.

    Where it diverges instead, it is shown as far as it goes, and at least until it failed.
    """
    end = motion.end
    limits = Failure(com_height=0.0, heading=0.0)
    falling = msgspec.structs.replace(scene, duration=end + FALLING, failure=limits)
    rollout = make_rollout(falling, 1, device, record=[0], record_rate=RATE, threads=threads)
    rollout.run()
    found = rollout.recording()
    return found if found.frames > motion.frames else motion


def before_and_after(result: Result, *, device: str | None = None, threads: int | None = None) -> tuple[Walked, Walked]:
    """The walk that a search began with, and its best one: the scene as a whole, not as its last stage changes it."""
    assert result.best is not None
    start = scene_in(result)
    numbers = (start_values(start), np.asarray(result.best.params, dtype=np.float64))
    first, last = (substitute(start, values) for values in numbers)
    before = watch(first, device=device, threads=threads)
    with drawn_meanwhile(before.shown, first):
        return before, watch(last, device=device, threads=threads)


def rows(before: Walked, after: Walked) -> list[tuple[str, str, str, str]]:
    """What the table says, a row a measure: its name, before, after, people's; empty where there is no number."""
    found = [
        (WALKED, _how_long(before), _how_long(after), ""),
        (f"falls of {judge.RUNS} disturbed runs", str(before.falls), str(after.falls), ""),
    ]
    for name, decimals in MEASURES.items():
        first, last = (walk.measures.get(name) for walk in (before, after))
        if first is not None or last is not None:
            found.append((f"{name}, {unit_of(name)}", _shown(first, decimals), _shown(last, decimals), human(name)[0]))
    return found


def lines(before: Walked, after: Walked) -> list[str]:
    """The table as plain text, and how its energy is counted."""
    table = [("", "before", "after", "people"), *rows(before, after)]
    return [*aligned(table), *_notes(after)]


def page(before: Walked, after: Walked, command: str = "") -> str:
    """Both walks side by side and the table, as one page that needs nothing but a browser."""
    title = html.escape(f"{after.scene.name}, before and after the search")
    head = "".join(f"<th>{name}</th>" for name in ("", "before", "after", "people"))
    body = "\n".join(f"<tr><td>{html.escape(name)}</td>{_cells(cells)}</tr>" for name, *cells in rows(before, after))
    notes = "".join(f"<p>{html.escape(line)}</p>\n" for line in [*_notes(after), *([command] if command else [])])
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="{POLICY}" content="{POLICY_OF_FILES}">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{title}</title>\n'
        f"<style>{_STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{_replay(before, after, title)}\n"
        f"<table>\n<tr>{head}</tr>\n{body}\n</table>\n{notes}</body>\n</html>\n"
    )


def _replay(before: Walked, after: Walked, title: str) -> str:
    """Both walks as an element of the page, without one that diverged at once; empty if both did."""
    walks = {name: walk for name, walk in (("before", before), ("after", after)) if walk.shown.frames}
    if not walks:
        return ""
    replay = replay_html(
        [walk.shown for walk in walks.values()], [walk.scene for walk in walks.values()],
        list(walks), title=title, plots=False, split=len(walks) > 1, facts=[_fate(walk) for walk in walks.values()],
    )  # fmt: skip
    return iframe(replay, _HEIGHT)


def _shown(value: float | None, decimals: int) -> str:
    return "" if value is None else f"{value:.{decimals}f}"


def _how_long(walk: Walked) -> str:
    end = walk.motion.end
    return f"{end:.0f} s" if walk.status == Status.COMPLETED else f"{end:.1f} s, then {walk.status.word}"


def _fate(walk: Walked) -> Facts:
    """How and when a walk failed, if it did."""
    if walk.status == Status.COMPLETED or not walk.motion.frames:
        return Facts()
    end = float(walk.motion.time[-1])
    return Facts(ended=f"{walk.status.word} at {end:.1f} s", until=end)


def _cells(cells: Sequence[str]) -> str:
    return "".join(f'<td class="number">{html.escape(cell)}</td>' for cell in cells)


def _notes(walk: Walked) -> list[str]:
    """What disturbs runs, and how metabolic energy is counted, if known."""
    notes = [f"disturbed: {judge.DISTURBED}"]
    words = accounting(walk.scene, walk.motion.muscle_names)
    if words and walk.measures.get("cost of transport") is not None:
        notes.append(f"cost of transport by {words}")
    return notes
