"""A small picture of a scene's character as it starts, seen from its left side, for tables of notebooks."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import rotate
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import bone_lines
from warpmuscle.scene.initial_pose import plain_vector, world_poses
from warpmuscle.scene.parameters import start_values, substitute

HEIGHT, EDGE = 150, 6  # px
BONE, MUSCLE = "#8a949e", "#2f69cf"


def picture(scene: Scene) -> str:
    """SVG of bones and muscles, or nothing where there is neither."""
    numeric = substitute(scene, start_values(scene))
    poses, character = world_poses(numeric), numeric.character
    lines: list[tuple[str, float, Floats]] = []
    for name in character.bodies:
        place, turn = poses[name]
        lines += [(BONE, 3.0, place + rotate(turn, line)) for line in bone_lines(character, name)]
    for muscle in character.muscles.values():
        places = [(poses[point.body], plain_vector(point.place())) for point in muscle.path]
        path = np.array([place + rotate(turn, own) for (place, turn), own in places]).reshape(-1, 3)
        lines.append((MUSCLE, 1.2, path))
    lines = [(color, width, points[:, [2, 1]]) for color, width, points in lines if len(points) > 1]
    if not lines:
        return ""
    everything = np.concatenate([points for _, _, points in lines])
    low, size = everything.min(axis=0), np.maximum(np.ptp(everything, axis=0), 1e-3)
    scale = (HEIGHT - 2 * EDGE) / float(size.max())
    wide, tall = (2 * EDGE + scale * size).round().astype(int)
    drawn = "".join(
        f'<polyline points="{_points(EDGE + scale * (points - low), tall)}" stroke="{color}" stroke-width="{width}"/>'
        for color, width, points in lines
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" height="{tall}" fill="none" stroke-linecap="round" '
        f'role="img" aria-label="the body at the start">{drawn}</svg>'
    )


def _points(places: Floats, tall: int) -> str:
    return " ".join(f"{x:.1f},{tall - y:.1f}" for x, y in places)
