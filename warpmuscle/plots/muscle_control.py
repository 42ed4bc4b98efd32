"""What a joint's controller asks for, and what its muscles make of it (Bergmann 2017, figs 14-15)."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.plain_text import number_of
from warpmuscle.plots.joints import RECORDED_COLOR, angle_label, joint_curves, recorded_curves
from warpmuscle.plots.style import GRAY, PALETTE, grid, heading
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.results.recording import Recording
from warpmuscle.scene.anatomy import leg

_MOST = 12  # muscles
_AXIS_COLORS = (PALETTE[0], PALETTE[1], PALETTE[2])


def draw(subject: Subject) -> Any:
    """Angles and torques of one joint, and of each of its muscles desired force, excitation and activation.

    Without a choice the joint is the lowest of the left leg that muscles act on, and the time the last stride.
    """
    crossed = _crossed(subject)
    joint = _joint(subject, crossed)
    muscles = subject.chosen("muscle", crossed[joint], subject.choices.muscles)[:_MOST]
    recording = _shown(subject)
    figure, panels = grid(2 + len(muscles), 3 if len(muscles) > 2 else 2, 1.75, sharex=True)
    if (recorded := subject.recorded(recording)) is not None:
        recorded_curves(panels[0], recorded, subject.scene, joint)
        panels[0].plot([], [], color=RECORDED_COLOR, lw=4.0, label="recorded")
    for (name, angle), color in zip(joint_curves(recording, subject.scene, joint), _AXIS_COLORS, strict=False):
        panels[0].plot(recording.time, angle, color=color, label=name)
    panels[0].set(title=joint, ylabel=angle_label(subject.scene, joint))
    _torques(panels[1], recording, joint)
    wanted = bool(np.any(recording.joint_torque_desired))
    for axes, name in zip(panels[2:], muscles, strict=True):
        k = recording.muscle_names.index(name)
        f_max = float(np.asarray(subject.scene.character.muscles[name].f_max))
        desired = np.clip(recording.muscle_desired_force[:, k] / f_max, 0.0, 1.0)
        if wanted:
            axes.plot(recording.time, desired, ":", color=PALETTE[6], label="desired force / f_max")
        axes.plot(recording.time, recording.muscle_excitation[:, k], color=PALETTE[1], label="excitation")
        axes.plot(recording.time, recording.muscle_activation[:, k], color=PALETTE[0], label="activation")
        axes.set(title=name, ylabel="part of the maximum")
    _share_scale(panels[2:])
    for axes in panels[-3 if len(muscles) > 2 else -2 :]:
        axes.set_xlabel("time (s)")
        axes.tick_params(labelbottom=True)
    for axes in panels[:2]:
        axes.axhline(0.0, color=GRAY, lw=0.6, zorder=0)
        axes.legend(fontsize=7.0, handlelength=1.0, labelspacing=0.2)
    if muscles:
        figure.legend(*panels[2].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    heading(
        figure,
        f"{subject.title}: {joint}, {'from the desired torque' if wanted else 'from excitation'} to activation",
        _note(recording, muscles),
    )
    return figure


def _share_scale(panels: list[Any]) -> None:
    """Give all panels of muscles the same scale, from 0, so that they can be compared."""
    limits = [axes.get_ylim() for axes in panels]
    for axes in panels:
        axes.set_ylim(min(0.0, *(low for low, _ in limits)), max(high for _, high in limits))


def _note(recording: Recording, muscles: list[str]) -> str:
    return f"{recording.time[0]:.2f} to {recording.time[-1]:.2f} s; {number_of(len(muscles), 'muscle')} on the joint"


def _torques(axes: Any, recording: Recording, joint: str) -> None:
    """Wanted torque as lines, the torque that acts as thin ones; alone where no controller wants any."""
    k = recording.joint_names.index(joint)
    wanted = bool(np.any(recording.joint_torque_desired))
    for axis, color in zip(range(3), _AXIS_COLORS, strict=True):
        desired, applied = recording.joint_torque_desired[:, k, axis], recording.joint_torque[:, k, axis]
        if wanted:
            axes.plot(recording.time, desired, color=color, label=f"{'xyz'[axis]} desired")
            axes.plot(recording.time, applied, "--", color=color, lw=0.8)
        else:
            axes.plot(recording.time, applied, color=color, label="xyz"[axis])
    if wanted:
        axes.plot([], [], "--", color=GRAY, lw=0.8, label="applied")
    axes.set(title="Torque on the parent, world", ylabel="torque (N m)")


def _crossed(subject: Subject) -> dict[str, list[str]]:
    """Muscles of the motion by the joints that they act on; joints without any are left out."""
    from warpmuscle.model.path_table import joints_of_muscles  # Warp takes a while to import
    from warpmuscle.scene.topology import topology

    recording, character = subject.recording, subject.scene.character
    if not recording.muscle_names:
        raise Absent(f"{subject.source}: the motion of {subject.scene.name} has no muscles")
    found: dict[str, list[str]] = {name: [] for name in recording.joint_names}
    for muscle, joints in joints_of_muscles(character, topology(character)).items():
        for joint in joints if muscle in recording.muscle_names else ():
            found[joint].append(muscle)
    return {joint: muscles for joint, muscles in found.items() if muscles}


def _joint(subject: Subject, crossed: dict[str, list[str]]) -> str:
    if not crossed:
        raise Absent(f"{subject.source}: no muscle of {subject.scene.name} acts on a joint")
    if subject.choices.joints:
        return subject.chosen("joint that muscles act on", list(crossed), subject.choices.joints)[0]
    feet = subject.scene.feet
    chain = leg(subject.scene.character, feet[0]) if feet is not None else []
    return next((joint for joint in reversed(chain) if joint in crossed), next(iter(crossed)))


def _shown(subject: Subject) -> Recording:
    """The last stride, unless a time was chosen or there is none."""
    if subject.choices.timed or not subject.walks:
        return subject.recording
    return subject.recording.window(*subject.strides["left"][-1])
