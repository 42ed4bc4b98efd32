"""What stands on the ground in a frame of a film: shadows, bodies, muscles and forces, as a picture to lay over it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.pose import normalized
from warpmuscle.video.colours import FORCES, LIGHT, SHADOW, SHADOW_ALPHA, SHORTEST, lit, skin_alpha
from warpmuscle.video.film import Film
from warpmuscle.video.raster import Seen, seen_triangles
from warpmuscle.video.triangles import arrow

_FINER = 2  # pixels along each axis whose mean is one of the picture's
_LEAST_FORCE = 0.015  # m, shorter arrows are not drawn
_THROUGH = 0.45  # how much a force counts where a body hides it


class _Window:
    """The part of a picture in which there is anything, in finer pixels."""

    def __init__(self, flat: Floats, width: int, height: int) -> None:
        """Hold points (n, 2), px, as far as they lie within a picture of this size; at least a pixel."""
        low, high = (flat.min(axis=0), flat.max(axis=0)) if len(flat) else (np.zeros(2), np.zeros(2))
        most = np.array([width, height])
        begin = np.clip(np.floor(low), 0, most - 1).astype(int)
        end = np.clip(np.ceil(high), begin + 1, most).astype(int)
        self.left, self.top = (int(number) for number in begin)
        self.fine = tuple(int(number) for number in _FINER * (end - begin))

    def inside(self, flat: Floats) -> Floats:
        """Points (n, 2) of the picture, px, in finer pixels from this part's corner."""
        return np.asarray(_FINER * (flat - [self.left, self.top]))


class Patch(NamedTuple):
    """A part of a picture: colours and opacity (height, width, 4), and px from the left and the top."""

    colours: NDArray[np.uint8]
    left: int
    top: int


