"""Fits of recorded throws, all together by number of synergies and each alone, and which of them meet all bars.

For docs/explanation/throwing.md.

W and the muscle parameters of a group are fitted to every other throw; of the others only the signals are. Fits run in
processes of their own; a line of JSON is kept of each as it ends.

Example: python tools/research/throw_table.py throws/*.csv --scene throw18 --number 4 --number 5 --alone --processes 2
"""

from __future__ import annotations

import json
import multiprocessing
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.metrics import LEAST_CORRELATION, LEAST_R2, LEAST_VELOCITY_R2, MOST_HAND_ERROR

BARS = f"r2 >= {LEAST_R2}, velocity >= {LEAST_VELOCITY_R2}, hand <= {MOST_HAND_ERROR} m, C >= {LEAST_CORRELATION}"


@dataclass(frozen=True)
class Task:
    """A fit of some files with N synergies; the usual number if None."""

    scene: str
    files: tuple[Path, ...]
    count: int | None
    threads: int = 1

    @property
    def kind(self) -> str:
        return "together" if len(self.files) > 1 else "alone"

    def gave(self, row: dict[str, Any]) -> bool:
        """Whether a row is of this fit."""
        stems = [file.stem for file in self.files]
        same = row["scene"] == self.scene and [Path(name).stem for name in row["names"]] == stems
        return same and row["asked"] == self.count


def kept(output: Path | None) -> list[dict[str, Any]]:
    """Rows of an earlier call that was ended."""
    if output is None or not output.exists():
        return []
    return [json.loads(text) for text in output.read_text(encoding="utf-8").splitlines()]


def ready(scene: str, file: Path) -> None:
    """Compile the kernels, which all processes then find in the cache."""
    Job(load(scene), [file], JobOptions()).follower.load()


def fitted(task: Task) -> dict[str, Any]:
    """What a fit came to, by throw."""
    begin, started = time.perf_counter(), time.process_time()
    job = Job(load(task.scene), task.files, JobOptions(count=task.count, threads=task.threads))
    found = job.fit()
    a = found.agreement
    values = zip(job.arm.parameters, job.arm.values(found.unknowns).tolist(), strict=True)
    weights = job.follower.synergies.weights
    return {
        "scene": task.scene, "kind": task.kind, "number": job.count, "asked": task.count,
        "names": list(job.motions.names), "held_out": job.held_out, "good": a.good().tolist(), "r2": a.r2.tolist(),
        "velocity_r2": a.velocity_r2.tolist(), "hand_error": a.hand_error.tolist(),
        "correlation": a.correlation.tolist(), "by_synergy": a.by_synergy.tolist(),
        "null_by_synergy": None if a.null_by_synergy is None else a.null_by_synergy.tolist(),
        "explained": job.follower.synergies.explained,
        "torque_r2": None if job.shared is None else job.shared.torque_r2.tolist(),
        "muscles": list(job.arm.muscles), "weights": weights.tolist(),
        "parameters": {parameter.name: value for parameter, value in values},
        "share": (weights.max(axis=0) / weights.sum(axis=0)).tolist(),
        "cpu": time.process_time() - started, "seconds": time.perf_counter() - begin,
    }  # fmt: skip


def line(rows: Sequence[dict[str, Any]]) -> str:
    """A row of the table, of the fits of one number together or alone."""
    good, held = [], []
    for row in rows:
        good += row["good"]
        held += [row["good"][k] for k in row["held_out"]]
    worst = [min(np.min(row[name]) for row in rows) for name in ("r2", "velocity_r2", "correlation")]
    hand = 100.0 * max(max(row["hand_error"]) for row in rows)
    explained = np.median([row["explained"] for row in rows])
    share = max(max(row["share"]) for row in rows)
    return (
        f"{rows[0]['number']:3d} {rows[0]['kind']:8s}  all bars {sum(good):2d} of {len(good):2d}, held out "
        f"{sum(held):2d} of {len(held):2d}; VAF {explained:.3f}, share {share:.2f}; lowest r2 {worst[0]:.4f}, velocity "
        f"{worst[1]:.3f}, hand {hand:4.1f} cm, correlation {worst[2]:.3f}; {sum(row['cpu'] for row in rows):4.0f} s "
        "of CPU"
    )


def missed(row: dict[str, Any]) -> list[str]:
    """A line of each throw that misses a bar."""
    return [
        f"      {row['names'][k]}: r2 {min(row['r2'][k]):.4f}, velocity {min(row['velocity_r2'][k]):.3f}, "
        f"hand {100.0 * row['hand_error'][k]:.1f} cm, correlation {row['correlation'][k]:.3f}"
        for k in np.flatnonzero(~np.array(row["good"]))
    ]


def main(
    files: Annotated[list[Path], typer.Argument(help="Motions, as `warpmuscle throw fit` takes them.")],
    scene: Annotated[str, typer.Option(help="The arm.")] = "throw18",
    number: Annotated[list[int] | None, typer.Option("--number", "-n", help="Of synergies, all together.")] = None,
    alone: Annotated[bool, typer.Option("--alone", help="Fit each by itself as well.")] = False,
    alone_number: Annotated[int | None, typer.Option(help="Of synergies then; else the usual number.")] = None,
    processes: Annotated[int, typer.Option(min=1, help="How many fits at a time.")] = 2,
    threads: Annotated[int, typer.Option(min=1, help="CPU threads of a fit of all together; else 1.")] = 1,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="A line of JSON of each fit; what it has is not fitted again.")
    ] = None,
) -> None:
    """Print a line for each number of synergies, and which throws miss a bar."""
    counts: list[int | None] = [*number] if number else [] if alone else [None]
    tasks = [Task(scene, tuple(files), count, threads) for count in counts]
    tasks += [Task(scene, (file,), alone_number) for file in files] if alone else []
    groups: dict[tuple[int, str], list[dict[str, Any]]] = {}
    for row in kept(output):
        tasks = [task for task in tasks if not task.gave(row)]
        groups.setdefault((row["number"], row["kind"]), []).append(row)
    if tasks:
        ready(scene, files[0])
    with ProcessPoolExecutor(processes, multiprocessing.get_context("spawn")) as pool:
        for done in as_completed([pool.submit(fitted, task) for task in tasks]):
            try:
                row = done.result()
            except Error as error:
                print(f"left out: {error}", flush=True)
                continue
            groups.setdefault((row["number"], row["kind"]), []).append(row)
            print(line([row]), *(row["names"] if row["kind"] == "alone" else []), flush=True)
            if output is not None:
                with open(output, "a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
    print(f"\n{scene}, {len(files)} throws; bars: {BARS}; C by static optimisation of the throws, no EMG")
    for _, rows in sorted(groups.items(), key=lambda item: item[0]):
        print(line(rows))
        for text in [text for row in rows for text in missed(row)]:
            print(text)


if __name__ == "__main__":
    run_script(main)
