"""Fits throws alone that are cut, slowed, reversed, bent in time, scaled or noisy, and says who meets the bars.

For docs/explanation/throwing.md.

Example: python tools/research/throw_variants.py throws/*.csv --each 3
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from scipy.signal import butter, filtfilt

from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.motion import ArmMotion
from warpmuscle.throw.recordings.motion_files import read

Curves = tuple[Floats, Floats]  # time (T,), s, and what moves (T, k)
JOINTS = ("shoulder", "elbow", "wrist")


def cut(time: Floats, values: Floats) -> Curves:
    """The middle 70 %."""
    first, last = round(0.15 * len(time)), round(0.85 * len(time))
    return time[first:last], values[first:last]


def cut_and_filtered(time: Floats, values: Floats) -> Curves:
    """Filtered at 6 Hz after it was cut, which bends the ends."""
    clock, part = cut(time, values)
    b, a = butter(2, 6.0 * 2.0 * (clock[1] - clock[0]))
    return clock, filtfilt(b, a, part, axis=0)


def slowed(time: Floats, values: Floats) -> Curves:
    """Half as fast."""
    return time[0] + 2.0 * (time - time[0]), values


def reversed_in_time(time: Floats, values: Floats) -> Curves:
    """The end first."""
    return time, values[::-1]


def bent(time: Floats, values: Floats) -> Curves:
    """Slower at first and faster later, by 20 %."""
    part = (time - time[0]) / (time[-1] - time[0])
    there = time[0] + (time[-1] - time[0]) * (part - 0.2 / np.pi * np.sin(np.pi * part) * 0.5)
    return time, np.stack([np.interp(there, time, column) for column in values.T], axis=1)


def scaled(factor: float) -> Callable[[Floats, Floats], Curves]:
    """So many times the excursion from the mean."""
    return lambda time, values: (time, values.mean(axis=0) + factor * (values - values.mean(axis=0)))


def noisy(size: float) -> Callable[[Floats, Floats], Curves]:
    """With white noise of so many degrees."""
    return lambda time, values: (
        time, values + np.radians(size) * np.random.default_rng(1).standard_normal(values.shape)
    )  # fmt: skip


VARIANTS: dict[str, Callable[[Floats, Floats], Curves]] = {
    "as recorded": lambda time, values: (time, values), "cut": cut, "cut, then filtered": cut_and_filtered,
    "half as fast": slowed, "reversed": reversed_in_time, "bent in time": bent, "half as large": scaled(0.5),
    "half as large again": scaled(1.5), "0.02 degrees of noise": noisy(0.02), "0.1 degrees of noise": noisy(0.1),
}  # fmt: skip


def write(path: Path, motion: ArmMotion, variant: Callable[[Floats, Floats], Curves]) -> None:
    """Write a variant of a motion as a table that `warpmuscle throw fit` reads."""
    time, values = variant(motion.time, np.column_stack([motion.angles, motion.pitch]))
    header = ",".join(["time_s", *(f"{name}_rad" for name in JOINTS), "trunk_pitch_rad"])
    np.savetxt(path, np.column_stack([time, values]), delimiter=",", header=header, comments="", fmt="%.9f")


def main(
    files: Annotated[list[Path], typer.Argument(help="Motions, as `warpmuscle throw fit` takes them.")],
    each: Annotated[int, typer.Option(help="How many of them are varied, spread over all.")] = 3,
    only: Annotated[list[str] | None, typer.Option(help="Variants to try; else all.")] = None,
    threads: Annotated[int | None, typer.Option(help="CPU threads.")] = None,
) -> None:
    """Print a line for each variant: how many meet all bars, and the worst of every measure."""
    motions = [motion for file in files for motion in read(file, JOINTS)]
    chosen = [motions[k] for k in np.unique(np.linspace(0, len(motions) - 1, each).round().astype(int))]
    met = fitted = 0
    print(f"{'variant':22s} bars met  r2      velocity  hand, cm  correlation   (the worst of each)")
    with tempfile.TemporaryDirectory() as folder:
        for name in only or VARIANTS:
            found = []
            for number, motion in enumerate(chosen):
                path = Path(folder) / f"{number}.csv"
                write(path, motion, VARIANTS[name])
                try:
                    found.append(Job(load("throw"), [path], JobOptions(threads=threads)).fit().agreement)
                except Error as error:
                    print(f"{name:22s} {motion.name}: {error}")
            good = sum(int(a.good().sum()) for a in found)
            met, fitted = met + good, fitted + len(found)
            if found:
                print(
                    f"{name:22s} {good} of {len(found):<3d}  {min(a.r2.min() for a in found):.5f} "
                    f"{min(a.velocity_r2.min() for a in found):8.4f} "
                    f"{100.0 * max(a.hand_error.max() for a in found):9.2f} "
                    f"{min(a.correlation.min() for a in found):9.3f}",
                    flush=True,
                )
    print(f"{met} of {fitted} meet all bars")


if __name__ == "__main__":
    run_script(main)
