"""What searches of a scene find in a given wall time, by strategy and seed, as a table of medians and quartiles.

    python tools/bench_search.py walk56_person_search --until 40 --sigma 0.1 --seeds 10
    python tools/bench_search.py fwalk --until 20 --seeds 3 --device cpu --options "cma; cma --searches 4"

Options are those of `warpmuscle optimize` as far as they matter here, separated by semicolons: a strategy (empty for
the usual one), `--population N`, `--searches N`, `--sigma S`, `--restarts KIND`. The kernel is compiled before anything
is timed. Time counts from the first batch. The curves of all searches are in the JSON file. `its lanes`: of the time of
each generation, as long as its longest candidate, the part that a candidate is simulated.
"""

from __future__ import annotations

import json
import shlex
import tempfile
import time
import warnings
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
import typer
import warp as wp

from warpmuscle.cli.ending import run_script
from warpmuscle.formats import load
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.progress import Progress
from warpmuscle.results.records import Evaluations
from warpmuscle.scene import Scene

PARTS = (0.1, 0.5, 1.0)  # of the time, at which the best cost is told
USUAL = "; cma; cma --population 64; cma --population 320; cma --searches 16; cma --searches 8 --population 64"


def options_of(text: str) -> dict[str, Any]:
    """Arguments of `optimize` from one of the options."""
    words, found = shlex.split(text), {}
    if words and not words[0].startswith("--"):
        found["search"] = words.pop(0)
    for name, value in zip(words[::2], words[1::2], strict=True):
        number = float(value) if name == "--sigma" else value
        found[name.removeprefix("--")] = int(value) if value.isdigit() else number
    return found


class Curve:
    """The best cost over the wall time of a search."""

    def __init__(self) -> None:
        self.time: list[float] = []
        self.best: list[float] = []
        self.computed = 0.0
        self._begin: float | None = None

    def __call__(self, progress: Progress) -> None:
        """Take what a search tells of itself."""
        now = time.monotonic()
        self._begin = now if self._begin is None or progress.compiling else self._begin
        self.computed = progress.computed
        if np.isfinite(progress.best) and (not self.best or progress.best < self.best[-1]):
            self.time.append(now - self._begin)
            self.best.append(progress.best)

    def at(self, seconds: float) -> float:
        """The best cost after so many seconds, infinite before there is one."""
        known = [cost for moment, cost in zip(self.time, self.best, strict=True) if moment <= seconds]
        return known[-1] if known else np.inf

    def until(self, cost: float) -> float:
        """Seconds until a cost was reached, infinite if it was not."""
        return next((t for t, best in zip(self.time, self.best, strict=True) if best <= cost), np.inf)


def measured(scene: Scene, until: float, seed: int, device: str | None, options: dict[str, Any]) -> dict[str, Any]:
    """One search: its curve, how much it evaluated, and the strategy that it came to use."""
    curve = Curve()
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "search.h5"
        result = optimize(scene, None, seed, device, until=until, progress=curve, output=output, **options)
    assert result.evaluations is not None
    assert result.searched is not None
    assert result.best is not None
    motion = float(result.evaluations.end_time.sum()) * scene.robustness.runs
    chosen = result.searched.options
    return {
        "seed": seed, "strategy": chosen.strategy, "population": chosen.population, "device": result.device,
        "candidates": len(result.evaluations.cost), "motion_per_second": motion / until, "computed": curve.computed,
        "occupied": occupied(result.evaluations),
        "best": [*(curve.at(part * until) for part in PARTS[:-1]), result.best.cost],
        "time": curve.time, "cost": curve.best,
    }  # fmt: skip


def occupied(evaluations: Evaluations) -> float:
    """Of the time of generations, each as long as its longest candidate, the part that a candidate is simulated."""
    number = evaluations.generation.astype(int)
    longest, count = np.zeros(number.max() + 1), np.bincount(number)
    np.maximum.at(longest, number, evaluations.end_time)
    return float(evaluations.end_time.sum() / (longest * count).sum())


def quartiles(values: list[float]) -> str:
    """Median, and both quartiles where there are several values."""
    if not np.isfinite(values).all():
        return "-"
    low, middle, high = np.percentile(values, [25, 50, 75])
    return f"{middle:.4g}" if len(values) == 1 else f"{middle:.4g} ({low:.4g} to {high:.4g})"


def row(title: str, runs: list[dict[str, Any]]) -> str:
    """A line of the table."""
    number = [f"{np.median([run[name] for run in runs]):.0f}" for name in ("candidates", "motion_per_second")]
    busy = f"{100.0 * float(np.median([run['computed'] for run in runs])):.0f} %"
    lanes = f"{100.0 * float(np.median([run['occupied'] for run in runs])):.0f} %"
    costs = [quartiles([run["best"][k] for run in runs]) for k in range(len(PARTS))]
    first = runs[0]
    chosen = "" if title else f": {first['strategy']}, population {first['population']}"
    return f"| {title or 'none'}{chosen} | {' | '.join([*number, busy, lanes, *costs])} |"


def main(
    scene: str,
    until: Annotated[float, typer.Option(help="Wall time of each search, s.")] = 40.0,
    sigma: Annotated[float | None, typer.Option(help="First step, as a part of each parameter's interval.")] = None,
    seeds: Annotated[int, typer.Option(help="Searches of each kind, with seeds 1, 2, ...")] = 10,
    first: Annotated[int, typer.Option(help="The first seed.")] = 1,
    options: Annotated[str, typer.Option(help="Kinds of searches, separated by semicolons.")] = USUAL,
    device: Annotated[str | None, typer.Option(help="cpu, cuda:0, ...")] = None,
    json_path: Annotated[Path | None, typer.Option("--json", help="File for figures and curves.")] = None,
) -> None:
    """Measure searches of a scene and print a table."""
    wp.config.log_level = wp.LOG_WARNING
    warnings.simplefilter("ignore")
    given = load(scene)
    kinds = [text.strip() for text in options.split(";")]
    figures: dict[str, list[dict[str, Any]]] = {}
    print(f"{scene}, {until:g} s each, {seeds} seeds, sigma {sigma or 'as usual'}")
    print("| options | candidates | s of motion a s | device at work | its lanes | best after a tenth | half | all |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    short = msgspec.structs.replace(given, duration=max(0.1, 4.0 * given.time_step))
    for text in kinds:
        asked = ({} if sigma is None else {"sigma": sigma}) | options_of(text)
        optimize(short, None, 1, device, until=0.5, **asked)  # compiles
        runs = figures[text] = []
        for seed in range(first, first + seeds):
            runs.append(measured(given, until, seed, device, asked))
            if json_path is not None:  # after each, so that what has been measured outlasts an interruption
                json_path.write_text(json.dumps(figures) + "\n")
        print(row(text, runs), flush=True)


if __name__ == "__main__":
    run_script(main)
