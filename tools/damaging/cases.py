"""Cases: which damage of which kind, with which seed; and the verdict on what is said about it."""

from __future__ import annotations

import copy
import random
import re
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from fuzzing.judge import Verdict, judged

from damaging.damage import Damage
from damaging.laboratory import EMG as ELECTRODES
from damaging.laboratory import LABORATORY
from damaging.markers import C3D, TRC
from damaging.setups import ELSEWHERE, MODEL, SETUP
from damaging.tables import COORDINATES, EMG, LOADS
from damaging.trial import NAMES, Trial

KINDS: dict[str, list[Damage]] = {
    "markers": TRC + ELSEWHERE["markers"], "c3d": C3D, "coordinates": COORDINATES + ELSEWHERE["coordinates"],
    "loads": LOADS + ELSEWHERE["loads"] + ELSEWHERE["described"], "emg": EMG + ELSEWHERE["emg"], "setup": SETUP,
    "model": MODEL, "laboratory": LABORATORY,
}  # fmt: skip
MEASURED = ("soleus_r", "tib_ant_r")  # muscles of OpenSim's walk
ALIKE = {"rad": 0.1, "N": 0.1}  # rad by which coordinates, and part of its range by which an array may differ
NAMED = "|".join([*map(re.escape, NAMES.values()), "the motion", "the force '"])  # what an error must name one of
SHOWN = 600  # characters of what was said


class Case(NamedTuple):
    """A damage with its own random numbers."""

    kind: str
    number: int  # within the kind
    seed: int

    @property
    def damage(self) -> Damage:
        return KINDS[self.kind][self.number % len(KINDS[self.kind])]


def cases(count: int, kinds: list[str], seed: int) -> list[Case]:
    """So many cases; each damage comes once before any comes again."""
    every = [(kind, k) for kind in kinds for k in range(len(KINDS[kind]))]
    return [Case(kind, k + n // len(every) * len(KINDS[kind]), seed)
            for n in range(count) for kind, k in [every[n % len(every)]]]  # fmt: skip


def command(kind: str) -> list[str]:
    """What is asked for."""
    output = ["-o", "out.h5", "--device", "cpu"]
    loads = ["--loads", NAMES["described"]]
    if kind in ("markers", "c3d"):
        on = loads if kind == "markers" else []  # times of C3D begin at 0
        return ["inverse", "model.osim", NAMES[kind], *on, "--steps", "ik,id" if on else "ik", *output]
    if kind == "laboratory":
        of = [f"--channel={muscle}={name}" for muscle, name in zip(MEASURED, ELECTRODES, strict=True)]
        named = ["--emg", NAMES["c3d"], *of, "--steps", "ik,id,so", "--reserve", "50", "--filter", "6"]
        return ["inverse", "model.osim", NAMES["c3d"], *named, *output]
    if kind == "setup":
        return ["inverse", "model.osim", NAMES["markers"], "--setup", NAMES["setup"], "--steps", "ik", *output]
    more = ["--emg", NAMES["emg"], "--steps", "id,so", "--reserve", "50"] if kind == "emg" else ["--steps", "id"]
    return ["inverse", "model.osim", NAMES["coordinates"], *loads, *more, *output]


def run(case: Case, sound: Trial, folder: Path, wanted: Path | None) -> Verdict:
    """Write the damaged trial into a folder of its own, run the command there, and judge what it says.

    Args:
        wanted: the result of the sound trial; None: this is it.
    """
    inside = folder / "case"
    inside.mkdir(parents=True)
    trial = copy.deepcopy(sound)
    if wanted is not None:
        case.damage.change(trial, random.Random(f"{case.seed} {case.kind} {case.number}"))
    trial.write(inside, case.kind)
    verdict = judged([command(case.kind)], inside, folder)
    if wanted is not None and not verdict.complaints:
        verdict.complaints += _complaints(case, verdict, inside / "out.h5", wanted)
    return verdict


def _complaints(case: Case, verdict: Verdict, result: Path, wanted: Path) -> list[str]:
    told, said = case.damage.told, verdict.said.strip()
    if verdict.refused and told is None:
        return [f"was refused: {said[:SHOWN]}"]
    if verdict.refused and not re.search(NAMED, said):
        return [f"does not name the file: {said[:SHOWN]}"]
    if told and not re.search(told, said):
        return [f"says nothing of /{told}/: {said[:SHOWN] or 'nothing'}"]
    if (told == "" and not verdict.refused and "note:" not in said) or told is None:
        return list(_differences(result, wanted))
    return []


def _differences(result: Path, wanted: Path) -> list[str]:
    """What is not as it should be in a result without a word."""
    with h5py.File(result) as one, h5py.File(wanted) as other:
        mine, right = (next(iter(file["trials"].values())) for file in (one, other))
        for name in ("coordinate_value", "activation"):
            if name in mine:
                a, b = mine[name][()], right[name][()]
                if a.shape != b.shape:
                    return [f"without a word, {name} has shape {a.shape}, not {b.shape}"]
                if (far := float(np.abs(a - b).max())) > ALIKE["rad"]:
                    return [f"without a word, {name} is off by {far:.3g}"]
    return []
