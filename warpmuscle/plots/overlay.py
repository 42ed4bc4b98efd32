"""Several results over one another in the same panels: a colour each, what is left solid and what is right dashed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.gait.curves import gait_curves
from warpmuscle.gait.cycles import PERCENT, leg_angles, over_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.ground_force import vertical_forces
from warpmuscle.plots.angles import angle_bands
from warpmuscle.plots.convergence import generations_of
from warpmuscle.plots.names import pairs
from warpmuscle.plots.one_curve import over_time
from warpmuscle.plots.style import GRAY, PALETTE, cycle_axis, grid, heading
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.scene.norms import LEG_ANGLES

LINES = {"left": "-", "right": "--"}
COLUMNS = 5  # of panels of muscles
NOTE = "means over the gait cycles; solid: left, dashed: right"


def names_of(subjects: Sequence[Subject]) -> list[str]:
    """How a legend calls results: by their files, or else by their scenes, told apart."""
    names = [subject.path.stem if subject.path is not None else subject.scene.name for subject in subjects]
    if len(set(names)) == len(names):
        return names
    if all(subject.path is not None for subject in subjects):
        names = [str(subject.path) for subject in subjects]
    return [f"{name}, {number}" if names.count(name) > 1 else name for number, name in enumerate(names, 1)]


def angles(subjects: Sequence[Subject]) -> Any:
    """Hip, knee and ankle over the gait cycle, beside the norms that judge the first one."""
    try:
        every = [leg_angles(subject.recording, subject.scene) for subject in subjects]
    except Error as error:
        raise Absent(str(error)) from None
    figure, panels = grid(3, 3, 2.9)
    for axes, title in zip(panels, every[0], strict=True):
        if subjects[0].norms:
            angle_bands(axes, title, subjects[0].runs)
        _cycles(axes, subjects, [found[title] for found in every])
        axes.set(title=title, ylabel="angle (deg)")
    return _finished(figure, subjects, "joint angles over the gait cycle")


def ground_force(subjects: Sequence[Subject]) -> Any:
    """The vertical ground force over the gait cycle, in body weights."""
    figure, panels = grid(1, 1, 3.2)
    _cycles(panels[0], subjects, [vertical_forces(subject.recording, subject.scene) for subject in subjects])
    panels[0].set(title="Vertical ground force", ylabel="force (body weights)")
    return _finished(figure, subjects, "ground force over the gait cycle")


def activation(subjects: Sequence[Subject]) -> Any:
    """Activations over the gait cycle of the muscles that all results have, all panels of one scale."""
    first = subjects[0]
    common = [name for name in first.recording.muscle_names
              if all(name in subject.recording.muscle_names for subject in subjects)]  # fmt: skip
    if not common:
        raise Absent("these motions have no muscles in common")
    rows = pairs(first.chosen("muscle", common, first.choices.muscles))
    figure, panels = grid(len(rows), COLUMNS, 1.45, sharex=True, sharey=True)
    for axes, row in zip(panels, rows, strict=True):
        curves = []
        for subject in subjects:
            names = subject.recording.muscle_names
            sides = SIDES if row.left != row.right else SIDES[:1]
            values = subject.recording.muscle_activation
            curves.append({side: values[:, names.index(getattr(row, side))] for side in sides})
        _cycles(axes, subjects, curves)
        axes.set(title=row.label, xlabel="")
    panels[0].set_ylim(0.0)
    for axes in panels[-COLUMNS:]:
        axes.set_xlabel("gait cycle (%)")
        axes.tick_params(labelbottom=True)
    figure.supylabel("activation (0 to 1)", size=9.0)
    return _finished(figure, subjects, "muscle activation over the gait cycle")


def curve(subjects: Sequence[Subject], name: str) -> Any:
    """One curve of all results: over the gait cycle where all walk, beside people's, or over time."""
    figure, panels = grid(1, 1, 3.2)
    axes, key = panels[0], name.strip().lower()
    cyclic = [
        {title.lower(): (title, found) for title, found in gait_curves(s.recording, s.scene, s.strides).items()}
        if s.walks else {}
        for s in subjects
    ]  # fmt: skip
    if all(key in found for found in cyclic):
        title, unit = cyclic[0][key][0], cyclic[0][key][1].unit
        if subjects[0].norms and title in LEG_ANGLES:
            angle_bands(axes, title, subjects[0].runs)
        for found, color in zip(cyclic, _colors(subjects), strict=True):
            for side, rows in found[key][1].sides.items():
                axes.plot(PERCENT, rows.mean(axis=0), LINES[side], color=color, lw=1.3)
        cycle_axis(axes)
        axes.set(xlabel="gait cycle (%)", ylabel=f"{title.split()[-1]} ({unit})")
        return _finished(figure, subjects, f"{title.lower()} over the gait cycle")
    for subject, color in zip(subjects, _colors(subjects), strict=True):
        title, unit, lines = over_time(subject)[key]
        for side, values in lines.items():
            axes.plot(subject.recording.time, values, LINES.get(side, "-"), color=color, lw=1.3)
    axes.margins(x=0.0)
    axes.set(xlabel="time (s)", ylabel=unit if unit == "activation" else f"{title.split()[-1]} ({unit})")
    return _finished(figure, subjects, title, "solid: left, dashed: right" if len(lines) > 1 else "")


