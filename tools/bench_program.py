"""How fast quadratic programmes of a body on its feet are solved: programmes a second, and how far from float64.

    python tools/bench_program.py
    python tools/bench_program.py --programs 262144 --device cuda:0
    python tools/bench_program.py --muscles 92 --torques 20 --points 8 --check 20
    python tools/bench_program.py --programs 262144 --device cuda:0 --lanes 0    # a thread each, rather than a warp

Programmes are random ones of a person's size (`tests/program_problems.py`), on two feet, of 92 muscles, 20 torques
and the edges of 8 friction cones unless told otherwise. Each search begins at nothing; with `--warm` it begins where
that of a programme a little other has ended, as in a controller. Rates are the best of some runs, kernels being
compiled and numbers on the device. `--check` solves some of them in float64, too.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
import warp as wp

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from program_problems import Problems, optimum, standing  # type: ignore[import-not-found]
from warpmuscle.cli.ending import run_script
from warpmuscle.core.machine import this_machine
from warpmuscle.simulation.devices import find_device
from warpmuscle.simulation.program.program_batch import ProgramBatch

OWN = 256  # programmes that differ; more are these again


def batch_of(problems: Problems, count: int, device: str | None, lanes: int | None = None) -> ProgramBatch:
    """So many programmes on a device, which are the given ones again and again."""
    n, m = problems.forces.shape[1:]
    rows = [np.flatnonzero(np.any(problems.forces[:, :, j] != 0.0, axis=0)).tolist() for j in range(m)]
    batch = ProgramBatch(count, n, rows, find_device(device), lanes=lanes)
    own = np.arange(count) % len(problems.mass)
    entry = np.concatenate([problems.forces[:, one, j] for j, one in enumerate(rows)], axis=1)
    given = {
        "mass": problems.mass.reshape(-1, n * n), "weight": problems.weight.reshape(-1, n * n), "bias": problems.bias,
        "wanted": problems.wanted, "entry": entry,
    }  # fmt: skip
    for name, values in given.items():
        getattr(batch.numbers, name).assign(values.astype(np.float32)[own])
    for name, values in (("gain", 1.0 / problems.cost), ("low", problems.low), ("high", problems.high)):
        getattr(batch.numbers, name).assign(values.astype(np.float32)[None])
    return batch


def seconds(batch: ProgramBatch, begin: np.ndarray, runs: int) -> float:
    """Shortest time of some runs, s, whose searches begin at multipliers (P, n)."""
    found = []
    for _ in range(runs + 1):  # the first one compiles
        batch.multiplier.assign(begin)
        wp.synchronize()
        start = time.perf_counter()
        batch.solve()
        wp.synchronize()
        found.append(time.perf_counter() - start)
    return min(found[1:])


def main(
    programs: Annotated[int, typer.Option(help="Solved at once.")] = 2048,
    muscles: Annotated[int, typer.Option(help="Of each body.")] = 92,
    torques: Annotated[int, typer.Option(help="Of each body.")] = 20,
    points: Annotated[int, typer.Option(help="Of contact, with 4 edges of a friction cone each.")] = 8,
    device: Annotated[str | None, typer.Option(help="Such as cuda:0; by default a GPU if there is one.")] = None,
    warm: Annotated[bool, typer.Option(help="Begin where a programme a little other has ended.")] = False,
    check: Annotated[int, typer.Option(help="Programmes that are solved in float64, too.")] = 20,
    lanes: Annotated[int | None, typer.Option(help="That share a programme: 32 on a GPU, 1 on a CPU; 0: none.")] = None,
    runs: Annotated[int, typer.Option(help="Of which the fastest counts.")] = 3,
) -> None:
    """Measure."""
    problems = standing(min(OWN, programs), muscles, torques, points)
    batch = batch_of(problems, programs, device, lanes)
    begin = np.zeros((programs, batch.coordinates))
    if warm:
        batch.solve()
        begin = batch.multiplier.numpy().copy()
        changed = problems.wanted + 0.1 * np.random.default_rng(1).normal(size=problems.wanted.shape)
        batch.numbers.wanted.assign(changed.astype(np.float32)[np.arange(programs) % len(changed)])
    taken = seconds(batch, begin, runs)
    iterations = batch.iterations.numpy()
    print(f"{this_machine()}, {batch.device}")
    print(f"{programs} programmes of {batch.coordinates} coordinates and {batch.controls} controls: {taken:.4f} s")
    rate, mean, most = programs / taken, iterations.mean(), iterations.max()
    print(f"{rate:,.0f} programmes/s; {mean:.1f} iterations in the mean, {most} at most")
    print(f"not balanced: {np.sum(iterations < 0)}")
    if check and not warm:
        control = batch.control.numpy()
        away = [np.abs(control[p] - optimum(problems, p, control[p])) for p in range(min(check, len(problems.mass)))]
        worst = [max(one[part].max(initial=0.0) for one in away) for part in parts(muscles, torques)]
        print("farthest from float64: activations {:.1e}, torques {:.1e} N m, edges {:.1e} N".format(*worst))


def parts(muscles: int, torques: int) -> tuple[slice, slice, slice]:
    """Where activations, torques and edges stand among the controls."""
    return slice(0, muscles), slice(muscles, muscles + torques), slice(muscles + torques, None)


if __name__ == "__main__":
    run_script(main)
