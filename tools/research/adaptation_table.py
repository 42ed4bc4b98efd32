"""How a policy adapts to one-sided weakness: learning goes on from it with weak muscles, and both walks are compared.

For docs/how-to/devices-and-impairments.md.

    python tools/research/adaptation_table.py gait2392_arms_by_policy.h5 gait2392_arms_by_policy.toml --folder patients

Learning goes on three times, where the folder has no file of it yet: with healthy muscles, so that more learning is not
taken for weakness, with the left calf and with the left gluteus medius at half their strength. Then each walks 30 s at
1.25 m/s, and so does the one with healthy muscles in the weak bodies, as if they had not adapted. The table has both
sides of all of them, what published studies found beside what is found here, and how much of what weakness changed
adapting brought back.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

SHARE = 0.5  # of the strength that is left
CASES = {  # muscles of the left side by names of the weak bodies
    "healthy": (),
    "calf": ("soleus_l", "med_gas_l", "lat_gas_l"),
    "glut_med": ("glut_med1_l", "glut_med2_l", "glut_med3_l"),
}
LASTING = 30.0  # s
OF_BOTH = {  # measures of the whole body: unit, decimals
    "speed": ("m/s", 2), "cadence": ("steps/min", 0), "step width": ("m", 3), "mean activation": ("0 to 1", 4),
    "cost of transport, Bhargava net": ("J/(kg m)", 2), "upright": ("of 20", 0),
}  # fmt: skip
LEFT, RIGHT = ", left", ", right"


class Expected(NamedTuple):
    """What a study found of a weak body, against a healthy one."""

    case: str
    measure: str
    change: str  # rises, falls, stays
    within: float  # of the measure's unit, in which it stays; else least change
    source: str


KROGT = "van der Krogt 2012, abstract: the weak muscle and others are more active, in all more, and walking costs more"
BLOCK = "Pohl 2015, Kendall 2013: a nerve block that halves hip abductors changes neither pelvic drop nor trunk lean"
PUBLISHED = (
    Expected("calf", "activation of soleus, left", "rises", 0.0, KROGT),
    Expected("calf", "mean activation", "rises", 0.0, KROGT),
    Expected("calf", "cost of transport, Bhargava net", "rises", 0.0, KROGT),
    Expected("calf", "ankle, maximum dorsiflexion in stance, left", "rises", 0.0, "Ong 2019: walking on heels"),
    Expected("calf", "ankle power, maximum, left", "falls", 0.0, "Ong 2019: weak push-off, slower"),
    Expected("glut_med", "activation of gluteus medius, left", "rises", 0.0, KROGT),
    Expected("glut_med", "mean activation", "rises", 0.0, KROGT),
    Expected("glut_med", "cost of transport, Bhargava net", "rises", 0.0, KROGT),
    Expected("glut_med", "pelvis, drop of the other side in single support, left", "stays", 2.0, BLOCK),
    Expected("glut_med", "trunk, lean to this side in single support, left", "stays", 2.0, BLOCK),
)
HALF = 0.5  # of what weakness took, or added, from which on it counts as recovered


class Wanted(NamedTuple):
    """What adapting should bring back of what weakness changed before it."""

    measure: str
    sides: bool  # what counts is the difference of left and right, else the measure itself
    least: float  # change by weakness, of the measure's unit, below which there is nothing to bring back


WANTED = (
    Wanted("speed", False, 0.02),
    Wanted("cost of transport, Bhargava net", False, 0.05),
    Wanted("upright", False, 1.0),
    Wanted("step length", True, 0.01),
    Wanted("gait profile score", True, 0.5),
    Wanted("ankle, maximum dorsiflexion in stance", True, 2.0),
)
Walk = dict[str, float]  # measures of a walk, those of sides with `LEFT` and `RIGHT`


def learned(policy: Path, scene: str, case: str, given: argparse.Namespace) -> Path:
    """The file of a policy that went on learning in a body, made unless it is there."""
    file: Path = given.folder / f"{case}.h5"
    if file.exists():
        return file
    command = ["learn", scene, "--from", policy, "--until", given.until, "--seed", str(given.seed), "-o", file]
    for setting in (*settings(case), *given.set):
        command += ["--set", setting]
    for option in given.option:
        command += ["--option", option]
    if given.device:
        command += ["--device", given.device]
    subprocess.run([sys.executable, "-m", "warpmuscle", *map(str, command)], check=True)
    return file


def settings(case: str) -> list[str]:
    """What the scene has of a case: no symmetry, which a weak side breaks, and weak muscles."""
    muscles = ", ".join(f'"{name}"' for name in CASES[case])
    weak = [f"impairments.{case} = {{ muscles = [{muscles}], f_max = {SHARE:g} }}"] if muscles else []
    return ["learning.symmetric = false", *weak]


def walked(policy: Path, body: Path, device: str | None, duration: float) -> Walk:
    """Measures of a policy's walk in the body of a result file; nothing but how it is disturbed if it falls."""
    from warpmuscle.core.errors import Error
    from warpmuscle.gait.quality import gait_measures
    from warpmuscle.gait.sides import measures_of_sides
    from warpmuscle.learning.player import learned_in
    from warpmuscle.optimization.best_scene import scene_in
    from warpmuscle.results.result import read
    from warpmuscle.simulation.perturbations import none
    from warpmuscle.studies.judge import disturbed_upright, energies
    from warpmuscle.studies.walkers import PolicyWalker

    walker = PolicyWalker(learned_in(policy), scene_in(read(body, replay=0)), device)
    walks = walker.walk(duration, none(1), record=True)
    found: Walk = {"upright": float(disturbed_upright(walker))}
    if not walks.upright[0]:
        return found
    motion, scene = walks.recordings[0], walker.scene()
    try:
        whole = gait_measures(motion, scene) | energies(motion, scene)
        sides = measures_of_sides(motion, scene)
    except Error:
        return found
    found |= {name: value for name in OF_BOTH if (value := whole.get(name)) is not None}
    for name, one in sides.items():
        found |= {name + LEFT: one.left, name + RIGHT: one.right}
    return found


