"""Close-ups of the feet, frame by frame, as they touch down and as they leave the ground."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.gait.cycles import body_weight, longest_span
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.foot_sliding import LOADED
from warpmuscle.gait.measures import feet_of
from warpmuscle.gait.relative_to_belts import over_belts
from warpmuscle.plots.projection import project
from warpmuscle.plots.style import GRAY, SIDE_COLORS, heading, page
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import Piece, foot_bodies, leg, pieces
from warpmuscle.scene.terrain.surface import surface

_FRAMES = 8
_SIDE_VIEW = (2, 1)  # world axes to the right and up of the page
_WINDOW = (0.52, 0.26)  # m, width and height of a close-up
_GROUND_POINTS = 60  # along the ground, which may not be flat
_BELOW = 0.045  # m, of ground that is seen
_ARROW = 0.12  # m, of a force of one body weight
_FORCE_ARROW = {"arrowstyle": "-|>", "color": "#009E73", "lw": 1.2, "shrinkA": 0.0, "shrinkB": 0.0, "mutation_scale": 7}
# When frames are taken, s from the event.
_SPANS = {"touch-down": (-0.03, 0.11), "toe-off": (-0.12, 0.09)}


def draw(subject: Subject) -> Any:
    """The last whole step of each foot: frames about its touch-down, and about its toe-off."""
    scene, cycles = subject.scene, subject.strides
    recording = over_belts(subject.recording, scene)
    try:
        feet = feet_of(scene)
    except Error as error:
        raise Absent(f"{subject.source}: {error}") from None
    figure = page(5.4, 12.0)
    rows = figure.subplots(2 * len(SIDES), _FRAMES)
    shown = pieces(scene.character, feet)
    for column, (side, foot) in enumerate(zip(SIDES, feet, strict=True)):
        begin, end = cycles[side][-2] if len(cycles[side]) > 1 else cycles[side][-1]
        events = {"touch-down": begin, "toe-off": toe_off(recording, scene, side, begin, end)}
        limb = {*foot_bodies(scene.character, foot), scene.character.joints[leg(scene.character, foot)[-1]].parent}
        own = [piece for piece in shown if piece.body in limb]
        for row, (event, time) in enumerate(events.items()):
            _row(list(rows[2 * column + row]), recording, scene, own, side, event, time)
    note = (
        f"seen from the right; arrow: ground force at the lowest point, {_ARROW:g} m a body weight; grey: the frame "
        f"before; numbers: height of the lowest point; toe-off: less than {LOADED:g} body weights on the foot"
    )
    heading(figure, f"{scene.name}: feet at touch-down and toe-off", note)
    return figure


def toe_off(recording: Recording, scene: Scene, side: str, begin: float, end: float) -> float:
    """Time between two touch-downs of a foot at which it gives off its load for the longest time, s."""
    force = recording[f"foot_force_{side}"][:, 1]
    inside = (recording.time >= begin) & (recording.time <= end)
    swing = longest_span(inside & (force < LOADED * body_weight(scene)))
    return end if swing is None else float(recording.time[swing.start])


def _row(
    panels: list[Any], recording: Recording, scene: Scene, shown: list[Piece], side: str, event: str, time: float
) -> None:
    """Frames about an event, all with the same piece of the ground, so that one sees what slides."""
    times = time + np.linspace(*_SPANS[event], _FRAMES)
    last = recording.frames - 1
    frames = [min(int(np.searchsorted(recording.time, one - 1e-6)), last) for one in times]
    foot = recording.position_of(feet_of(scene)[SIDES.index(side)])
    middle = float(foot[min(int(np.searchsorted(recording.time, time)), last), 2]) + 0.04
    for axes, frame, before in zip(panels, frames, [frames[0], *frames[:-1]], strict=True):
        _close_up(axes, recording, scene, shown, side, frame, before, middle)
        axes.set_title(f"{1000.0 * (recording.time[frame] - time):+.0f} ms", size=7.5, color=GRAY)
    panels[0].set_ylabel(f"{side}\n{event}\n({time:.2f} s)", rotation=0, ha="right", va="center", size=8.0)


def _close_up(
    axes: Any, recording: Recording, scene: Scene, shown: list[Piece], side: str, frame: int, before: int, middle: float
) -> None:
    window = middle + np.array([-0.5, 0.5]) * _WINDOW[0]
    across = np.linspace(window[0], window[1], _GROUND_POINTS)
    foot = recording.position_of(feet_of(scene)[SIDES.index(side)])
    ground = surface(scene.ground).height_at(foot[frame, 0], across)
    axes.fill_between(across, ground, ground - 1.0, color="#E4E0D8", lw=0.0, zorder=0)
    axes.plot(across, ground, color=GRAY, lw=0.8, zorder=3)
    outlines = []
    for piece in shown:
        for at, color, width in ((before, "#BBBBBB", 0.7), (frame, SIDE_COLORS[side], 1.1)):
            points, now = project(recording, piece, at, _SIDE_VIEW), at == frame
            if piece.outline:
                axes.fill(
                    *points.T, facecolor=f"{color}30" if now else "none", edgecolor=color, lw=width, zorder=1 + now
                )
                outlines += [points] if now else []
            else:
                axes.plot(*points.T, color=color, lw=width, zorder=1 + now)
    level = float(ground.mean())
    if outlines:
        points = np.concatenate(outlines)
        heights = points[:, 1] - np.interp(points[:, 0], across, ground)
        lowest = points[int(np.argmin(heights))]
        text = f"{1000.0 * float(heights.min()):+.1f} mm"
        axes.text(0.97, 0.03, text, transform=axes.transAxes, size=6.5, ha="right", color=GRAY)
        force = recording[f"foot_force_{side}"][frame] * (_ARROW / body_weight(scene))
        if float(np.linalg.norm(force)) > 0.02 * _ARROW:
            tip = (lowest[0] + force[2], lowest[1] + force[1])
            axes.annotate("", tip, lowest, arrowprops=_FORCE_ARROW, zorder=4)
    axes.set(xlim=window, ylim=(level - _BELOW, level + _WINDOW[1] - _BELOW), aspect="equal", xticks=[], yticks=[])
