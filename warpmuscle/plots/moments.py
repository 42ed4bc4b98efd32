"""Moments and powers of hip, knee and ankle over the gait cycle, and turns of pelvis and trunk, beside people's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from warpmuscle.gait.curves import FORWARDS, PRESSURE, Curves, gait_curves
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.joint_moments import JOINTS
from warpmuscle.plots.angles import legend_below
from warpmuscle.plots.style import BAND_COLOR, cycle_curves, grid, heading
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.scene.people.pinzone import SOURCE

_MOMENTS = [f"{joint} {what}" for what in ("moment", "power") for joint in JOINTS]
_BODY = [f"{segment} {turn}" for segment in ("Pelvis", "Trunk") for turn in ("tilt", "obliquity", "rotation")]


def draw(subject: Subject) -> Any:
    """Moments and powers of both legs in the sagittal plane from contact to contact, people's as a band."""
    curves = gait_curves(subject.recording, subject.scene, subject.strides)
    if _MOMENTS[0] not in curves:
        raise Absent(f"{subject.source}: {subject.scene.name} has no hip, knee and ankle")
    return _drawn(subject, curves, _MOMENTS, "joint moments and powers")


def draw_body(subject: Subject) -> Any:
    """Turns of pelvis and trunk, fore-aft force and centre of pressure from contact to contact."""
    curves = gait_curves(subject.recording, subject.scene, subject.strides)
    names = [name for name in (*_BODY, FORWARDS, PRESSURE) if name in curves]
    return _drawn(subject, curves, names, "pelvis, trunk and ground")


def _drawn(subject: Subject, curves: dict[str, Curves], names: Sequence[str], title: str) -> Any:
    """A panel for each curve."""
    figure, panels = grid(len(names), 3, 2.3)
    for axes, name in zip(panels, names, strict=True):
        curve = curves[name]
        if curve.people is not None and subject.norms and not subject.runs:
            mean, deviation = curve.people
            label = f"norm ({SOURCE}, mean and SD)"
            axes.fill_between(PERCENT, mean - deviation, mean + deviation, color=BAND_COLOR, lw=0.0, label=label)
        cycle_curves(axes, curve.sides)
        axes.set(title=name, xlabel="gait cycle (%)", ylabel=f"{name.split()[-1]} ({curve.unit})")
    legend_below(figure, panels[0])
    heading(figure, f"{subject.scene.name}: {title} over the gait cycle", subject.about_strides())
    return figure