def table(walks: Mapping[str, Walk]) -> str:
    """A row a measure in Markdown, left and right in one cell, and a column a walk."""
    names = dict.fromkeys(name for walk in walks.values() for name in walk)
    lines = [["measure", *walks], ["---"] * (1 + len(walks))]
    for name, (unit, decimals) in OF_BOTH.items():
        cells = (f"{walk[name]:.{decimals}f}" if name in walk else "falls" for walk in walks.values())
        lines.append([f"{name}, {unit}", *cells])
    for name in (one.removesuffix(LEFT) for one in names if one.endswith(LEFT)):
        both = ([walk.get(name + side) for side in (LEFT, RIGHT)] for walk in walks.values())
        lines.append([name, *("" if None in pair else "{:.3g}, {:.3g}".format(*pair) for pair in both)])
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def verdicts(walks: Mapping[str, Walk]) -> str:
    """What studies found beside what is found here, a line each."""
    lines = [["weak", "measure", "published", "here", "", "source"], ["---"] * 6]
    for one in PUBLISHED:
        before, after = (walks.get(case, {}).get(one.measure) for case in ("healthy", one.case))
        if before is None or after is None:
            lines.append([one.case, one.measure, one.change, "not measured", "", one.source])
            continue
        said = "as published" if agreeing(one, after - before) else "otherwise"
        lines.append([one.case, one.measure, one.change, f"{before:.3g} to {after:.3g}", said, one.source])
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def recoveries(walks: Mapping[str, Walk]) -> str:
    """What adapting brought back of what weakness changed before it, a line each; unlike a direction, it can fail.

    The healthy walk is that of the policy which learnt on for as long, so that more learning is not taken for it.
    """
    lines = [["weak", "measure", "healthy", "not adapted", "adapted", "brought back, %", ""], ["---"] * 7]
    for case in CASES:
        if case == "healthy":
            continue
        for one in WANTED:
            values = [valued(walks.get(name, {}), one) for name in ("healthy", f"{case}, not adapted", case)]
            name = f"{one.measure}, left less right" if one.sides else one.measure
            if any(value is None for value in values):
                shown = ["falls" if value is None else f"{value:.3g}" for value in values]
                again = values[1] is None and None not in (values[0], values[2])
                lines.append([case, name, *shown, "", "walks again" if again else "not measured"])
                continue
            healthy, before, after = (float(value) for value in values if value is not None)
            shown = [f"{value:.3g}" for value in (healthy, before, after)]
            lines.append([case, name, *shown, *recovered(one, healthy, before, after)])
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def valued(walk: Walk, one: Wanted) -> float | None:
    """A measure of a walk, or how its sides differ; None if the walk has none."""
    if not one.sides:
        return walk.get(one.measure)
    left, right = walk.get(one.measure + LEFT), walk.get(one.measure + RIGHT)
    return None if left is None or right is None else left - right


def recovered(one: Wanted, healthy: float, before: float, after: float) -> tuple[str, str]:
    """Share of the change by weakness that adapting undid, %, and whether it is at least half."""
    if abs(before - healthy) < one.least:
        return "", "weakness changed too little"
    share = (before - after) / (before - healthy)
    if one.sides:  # who comes to differ the other way has not recovered
        share = 1.0 - abs(after - healthy) / abs(before - healthy)
    return f"{100.0 * share:.0f}", "recovered" if share >= HALF else "not recovered"


def agreeing(expected: Expected, change: float) -> bool:
    """Whether a change is as a study found."""
    if expected.change == "stays":
        return abs(change) <= expected.within
    return bool(np.sign(change) == (1.0 if expected.change == "rises" else -1.0) and abs(change) > expected.within)


def main() -> None:
    """Learn what is not learnt yet, walk, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("policy", type=Path, help="that learning goes on from")
    parser.add_argument("scene", help="that it was learnt in")
    parser.add_argument("--folder", type=Path, required=True, help="of the policies and the table")
    parser.add_argument("--until", default="120s", help="of each learning")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--set", action="append", default=[], help="as of warpmuscle learn, in all scenes")
    parser.add_argument("--option", action="append", default=[], help="as of warpmuscle learn, in all trainings")
    parser.add_argument("--device", default=None)
    parser.add_argument("--duration", type=float, default=LASTING, help="s, of the walks that are compared")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    files = {case: learned(given.policy, given.scene, case, given) for case in CASES}
    walks: dict[str, Walk] = {}
    for case, file in files.items():
        if case != "healthy":
            walks[f"{case}, not adapted"] = walked(files["healthy"], file, given.device, given.duration)
        walks[case] = walked(file, file, given.device, given.duration)
        text = "\n".join((table(walks), verdicts(walks), recoveries(walks)))
        (given.folder / "adaptation.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
