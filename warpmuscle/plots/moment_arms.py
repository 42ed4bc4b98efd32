"""Moment arms of muscles over the angle of a joint."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from warpmuscle.gait.cycles import flexion_signs
from warpmuscle.plots.joints import angle_label
from warpmuscle.plots.names import pairs
from warpmuscle.plots.style import GRAY, PALETTE, grid, heading, label_ends
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.scene.anatomy import leg
from warpmuscle.scene.joints import joint_type

if TYPE_CHECKING:
    from warpmuscle.studies.moment_arms import MomentArms

_SAMPLES = 41
_MOST = 9  # panels
_WORTH = 2.0e-3  # m: muscles whose moment arm stays below are not drawn


def draw(subject: Subject) -> Any:
    """A panel a degree of freedom that muscles act on, by default those of the legs first and of one side."""
    from warpmuscle.studies.moment_arms import joint_range, moment_arms  # Warp takes a while to import

    scene = subject.scene
    if not scene.character.muscles:
        raise Absent(f"{subject.source}: {scene.name} has no muscles")
    wanted = set(subject.chosen("muscle", list(scene.character.muscles), subject.choices.muscles))
    curves: list[tuple[str, MomentArms, list[int]]] = []
    drawn: set[str] = set()
    signs = flexion_signs(scene)
    for name, other in _joints(subject):
        joint = scene.character.joints[name]
        kind = joint_type(joint)
        for axis in range(len(kind.speeds) if len(curves) < _MOST and other not in drawn else 0):
            arms = moment_arms(scene, name, axis, np.linspace(*joint_range(joint, axis), _SAMPLES))
            if axis == 0 and signs.get(name, 1.0) < 0.0:
                arms = replace(arms, angle=-arms.angle[::-1], arm=-arms.arm[::-1])
            strong = np.flatnonzero(np.abs(arms.arm).max(axis=0, initial=0.0) > _WORTH).tolist()
            if shown := [k for k in strong if arms.muscles[k] in wanted]:
                curves.append((f"{name}, {kind.angle_names[axis]}", arms, shown))
                drawn.add(name)
    curves = curves[:_MOST]
    if not curves:
        raise Absent(f"{subject.source}: no muscle acts on the joints asked for")
    figure, panels = grid(len(curves), 3, 2.2)
    for axes, (title, arms, shown) in zip(panels, curves, strict=True):
        joint = scene.character.joints[arms.joint]
        turns = joint_type(joint).unit(joint) == "rad"
        position = np.degrees(arms.angle) if turns else arms.angle
        for number, k in enumerate(shown):
            line = ("-", "--", ":")[number // len(PALETTE) % 3]
            axes.plot(position, 1e3 * arms.arm[:, k], line, color=PALETTE[number % len(PALETTE)], lw=1.3)
        axes.axhline(0.0, color=GRAY, lw=0.6, zorder=0)
        label = "moment arm (mm)" if turns else "moment arm (mm/m)"
        axes.set(title=title, xlabel=angle_label(scene, arms.joint), ylabel=label)
        axes.margins(x=0.0, y=0.12)
    heading(
        figure,
        f"{scene.name}: moment arms",
        "positive: tension turns the child towards greater angles, which are flexion of hip, knee and ankle",
    )
    figure.draw_without_rendering()  # places the panels, so that names at their edges can keep apart
    for axes, (_, arms, shown) in zip(panels, curves, strict=True):
        ends = [(1e3 * float(arms.arm[-1, k]), arms.muscles[k], PALETTE[n % len(PALETTE)]) for n, k in enumerate(shown)]
        label_ends(axes, ends)
    return figure


def _joints(subject: Subject) -> list[tuple[str, str]]:
    """The joints to draw, and with each one the joint in place of which it is drawn if that has no muscles.

    Those asked for; else the left leg's, all others but right ones, and these where their left one has no muscles.
    """
    scene = subject.scene
    names = list(scene.character.joints)
    if subject.choices.joints:
        return [(name, "") for name in subject.chosen("joint", names, subject.choices.joints)]
    leg_joints = leg(scene.character, scene.feet[0]) if scene.feet is not None else []
    found = pairs(names)
    others = [pair.left for pair in found if pair.left not in leg_joints]
    return [(name, "") for name in (*leg_joints, *others)] + [
        (pair.right, pair.left) for pair in found if pair.right != pair.left
    ]
