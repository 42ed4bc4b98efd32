"""Draws the frames of a film without a screen: the ground and words with matplotlib, what stands there as triangles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.plots.style import matplotlib
from warpmuscle.scene.terrain.mesh import in_world, mesh_of
from warpmuscle.scene.terrain.surface import Lie
from warpmuscle.video.camera import VIEW
from warpmuscle.video.colours import HORIZON, LIGHT, TILES, WATER, WATER_ALPHA, ZENITH, activation_colours
from warpmuscle.video.film import Film
from warpmuscle.video.standing import Standing

_FAR = 24  # tiles of ground to each side of what is followed
_FADE = (5.0, 22.0)  # m from the middle over which the ground fades into the horizon
_STEEP = 10.0  # m from the middle within which ground that is not flat is drawn
_LINES = 120  # of its mesh, along each axis
_SLOPE_SHADE = 0.9  # how much darker faces are that are inclined
_ZENITH = 0.9  # of half the picture's height above the horizon, at which the sky is darkest
_TEXT = "#3A4650"
_NARROW = 1.3  # width over height


def muscle_colors(count: int = 48) -> Floats:
    """Colours (count, 3), 0..1, of activations from 0 to 1."""
    return activation_colours(np.linspace(0.0, 1.0, count))


class Painter:
    """A page that shows one frame of a film after the other."""

    def __init__(self, film: Film, colors: bool = True) -> None:
        """Prepare the page, with a scale of colours or without; raises Error without matplotlib."""
        matplotlib()
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.collections import PolyCollection
        from matplotlib.figure import Figure

        self._film, look = film, film.look
        dpi = 72.0 * look.height / 480.0  # a point of text is 1/480 of the height
        figure = Figure(figsize=(look.width / dpi, look.height / dpi), dpi=dpi, facecolor=HORIZON)
        self._canvas: Any = FigureCanvasAgg(figure)
        aspect = look.width / look.height
        ground, axes = (figure.add_axes((0.0, 0.0, 1.0, 1.0), zorder=order, facecolor="none") for order in (0, 2))
        for each in (ground, axes):
            each.set(xlim=(-aspect, aspect), ylim=(-1.0, 1.0))
            each.set_axis_off()
        _sky(ground, film, aspect)
        # Without smooth edges, between which what lies behind would be seen.
        self._ground: Any = PolyCollection([], linewidths=0.0, zorder=1, antialiased=False)
        self._surface: Any = PolyCollection([], linewidths=0.0, zorder=1, antialiased=False)
        ground.add_collection(self._ground, autolim=False)
        axes.add_collection(self._surface, autolim=False)
        self._standing = Standing(film)
        self._patch = figure.figimage(np.zeros((1, 1, 4), dtype=np.uint8), zorder=1, origin="upper")
        narrow = aspect < _NARROW  # then there is no room beside the scale of colours
        letters = len(self._caption(len(film.time) - 1))
        size = min(15.0, (480.0 * aspect - 30.0) / (0.62 * letters))  # a letter is some 0.62 of its size wide
        self._clock = axes.text(
            -aspect + 0.06, 0.9 if narrow else -0.94, "", size=size, color=_TEXT, zorder=5, parse_math=False
        )
        if colors and look.caption and film.activation.shape[1]:
            _scale(axes, aspect)

    def frame(self, number: int) -> NDArray[np.uint8]:
        """Frame (height, width, 3)."""
        film = self._film
        tiles, shades = self._tiles(number)
        self._ground.set_verts(tiles)
        self._ground.set_facecolor(shades)
        patch = self._standing.picture(number)
        self._patch.set_data(patch.colours)
        self._patch.ox, self._patch.oy = patch.left, film.look.height - patch.top - len(patch.colours)
        if film.water is not None:
            surface, shades = self._water(film.water, number)
            self._surface.set_verts(surface)
            self._surface.set_facecolor(shades)
        if film.look.caption:
            self._clock.set_text(self._caption(number))
        self._canvas.draw()
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()

    def _caption(self, number: int) -> str:
        return f"{self._film.name}   {self._film.time[number]:.2f} s"

    def _project(self, points: Floats, number: int) -> tuple[Floats, Floats]:
        flat, depth = self._film.camera.project(points.reshape(-1, 3), self._film.followed[number])
        return flat.reshape(*points.shape[:-1], 2), depth.reshape(points.shape[:-1])

    def _tiles(self, number: int) -> tuple[Floats, Floats]:
        """Squares of the ground about what is followed, in colours that fade into the horizon."""
        film = self._film
        if film.ground.lie is not None:
            return self._terrain(film.ground.lie, number)
        x, _, z = film.followed[number]
        column, row = np.meshgrid(np.arange(-_FAR, _FAR), np.arange(-_FAR, _FAR), indexing="ij")
        column, row = column.ravel() + round(x / film.tile), row.ravel() + round(z / film.tile)
        corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        places = (np.stack([column, row], axis=-1)[:, None] + corner) * film.tile  # (n, 4, 2)
        across, along = places[..., 0], places[..., 1]
        points = np.stack([across, film.ground.height_at(across, along), along], axis=-1)
        flat, depth = self._project(points, number)
        distance = np.linalg.norm(places.mean(axis=1) - np.array([x, z]), axis=1)
        fade = np.clip((distance - _FADE[0]) / (_FADE[1] - _FADE[0]), 0.0, 1.0)[:, None]
        colors = (1.0 - fade) * np.array(TILES)[(column + row) % 2] + fade * np.array(HORIZON)
        seen = (depth.min(axis=1) > 0.1) & (fade[:, 0] < 1.0)
        return flat[seen], colors[seen]

    def _terrain(self, lie: Lie, number: int) -> tuple[Floats, Floats]:
        """Faces of ground that is not flat, from the farthest on, darker where they are turned from the light."""
        film = self._film
        middle = film.followed[number][[0, 2]]
        mesh = mesh_of(lie, middle - _STEEP, middle + _STEEP, _LINES, film.tile)
        points = in_world(lie, mesh, film.ground)
        faces = np.stack([points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]], axis=2).reshape(-1, 4, 3)
        normal = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
        normal *= np.sign(normal[:, 1:2]) / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        shade = np.clip(1.0 + _SLOPE_SHADE * (normal @ LIGHT - LIGHT[1]), 0.5, 1.08)[:, None]
        place = faces.mean(axis=1)
        dark = (np.floor(place[:, 0] / film.tile) + np.floor(place[:, 2] / film.tile)) % 2 == 0
        tone = np.where(dark[:, None], np.array(TILES[0]), np.array(TILES[1]))
        away = np.linalg.norm(place[:, [0, 2]] - middle, axis=1)
        fade = np.clip((away - _FADE[0]) / (_STEEP - _FADE[0]), 0.0, 1.0)
        colors = np.minimum((1.0 - fade)[:, None] * tone * shade + fade[:, None] * np.array(HORIZON), 1.0)
        flat, depth = self._project(faces, number)
        seen = np.flatnonzero((depth.min(axis=1) > 0.1) & (fade < 1.0))
        order = seen[np.argsort(-depth[seen].mean(axis=1), kind="stable")]
        return flat[order], colors[order]

    def _water(self, level: float, number: int) -> tuple[Floats, Floats]:
        """Squares of the surface of water, through which all below it is seen."""
        x, _, z = self._film.followed[number]
        edge = np.arange(-_FADE[1], _FADE[1] + 1.0)
        corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        places = np.stack(np.meshgrid(edge, edge, indexing="ij"), axis=-1).reshape(-1, 1, 2) + corner + [x, z]
        points = np.stack([places[..., 0], np.full(places.shape[:2], level), places[..., 1]], axis=-1)
        flat, depth = self._project(points, number)
        distance = np.linalg.norm(places.mean(axis=1) - np.array([x, z]), axis=1)
        fade = np.clip((distance - _FADE[0]) / (_FADE[1] - _FADE[0]), 0.0, 1.0)
        seen = (depth.min(axis=1) > 0.1) & (fade < 1.0)
        tone = np.broadcast_to(WATER, (len(fade), 3))
        return flat[seen], np.column_stack([tone, WATER_ALPHA * (1.0 - fade)])[seen]


def _sky(axes: Any, film: Film, aspect: float) -> None:
    """The sky, darker from the horizon upwards, as far as the camera sees any."""
    level = np.tan(np.radians(film.look.elevation)) / np.tan(0.5 * VIEW)
    if not -1.0 < level < 1.0:
        return
    part = np.clip((np.linspace(level, 1.0, 128) - level) / _ZENITH, 0.0, 1.0)[:, None]
    tones = (1.0 - part) * np.array(HORIZON) + part * np.array(ZENITH)
    axes.imshow(tones[:, None], extent=(-aspect, aspect, level, 1.0), aspect="auto", origin="lower", zorder=0)
    axes.set(xlim=(-aspect, aspect), ylim=(-1.0, 1.0))


def _scale(axes: Any, aspect: float) -> None:
    """What the colours of muscles mean."""
    left, bottom, width, height = aspect - 0.72, -0.925, 0.5, 0.035
    axes.imshow(muscle_colors(256)[None], extent=(left, left + width, bottom, bottom + height), aspect="auto", zorder=5)
    axes.set(xlim=(-aspect, aspect), ylim=(-1.0, 1.0))
    for x, text, side in ((left - 0.03, "activation 0", "right"), (left + width + 0.03, "1", "left")):
        axes.text(x, bottom - 0.008, text, size=13.0, ha=side, color=_TEXT, zorder=5)
