"""A typical walk of each condition of a study, side by side, to be looked at."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.optimization.best_scene import recorded_scene
from warpmuscle.results.result import read
from warpmuscle.studies.conditions import Condition
from warpmuscle.sweep.study.measured import MeasuredRun, StudyResult
from warpmuscle.sweep.study.table import COST
from warpmuscle.view.page import iframe, replay_html

MOST = 4  # conditions that are shown
LARGEST = 550_000  # bytes of the page of motions within that of the study
HEIGHT = 640  # px


def typical(found: StudyResult) -> dict[Condition, MeasuredRun]:
    """The run with the median cost, of two the better one, among those that walked, or else of all, by condition.

    Of many conditions there are the first, the last and some between, and in any case the reference; of several series
    the first.
    """
    series = found.runs[0].series
    runs = [run for run in found.runs if run.series == series and run.file is not None and COST in run.measures]
    conditions = list(dict.fromkeys(run.condition for run in runs))
    if len(conditions) > MOST:
        kept = [conditions[k] for k in np.linspace(0, len(conditions) - 1, MOST).round().astype(int)]
        if found.study.reference in conditions and found.study.reference not in kept:
            kept[1] = found.study.reference
        conditions = [condition for condition in conditions if condition in kept]
    chosen = {}
    for condition in conditions:
        mine = [run for run in runs if run.condition == condition]
        mine = sorted([run for run in mine if run.walked] or mine, key=lambda run: run.measures[COST] or 0.0)
        chosen[condition] = mine[(len(mine) - 1) // 2]
    return chosen


def replay_of(found: StudyResult, names: dict[Condition, str]) -> str:
    """The motions as an element of the page; empty where there are none.

    Args:
        names: of conditions, in words.
    """
    recordings, scenes, labels = [], [], []
    for condition, run in typical(found).items():
        if run.file is None:
            continue
        try:
            result = read(run.file, replay=0)
            scene = recorded_scene(result)
        except Error:  # what has no motion is listed below
            continue
        if not result.replays[0].frames:  # it diverged at once
            continue
        scenes.append(scene)
        recordings.append(result.replays[0])
        labels.append(f"{names[condition]}, seed {run.run.seed}" + ("" if run.walked else ", fell"))
    if not recordings:
        return ""
    page = replay_html(
        recordings, scenes, labels, title=found.study.title, autoplay=False, split=len(labels) > 1, largest=LARGEST
    )
    return iframe(page, HEIGHT)
