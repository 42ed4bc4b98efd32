"""All runs of a sweep over measured conditions, measured and compared."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from warpmuscle.scene import Scene
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import at_start
from warpmuscle.sweep.adaptation.compared import angle_changes, changes, scores
from warpmuscle.sweep.adaptation.page import Comparison
from warpmuscle.sweep.adaptation.predicted import Prediction, predicted
from warpmuscle.sweep.adaptation.records import Record
from warpmuscle.sweep.plan import Plan
from warpmuscle.sweep.processes import in_processes
from warpmuscle.sweep.run import SweepResult


def comparison(
    records: Sequence[Record], plan: Plan, done: SweepResult, scene: Scene, processes: int = 1
) -> Comparison:
    """What the runs of a plan predict, beside what was measured.

    Args:
        scene: that all of them change. processes: at most so many measure at the same time.
    """
    mass = body_mass(at_start(scene).character)
    found: dict[str, dict[int, Prediction]] = {}
    left_out: dict[str, str] = dict(done.failed)
    ended = [run for run in plan.runs if run.name not in done.failed]
    files = [done.folder.result(run.name) for run in ended]
    for run, one in zip(ended, in_processes(processes, partial(predicted, mass), files), strict=True):
        if isinstance(one, str):
            left_out[run.name] = one
        else:
            found.setdefault(str(run.axes["run"]), {})[run.seed] = one
    all_changes = changes(records, found)
    return Comparison(
        len(records), len(plan.runs), all_changes, scores(all_changes), angle_changes(records, found), left_out
    )
