"""A recorded gait judged, as of a person: what would have to be simulated besides is left out."""

from __future__ import annotations

from warpmuscle.core.status import Status
from warpmuscle.gait.cycles import NO_CYCLE
from warpmuscle.gait.measures import feet_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.studies.hard_trials import of_measures
from warpmuscle.studies.judge import Judgement, bars_of, bodies_and_norms, ended, gait_of, measured
from warpmuscle.studies.people_comparison import IN_PLACE, of_force
from warpmuscle.studies.verdicts import APART, FURTHER_RUN, FURTHER_WALK, HUMPS, RUN, WALK, Finding, Verdict

RECORDED = "a recording, of which nothing is simulated"
RECORDED_IN_PLACE = "a recording, of which nothing is simulated, of a body that stays in its place"


def judge_recording(recording: Recording, scene: Scene, end: Status | None = None) -> Judgement:
    """Judge a recorded motion by itself.

    Args:
        scene: of the motion, without free parameters. end: how it ended, if it was simulated: then it counts as the
            long run of a judgement, so that who falls has missed, and nothing counts of bodies inside each other.

    Raises:
        Error: it has no feet.
    """
    feet_of(scene)
    gait = gait_of(recording, scene)
    running = gait == "run"
    measures, why = measured(recording, scene, gait)
    known = measures | of_force(measures)
    found = {name: Finding(value) for name, value in known.items()}
    if measures:
        found["toe-off"] = Finding(measures.get("stance"))
        if HUMPS in found and found[HUMPS].value is None:
            found[HUMPS] = Finding(None, "no valley between two peaks", failed=True)
    found |= bodies_and_norms(recording, scene, known, running) | of_measures(measures, recording, scene)
    in_place = abs(measures.get("speed") or 0.0) < IN_PLACE
    without = Finding(None, why or (RECORDED_IN_PLACE if in_place else RECORDED))
    impossible = False
    if end is not None:
        without = Finding(None, why, failed=end != Status.COMPLETED or NO_CYCLE in why)
        impossible = APART.reached(found[APART.name].value or 0.0) == "missed"
    verdicts, further = (
        [
            Verdict(bar, *found.get(bar.name, without), void=impossible)
            for bar in bars_of(rows, bool(recording.muscle_names))
        ]
        for rows in ((RUN, FURTHER_RUN) if running else (WALK, FURTHER_WALK))
    )
    how = "recorded" if end is None else ended(end, recording.end)
    return Judgement(
        verdicts, running, how, measures, [], impossible, further=further, motion=recording, scene=scene
    )  # fmt: skip
