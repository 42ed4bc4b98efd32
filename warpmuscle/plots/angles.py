"""Joint angles of the legs over the gait cycle, beside norms."""

from __future__ import annotations

from typing import Any

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.gait.cycles import PERCENT, leg_angles, over_strides
from warpmuscle.gait.likeness import norms_of
from warpmuscle.plots.style import BAND_COLOR, GRAY, cycle_axis, grid, heading, mean_and_spread
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.scene.norms import NORMS, SOURCE, Norm


def draw(subject: Subject) -> Any:
    """Hip, knee and ankle of both legs from contact to contact, and norms of walking, or of running, as bands."""
    cycles, time = subject.strides, subject.recording.time
    try:
        angles = leg_angles(subject.recording, subject.scene)
    except Error as error:
        raise Absent(f"{subject.source}: {error}") from None
    figure, panels = grid(3, 3, 2.9)
    for axes, (name, sides) in zip(panels, angles.items(), strict=True):
        if subject.norms:
            angle_bands(axes, name, subject.runs)
        for side, angle in sides.items():
            mean_and_spread(axes, PERCENT, over_strides(time, angle, cycles[side]), side)
        axes.axhline(0.0, color=GRAY, lw=0.6, zorder=0)
        cycle_axis(axes)
        axes.set(title=name, xlabel="gait cycle (%)", ylabel="angle (deg)")
    legend_below(figure, panels[0])
    heading(figure, f"{subject.scene.name}: joint angles over the gait cycle", subject.about_strides())
    return figure


def angle_bands(axes: Any, name: str, running: bool) -> None:
    """The norms of an angle that judge a walk, or a run: those of key points as a band, measured ones hatched."""
    for norm in norms_of(running):
        band = norm.angles[name]
        if isinstance(band, Norm):
            norm_band(axes, name)
            continue
        mean, sd = band.mean(PERCENT), band.sd(PERCENT)
        label = f"norm ({norm.source}, {norm.what})"
        axes.fill_between(PERCENT, mean - sd, mean + sd, facecolor="none", edgecolor="#B8B8B8", hatch="////", lw=0.5,
                          label=label)  # fmt: skip


def norm_band(axes: Any, name: str) -> None:
    """The key points of a quantity as a band, the points that it is made of as dots."""
    norm = NORMS[name]
    mean: Floats = norm.mean(PERCENT)
    label = f"norm (dots: extremes of the {SOURCE})"
    low, high = mean - norm.half_width, mean + norm.half_width
    there = norm.periodic | (mean > 0.0)
    axes.fill_between(PERCENT, low, high, where=there, color=BAND_COLOR, lw=0.0, label=label)
    axes.plot(*zip(*norm.points, strict=True), "o", color="#A0A0A0", ms=2.5)


def legend_below(figure: Any, axes: Any) -> None:
    """One legend for all panels, left and right first."""
    handles, labels = axes.get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda k: labels[k].startswith("norm"))
    entries = ([handles[k] for k in order], [labels[k] for k in order])
    figure.legend(*entries, loc="outside lower center", ncols=len(labels))
