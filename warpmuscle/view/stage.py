"""Bipeds as objects of a viser server's scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Ground
from warpmuscle.scene.ground import plane
from warpmuscle.view import instances, meshes
from warpmuscle.view.colors import COM, PUSH, Bytes
from warpmuscle.view.instances import Instances, Moment, moments_of
from warpmuscle.view.parts import Kind, turn_from_y
from warpmuscle.view.track import Track

KINDS: tuple[Kind, ...] = ("sphere", "cylinder", "box")
GLASS, GHOST = 0.6, 0.35  # opacity of shapes over muscles, and of the desired pose
PATH_POINTS = 200
PUSH_LENGTH = 0.02  # m per N s
SHOWN = {
    "muscles": True, "shapes": True, "bones": True, "desired pose": False, "ground forces": True,
    "centre of mass": True, "shadows": False, "follow": True,
}  # fmt: skip
Draw = Callable[[Moment], Instances]


class Stage:
    """What a server shows of several tracks at a moment.

    Attributes:
        handles: viser's handles, by what they show: the words of `SHOWN`, each a list.
        world: viser's handle of the frame of what does not move, which is moved instead of the camera that follows.
    """

    def __init__(self, server: Any, tracks: Sequence[Track], offsets: Floats, ground: Ground) -> None:
        """Put the first moment of tracks, moved by offsets (n, 3), m, on the server's scene."""
        self._server, self._offsets = server, offsets
        self.shown = dict(SHOWN)
        self._middle = np.zeros(3)  # m, of what the camera follows, on the ground
        self.handles: dict[str, list[Any]] = {name: [] for name in SHOWN}
        self._drawn: list[tuple[str, Any, Draw]] = []
        server.scene.set_up_direction("+y")
        server.scene.configure_default_lights(cast_shadow=self.shown["shadows"])
        self.world = server.scene.add_frame("/world", show_axes=False)
        self._ground: Any = None
        self._add_ground(ground)
        frames = [0] * len(tracks)
        first = moments_of(tracks, frames, offsets)
        glass = GLASS if any(track.doll.muscles.names for track in tracks) else None
        for kind in KINDS:
            self._add("shapes", kind, first, _body_draw(kind, bones=False), glass, flat=kind == "box")
        self._add("bones", "cylinder", first, _body_draw("cylinder", bones=True))
        self._add("muscles", "cylinder", first, instances.muscles)
        for kind in KINDS:
            self._add("desired pose", kind, first, _desired_draw(kind), GHOST, flat=kind == "box")
        self._add("ground forces", "cylinder", first, lambda moment: instances.arrows(moment)[0])
        self._add("ground forces", "cone", first, lambda moment: instances.arrows(moment)[1])
        self._add("centre of mass", "sphere", first, instances.mass_center)
        self.paths = [self._add_path(number, track) for number, track in enumerate(tracks)]
        self.labels = [self._add_label(number, track) for number, track in enumerate(tracks) if len(tracks) > 1]
        self.show(tracks, frames)

    def _add_ground(self, ground: Ground) -> None:
        if float(np.asarray(ground.stiffness)) <= 0.0:
            return
        self._ground = self._server.scene.add_grid(
            "/world/ground", plane="xz", infinite_grid=True, cell_size=0.5, section_size=5.0, fade_distance=40.0,
            plane_color=(226, 231, 237), plane_opacity=1.0, cell_color=(205, 212, 220), section_color=(165, 175, 187),
        )  # fmt: skip
        self.move_ground(ground)

    def move_ground(self, ground: Ground) -> None:
        """Show the ground where it is now."""
        if self._ground is not None:
            normal, height = plane(ground)
            self._ground.wxyz = wxyz(turn_from_y(normal))
            self._ground.position = normal * height - 0.002 * normal

    def _add(
        self, what: str, kind: str, moments: Sequence[Moment], draw: Draw,
        opacity: float | None = None, flat: bool = False,
    ) -> None:  # fmt: skip
        """Add one batch of instances, unless there are none."""
        first = _joined(draw, moments)
        if not len(first):
            return
        mesh = {"sphere": meshes.sphere(), "cylinder": meshes.tube(), "box": meshes.box(), "cone": meshes.tube(16, 0.0)}
        corners, faces = mesh[kind]
        handle = self._server.scene.add_batched_meshes_simple(
            f"/{what.replace(' ', '_')}/{kind}", corners, faces, wxyz(first.orientation), first.position,
            batched_scales=first.size, batched_colors=dimmed(first.color), opacity=opacity, flat_shading=flat,
            lod="off",
            side="double" if kind == "cone" else "front", receive_shadow=False,
            cast_shadow=what == "shapes", visible=self.shown[what],
        )  # fmt: skip
        self.handles[what].append(handle)
        self._drawn.append((what, handle, draw))

    def _add_path(self, number: int, track: Track) -> Any:
        handle = self._server.scene.add_line_segments(
            f"/world/centre_of_mass/path{number}", self._path(track, number), COM, thickness=0.012
        )
        self.handles["centre of mass"].append(handle)
        return handle

    def _path(self, track: Track, number: int) -> Floats:
        """Segments (n, 2, 3) of the way of the centre of mass, m; at least one."""
        points = track.recording.com[:: max(1, track.frames // PATH_POINTS)] + self._offsets[number]
        points = np.concatenate([points, points[-1:]])
        return np.asarray(np.stack([points[:-1], points[1:]], axis=1), dtype=np.float32)

    def _add_label(self, number: int, track: Track) -> Any:
        return self._server.scene.add_label(f"/label{number}", track.label, anchor="bottom-center")

    def show_push(self, place: Floats, impulse: Floats) -> Any:
        """An arrow that ends at a place (3,), m, as long as the impulse (3,), N s, is great; to be removed in time."""
        arrow = np.stack([place - PUSH_LENGTH * impulse, place])[None] - self._middle
        return self._server.scene.add_arrows(
            "/push", arrow.astype(np.float32), PUSH, shaft_radius=0.02, head_radius=0.05, head_length=0.12
        )

    def toggle(self, what: str, on: bool) -> None:
        """Show or hide what one of the words of `SHOWN` names, or follow or not."""
        self.shown[what] = on
        if what == "shadows":  # they cost most of all where there is no graphics card
            self._server.scene.configure_default_lights(cast_shadow=on)
        for handle in self.handles[what]:
            handle.visible = on

    def extend_path(self, tracks: Sequence[Track]) -> None:
        """Draw the way of the centre of mass along these tracks instead."""
        for number, (handle, track) in enumerate(zip(self.paths, tracks, strict=True)):
            handle.points = self._path(track, number)

    def show(self, tracks: Sequence[Track], frames: Sequence[int]) -> None:
        """Bring all objects that are to be seen to a frame of each track."""
        com = np.array([track.recording.com[frame] for track, frame in zip(tracks, frames, strict=True)], dtype=float)
        with self._server.atomic():
            if self.shown["follow"]:
                self._middle = (com + self._offsets).mean(axis=0) * np.array([1.0, 0.0, 1.0])
                self.world.position = -self._middle
            moments = moments_of(tracks, frames, self._offsets - self._middle)
            for what, handle, draw in self._drawn:
                if self.shown[what]:
                    now = _joined(draw, moments)
                    handle.batched_positions = now.position.astype(np.float32)
                    handle.batched_wxyzs = wxyz(now.orientation).astype(np.float32)
                    if what in ("muscles", "ground forces"):
                        handle.batched_scales = now.size.astype(np.float32)
                    if what == "muscles":
                        handle.batched_colors = dimmed(now.color)
            for label, place, offset in zip(self.labels, com, self._offsets, strict=False):
                label.position = place + offset - self._middle + np.array([0.0, 0.85, 0.0])


def dimmed(color: Bytes) -> Bytes:
    """Colours (..., 3) that viser's lights make as bright as they were meant."""
    return np.asarray(0.72 * color, dtype=np.uint8)


def wxyz(orientation: Floats) -> Floats:
    """Quaternions (..., 4) with the scalar first, as viser has them."""
    return np.roll(orientation, 1, axis=-1)


def _joined(draw: Draw, moments: Sequence[Moment]) -> Instances:
    return instances.joined([draw(moment) for moment in moments])


def _body_draw(kind: Kind, bones: bool) -> Draw:
    return lambda moment: instances.solids(moment, kind, bones)


def _desired_draw(kind: Kind) -> Draw:
    return lambda moment: instances.desired(moment, kind)
