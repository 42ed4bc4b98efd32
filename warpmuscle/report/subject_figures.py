"""Figures of a subject's recorded trials: angles, moments, activations, forces of muscles and in joints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.muscle_timing import side_and_muscle
from warpmuscle.plots.style import PALETTE, SIDE_COLORS, all_handles, cycle_axis, grid, heading, style, top_legend
from warpmuscle.report.gait_cycles import Cycle, RecordedTrial, cycles_of, over_cycle, side_of
from warpmuscle.scene.norms import FORCE, NORMS
from warpmuscle.scene.norms import SOURCE as NORM_SOURCE
from warpmuscle.scene.people.emg import SOURCE as EMG_SOURCE
from warpmuscle.scene.people.emg import WINDOWS

MOST_PANELS = 48
NORM_OF = {"hip_flexion": "Hip flexion", "knee_angle": "Knee flexion", "knee_flexion": "Knee flexion",
           "ankle_angle": "Ankle dorsiflexion", "ankle_flexion": "Ankle dorsiflexion"}  # fmt: skip


class Curve(NamedTuple):
    """A quantity of a trial over time."""

    trial: int
    side: str
    times: Floats
    values: Floats
    dashed: bool = False


class Panel(NamedTuple):
    """What one panel shows."""

    title: str
    unit: str
    curves: list[Curve]
    norm: str = ""  # of `NORMS`
    windows: tuple[tuple[float, float], ...] = ()  # of people's EMG, % of the cycle
    sign: float = 1.0


def draw_panels(title: str, panels: Sequence[Panel], trials: Sequence[RecordedTrial]) -> Any:
    """Panels over the gait cycle where all trials have one, else over time."""
    cycles = [cycles_of(trial) for trial in trials]
    walking = any(cycles)
    shown = list(panels)[:MOST_PANELS]
    with style():
        return _drawn(title, panels, shown, cycles, walking)


def _drawn(
    title: str, panels: Sequence[Panel], shown: Sequence[Panel], cycles: Sequence[Sequence[Cycle]], walking: bool
) -> Any:
    """The figure of `draw_panels`."""
    figure, axes = grid(len(shown), 4, 1.55, sharex=walking)
    for one, panel in zip(axes, shown, strict=True):
        if walking:
            _over_cycle(one, panel, cycles)
        else:
            _over_time(one, panel)
        one.set_title(f"{panel.title}, {panel.unit}" if panel.unit not in ("", "1") else panel.title, size=8.0)
    note = f"over the gait cycle, % from the contact of the own foot; {_strides(cycles)}" if walking else "over time, s"
    if walking and any(panel.norm for panel in shown):
        note += f"; band: {NORM_SOURCE}"
    if walking and any(panel.windows for panel in shown):
        note += f"; bars: {EMG_SOURCE}"
    if any(curve.dashed for panel in shown for curve in panel.curves):
        note += "; dashed: measured EMG"
    if len(panels) > len(shown):
        note += f"; {len(panels) - len(shown)} more are not shown"
    heading(figure, title, note)
    _legend(figure, axes)
    return figure


def _legend(figure: Any, axes: Sequence[Any]) -> None:
    shown = all_handles(axes)
    if shown:
        top_legend(figure, list(shown.values()), list(shown))


def _strides(cycles: Sequence[Sequence[Cycle]]) -> str:
    counts = {side: sum(one.side == side for own in cycles for one in own) for side in ("left", "right")}
    return " and ".join(f"{count} {side}" for side, count in counts.items() if count)


def _over_cycle(axes: Any, panel: Panel, cycles: Sequence[Sequence[Cycle]]) -> None:
    if panel.norm:
        norm = NORMS[panel.norm]
        mean, deviation = norm.mean(PERCENT), norm.sd(PERCENT)
        axes.fill_between(PERCENT, mean - deviation, mean + deviation, color="#DDDDDD", lw=0.0, label="people")
    for curve in panel.curves:
        for cycle in cycles[curve.trial]:
            if curve.side and cycle.side != curve.side:
                continue
            values = over_cycle(curve.times, curve.values, cycle)
            if values is not None:
                side = curve.side or "middle"
                axes.plot(PERCENT, panel.sign * values, color=SIDE_COLORS[side], lw=0.9,
                          ls="--" if curve.dashed else "-", label=side)  # fmt: skip
                if not curve.side:
                    break  # which of the feet it begins with does not matter for the trunk
    for begin, end in panel.windows:
        axes.axvspan(begin, end, ymax=0.05, color="0.35", lw=0.0)
    cycle_axis(axes)


def _over_time(axes: Any, panel: Panel) -> None:
    for curve in panel.curves:
        color = SIDE_COLORS[curve.side] if curve.side else PALETTE[curve.trial % len(PALETTE)]
        label = curve.side or f"trial {curve.trial + 1}"
        axes.plot(curve.times, panel.sign * curve.values, color=color, lw=1.0, ls="--" if curve.dashed else "-",
                  label=label)  # fmt: skip


def angle_panels(trials: Sequence[RecordedTrial]) -> list[Panel]:
    """Coordinates in degrees and metres; hip, knee and ankle beside norms, with flexion upwards."""

    def curve(k: int, trial: RecordedTrial, name: str) -> Curve | None:
        motion = trial.found.coordinates
        if name not in motion.names:
            return None
        return Curve(k, side_of(name), motion.times, motion.of(name))

    found = []
    for panel in _by_name(trials, [trial.found.coordinates.names for trial in trials], curve):
        stem = panel.title.lower()
        angle = not stem.endswith(("_tx", "_ty", "_tz"))
        factor = 180.0 / np.pi if angle else 1.0
        curves = [one._replace(values=factor * one.values) for one in panel.curves]
        knee = stem.startswith("knee")
        bends = -1.0 if knee and np.mean([one.values.mean() for one in curves]) < 0.0 else 1.0
        found.append(panel._replace(unit="degrees" if angle else "m", curves=curves, norm=NORM_OF.get(stem, ""),
                                    sign=bends))  # fmt: skip
    return found


def force_panels(trials: Sequence[RecordedTrial], weight: float) -> list[Panel]:
    """Vertical ground force, in body weights."""
    curves = []
    for k, trial in enumerate(trials):
        for side in ("left", "right"):
            own = [n for n, other in enumerate(trial.sides) if other == side]
            if own:
                curves.append(Curve(k, side, trial.times, trial.loads.force[:, own, 1].sum(axis=1) / weight))
    return [Panel("ground force", "body weights", curves, FORCE)] if curves else []


def moment_panels(trials: Sequence[RecordedTrial], mass: float) -> list[Panel]:
    """Moments of joints over the body's mass, as coordinates are positive."""

    def curve(k: int, trial: RecordedTrial, name: str) -> Curve | None:
        one = trial.found.moments
        if one is None or name not in one.names[one.residuals :]:
            return None
        return Curve(k, side_of(name), one.times, one.of(name) / mass)

    names = [trial.found.moments.names if trial.found.moments is not None else () for trial in trials]
    return [panel._replace(unit="N m/kg") for panel in _by_name(trials, names, curve)]


