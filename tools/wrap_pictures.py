"""Pictures of a model's muscles round their surfaces, with OpenSim's length of the same path beside ours.

    python tools/wrap_pictures.py Rajagopal2016.osim -o wraps.png

Three angles of the right knee and of the right hip from the side, of OpenSim's Rajagopal2016; needs `pip install
opensim`. Surfaces are drawn as outlines, bones as lines between joints. A path round several surfaces has two lengths
in OpenSim: that which it uses, and that of the path that it draws; both are told where they differ by a millimetre.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from matplotlib import pyplot
from opensim_oracle import Floats, Posed, with_process
from opensim_ours import Ours

import warpmuscle as wm
from warpmuscle.core.pose import rotate
from warpmuscle.scene import CylinderSurface, EllipsoidSurface, Scene, SphereSurface, Surface
from warpmuscle.scene.anatomy import bone_lines, convex_hull
from warpmuscle.scene.number import Number
from warpmuscle.scene.wrapping.drawn import drawn_route, surface_pose
from warpmuscle.studies.inverse_dynamics import body_points

Poses = dict[str, tuple[Floats, Floats]]
COLORS = ("#b5333d", "#d97a1c", "#2f7d4f", "#2b6cb0", "#7b4fa3", "#0f8b8d")


@dataclass(frozen=True)
class Row:
    """A joint at three angles."""

    coordinate: str
    angles: tuple[float, ...]  # degrees
    muscles: tuple[str, ...]
    bodies: tuple[str, ...]  # whose bones are drawn
    middle: str  # body at whose joint the picture is centred
    reach: float  # m
    legend: str  # where it stands


ROWS = (
    Row("knee_angle_r", (5.0, 60.0, 110.0), ("vasint_r", "recfem_r", "gasmed_r", "semimem_r", "bfsh_r"),
        ("femur_r", "tibia_r", "patella_r"), "tibia_r", 0.24, "lower right"),
    Row("hip_flexion_r", (-20.0, 30.0, 90.0), ("glmax1_r", "glmax2_r", "glmax3_r", "psoas_r", "iliacus_r"),
        ("pelvis", "femur_r"), "femur_r", 0.24, "lower left"),
)  # fmt: skip


def theirs(model: Path, poses: Floats, muscles: list[str]) -> tuple[list[str], list[int], Floats, list[list[float]]]:
    """Names of OpenSim's coordinates, the independent ones, its poses (n, K), and its lengths (n, m)."""
    posed = Posed(model)
    every = np.repeat(posed.coupled(posed.start)[None], len(poses), axis=0)
    column = {name: k for k, name in enumerate(posed.names)}
    index = {muscle.getName(): k for k, muscle in enumerate(posed.muscles)}
    for row, (number, degrees) in zip(every, poses, strict=True):
        row[column[ROWS[int(number)].coordinate]] = np.radians(degrees)
        row[:] = posed.coupled(row)
    lengths = [[posed.lengths_at(row)[index[name]] for name in muscles] for row in every]
    return posed.names, [int(k) for k in posed.independent], every, lengths


def poses_of(ours: Ours, scene: Scene, q: Floats) -> Poses:
    """Centre of mass and orientation of every body in one pose."""
    arms = {joint.child: np.array(joint.position_in_child, dtype=float) for joint in scene.character.joints.values()}
    found = {}
    for name, (place, turn) in body_points(scene, ours.places(q[None])).items():
        found[name] = place[0] - rotate(turn[0], arms.get(name, np.zeros(3))), turn[0]
    return found


def outline(surface: Surface, poses: Poses) -> Floats:
    """Corners (n, 2) of a surface seen from the side: forwards and up."""
    round_, flat = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 40), np.linspace(-1.0, 1.0, 21))
    across = np.sqrt(1.0 - flat**2)
    ball = np.stack([across * np.cos(round_), across * np.sin(round_), flat], axis=-1).reshape(-1, 3)
    if isinstance(surface, CylinderSurface):
        ends = np.stack([np.cos(round_), np.sin(round_), flat], axis=-1).reshape(-1, 3)
        points = ends * [_number(surface.radius), _number(surface.radius), 0.5 * _number(surface.length)]
    elif isinstance(surface, SphereSurface):
        points = ball * _number(surface.radius)
    elif isinstance(surface, EllipsoidSurface):
        points = ball * np.array([_number(radius) for radius in surface.radii])
    else:
        points = ball * _number(surface.outer_radius) * [1.0, 1.0, 0.3]
    center, turn = surface_pose(surface, poses)
    return convex_hull((center + rotate(turn, points))[:, [2, 1]])


