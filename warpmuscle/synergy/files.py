"""Files of synergies: HDF5 that says what it holds, written whole or not at all.

- attributes of `/`: `format` ("warpmuscle synergies"), `format_version`, `command`, `seed`, versions of what made it,
  `processor`, `blas`, and how the recordings were prepared: `band`, `low_pass`, `order`, ... as in
  `warpmuscle.synergy.preparation`
- `/muscles` (M,), `/sources` (S,), `/notes`: names of the channels and of the files, and remarks
- `/activations` (T, M), `/time` (T,) with the unit s or cycle, `/trial` (T,), `/maxima` (M,)
- `/W` (M, N): synergies, the greatest weight of each 1; `/C` (N, T): their coefficients, A = W C
- `/vaf`, `/muscle_vaf` (M,), `/r2` of those N
- `/counts/{count, vaf, r2, muscle_vaf, restart_vaf}`: (K,), (K,), (K,), (K, M), (K, R) for each number of synergies
- `/timing/{centre, centre_spread, width, width_spread}` (N,): when a synergy is active and for how long, means and
  standard deviations over trials, see `warpmuscle.synergy.timing`
- `/similarity` (N,): cosines with the synergies of another file, if these were put in its order

There are no time stamps, so that the same result gives the same bytes.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from warpmuscle.core import hdf5
from warpmuscle.core.array_checks import check_numbers
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ResultError, SceneError
from warpmuscle.core.files import replace_file
from warpmuscle.core.hdf5_writing import store
from warpmuscle.core.machine import this_machine
from warpmuscle.synergy.factorization import Account, Synergies, match
from warpmuscle.synergy.preparation import Activations, Preparation
from warpmuscle.synergy.timing import Timing, timing

FORMAT = "warpmuscle synergies"
FORMAT_VERSION = 1
PACKAGES = ("warpmuscle", "numpy", "scipy", "scikit-learn", "h5py")


@dataclass(frozen=True)
class SynergyResult:
    """What the extraction of synergies leaves behind."""

    activations: Activations
    synergies: Synergies
    counts: tuple[Account, ...]  # of each number of synergies that was tried
    similarity: Floats | None = None  # (N,), cosines with the synergies of a reference
    attributes: Mapping[str, Any] = field(default_factory=dict)  # command, seed, how recordings were prepared

    @property
    def timing(self) -> Timing:
        """When the synergies are active."""
        a = self.activations
        return timing(self.synergies.coefficients, a.trial, a.time, a.time_unit == "cycle")


def described(preparation: Preparation) -> dict[str, Any]:
    """How recordings were prepared, as attributes of a file."""
    p = preparation
    options: dict[str, Any] = {
        "channels": ", ".join(p.channels), "already_filtered": p.already_filtered, "ecg": p.ecg,
        "subtract_minimum": p.subtract_minimum, "maxima_file": str(p.maxima or ""),
    }  # fmt: skip
    if not p.already_filtered:
        options |= {"band": p.chain.band or (), "low_pass": p.chain.low_pass, "order": p.chain.order}
    if p.cycles:
        options |= {"cycle_files": ", ".join(map(str, p.cycles)), "points": p.points, "cycle_range": p.cycle_range}
    else:
        options |= {"rate": p.rate, "window": p.window}
    return {name: value for name, value in options.items() if value is not None and value != ()}


def write(path: str | Path, result: SynergyResult) -> None:
    """Write a file of synergies, replacing a file of that name only once the new one is complete.

    Raises:
        ResultError: the file cannot be written; nothing is left behind then.
    """
    memory = io.BytesIO()
    with h5py.File(memory, "w", track_order=True) as file:
        file.attrs["format"], file.attrs["format_version"] = FORMAT, FORMAT_VERSION
        for name, text in _versions().items():
            file.attrs[f"{name}_version"] = text
        for name, text in this_machine().items():
            file.attrs[name] = text
        for name, value in result.attributes.items():
            file.attrs[name] = value
        _put_activations(file, result.activations)
        _put_synergies(file, result)
    try:
        replace_file(Path(path), memory.getvalue())
    except SceneError as error:
        raise ResultError(f"{path}: {error.message}") from None


def read(path: str | Path) -> SynergyResult:
    """Read a file of synergies.

    Raises:
        ResultError: no such file, not a file of synergies, damaged, or written by a newer version of the format.
    """
    with hdf5.opened(path, lambda message: ResultError(f"{path}: {message}"), "damaged file of synergies") as file:
        if file.attrs.get("format") != FORMAT:
            raise ResultError(f"{path}: an HDF5 file, but not one of synergies")
        if int(file.attrs["format_version"]) > FORMAT_VERSION:
            raise ResultError(f"{path}: its format is newer than what this warpmuscle reads; update it")
        hdf5.check_contents(file)
        result = _load(file)
        _check(result)
        return result


def in_order_of(reference: SynergyResult, muscles: Sequence[str], synergies: Synergies) -> tuple[Synergies, Floats]:
    """Synergies in the order of those of another file, and the cosines of the pairs, (synergies,).

    Raises:
        ResultError: they are not of the same muscles.
    """
    others = reference.activations.muscles
    if others != tuple(muscles):
        raise ResultError(f"the synergies to compare with are of {', '.join(others)}, not of {', '.join(muscles)}")
    order, cosines = match(reference.synergies.weights, synergies.weights)
    return synergies.ordered(order), cosines


TIMING = {
    "centre": "mean time of the synergy's activity over the trials, -1 if it is never active",
    "centre_spread": "its standard deviation over the trials",
    "width": "mean duration of the synergy's activity over the trials, -1 if it is never active",
    "width_spread": "its standard deviation over the trials",
}
COUNTS = {
    "vaf": "variance accounted for by so many synergies",
    "r2": "the same about the mean of all activations",
    "muscle_vaf": "variance accounted for of each muscle",
    "restart_vaf": "variance accounted for after each restart, of which the best was taken",
}


def _put_activations(file: Any, activations: Activations) -> None:
    store(
        file,
        "muscles",
        tuple(activations.muscles),
        axes="muscle",
        description="muscles that were recorded, or simulated",
    )
    store(
        file,
        "sources",
        tuple(activations.sources),
        axes="recording",
        description="files and recordings that the activations are from",
    )
    store(
        file,
        "notes",
        tuple(activations.notes),
        axes="note",
        description="what was done to them, and what is to be known",
    )
    store(file, "activations", activations.values, axes="sample, muscle", units="1",
          description="envelopes over their maxima")  # fmt: skip
    store(
        file,
        "time",
        activations.time,
        axes="sample",
        units=activations.time_unit,
        description="time of each sample, within its recording or cycle",
    )
    store(file, "trial", activations.trial, axes="sample", description="number of the recording, or of the cycle")
    store(file, "maxima", activations.maxima, axes="muscle", description="what 1 stands for, in the recordings' unit")


def _put_synergies(file: Any, result: SynergyResult) -> None:
    s, counts = result.synergies, result.counts
    account = s.account
    store(file, "W", s.weights, axes="muscle, synergy", units="1", description="synergies, the greatest weight is 1")
    store(file, "C", s.coefficients, axes="synergy, sample", units="1", description="coefficients of the synergies")
    store(file, "vaf", account.vaf, description="variance accounted for, 1 - |A - W C|^2 / |A|^2")
    store(file, "muscle_vaf", account.muscle_vaf, axes="muscle", description="the same of each muscle")
    store(file, "r2", account.r2, description="the same about the mean of all activations")
    if result.similarity is not None:
        store(file, "similarity", result.similarity, axes="synergy", description="cosines with those of a reference")
    times, unit = result.timing, result.activations.time_unit
    group = file.create_group("timing", track_order=True)
    for name in ("centre", "centre_spread", "width", "width_spread"):
        # What is never active has no time.
        store(
            group,
            name,
            np.nan_to_num(getattr(times, name), nan=-1.0),
            axes="synergy",
            units=unit,
            description=TIMING[name],
        )
    group = file.create_group("counts", track_order=True)
    store(
        group,
        "count",
        np.array([c.count for c in counts], np.int64),
        axes="number of synergies",
        description="numbers of synergies that were tried",
    )
    for name, axes in {"vaf": "", "r2": "", "muscle_vaf": ", muscle", "restart_vaf": ", restart"}.items():
        store(
            group,
            name,
            np.array([getattr(c, name) for c in counts]),
            axes=f"number of synergies{axes}",
            description=COUNTS[name],
        )


def _load(file: Any) -> SynergyResult:
    activations = Activations(
        hdf5.strings(file["muscles"]), file["activations"][()], file["time"][()], str(file["time"].attrs["units"]),
        file["trial"][()], file["maxima"][()], hdf5.strings(file["sources"]), hdf5.strings(file["notes"]),
    )  # fmt: skip
    group = file["counts"]
    names = ("count", "vaf", "muscle_vaf", "r2", "restart_vaf")
    counts = tuple(
        Account(int(count), float(vaf), muscle_vaf, float(r2), restarts)
        for count, vaf, muscle_vaf, r2, restarts in zip(*(group[name][()] for name in names), strict=True)
    )
    account = next(account for account in counts if account.count == file["W"].shape[1])
    synergies = Synergies(file["W"][()], file["C"][()], account)
    similarity = file["similarity"][()] if "similarity" in file else None
    return SynergyResult(activations, synergies, counts, similarity, dict(file.attrs))


def _check(result: SynergyResult) -> None:
    """ValueError unless shapes fit each other and all numbers are finite and of a usable size."""
    a, s = result.activations, result.synergies
    samples, muscles, count = len(a.time), len(a.muscles), s.account.count
    if len(set(a.muscles)) != muscles:
        raise ValueError("muscles holds a name twice")
    check_numbers("activations", a.values, (samples, muscles))
    check_numbers("time", a.time, (samples,))
    check_numbers("trial", a.trial, (samples,))
    check_numbers("maxima", a.maxima, (muscles,))
    check_numbers("W", s.weights, (muscles, count), 0.0)
    check_numbers("C", s.coefficients, (count, samples), 0.0)
    if result.similarity is not None:
        check_numbers("similarity", result.similarity, (count,))
    for account in result.counts:
        check_numbers("counts/vaf", [account.vaf, account.r2], (2,))
        check_numbers("counts/muscle_vaf", account.muscle_vaf, (muscles,))
        check_numbers("counts/restart_vaf", account.restart_vaf, np.shape(account.restart_vaf))


def _versions() -> dict[str, str]:
    found = {}
    for package in PACKAGES:
        try:
            found[package.replace("-", "_")] = version(package)
        except PackageNotFoundError:
            found[package.replace("-", "_")] = "unknown"
    return found