def activation_panels(trials: Sequence[RecordedTrial], tracked: bool = False) -> list[Panel]:
    """Activations beside windows of people's EMG, and envelopes that were measured."""

    def curve(k: int, trial: RecordedTrial, name: str) -> Curve | None:
        if tracked:
            one = trial.found.tracked
            return (
                None if one is None else Curve(k, side_of(name), one.times, one.activation[:, one.muscles.index(name)])
            )
        acts = trial.found.activations
        return (
            None if acts is None else Curve(k, side_of(name), acts.times, acts.activation[:, acts.muscles.index(name)])
        )

    names = [_muscles(trial, tracked) for trial in trials]
    found = []
    for panel in _by_name(trials, names, curve):
        curves = list(panel.curves)
        for k, trial in enumerate(trials):
            for name, (times, values) in trial.emg.items():
                if _stem(name) == panel.title:
                    curves.append(Curve(k, side_of(name), times, values, dashed=True))
        windows = WINDOWS.get(side_and_muscle(f"{panel.title}_r")[1], ())
        found.append(panel._replace(curves=curves, windows=windows))
    return found


def muscle_force_panels(trials: Sequence[RecordedTrial]) -> list[Panel]:
    """Forces of muscles by static optimisation, N."""

    def curve(k: int, trial: RecordedTrial, name: str) -> Curve | None:
        acts = trial.found.activations
        return None if acts is None else Curve(k, side_of(name), acts.times, acts.force[:, acts.muscles.index(name)])

    return [panel._replace(unit="N") for panel in _by_name(trials, [_muscles(one, False) for one in trials], curve)]


def joint_panels(trials: Sequence[RecordedTrial], weight: float) -> list[Panel]:
    """Magnitudes of forces in joints, in body weights."""

    def curve(k: int, trial: RecordedTrial, name: str) -> Curve | None:
        one = trial.found.reactions
        if one is None or name not in one.joints:
            return None
        return Curve(k, side_of(name), one.times, np.linalg.norm(one.force[:, one.joints.index(name)], axis=1) / weight)

    names = [trial.found.reactions.joints if trial.found.reactions is not None else () for trial in trials]
    return [panel._replace(unit="body weights") for panel in _by_name(trials, names, curve)]


def _muscles(trial: RecordedTrial, tracked: bool) -> tuple[str, ...]:
    one = trial.found.tracked if tracked else trial.found.activations
    return () if one is None else one.muscles


def _stem(name: str) -> str:
    """A name without its side."""
    for ending in ("_r", "_l"):
        if name.endswith(ending):
            return name[: -len(ending)]
    return name


def _by_name(
    trials: Sequence[RecordedTrial],
    names: Sequence[Sequence[str]],
    curve: Callable[[int, RecordedTrial, str], Curve | None],
) -> list[Panel]:
    """A panel for each name without its side, with the curves of all trials."""
    stems: dict[str, list[Curve]] = {}
    for k, (trial, own) in enumerate(zip(trials, names, strict=True)):
        for name in own:
            one = curve(k, trial, name)
            if one is not None:
                stems.setdefault(_stem(name), []).append(one)
    return [Panel(stem, "1", curves) for stem, curves in stems.items()]