def _number(number: Number) -> float:
    return float(np.asarray(number))


def draw(axes: Any, row: Row, degrees: float, scene: Scene, poses: Poses, angles: Any, lengths: list[float]) -> None:
    """One picture."""
    character, shown = scene.character, {}
    bones = [line for body in row.bodies for line in bone_lines(character, body)]
    owners = [body for body in row.bodies for _ in bone_lines(character, body)]
    for body, line in zip(owners, bones, strict=True):
        points = poses[body][0] + rotate(poses[body][1], line)
        axes.plot(points[:, 2], points[:, 1], color="#c8ccd2", lw=7, solid_capstyle="round", zorder=1)
    for color, name, length in zip(COLORS, row.muscles, lengths, strict=False):
        points = drawn_route(character, character.muscles[name], poses, angles)
        drawn = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        label = f"{name}: {1e3 * length:.1f}"
        if abs(drawn - length) > 1e-3:
            label += f" (drawn {1e3 * drawn:.1f})"
        axes.plot(points[:, 2], points[:, 1], color=color, lw=2, zorder=3, label=label)
        axes.plot(points[[0, -1], 2], points[[0, -1], 1], "o", color=color, ms=3, zorder=3)
        shown |= {wrap.surface: color for wrap in character.muscles[name].wraps}
    for name, color in shown.items():
        corners = outline(character.surfaces[name], poses)
        axes.fill(corners[:, 0], corners[:, 1], color=color, alpha=0.14, zorder=2)
        axes.plot(corners[:, 0], corners[:, 1], color=color, alpha=0.5, lw=0.6, zorder=2)
    arm = next(np.array(j.position_in_child, float) for j in character.joints.values() if j.child == row.middle)
    middle = poses[row.middle][0] + rotate(poses[row.middle][1], arm)
    axes.set(xlim=middle[2] + row.reach * np.array([-1, 1]), ylim=middle[1] + row.reach * np.array([-1.0, 1.0]))
    axes.set(aspect="equal", xticks=[], yticks=[], title=f"{row.coordinate} {degrees:g} degrees")
    axes.legend(fontsize=6.5, loc=row.legend, title="OpenSim's length, mm", title_fontsize=6.5, framealpha=0.9)


def main(
    model: Annotated[Path, typer.Argument(help="File of the model.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Picture to write.")] = Path("wraps.png"),
) -> None:
    """Draw."""
    scene = wm.load(model)
    poses = np.array([(number, degrees) for number, row in enumerate(ROWS) for degrees in row.angles])
    muscles = [name for row in ROWS for name in row.muscles]
    names, independent, q, lengths = with_process(theirs, model, poses, muscles)
    ours = Ours(scene, names, independent)
    own = ours.lengths(q)[:, [ours.muscles.index(name) for name in muscles]]
    print("pose".ljust(24) + "muscle".ljust(12) + "OpenSim, m   ours, m      difference, mm")
    figure, grid = pyplot.subplots(len(ROWS), 3, figsize=(13, 4.6 * len(ROWS)), squeeze=False, layout="constrained")
    for k, (number, degrees) in enumerate(poses):
        row = ROWS[int(number)]
        angles = {names[c]: q[k, [c]] for c in ours.own}
        first = sum(len(other.muscles) for other in ROWS[: int(number)])
        chosen = lengths[k][first : first + len(row.muscles)]
        axes = grid[int(number), row.angles.index(degrees)]
        draw(axes, row, degrees, scene, poses_of(ours, scene, q[k]), angles, chosen)
        for name, length, mine in zip(row.muscles, chosen, own[k, first:], strict=False):
            place = f"{row.coordinate} {degrees:g}"
            print(f"{place:24}{name:12}{length:.7f}    {mine:.7f}    {1e3 * (mine - length):+.4f}")
    figure.savefig(output, dpi=110)
    print(f"wrote {output}")


if __name__ == "__main__":
    typer.run(main)
