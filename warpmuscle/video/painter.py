"""Draws the frames of a film with matplotlib, without a screen: everything is outlines, the farthest first."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.plots.style import matplotlib
from warpmuscle.scene.anatomy import convex_hull
from warpmuscle.scene.terrain.mesh import in_world, mesh_of
from warpmuscle.scene.terrain.surface import Lie
from warpmuscle.video.film import Film
from warpmuscle.video.solids import faces, outlines

MUSCLES = "plasma"  # colours of activation
_SIDE_TINTS = {"left": (0.70, 0.82, 0.92), "right": (0.96, 0.83, 0.73), "middle": (0.84, 0.86, 0.88),
               "object": (0.84, 0.74, 0.57)}  # fmt: skip
_BONE_TINT, _DEVICE_TINT = (0.93, 0.91, 0.86), (0.2, 0.24, 0.28)
SKY, _TILE, _SHADOW = (0.957, 0.965, 0.973), (0.862, 0.88, 0.898), (0.745, 0.77, 0.795)
FORCE_TINTS = ((0.0, 0.38, 0.62), (0.76, 0.31, 0.0))  # left, right
_WATER, _CLEAR = (0.30, 0.56, 0.76), 0.4  # and how much of what is below it its surface hides
_LEVELS = 5  # of shade on a round surface
_LIGHT = np.array([-0.45, 0.8, -0.4])  # from where the light comes: left, up and towards the eye in the picture
_SHADOW_LEAN = (0.35, 0.12)  # m to the left and forwards that the shadow of a point 1 m high falls
_MUSCLE_RADIUS = (0.005, 0.018)  # m, without force and with the greatest
_IN_FRONT = 0.11  # m that muscles count as nearer than they are, so that their own limb does not hide them
_FAR = 22  # tiles of ground to each side of what is followed
_FADE = (3.0, 10.0)  # m from the middle over which the ground fades into the sky
_LINES = 120  # of the mesh of ground that is not flat, along each axis
_SUN = np.array([-0.39, 0.87, 0.3])  # from where light comes on these faces: from the right, above and the front
_SLOPE_SHADE = 0.9  # how much darker faces are that are inclined
_LEAST_FORCE = 0.03  # m, shorter arrows are not drawn
_TEXT = "#3A4650"
_NARROW = 1.3  # width over height


def muscle_colors(count: int = 48) -> Floats:
    """Colours (count, 3), 0..1, of activations from 0 to 1."""
    from matplotlib import colormaps

    return np.asarray(colormaps[MUSCLES](np.linspace(0.0, 1.0, count))[:, :3])


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
        figure = Figure(figsize=(look.width / dpi, look.height / dpi), dpi=dpi, facecolor=SKY)
        self._canvas: Any = FigureCanvasAgg(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        aspect = look.width / look.height
        axes.set(xlim=(-aspect, aspect), ylim=(-1.0, 1.0))
        axes.set_axis_off()
        self._colors = muscle_colors(256)
        self._layers: list[Any] = [PolyCollection([], linewidths=0.0, zorder=order) for order in range(3)]
        self._layers.append(PolyCollection([], linewidths=0.0, zorder=3, antialiased=False))  # of water, without seams
        for layer in self._layers:
            axes.add_collection(layer, autolim=False)
        narrow = aspect < _NARROW  # then there is no room beside the scale of colours
        letters = len(self._caption(len(film.time) - 1))
        size = min(15.0, (480.0 * aspect - 30.0) / (0.62 * letters))  # a letter is some 0.62 of its size wide
        self._clock = axes.text(
            -aspect + 0.06, 0.9 if narrow else -0.94, "", size=size, color=_TEXT, zorder=5, parse_math=False
        )
        if colors and look.caption and film.activation.shape[1]:
            _scale(axes, aspect, self._colors)

    def frame(self, number: int) -> NDArray[np.uint8]:
        """Frame (height, width, 3)."""
        film = self._film
        tiles, shades = self._tiles(number)
        self._layers[0].set_verts(tiles)
        self._layers[0].set_facecolor(shades)
        self._layers[1].set_verts(self._shadows(number))
        self._layers[1].set_facecolor(_SHADOW)
        shapes, colors, depth = (np.concatenate(part) for part in zip(*self._parts(number), strict=True))
        order = np.argsort(-depth, kind="stable")
        self._layers[2].set_verts(shapes[order])
        self._layers[2].set_facecolor(colors[order])
        if film.water is not None:
            surface, shades = self._water(film.water, number)
            self._layers[3].set_verts(surface)
            self._layers[3].set_facecolor(shades)
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
        """Every other square of the ground about what is followed, in colours that fade into the sky."""
        film = self._film
        if film.ground.lie is not None:
            return self._terrain(film.ground.lie, number)
        x, _, z = film.followed[number]
        column, row = np.meshgrid(np.arange(-_FAR, _FAR), np.arange(-_FAR, _FAR), indexing="ij")
        column, row = column.ravel() + round(x / film.tile), row.ravel() + round(z / film.tile)
        column, row = (index[(column + row) % 2 == 0] for index in (column, row))
        corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        places = (np.stack([column, row], axis=-1)[:, None] + corner) * film.tile  # (n, 4, 2)
        across, along = places[..., 0], places[..., 1]
        points = np.stack([across, film.ground.height_at(across, along), along], axis=-1)
        flat, depth = self._project(points, number)
        distance = np.linalg.norm(places.mean(axis=1) - np.array([x, z]), axis=1)
        fade = np.clip((distance - _FADE[0]) / (_FADE[1] - _FADE[0]), 0.0, 1.0)[:, None]
        colors = (1.0 - fade) * np.array(_TILE) + fade * np.array(SKY)
        seen = (depth.min(axis=1) > 0.1) & (fade[:, 0] < 1.0)
        return flat[seen], colors[seen]

    def _terrain(self, lie: Lie, number: int) -> tuple[Floats, Floats]:
        """Faces of ground that is not flat, from the farthest on, darker where they are turned from the light."""
        film = self._film
        middle = film.followed[number][[0, 2]]
        mesh = mesh_of(lie, middle - _FADE[1], middle + _FADE[1], _LINES, film.tile)
        points = in_world(lie, mesh, film.ground)
        faces = np.stack([points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]], axis=2).reshape(-1, 4, 3)
        normal = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
        normal *= np.sign(normal[:, 1:2]) / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        shade = np.clip(1.0 + _SLOPE_SHADE * (normal @ _SUN - _SUN[1]), 0.5, 1.08)[:, None]
        place = faces.mean(axis=1)
        dark = (np.floor(place[:, 0] / film.tile) + np.floor(place[:, 2] / film.tile)) % 2 == 0
        tone = np.where(dark[:, None], np.array(_TILE), 0.5 * (np.array(_TILE) + np.array(SKY)))
        fade = np.clip((np.linalg.norm(place[:, [0, 2]] - middle, axis=1) - _FADE[0]) / (_FADE[1] - _FADE[0]), 0.0, 1.0)
        colors = np.minimum((1.0 - fade)[:, None] * tone * shade + fade[:, None] * np.array(SKY), 1.0)
        flat, depth = self._project(faces, number)
        seen = np.flatnonzero((depth.min(axis=1) > 0.1) & (fade < 1.0))
        order = seen[np.argsort(-depth[seen].mean(axis=1), kind="stable")]
        return flat[order], colors[order]

    def _water(self, level: float, number: int) -> tuple[Floats, Floats]:
        """Squares of the surface of water, through which all below it is seen."""
        x, _, z = self._film.followed[number]
        edge = np.arange(-_FADE[1], _FADE[1])
        corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        places = np.stack(np.meshgrid(edge, edge, indexing="ij"), axis=-1).reshape(-1, 1, 2) + corner + [x, z]
        points = np.stack([places[..., 0], np.full(places.shape[:2], level), places[..., 1]], axis=-1)
        flat, depth = self._project(points, number)
        distance = np.linalg.norm(places.mean(axis=1) - np.array([x, z]), axis=1)
        fade = np.clip((distance - _FADE[0]) / (_FADE[1] - _FADE[0]), 0.0, 1.0)
        seen = (depth.min(axis=1) > 0.1) & (fade < 1.0)
        tone = np.broadcast_to(_WATER, (len(fade), 3))
        return flat[seen], np.column_stack([tone, _CLEAR * (1.0 - fade)])[seen]

    def _shadows(self, number: int) -> list[Floats]:
        """Outlines of the solids' shadows."""
        film = self._film
        ends, corners = film.capsule_ends[number].copy(), film.box_corners[number].copy()
        ring = np.linspace(0.0, 2.0 * np.pi, 10, endpoint=False)
        circle = np.stack([np.cos(ring), 0.0 * ring, np.sin(ring)], axis=-1)
        rims = ends[:, :, None] + film.capsules.radius[:, None, None, None] * circle
        found = []
        for points in (*rims.reshape(len(rims), -1, 3), *corners):
            height = points[:, 1] - film.ground.height_at(points[:, 0], points[:, 2])
            points[:, 0] += _SHADOW_LEAN[0] * height
            points[:, 2] += _SHADOW_LEAN[1] * height
            points[:, 1] = film.ground.height_at(points[:, 0], points[:, 2])
            found.append(convex_hull(self._project(points, number)[0]))
        return found

    def _parts(self, number: int) -> list[tuple[Floats, Floats, Floats]]:
        """Outlines (n, k, 2), colours (n, 3) and depths (n,) of all that stands on the ground."""
        return [self._capsules(number), self._boxes(number), self._muscles(number), self._forces(number)]

    def _capsules(self, number: int) -> tuple[Floats, Floats, Floats]:
        film = self._film
        kinds = zip(film.capsules.side, film.capsules.bone, film.capsules.device, strict=True)
        tints = np.array(
            [_BONE_TINT if bone else _DEVICE_TINT if own else _SIDE_TINTS[side] for side, bone, own in kinds]
        )
        flat, depth = self._project(film.capsule_ends[number], number)
        radius = film.capsules.radius[:, None] * film.camera.scale(depth)
        # Bones are within what is around them, and devices around it.
        away = depth.mean(axis=1) + _IN_FRONT * (film.capsules.bone.astype(float) - film.capsules.device)
        return _shaded(flat, radius, tints.reshape(-1, 3), away)

    def _boxes(self, number: int) -> tuple[Floats, Floats, Floats]:
        film = self._film
        length = outlines(np.zeros((1, 2, 2)), np.ones((1, 2))).shape[1]
        shapes, colors, depths = [np.zeros((0, length, 2))], [np.zeros((0, 3))], [np.zeros(0)]
        light = np.stack([film.camera.right, film.camera.up, film.camera.forward], axis=1) @ _LIGHT
        for corners, side in zip(film.box_corners[number], film.boxes.side, strict=True):
            sides = faces(corners)
            flat, depth = self._project(sides, number)
            a, b = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 1]
            normal = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 1])
            normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
            bright = 0.78 + 0.22 * np.clip(normal @ light, -1.0, 1.0)
            seen = a[:, 0] * b[:, 1] > a[:, 1] * b[:, 0]  # from outside
            padded = np.concatenate([flat, np.repeat(flat[:, -1:], length - 4, axis=1)], axis=1)
            shapes.append(padded[seen])
            colors.append((bright[:, None] * np.array(_SIDE_TINTS[side]))[seen])
            depths.append(np.full(int(seen.sum()), depth.mean()))
        return np.concatenate(shapes), np.concatenate(colors), np.concatenate(depths)

    def _muscles(self, number: int) -> tuple[Floats, Floats, Floats]:
        """Each piece of a muscle between via points as a dark and over it a coloured line."""
        film = self._film
        start = film.muscle_start
        inner = np.ones(len(film.muscle_points[number]), dtype=bool)
        inner[start[1:][np.diff(start) > 0] - 1] = False  # a muscle may act without a path
        first = np.flatnonzero(inner)
        owner = np.searchsorted(start, first, side="right") - 1
        pieces = np.stack([film.muscle_points[number][first], film.muscle_points[number][first + 1]], axis=1)
        flat, depth = self._project(pieces, number)
        thin, thick = _MUSCLE_RADIUS
        radius = (thin + (thick - thin) * film.load[number, owner])[:, None] * film.camera.scale(depth)
        level = np.clip(film.activation[number, owner] * 255.0, 0.0, 255.0).astype(int)
        pieces_of = np.maximum(np.bincount(owner, minlength=len(start) - 1), 1)
        away = (np.bincount(owner, depth.mean(axis=1), len(start) - 1) / pieces_of)[owner] - _IN_FRONT
        shapes, colors, depths = _shaded(flat, radius, self._colors[level], away)
        return shapes, colors, depths

    def _forces(self, number: int) -> tuple[Floats, Floats, Floats]:
        """Arrows of the ground forces."""
        film = self._film
        begin, tip = film.force_from[number], film.force_to[number]
        shown = np.linalg.norm(tip - begin, axis=1) > _LEAST_FORCE
        flat, depth = self._project(np.stack([begin, tip], axis=1)[shown], number)
        tints, scale = np.array(FORCE_TINTS)[shown], film.camera.scale(depth)
        along = flat[:, 1] - flat[:, 0]
        unit = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
        head = np.minimum(0.07 * scale[:, 1:], np.linalg.norm(along, axis=1, keepdims=True))
        neck = flat[:, 1] - unit * head
        shafts = outlines(np.stack([flat[:, 0], neck], axis=1), 0.009 * scale)
        across = np.stack([-unit[:, 1], unit[:, 0]], axis=1) * head * 0.45
        heads = np.stack([neck + across, neck - across, flat[:, 1]], axis=1)
        heads = np.concatenate([heads, np.repeat(heads[:, -1:], shafts.shape[1] - 3, axis=1)], axis=1)
        near = depth.min(axis=1) - 2.0 * _IN_FRONT
        return np.concatenate([shafts, heads]), np.concatenate([tints, tints]), np.concatenate([near, near])