class Standing:
    """Draws one frame after the other."""

    def __init__(self, film: Film) -> None:
        self._film = film

    def picture(self, number: int) -> Patch:
        """What is not clear in a frame."""
        film = self._film
        corners, normals, tints, faces, glass = self._bodies(number)
        forces = self._forces(number)
        casting = film.figure.faces[film.figure.casts == 1]
        places = [self._project(points, number) for points in (corners, forces[0], self._shadow(corners))]
        window = _Window(np.concatenate([flat for flat, _ in places]), film.look.width, film.look.height)
        (flat, depth), (arrow_flat, arrow_depth), (fallen, _) = ((window.inside(one), away) for one, away in places)
        wide, tall = window.fine
        canvas = np.zeros((wide * tall, 4), dtype=np.float32)  # colours times opacity, and opacity
        shadow = seen_triangles(fallen, np.ones(len(fallen)), casting, wide, tall).pixel
        canvas[shadow] = np.append(np.array(SHADOW) * SHADOW_ALPHA, SHADOW_ALPHA)
        solid = seen_triangles(flat, depth, faces[~glass], wide, tall)
        _lay(canvas, solid.pixel, self._colours(number, solid, faces[~glass], corners, normals, tints)[0])
        nearest = np.zeros(wide * tall, dtype=np.float32)
        nearest[solid.pixel] = solid.nearness
        skin = seen_triangles(flat, depth, faces[glass], wide, tall)
        skin = skin.where(skin.nearness > nearest[skin.pixel])
        _lay(canvas, skin.pixel, *self._colours(number, skin, faces[glass], corners, normals, tints))
        arrows = seen_triangles(arrow_flat, arrow_depth, forces[3], wide, tall)
        hidden = nearest[arrows.pixel] > arrows.nearness
        paint, _ = self._colours(number, arrows, forces[3], *forces[:3])
        _lay(canvas, arrows.pixel, paint, np.where(hidden, _THROUGH, 1.0))
        return Patch(_mean(canvas.reshape(tall, wide, 4)), window.left, window.top)

    def _bodies(self, number: int) -> tuple[Floats, Floats, Floats, Integers, NDArray[np.bool_]]:
        """Corners, normals, tints and faces of all bodies and muscles, and which faces are skin."""
        film = self._film
        corners, normals = film.figure.placed(film.position[number], film.orientation[number])
        muscles = film.bellies.drawn(film.muscle_points[number], film.activation[number])
        faces = np.concatenate([film.figure.faces, muscles[3] + len(corners)])
        glass = np.concatenate([film.figure.glass == 1, np.zeros(len(muscles[3]), dtype=bool)])
        return (
            np.concatenate([corners, muscles[0]]),
            np.concatenate([normals, muscles[1]]),
            np.concatenate([film.figure.tints, muscles[2]]),
            faces,
            glass,
        )

    def _forces(self, number: int) -> tuple[Floats, Floats, Floats, Integers]:
        """Corners, normals, tints and faces of the arrows of ground forces."""
        film = self._film
        none = np.zeros((0, 3))
        parts: list[tuple[Floats, Floats, Floats, Integers]] = [(none, none, none, none.astype(np.int64))]
        offset = 0
        for start, tip, tint in zip(film.force_from[number], film.force_to[number], FORCES, strict=True):
            if np.linalg.norm(tip - start) > _LEAST_FORCE:
                corners, normals, faces = arrow(start, tip)
                parts.append((corners, normals, np.tile(tint, (len(corners), 1)), faces + offset))
                offset += len(corners)
        corners, normals, tints, faces = (np.concatenate(part) for part in zip(*parts, strict=True))
        return corners, normals, tints, faces

    def _shadow(self, corners: Floats) -> Floats:
        """Where the shadows of corners (V, 3) fall on the ground."""
        ground = self._film.ground
        height = corners[:, 1] - ground.height_at(corners[:, 0], corners[:, 2])
        fallen = corners - LIGHT * (height / LIGHT[1])[:, None]
        fallen[:, 1] = ground.height_at(fallen[:, 0], fallen[:, 2])
        return np.asarray(fallen)

    def _project(self, points: Floats, number: int) -> tuple[Floats, Floats]:
        """Pixels (n, 2) from the left and the top, and depths (n,), m."""
        look = self._film.look
        flat, depth = self._film.camera.project(points, self._film.followed[number])
        x, y = 0.5 * (look.width + look.height * flat[:, 0]), 0.5 * look.height * (1.0 - flat[:, 1])
        return np.stack([x, y], axis=1), depth

    def _colours(
        self, number: int, seen: Seen, faces: Integers, corners: Floats, normals: Floats, tints: Floats
    ) -> tuple[Floats, Floats]:
        """Colours (n, 3) of pixels, and how much of what is behind they would hide as skin (n,)."""
        every = np.concatenate([corners, normals, tints], axis=1)
        owner, share = faces[seen.face], seen.share
        mixed = sum(share[:, k, None] * every[owner[:, k]] for k in range(3)) + np.zeros((1, 9))
        place, normal, tint = mixed[:, :3], mixed[:, 3:6], mixed[:, 6:]
        normal = normalized(normal, SHORTEST)
        towards = normalized(self._film.camera.eye(self._film.followed[number]) - place, SHORTEST)
        return lit(normal, towards, tint), skin_alpha(normal, towards)


def _lay(canvas: Floats, pixel: Integers, colours: Floats, opacity: Floats | float = 1.0) -> None:
    """Lay colours (n, 3) over pixels of a canvas (m, 4), in place."""
    hidden = np.broadcast_to(np.asarray(opacity, dtype=np.float32), len(pixel))[:, None]
    over = np.concatenate([np.minimum(colours, 1.0), np.ones((len(pixel), 1))], axis=1) * hidden
    canvas[pixel] = canvas[pixel] * (1.0 - hidden) + over


def _mean(fine: Floats) -> NDArray[np.uint8]:
    """A picture of finer pixels, as colours that are not multiplied by their opacity (height, width, 4)."""
    height, width, _ = fine.shape
    mean = fine.reshape(height // _FINER, _FINER, width // _FINER, _FINER, 4).mean(axis=(1, 3))
    mean[..., :3] /= np.maximum(mean[..., 3:], 1e-6)
    return np.asarray(np.round(255.0 * mean), dtype=np.uint8)
