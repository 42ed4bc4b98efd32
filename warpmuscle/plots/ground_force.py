"""Ground forces over the gait cycle, in body weights."""

from __future__ import annotations

from typing import Any

from warpmuscle.gait.cycles import PERCENT, body_weight, over_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.plots.angles import legend_below, norm_band
from warpmuscle.plots.style import GRAY, cycle_axis, grid, heading, mean_and_spread
from warpmuscle.plots.subject import Subject

_PARTS = (("Vertical ground force", 1), ("Ground force forwards", 2), ("Ground force towards the middle", 0))


def draw(subject: Subject) -> Any:
    """The three parts of the ground force on each foot from contact to contact, and the norm of the vertical."""
    cycles, recording = subject.strides, subject.recording
    weight = body_weight(subject.scene)
    figure, panels = grid(3, 3, 2.9)
    for axes, (name, axis) in zip(panels, _PARTS, strict=True):
        if axis == 1 and subject.norms and not subject.runs:
            norm_band(axes, name)
        for side in SIDES:
            force = recording[f"foot_force_{side}"][:, axis] / weight
            if axis == 0 and side == "left":
                force = -force  # x points to the left
            mean_and_spread(axes, PERCENT, over_strides(recording.time, force, cycles[side]), side)
        axes.axhline(0.0, color=GRAY, lw=0.6, zorder=0)
        cycle_axis(axes)
        axes.set(title=name, xlabel="gait cycle (%)", ylabel="force (body weights)")
    legend_below(figure, panels[0])
    note = f"{subject.about_strides()}; a body weight is {weight:.0f} N"
    heading(figure, f"{subject.scene.name}: ground force over the gait cycle", note)
    return figure
