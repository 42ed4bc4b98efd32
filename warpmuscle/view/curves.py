"""Curves over time to plot below a replay: angles, torques, activations and ground forces; numbers only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import conjugate, rotate
from warpmuscle.gait.cycles import flexion_signs
from warpmuscle.results.joint_poses import joint_angles
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import Side
from warpmuscle.scene.joints import joint_type


@dataclass(frozen=True)
class Line:
    """One curve of a panel."""

    name: str
    side: Side
    values: Floats  # (F,)


@dataclass(frozen=True)
class Panel:
    """Curves in common axes, of the left and the right side where there are both."""

    group: str
    title: str
    unit: str
    lines: tuple[Line, ...]


def panels_of(recording: Recording, scene: Scene) -> list[Panel]:
    """All panels of a recording and its scene without free parameters, group by group.

    Angles are a joint's own, of a ball joint turns about the child's x, then y, then z axis; torques act on the child,
    about the same axes, of a ball joint those of the parent. Units are degrees, N m, 1 and N. Flexion of
    hips, knees and ankles is positive, and so is a torque towards it.
    """
    signs = flexion_signs(scene)
    curves: dict[str, tuple[dict[str, Floats], dict[str, Floats]]] = {"rad": ({}, {}), "m": ({}, {})}
    orientations = dict(zip(recording.body_names, np.moveaxis(recording.body_orientation, 1, 0), strict=True))
    for number, name in enumerate(recording.joint_names):
        joint = scene.character.joints[name]
        kind, own = joint_type(joint), joint_angles(recording, scene.character, name)
        shown, factor = curves[kind.unit(joint)], np.degrees(1.0) if kind.unit(joint) == "rad" else 1.0
        acting = -rotate(conjugate(orientations[joint.parent]), recording.joint_torque[:, number])
        about = kind.components(joint, acting)
        for axis, word in enumerate(kind.angles):
            key, sign = f"{name} {word}".strip(), signs.get(name, 1.0) if axis == 0 else 1.0
            shown[0][key], shown[1][key] = sign * factor * own[:, axis], sign * about[:, axis]
    feet = {"left": recording.foot_force_left, "right": recording.foot_force_right}
    panels = _panels("angles", "°", curves["rad"][0]) + _panels("positions", "m", curves["m"][0])
    panels += _panels("torques", "N m", curves["rad"][1]) + _panels("forces", "N", curves["m"][1])
    activation = dict(zip(recording.muscle_names, recording.muscle_activation.T, strict=True))
    panels += _panels("activations", "", activation)
    if any(np.any(force) for force in feet.values()):
        for word, axis in (("vertical", 1), ("forwards", 2), ("to the left", 0)):
            lines = tuple(Line(f"{side} foot", side, force[:, axis]) for side, force in _sided(feet))
            panels.append(Panel("ground forces", word, "N", lines))
    return panels


def _sided(feet: dict[str, Floats]) -> list[tuple[Side, Floats]]:
    return [("left", feet["left"]), ("right", feet["right"])]


def _panels(group: str, unit: str, curves: dict[str, Floats]) -> list[Panel]:
    """A panel for each curve, or for the curves of both sides, whose names begin with l and r."""
    panels = []
    for name, values in curves.items():
        other = _other_side(name, curves)
        if other is None:
            panels.append(Panel(group, name.replace("_", " "), unit, (Line(name, "middle", values),)))
        elif name[0] == "l":
            lines = (Line(name, "left", values), Line(other, "right", curves[other]))
            panels.append(Panel(group, name[1:].replace("_", " ").strip(), unit, lines))
    return panels


def _other_side(name: str, names: Sequence[str] | dict[str, Floats]) -> str | None:
    """The name of the same on the other side, if there is one."""
    mirrored = {"l": "r", "r": "l"}.get(name[:1])
    return mirrored + name[1:] if mirrored is not None and mirrored + name[1:] in names else None
