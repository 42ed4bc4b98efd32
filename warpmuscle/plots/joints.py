"""Joint angles over time, of any character."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.formats.sto import coordinates
from warpmuscle.gait.cycles import flexion_signs
from warpmuscle.plots.names import pairs
from warpmuscle.plots.style import GRAY, PALETTE, grid, heading
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import joint_type

_AXES = {"x": "x", "y": "y", "z": "z", "a": "first axis", "b": "second axis", "": "angle"}
_COLORS = dict(zip(_AXES.values(), (*PALETTE[:3], *PALETTE[:2], PALETTE[0]), strict=True))
_LEGEND = {"x, first or only axis": PALETTE[0], "y, second axis": PALETTE[1], "z": PALETTE[2]}
RECORDED_COLOR = "#BBBBBB"
FLEXING = ("x", "first axis", "angle")  # of which one is flexion, if any
_STRIDES = 3  # that are shown unless a time is chosen


def draw(subject: Subject) -> Any:
    """A panel a joint, left and right in the same one."""
    recording, scene = _shown(subject), subject.scene
    moving = [name for name in recording.joint_names if joint_type(scene.character.joints[name]).moves]
    if not moving:
        raise Absent(f"{subject.source}: no joint of {scene.name} moves")
    rows = pairs(subject.chosen("joint", moving, subject.choices.joints))
    columns = len(rows) if len(rows) <= 3 else min(4, (len(rows) + 1) // 2)
    figure, panels = grid(len(rows), columns, 1.9, sharex=True)
    used: set[str] = set()
    recorded = subject.recorded(recording)
    for axes, row in zip(panels, rows, strict=True):
        for name, line in ((row.left, "-"), (row.right, "--")) if row.left != row.right else ((row.left, "-"),):
            if recorded is not None:
                recorded_curves(axes, recorded, scene, name)
            for number, (label, angle) in enumerate(joint_curves(recording, scene, name)):
                axes.plot(recording.time, angle, line, color=_COLORS[label], lw=1.4 - 0.2 * number)
                used.add(_COLORS[label])
        axes.axhline(0.0, color=GRAY, lw=0.6, zorder=0)
        axes.set(title=row.label, ylabel=angle_label(scene, row.left))
        axes.margins(x=0.0)
    for axes in panels[-columns:]:
        axes.set_xlabel("time (s)")
        axes.tick_params(labelbottom=True)
    _legend(figure, panels[0], used, any(row.left != row.right for row in rows))
    note = "child relative to parent; of a ball joint turns about x, y, z; flexion of hip, knee and ankle is positive"
    note += "; wide and gray: as recorded" if recorded is not None else ""
    heading(figure, f"{subject.title}: joint angles over time", note)
    return figure


def _legend(figure: Any, axes: Any, used: set[str], paired: bool) -> None:
    for label, color in ((label, color) for label, color in _LEGEND.items() if color in used):
        axes.plot([], [], color=color, label=label)
    for line, side in (("-", "left"), ("--", "right")) if paired else ():
        axes.plot([], [], line, color=PALETTE[6], label=side)
    handles = axes.get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=len(handles[1]))


def _shown(subject: Subject) -> Recording:
    """The last strides of a walk, unless a time was chosen."""
    if subject.choices.timed or not subject.walks:
        return subject.recording
    cycles = subject.strides["left"][-_STRIDES:]
    return subject.recording.window(cycles[0][0], cycles[-1][1])


def recorded_curves(axes: Any, recorded: Recording, scene: Scene, joint: str) -> None:
    """The angles of a joint in a recorded motion, below those that are drawn over them."""
    for _, angle in joint_curves(recorded, scene, joint):
        axes.plot(recorded.time, angle, color=RECORDED_COLOR, lw=4.0, zorder=1)


def angle_label(scene: Scene, joint: str) -> str:
    """Label of an axis with the angles of a joint, or the positions of one whose coordinate is a length."""
    entry = scene.character.joints[joint]
    return "angle (deg)" if joint_type(entry).unit(entry) == "rad" else "position (m)"


def joint_curves(recording: Recording, scene: Scene, joint: str) -> list[tuple[str, Floats]]:
    """Angles (F,) of a joint, degrees (see `angle_label`), with names of their axes; turns about x, y, z of a ball.

    Flexion of hips, knees and ankles is positive, as beside the norms.
    """
    names, values = coordinates(recording, scene)
    signs = flexion_signs(scene)
    found: list[tuple[str, Floats]] = []
    for k, name in enumerate(names):
        base, _, axis = name.rpartition("_")
        if name == joint or (base == joint and axis in _AXES):
            label = _AXES["" if name == joint else axis]
            sign = signs.get(joint, 1.0) if label in FLEXING else 1.0
            found.append((label, sign * np.asarray(values[:, k])))
    return found
