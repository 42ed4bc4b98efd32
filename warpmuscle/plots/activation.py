"""Muscle activations over the gait cycle beside windows of people's EMG, or over time where there is none."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.gait.cycles import PERCENT, over_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.muscle_timing import side_and_muscle
from warpmuscle.plots.names import Pair, pairs
from warpmuscle.plots.style import MAP, cycle_axis, grid, heading, legible, mean_and_spread, page, top_legend
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.scene.people.emg import SOURCE, WINDOWS

_CURVES = 15  # pairs of muscles up to which each has a panel
_ROW = 0.17  # inches
_LEAST_TOP = 0.05  # of the axis of activation
_BAR = "0.35"  # grey of the windows
_PEOPLE = "people's EMG"


def draw(subject: Subject) -> Any:
    """Panels with both sides' curves for a few muscles, a map of rows for many."""
    names = subject.recording.muscle_names
    if not names:
        raise Absent(f"{subject.source}: the motion of {subject.scene.name} has no muscles")
    rows = pairs(subject.chosen("muscle", names, subject.choices.muscles))
    title = f"{subject.title}: muscle activation"
    if not subject.walks:
        figure = _over_time(subject, rows)
        heading(figure, f"{title} over time", "activation 0 to 1")
        return figure
    figure = _panels(subject, rows) if len(rows) <= _CURVES else _map(subject, rows)
    note = subject.about_strides().replace(*_words(len(rows)))
    beside = any(_windows(subject, name) for row in rows for name in (row.left, row.right))
    heading(figure, f"{title} over the gait cycle", f"{note}; bars: {SOURCE}" if beside else note)
    return figure


def _words(rows: int) -> tuple[str, str]:
    """A map shows means only."""
    return ("", "") if rows <= _CURVES else ("mean and standard deviation", "mean")


def _cycles(subject: Subject, name: str, side: str) -> Floats:
    """Activation (S, 101) of a muscle over the gait cycles of a side."""
    index = subject.recording.muscle_names.index(name)
    values = subject.recording.muscle_activation[:, index]
    return over_strides(subject.recording.time, values, subject.strides[side])


def _panels(subject: Subject, rows: list[Pair]) -> Any:
    """A panel a pair; a muscle without its like on the other side is drawn over the gait cycle of the left leg."""
    columns = min(5, max(3, len(rows) // 3))
    figure, panels = grid(len(rows), columns, 1.45, sharex=True, sharey=True)
    shown: dict[str, Any] = {}
    greatest = _LEAST_TOP
    for axes, row in zip(panels, rows, strict=True):
        for side in SIDES if row.left != row.right else SIDES[:1]:
            curves = _cycles(subject, getattr(row, side), side)
            mean_and_spread(axes, PERCENT, curves, side if row.left != row.right else "middle")
            greatest = max(greatest, float((curves.mean(axis=0) + curves.std(axis=0)).max()))
        shown |= {side: line for line, side in zip(*axes.get_legend_handles_labels(), strict=True)}
        for begin, end in _windows(subject, row.left):
            shown["people"] = axes.axvspan(begin, end, ymax=0.05, color=_BAR, linewidth=0.0)
        cycle_axis(axes)
        axes.set(title=row.label)
    panels[0].set_ylim(0.0, min(1.05 * greatest, 1.02))
    for axes in panels[-columns:]:
        axes.set_xlabel("gait cycle (%)")
        axes.tick_params(labelbottom=True)
    figure.supylabel("activation (0 to 1)", size=9.0)
    names = {"left": "left", "right": "right", "middle": "unpaired, left cycle", "people": _PEOPLE}
    top_legend(figure, list(shown.values()), [names[side] for side in shown])
    return figure


def _map(subject: Subject, rows: list[Pair]) -> Any:
    """A row a pair: on the left the left one over its leg's gait cycle, on the right the right one over the other's."""
    figure = page(_ROW * len(rows) + 1.3)
    columns = figure.subplots(1, 2, sharey=True)
    people = None
    for axes, side in zip(columns, SIDES, strict=True):
        means = np.array([_cycles(subject, getattr(row, side), side).mean(axis=0) for row in rows])
        image = _image(axes, means, (0.0, 100.0))
        for number, row in enumerate(rows):
            for begin, end in _windows(subject, getattr(row, side)):
                people = axes.hlines(number + 0.88, begin, end, color="tab:red", linewidth=1.3)
        title = f"{side.capitalize()} muscles, cycle" if any(row.left != row.right for row in rows) else "Cycle"
        axes.set(title=f"{title} of the {side} leg", xlabel="gait cycle (%)")
        cycle_axis(axes)
    _name_rows(columns[0], [row.label for row in rows])
    columns[1].tick_params(axis="y", length=0.0)
    if people is not None:
        top_legend(figure, [people], [_PEOPLE])
    figure.colorbar(image, ax=columns, shrink=0.6, aspect=25, label="activation (0 to 1)")
    return figure


def _windows(subject: Subject, muscle: str) -> tuple[tuple[float, float], ...]:
    """When people have a muscle active in walking, % of the cycle; none for those not tabled, and of runs."""
    name = side_and_muscle(muscle)[1] if subject.norms and not subject.runs else ""
    return tuple((float(begin), float(end)) for begin, end in WINDOWS.get(name, ()))


def _over_time(subject: Subject, rows: list[Pair]) -> Any:
    """A row a muscle."""
    recording = subject.recording
    names = [name for row in rows for name in dict.fromkeys((row.left, row.right))]
    figure = page(max(_ROW * len(names), 0.8) + 1.1)
    axes = figure.subplots()
    values = recording.muscle_activation[:, [recording.muscle_names.index(name) for name in names]]
    image = _image(axes, values.T, (float(recording.time[0]), float(recording.time[-1])))
    axes.set(xlabel="time (s)")
    _name_rows(axes, names)
    figure.colorbar(image, ax=axes, shrink=0.8, aspect=25, label="activation (0 to 1)")
    return figure


def _image(axes: Any, values: Floats, span: tuple[float, float]) -> Any:
    extent = (*span, len(values), 0.0)
    further = {"aspect": "auto", "cmap": MAP, "vmin": 0.0, "vmax": 1.0, "interpolation": "nearest"}
    return axes.imshow(values, extent=extent, **further)


def _name_rows(axes: Any, names: list[str]) -> None:
    axes.set_yticks(np.arange(len(names)) + 0.5, [legible(name) for name in names], size=7.5)
    axes.tick_params(axis="y", length=0.0)
