"""Stick figures of a motion over time, and curves below them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import rounded
from warpmuscle.gait.cycles import leg_angles
from warpmuscle.gait.foot_contact import SIDES, touch_downs
from warpmuscle.gait.measures import Gait
from warpmuscle.gait.relative_to_belts import over_belts
from warpmuscle.plots.joints import RECORDED_COLOR, angle_label, joint_curves, recorded_curves
from warpmuscle.plots.projection import project
from warpmuscle.plots.style import SIDE_COLORS, WIDTH, empty_figure, save, style
from warpmuscle.plots.subject import Subject
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import Piece, pieces
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.terrain.surface import Surface, surface

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TINTS = {"left": "#B8D8EA", "right": "#F6D5BF", "middle": "#FFFFFF"}  # of outlines
_GROUND_POINTS = 80  # of ground that is not flat, below a figure
_COM_COLOR, _GROUND_COLOR = "#009E73", "#909090"
_LAYERS = ("left", "middle", "right")  # seen from the character's right
_SIDE, _FRONT = (2, 1), (0, 1)  # world axes to the right and up of the page
_FIGURES = 9
_STEPS = 2  # a stride
_GAP = 0.08  # m, least distance between neighbouring figures
_PITCH = 0.65  # m, least mean advance from one figure to the next, which fills the page
_MARGIN = 0.12  # m, around the figures
_PANELS = 4  # below the figures


def draw(subject: Subject) -> Any:
    """The last two steps of a walk, or the part of a motion that was chosen."""
    recording = over_belts(subject.recording, subject.scene)
    shown = recording if subject.choices.timed else _last_steps(recording)
    return _figure(shown, subject.scene, subject.gait, subject.title, subject.recorded(shown))


def stick_figures(recording: Recording, scene: Scene, path: str | Path, gait: Gait | None = None) -> None:
    """Draw a recorded walk: figures seen from the side and from the front, joint angles and ground forces.

    The last two steps are drawn, or the whole recording if the stance changes less often. Figures from the side are
    moved apart along the direction of travel until none overlaps, so the axis below them tells their times.

    Args:
        recording: at least two frames, of the scene's character.
        scene: checked scene; free parameters count with their start values.
        path: file to write; its ending (png, pdf, svg) chooses the format.
        gait: measures for the title.

    Raises:
        Error: matplotlib is not installed, fewer than two frames, or the file cannot be written.
    """
    if recording.frames < 2:
        raise Error("a figure needs a recording of at least two frames")
    with style():
        numeric = at_start(scene)
        figure = _figure(_last_steps(over_belts(recording, numeric)), numeric, gait, scene.name)
    save(figure, path)


def _figure(
    recording: Recording, scene: Scene, gait: Gait | None, title: str, recorded: Recording | None = None
) -> Any:
    """Side and front view at the same scale above, curves over time below."""
    feet = scene.feet or ("lFoot", "rFoot")
    drawn = sorted(pieces(scene.character, feet), key=lambda piece: _LAYERS.index(piece.side))
    if not drawn:
        raise Error(f"no body of {scene.name} is as long as a stick")
    frames, offsets = _spread(recording, drawn)
    middle = int(frames[len(frames) // 2])
    side, front = _extent(recording, drawn, frames, offsets, _SIDE), _extent(recording, drawn, [middle], 0.0, _FRONT)
    ground = surface(scene.ground)
    grounds = [_ground_below(recording, ground, drawn, int(k), float(offsets[k]), _SIDE) for k in frames]
    low, high = min(side[0, 1], np.min(grounds, axis=(0, 1))[1]) - _MARGIN, side[1, 1] + _MARGIN
    side_width = side[1, 0] - side[0, 0]
    center, front_width = front[:, 0].mean(), max(front[1, 0] - front[0, 0] + 2.0 * _MARGIN, 0.13 * side_width)
    room = WIDTH - 1.07  # inches for both views, without margins and gap
    scale = min(room / (side_width + 2.0 * _MARGIN + front_width), 3.2 / (high - low))  # inches/m
    spare = (room / scale - front_width - side_width) / 2.0

    height = scale * (high - low)
    paper = _Page(empty_figure(figsize=(WIDTH, height + 3.65)))
    front_axes = paper.axes(WIDTH - 0.12 - scale * front_width, 3.0, scale * front_width, height)
    side_axes = paper.axes(0.62, 3.0, room - scale * front_width, height)
    side_axes.set(xlim=(side[0, 0] - spare, side[1, 0] + spare), ylim=(low, high))
    front_axes.set(xlim=(center - front_width / 2.0, center + front_width / 2.0), ylim=(low, high))
    _draw_ground(side_axes, grounds)
    _draw_ground(front_axes, [_ground_below(recording, ground, drawn, middle, 0.0, _FRONT)])
    _draw_side(side_axes, recording, drawn, frames, offsets)
    _draw_front(front_axes, recording, drawn, middle)

    pitch = (WIDTH - 0.05) / _PANELS
    panels = [paper.axes(0.58 + pitch * column, 0.8, pitch - 0.74, 1.45) for column in range(_PANELS)]
    _draw_curves(panels, recording, scene, recorded)
    for axes in panels:
        axes.set_xlabel("time (s)")
        axes.set_xlim(recording.time[0], recording.time[-1])
        axes.locator_params(axis="x", nbins=4)
    if recorded is not None:
        side_axes.plot([], [], color=RECORDED_COLOR, lw=4.0, label="angle as recorded")
    paper.figure.legend(*side_axes.get_legend_handles_labels(), loc="lower center", ncols=4)
    paper.figure.text(0.008, 1.0 - 0.06 / (height + 3.65), _title(title, gait), weight="bold", size=11.0, va="top")
    return paper.figure


class _Page:
    """A figure with axes placed in inches from its lower left corner."""

    def __init__(self, figure: Any) -> None:
        self.figure = figure

    def axes(self, left: float, bottom: float, width: float, height: float) -> Any:
        full_width, full_height = self.figure.get_size_inches()
        box = (left / full_width, bottom / full_height, width / full_width, height / full_height)
        return self.figure.add_axes(box)


def _title(name: str, gait: Gait | None) -> str:
    if gait is None:
        return name
    sign, way = (1.0, "forwards") if gait.speed_forward >= 0.0 else (-1.0, "backwards")
    speed = rounded(sign * gait.speed_forward, 2)
    parts = [f"{speed} m/s {way}" if float(speed) else "on the spot"]
    if gait.step_length is not None:
        parts.append(f"step length {rounded(sign * gait.step_length, 2)} m")
    if gait.cadence is not None:
        parts.append(f"{gait.cadence:.0f} steps/min")
    return f"{name}: {', '.join(parts)}"


def _last_steps(recording: Recording) -> Recording:
    """The last whole steps of the recording, all of it if there are too few."""
    landings = np.sort(np.concatenate([touch_downs(recording, side) for side in SIDES]))
    if len(landings) <= _STEPS:
        return recording
    return recording.window(float(landings[-1 - _STEPS]), float(landings[-1]))


def _spread(recording: Recording, drawn: list[Piece]) -> tuple[Integers, Floats]:
    """Frames to draw, and by how much to move each of the F frames forwards, m, so that no two drawn ones overlap.

    The distance grows in proportion to time, so that the path of the centre of mass stays a smooth curve.
    """
    frames = np.unique(np.linspace(0, recording.frames - 1, min(_FIGURES, recording.frames)).round().astype(int))
    extents = np.array([_extent(recording, drawn, [frame], 0.0, _SIDE)[:, 0] for frame in frames])
    travel = float(recording.com[-1, 2] - recording.com[0, 2])
    way = -1.0 if travel < -0.05 else 1.0
    overlaps = extents[:-1, 1] - extents[1:, 0] if way > 0.0 else extents[1:, 1] - extents[:-1, 0]
    time = recording.time.astype(float)
    steepest = np.max((overlaps + _GAP) / np.diff(time[frames]))
    widest = ((len(frames) - 1) * _PITCH - way * travel) / (time[-1] - time[0])
    return frames, way * max(0.0, float(steepest), widest) * (time - time[0])


def _extent(
    recording: Recording, drawn: list[Piece], frames: Any, offsets: Floats | float, view: tuple[int, int]
) -> Floats:
    """Lowest and highest [horizontal, vertical] coordinates (2, 2), m, of figures moved by offsets (F,) or a number."""
    shifts = np.broadcast_to(offsets, recording.frames)
    points = []
    for frame in frames:
        shift = np.array([shifts[frame], 0.0])
        points += [project(recording, piece, frame, view) + shift for piece in drawn]
    every = np.concatenate(points)
    return np.stack([every.min(axis=0), every.max(axis=0)])


def _ground_below(
    recording: Recording, ground: Surface, drawn: list[Piece], frame: int, offset: float, view: tuple[int, int]
) -> Floats:
    """Points (n, 2) on the page, m, of the ground below a figure: as it is where the figure really stands."""
    across = _extent(recording, drawn, [frame], offset, view)[:, 0] + np.array([-0.5, 0.5]) * _GAP
    if ground.lie is not None:
        across = np.linspace(across[0], across[1], _GROUND_POINTS)
    place = {axis: np.full(len(across), recording.com[frame, axis], dtype=float) for axis in (0, 2)}
    place |= {view[0]: across - offset}
    return np.stack([across, ground.height_at(place[0], place[2])], axis=1)


def _draw_ground(axes: Axes, lines: list[Floats]) -> None:
    """The ground below figures; where it is level, one line all across the page."""
    if np.ptp([line[:, 1] for line in lines]) == 0.0:
        axes.axhline(lines[0][0, 1], color=_GROUND_COLOR, lw=1.2, zorder=0)
        return
    for line in lines:
        axes.plot(*line.T, color=_GROUND_COLOR, lw=1.2, zorder=0)


def _draw_side(axes: Axes, recording: Recording, drawn: list[Piece], frames: Integers, offsets: Floats) -> None:
    """Figures walking along the page, each over its time, and the path of the centre of mass."""
    for frame in frames:
        _draw_figure(axes, recording, drawn, int(frame), _SIDE, float(offsets[frame]))
    for side in (side for side in SIDES if any(piece.side == side for piece in drawn)):
        axes.plot([], [], color=SIDE_COLORS[side], lw=2.0, label=f"{side} side")
    places = recording.com[:, 2] + offsets
    axes.plot(places, recording.com[:, 1], color=_COM_COLOR, lw=1.5, label="centre of mass", zorder=4)
    axes.plot(places[frames], recording.com[frames, 1], "o", color=_COM_COLOR, ms=3.5, zorder=4)
    axes.set_xticks(places[frames], [f"{time:.2f}" for time in recording.time[frames]])
    moved = ", figures moved apart" if np.any(offsets) else ""
    axes.set(title="Side view", xlabel=f"time (s){moved}", ylabel="height, y (m)")


def _draw_front(axes: Axes, recording: Recording, drawn: list[Piece], frame: int) -> None:
    """One figure as it comes towards the viewer, its left to the right of the page."""
    _draw_figure(axes, recording, drawn, frame, _FRONT, 0.0)
    axes.plot(*recording.com[frame, :2], "o", color=_COM_COLOR, ms=3.5, zorder=4)
    axes.tick_params(labelleft=False)
    axes.locator_params(axis="x", nbins=3, steps=[1, 5, 10], min_n_ticks=1)  # no room for more labels
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set(title=f"Front, {recording.time[frame]:.2f} s", xlabel="left, x (m)")


def _draw_figure(
    axes: Axes, recording: Recording, drawn: list[Piece], frame: int, view: tuple[int, int], offset: float
) -> None:
    for piece in drawn:
        points = project(recording, piece, frame, view) + np.array([offset, 0.0])
        color = SIDE_COLORS[piece.side]
        if piece.outline:
            axes.fill(*points.T, facecolor=_TINTS[piece.side], edgecolor=color, lw=1.2, zorder=2)
        else:
            axes.plot(*points.T, color=color, lw=2.0, zorder=2)


def _draw_curves(panels: list[Any], recording: Recording, scene: Scene, recorded: Recording | None) -> None:
    """Angles of the legs and vertical ground forces; of a character without legs the joints that turn most."""
    try:
        angles = leg_angles(recording, scene)
    except Error:
        _draw_joints(panels, recording, scene, recorded)
        return
    for axes, (name, sides) in zip(panels, angles.items(), strict=False):
        for side, angle in sides.items():
            axes.plot(recording.time, angle, color=SIDE_COLORS[side])
        axes.set(title=name, ylabel="angle (deg)")
        axes.axhline(0.0, color=_GROUND_COLOR, lw=0.8, zorder=0)
    for side in SIDES:
        panels[-1].plot(recording.time, recording[f"foot_force_{side}"][:, 1], color=SIDE_COLORS[side], lw=1.2)
    panels[-1].set(title="Vertical ground force", ylabel=f"force ({QUANTITIES['foot_force_left'].units})")


def _draw_joints(panels: list[Any], recording: Recording, scene: Scene, recorded: Recording | None) -> None:
    found = [(name, f"{name}, {axis}", angle) for name in recording.joint_names
             for axis, angle in joint_curves(recording, scene, name)]  # fmt: skip
    found.sort(key=lambda curve: -float(np.ptp(curve[2])))
    for axes, (joint, name, angle) in zip(panels, found, strict=False):
        if recorded is not None:
            recorded_curves(axes, recorded, scene, joint)
        axes.plot(recording.time, angle, color=SIDE_COLORS["middle"])
        axes.set(title=name, ylabel=angle_label(scene, joint))
    for axes in panels[len(found) :]:
        axes.set_visible(False)
