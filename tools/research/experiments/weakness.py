"""What becomes of a gait when groups of muscles weaken: the figure and the tables of a sweep.

For docs/explanation/gaits.md.

warpmuscle sweep tools/research/sweeps/weakness.toml
python tools/research/experiments/weakness.py weakness.h5 [--folder FOLDER]

Every axis of the sweep is a group of muscles, its values the parts of f_max that are left; the run in which all are 1
is the normal gait, with which the others are compared.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import h5py

try:
    import matplotlib as mpl
except ModuleNotFoundError:
    raise SystemExit("experiments draw figures by matplotlib: pip install 'warpmuscle[plot]'") from None
import numpy as np
import typer
import warp as wp

from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.gait.cycles import PERCENT, leg_angles, over_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.ground_force import vertical_forces
from warpmuscle.gait.quality import Measures, gait_measures
from warpmuscle.plots import Subject
from warpmuscle.plots.angles import norm_band
from warpmuscle.plots.names import pairs
from warpmuscle.plots.style import GRAY, cycle_axis, heading, label_ends, page, save, style
from warpmuscle.results.result import SWEEP_FORMAT, read
from warpmuscle.scene.accounting import accounting
from warpmuscle.scene.norms import FORCE, LEG_ANGLES

SHOWN = ("speed", "step length", "cost of transport")  # beside the normal ones
TABLE = {  # measures by their head in the table, and their decimals
    "speed": ("speed, m/s", 2), "step length": ("step, m", 2), "cadence": ("steps/min", 0),
    "cost of transport": ("cost, J/(kg m)", 1), "deviation of the three angles": ("half-widths off", 2),
    "hip, maximum": ("hip greatest, deg", 0), "knee, maximum in stance": ("knee in stance", 0),
    "knee, maximum in swing": ("knee in swing", 0), "ankle, minimum at push-off": ("ankle at push-off", 0),
    "step width": ("width, m", 2),
}  # fmt: skip
LEAST = (90.0, 110.0)  # %, that the axis of relative numbers has at least
GAINS = 5  # muscles whose activations are drawn: those that change most
WHOLE = 1e-3  # s: a motion that ends earlier before its time has fallen


@dataclass
class Run:
    """The best gait of a run of the sweep."""

    subject: Subject
    level: float  # part of f_max that is left
    seconds: float  # that it walked
    fell: bool
    measures: Measures = field(default_factory=dict)  # none of what falls or is no gait

    @property
    def walks(self) -> bool:
        """Whether it has gait cycles."""
        return bool(self.measures)

    @cached_property
    def curves(self) -> dict[str, Floats]:
        """Means (101,) of both legs over the gait cycle."""
        recording, scene, cycles = self.subject.recording, self.subject.scene, self.subject.strides
        sides = {**leg_angles(recording, scene), FORCE: vertical_forces(recording, scene)}
        return {
            name: np.mean([over_strides(recording.time, of[s], cycles[s]).mean(axis=0) for s in SIDES], axis=0)
            for name, of in sides.items()
        }

    @cached_property
    def activations(self) -> dict[str, float]:
        """Mean activation of each pair of muscles over whole gait cycles."""
        recording = self.subject.recording
        begin = min(cycles[0][0] for cycles in self.subject.strides.values())
        end = max(cycles[-1][1] for cycles in self.subject.strides.values())
        part = recording.window(begin, end)
        mean = dict(zip(part.muscle_names, part.muscle_activation.mean(axis=0), strict=True))
        return {pair.label: float(mean[pair.left] + mean[pair.right]) / 2.0 for pair in pairs(part.muscle_names)}


def runs_of(path: Path) -> dict[str, list[Run]]:
    """The runs of each group, from strong to weak, the normal one first.

    Raises:
        Error: no file of a sweep, no normal run in it, or one that does not walk.
    """
    try:
        with h5py.File(path) as file:
            if file.attrs.get("format") != SWEEP_FORMAT:
                raise Error(f"{path}: not the file of a sweep")
            names = file["table/run"].asstr()[()].tolist()
            axes = {axis: np.asarray(values) for axis, values in file["table/axes"].items() if values.dtype.kind == "f"}
    except OSError:
        raise Error(f"{path}: there is no such HDF5 file") from None
    groups = {axis: values for axis, values in axes.items() if np.any(values == 1.0) and np.any(values < 1.0)}
    normal = (
        np.all([values == 1.0 for values in groups.values()], axis=0) if groups else np.zeros(len(names), dtype=bool)
    )
    if not np.any(normal):
        raise Error(f"{path}: no run has all its muscles: each group is an axis of factors, 1 among them")
    first = _run(path, names[int(np.argmax(normal))], 1.0)
    if not first.walks:
        raise Error(f"{path}: the gait with all muscles is none, so that nothing can be compared with it")
    found = {}
    for group, values in groups.items():
        rows = [row for row in np.argsort(-values, kind="stable") if values[row] < 1.0]
        found[group] = [first, *(_run(path, names[row], float(values[row])) for row in rows)]
    return found


def _run(path: Path, name: str, level: float) -> Run:
    subject = Subject(read(path, name), path=path, run=name)
    seconds = float(subject.recording.time[-1])
    interval = seconds / max(subject.recording.frames - 1, 1)
    fell = seconds < subject.scene.duration - 1.5 * interval - WHOLE
    try:
        return Run(subject, level, seconds, fell, {} if fell else gait_measures(subject.recording, subject.scene))
    except Error:  # it stands or stumbles
        return Run(subject, level, seconds, fell)


def compensating(runs: list[Run]) -> list[str]:
    """Pairs of muscles whose activation changes most between the normal and any weaker gait."""
    normal = runs[0].activations
    change = {
        name: max((abs(run.activations[name] - value) for run in runs[1:] if run.walks), default=0.0)
        for name, value in normal.items()
    }
    return sorted(change, key=lambda name: -change[name])[:GAINS]


def table(groups: dict[str, list[Run]]) -> list[str]:
    """Lines of a table in Markdown: every gait, and in brackets what has changed from the normal one."""
    heads = ["muscles", "f_max, %", "upright, s", *(head for head, _ in TABLE.values()), "activations that change most"]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for group, runs in groups.items():
        for run in runs:
            end = f"falls at {run.seconds:.1f}" if run.fell else f"{run.seconds:.0f}"
            cells = [group.replace("_", " "), f"{100.0 * run.level:.0f}", end]
            cells += [_change(run, runs[0], name, decimals) for name, (_, decimals) in TABLE.items()]
            lines.append(f"| {' | '.join([*cells, _gains(run, runs[0])])} |")
    return lines


def _change(run: Run, normal: Run, name: str, decimals: int) -> str:
    value, before = run.measures.get(name), normal.measures.get(name)
    if value is None:
        return ""
    text = f"{value:.{decimals}f}"
    return text if run is normal or before is None else f"{text} ({value - before:+.{decimals}f})"


def _gains(run: Run, normal: Run) -> str:
    """Mean activations that differ most from the normal ones, as words."""
    if run is normal or not run.walks:
        return ""
    change = {name: value - normal.activations[name] for name, value in run.activations.items()}
    most = sorted(change, key=lambda name: -abs(change[name]))[:3]
    return ", ".join(f"{name} {change[name]:+.3f}" for name in most)


def figure_of(groups: dict[str, list[Run]], title: str, counted: str) -> Any:
    """A row a group: curves over the gait cycle by strength; speed, step and cost, and activations over strength.

    Args:
        counted: how the cost of the normal gait is counted.
    """
    figure = page(2.35 * len(groups) + 0.9, 15.0)
    rows = figure.subplots(len(groups), 6, squeeze=False, width_ratios=(1, 1, 1, 1, 1, 1.15))
    for row, (group, runs) in zip(rows, groups.items(), strict=True):
        colors = mpl.colormaps["plasma"](np.linspace(0.0, 0.85, len(runs)))
        for axes, name in zip(row, (*LEG_ANGLES, FORCE), strict=False):
            norm_band(axes, name)
            for run, color in zip(runs, colors, strict=True):
                if run.walks:
                    axes.plot(PERCENT, run.curves[name], color=color, lw=1.5, label=f"{100.0 * run.level:.0f} %")
            axes.axhline(0.0, color=GRAY, lw=0.6, zorder=0)
            cycle_axis(axes)
            axes.set_title(name)
        row[0].set_ylabel(f"{group.replace('_', ' ')}\nangle (deg)")
        row[3].set(ylabel="force (body weights)", ylim=(0.0, 2.0))
        _numbers(row[4], runs)
        _activations(row[5], runs)
    for axes in rows[-1, :4]:
        axes.set_xlabel("gait cycle (%)")
    handles, labels = rows[0, 0].get_legend_handles_labels()
    words = [label if label.startswith("norm") else f"{label} of f_max" for label in labels]
    order = sorted(range(len(words)), key=lambda k: words[k].startswith("norm"))
    chosen = [handles[k] for k in order], [words[k] for k in order]
    figure.legend(*chosen, loc="outside lower center", ncols=len(words))
    note = "each re-optimised; curves are means of both legs; 100 % is the same gait in all rows"
    heading(figure, title, f"{note}; cost of transport: {counted}")
    return figure


def _numbers(axes: Any, runs: list[Run]) -> None:
    """Speed, step length and cost of transport over the strength, relative to the normal gait."""
    ends = []
    there = [run for run in runs if run.walks]
    for name in SHOWN:
        normal = runs[0].measures.get(name)
        points = [(run.level, run.measures[name]) for run in there if run.measures.get(name) is not None]
        if not normal or not points:
            continue
        x, y = np.array(points).T
        (line,) = axes.plot(100.0 * x, 100.0 * y / normal, "o-", ms=3.5)
        ends.append((float(100.0 * y[-1] / normal), name, line.get_color()))
    axes.axhline(100.0, color=GRAY, lw=0.6, zorder=0)
    _strength_axis(axes, runs)
    low, high = axes.get_ylim()
    axes.set(title="Relative to normal", ylabel="part of normal (%)", ylim=(min(low, LEAST[0]), max(high, LEAST[1])))
    for run in runs:
        if run.fell:
            axes.text(100.0 * run.level, 100.0, "falls", color=GRAY, size=7.5, ha="center", va="bottom")
    label_ends(axes, ends)


def _activations(axes: Any, runs: list[Run]) -> None:
    """Mean activations, over the strength, of the muscles that change most."""
    ends = []
    there = [run for run in runs if run.walks]
    for name in compensating(runs):
        (line,) = axes.plot(
            [100.0 * run.level for run in there], [run.activations[name] for run in there], "o-", ms=3.5
        )
        ends.append((there[-1].activations[name], name, line.get_color()))
    axes.set_ylim(bottom=0.0)
    _strength_axis(axes, runs)
    axes.set(title="Mean activation", ylabel="activation (0 to 1)")
    label_ends(axes, ends)


def _strength_axis(axes: Any, runs: list[Run]) -> None:
    levels = [100.0 * run.level for run in runs]
    axes.set(xlim=(max(levels) + 3.0, min(levels) - 3.0), xticks=levels, xlabel="f_max (%)")


def main(
    file: Annotated[Path, typer.Argument(help="HDF5 file of the sweep.")],
    folder: Annotated[Path, typer.Option(help="Where the figure goes.")] = Path(),
) -> None:
    """Draw the figure of a sweep of weaknesses, and print its table."""
    wp.config.log_level = wp.LOG_WARNING
    groups = runs_of(file)
    first = next(iter(groups.values()))[0].subject
    counted = accounting(first.scene, first.recording.muscle_names)
    with style():
        figure = figure_of(groups, f"{first.scene.name}: gaits of weakened muscles", counted)
    folder.mkdir(parents=True, exist_ok=True)
    save(figure, folder / "weakness.png")
    typer.echo("\n".join(table(groups)))
    typer.echo(f"\nCost of transport of the normal gait: {counted}; weaker muscles are lighter.")
    typer.echo(f"\nwrote {folder / 'weakness.png'}")


if __name__ == "__main__":
    run_script(main)