def convergence(subjects: Sequence[Subject]) -> Any:
    """The least cost so far of each search, over its candidates."""
    figure, panels = grid(1, 1, 3.2)
    for subject, name, color in zip(subjects, names_of(subjects), _colors(subjects), strict=True):
        found = subject.result.evaluations
        if found is None or not len(found):
            raise Absent(f"{subject.source} holds no search; `warpmuscle optimize` writes files that do")
        if subject.result.searched is not None and subject.result.searched.stages:
            raise Absent(f"{subject.source}: costs of stages cannot be compared; draw it alone")
        count, cost = np.arange(1.0, len(found) + 1.0), found.cost.astype(float)
        if subject.result.is_brief:
            count, cost = generations_of(subject.result)
        panels[0].plot(count, np.minimum.accumulate(cost), color=color, label=name, drawstyle="steps-post")
    panels[0].set(xlabel="candidates evaluated", ylabel="least cost so far (unit of the objective)")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    heading(figure, "Convergence", "costs can be compared where the objectives are the same")
    return figure


OVERLAYS: dict[str, Callable[[Sequence[Subject]], Any]] = {
    "angles": angles, "ground_force": ground_force, "activation": activation, "convergence": convergence,
}  # fmt: skip


def _colors(subjects: Sequence[Subject]) -> list[str]:
    return [PALETTE[number % len(PALETTE)] for number in range(len(subjects))]


def _cycles(axes: Any, subjects: Sequence[Subject], curves: Sequence[dict[str, Any]]) -> None:
    """Means of each result's curves (F,) by side over its gait cycles."""
    for subject, own, color in zip(subjects, curves, _colors(subjects), strict=True):
        for side, values in own.items():
            mean = over_strides(subject.recording.time, values, subject.strides[side]).mean(axis=0)
            axes.plot(PERCENT, mean, LINES[side], color=color, lw=1.3)
    axes.axhline(0.0, color=GRAY, lw=0.6, zorder=0)
    cycle_axis(axes)
    axes.set_xlabel("gait cycle (%)")


def _finished(figure: Any, subjects: Sequence[Subject], what: str, note: str = NOTE) -> Any:
    names = names_of(subjects)
    axes = figure.axes[0]
    bands = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    handles = [axes.plot([], [], color=color)[0] for color in _colors(subjects)]
    labels = [*names, *bands]
    figure.legend([*handles, *bands.values()], labels, loc="outside lower center", ncols=3)
    heading(figure, f"{', '.join(names)}: {what}", note)
    return figure