def _shaded(flat: Floats, radius: Floats, tints: Floats, depth: Floats) -> tuple[Floats, Floats, Floats]:
    """Round things as outlines within outlines, the lighter the nearer to the light.

    Args:
        flat: (n, 2, 2) ends in the picture. radius: (n, 2). tints: (n, 3) colours. depth: (n,)
    """
    shapes, colors, depths = [], [], []
    for level in range(_LEVELS):
        part = level / (_LEVELS - 1)
        moved = flat + 0.42 * part * radius[..., None] * _LIGHT[:2]
        shapes.append(outlines(moved, radius * (1.0 - 0.75 * part)))
        colors.append(np.clip(tints * (0.62 + 0.40 * np.sqrt(part)) + 0.05 * part**2, 0.0, 1.0))
        depths.append(depth - 1e-6 * level)
    # Thing by thing, so that things at the same depth do not mix their shades.
    return tuple(np.stack(part, axis=1).reshape(-1, *part[0].shape[1:]) for part in (shapes, colors, depths))  # type: ignore[return-value]


def _scale(axes: Any, aspect: float, colors: Floats) -> None:
    """What the colours of muscles mean."""
    left, bottom, width, height = aspect - 0.72, -0.925, 0.5, 0.035
    axes.imshow(colors[None], extent=(left, left + width, bottom, bottom + height), aspect="auto", zorder=5)
    axes.set(xlim=(-aspect, aspect), ylim=(-1.0, 1.0))
    for x, text, side in ((left - 0.03, "activation 0", "right"), (left + width + 0.03, "1", "left")):
        axes.text(x, bottom - 0.008, text, size=13.0, ha=side, color=_TEXT, zorder=5)
