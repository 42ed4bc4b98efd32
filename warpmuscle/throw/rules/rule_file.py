"""Rules from goals to signals in HDF5 files, from which an interrupted search goes on."""

from __future__ import annotations

import contextlib
import hashlib
import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from warpmuscle.core import hdf5
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ResultError
from warpmuscle.core.files import replace_file
from warpmuscle.core.hdf5_writing import store
from warpmuscle.formats import toml
from warpmuscle.throw.job import Job
from warpmuscle.throw.rules.rule import Rule, Walk
from warpmuscle.throw.synthesis import Thrower

FORMAT = "warpmuscle throw rule"
NUMBERS = ("wanted", "met", "tried_from", "goals", "changes", "known", "parameters", "place", "release", "simulations")


def origin(job: Job) -> str:
    """What a rule is learned out of, as a digest: scene, motion and synergies."""
    found = hashlib.sha256(toml.dumps(job.arm.scene).encode())
    for part in (job.motions.angles[0], job.follower.synergies.weights):
        found.update(np.round(part, 6).astype(np.float32).tobytes())
    return found.hexdigest()


def write_rule(path: Path, job: Job, rule: Rule, errors: Mapping[str, Floats], command: str) -> None:
    """Keep goals, changes of the signals, the errors of the goals that were tried, and what to go on from."""
    memory = io.BytesIO()
    with h5py.File(memory, "w", track_order=True) as file:
        file.attrs["format"], file.attrs["command"], file.attrs["seed"] = FORMAT, command, rule.seed
        file.attrs["origin"] = origin(job)
        store(file, "goals", rule.goals, axes="goal, distance height angle", description="met; in m, m and rad")
        store(file, "changes", rule.changes, axes="goal, synergy and coarse knot",
              description="of the signals, from those of the first goal")  # fmt: skip
        store(file, "known", rule.walk.thrower.individual, axes="signal", description="signals that changes are of")
        store(
            file,
            "hats",
            rule.walk.thrower.hats,
            axes="knot, coarse knot",
            description="weight of each coarse knot at each knot of a signal",
        )
        store(file, "parameters", rule.parameters, axes="parameter", description="fitted ones, as parts of intervals")
        store(file, "release", rule.release, units="s", description="time of the release")
        store(file, "place", rule.place, units="m", axes="forwards up", description="of the release at the first goal")
        store(file, "wanted", rule.wanted, axes="goal, distance height angle", description="to learn from")
        store(file, "met", rule.met, axes="goal", description="whether a wanted goal is met")
        store(file, "tried_from", rule.tried_from, axes="goal",
              description="number of the met goal that it was last tried from; -1 if it was not tried yet")  # fmt: skip
        store(file, "simulations", rule.walk.simulations, axes="", description="of throws at goals, so far")
        group = file.create_group("errors", track_order=True)
        for name, error in errors.items():
            store(group, name.replace(", ", "_").replace(" ", "_"), error, axes="goal, landing angle limits",
                  description="of landing, m, and angle, rad; how far joints pass their limits, rad")  # fmt: skip
    replace_file(path, memory.getvalue())


def read_seed(path: Path) -> int:
    """The seed that a rule was begun with; raises ResultError if the file holds none that can be gone on with."""
    with _opened(path) as file:
        return int(file.attrs["seed"])


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    says = _says(path)
    with hdf5.opened(path, says) as file:
        hdf5.check_contents(file)
        if "format" not in file.attrs or file.attrs["format"] != FORMAT or "origin" not in file.attrs:
            raise says("no rule that can be gone on with; name a file that `throw predict` wrote")
        yield file


def _says(path: Path) -> hdf5.Says:
    return lambda text: ResultError(f"{path}: {text}")


def read_rule(path: Path, job: Job) -> Rule:
    """A rule to go on with, for a job whose motion need not be fitted.

    Raises:
        ResultError: the file holds no such rule, or one that was learned out of something else.
    """
    says = _says(path)
    with _opened(path) as file:
        if file.attrs["origin"] != origin(job):
            raise says("learned out of another motion, scene or number of synergies; name the same, or leave out "
                       "--resume")  # fmt: skip
        values = {name: np.asarray(hdf5.array(file, name)) for name in NUMBERS}
        seed = int(file.attrs["seed"])
    _check(values, job, says)
    thrower = Thrower(job.follower, values["known"], values["parameters"], float(values["release"]), seed=seed)
    walk = Walk(thrower, list(values["goals"]), list(values["changes"]), int(values["simulations"]))
    if values["changes"].shape[1] != thrower.hats.shape[1] * job.follower.synergies.count:
        raise says("damaged: the changes are of another number of knots")
    return Rule(walk, values["place"], float(values["release"]), values["parameters"], values["wanted"],
                values["met"].astype(bool), values["tried_from"].astype(np.intp), seed)  # fmt: skip


def _check(values: Mapping[str, Any], job: Job, says: hdf5.Says) -> None:
    """Error unless the numbers are finite and belong together."""
    count, goals = len(np.atleast_1d(values["wanted"])), len(np.atleast_1d(values["goals"]))
    shapes = {
        "wanted": (count, 3), "met": (count,), "tried_from": (count,), "goals": (goals, 3), "place": (2,),
        "release": (), "simulations": (), "known": (job.follower.size,), "parameters": (len(job.arm.parameters),),
    }  # fmt: skip
    for name, shape in shapes.items():
        if values[name].shape != shape:
            raise says(f"damaged: {name} has shape {values[name].shape}, not {shape}")
    if values["changes"].ndim != 2 or len(values["changes"]) != goals:
        raise says("damaged: there are not as many changes as goals")
    wrong = [name for name in NUMBERS if values[name].dtype.kind not in "fiub" or not np.isfinite(values[name]).all()]
    if wrong:
        raise says(f"damaged: {wrong[0]} holds what is not a finite number")
    if values["simulations"] < 0:
        raise says("damaged: simulations are fewer than none")
    if goals != 1 + int(np.sum(values["met"])):
        raise says("damaged: there are not as many goals as are met")
    if not np.all((values["tried_from"] >= -1) & (values["tried_from"] < goals)):
        raise says("damaged: a goal was tried from one that is not met")
