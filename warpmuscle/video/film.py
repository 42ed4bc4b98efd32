"""A motion prepared for a film: what is where at each of its moments, and the camera that follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.limits import check_size
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import normalized
from warpmuscle.core.sequences import at_moments, mirrored
from warpmuscle.gait.cycles import body_weight, steady_strides
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.terrain.surface import Surface, surface
from warpmuscle.video.bellies import Bellies, bellies_of
from warpmuscle.video.camera import Camera, camera_on
from warpmuscle.video.triangles import Triangles, triangles_of
from warpmuscle.view.bones.model_meshes import mesh_folder
from warpmuscle.view.content import continuous
from warpmuscle.view.objects import with_objects
from warpmuscle.view.page import look_of
from warpmuscle.view.track import Track, track_of

TILE = 1.0  # m, of the ground
_SMOOTH = 1.2  # s over which the camera evens out what it follows
_FORCE_LENGTH = 0.7  # m that a force of one body weight is drawn as
_WITHIN = 64  # moments that the camera's distance is chosen from
FEW = 4  # motions in one film up to which figures are drawn finely


@dataclass(frozen=True)
class Look:
    """How a film looks.

    Attributes:
        width, height: px, even numbers. rate: frames a second.
        azimuth: deg, from where the camera looks: 0 from the right side, 90 from the front.
        elevation: deg, from above.
        speed: of the motion in the film; 0.25 is four times slower.
        strides: so many last gait cycles as a film that can be repeated without a jump; 0: the whole motion.
        forces: whether ground forces are drawn. caption: whether name, time and colours are written.
    """

    width: int = 1280
    height: int = 720
    rate: float = 30.0
    azimuth: float = 20.0
    elevation: float = 6.0
    speed: float = 1.0
    strides: int = 0
    forces: bool = True
    caption: bool = True


@dataclass(frozen=True)
class Film:
    """What is drawn, over F frames; places are m, world."""

    name: str
    look: Look
    time: Floats  # (F,) s, of the motion
    followed: Floats  # (F, 3)
    camera: Camera
    bounds: Floats  # (2, 3) m, lowest and highest coordinates of all that is seen, from what is followed
    tile: float  # m
    ground: Surface
    figure: Triangles
    position: Floats  # (F, B, 3) of bodies, and of objects behind them
    orientation: Floats  # (F, B, 4)
    bellies: Bellies
    muscle_points: Floats  # (F, P, 3)
    activation: Floats  # (F, M) 0..1
    force_from: Floats  # (F, 2, 3) where ground forces act
    force_to: Floats  # (F, 2, 3) tips of their arrows
    water: float | None = None  # m, y of its surface

    def corners(self, frame: int) -> Floats:
        """Corners (V, 3) of the figure in a frame, m, world."""
        return self.figure.placed(self.position[frame], self.orientation[frame])[0]


def make_film(
    recording: Recording, scene: Scene, look: Look | None = None, name: str = "", figure: Triangles | None = None
) -> Film:
    """Prepare the film of a motion.

    Args:
        recording: at least two frames. scene: that made it; free parameters count with their start values.
        name: that is written into it, by default the scene's.
        figure: of another film of this scene, which takes a while to make.

    Raises:
        Error: too short a motion, one of another character, or no gait cycles where some are asked for.
    """
    look = look or Look()
    check_look(look)
    track, scene = _prepared(recording, scene, name)
    start, end = float(recording.time[0]), float(recording.time[-1])
    if look.strides:
        cycles = steady_strides(recording, scene)["left"]
        if len(cycles) < look.strides:
            raise Error(
                f"{scene.name}: {number_of(look.strides, 'gait cycle', 'were')} asked for, the steady walk has "
                f"{len(cycles)}"
            )
        start, end = cycles[-look.strides][0], cycles[-1][1]
    frames = max(2, round((end - start) / look.speed * look.rate))
    check_size("film", frames)
    moments = start + np.arange(frames) * (end - start) / frames  # of a film that repeats, the last is not the first
    return _film(track, scene, look, moments, (start, end), figure or figure_of_track(track, scene))


def make_films(motions: Sequence[tuple[str, Recording, Scene]], look: Look) -> list[Film]:
    """Prepare films of the same length and scale, each of a motion with its name, from its begin on.

    One that ends before the others stands still.

    Args:
        look: of each.

    Raises:
        Error: as `make_film`; gait cycles, which differ in length, cannot be shown.
    """
    check_look(look)
    if look.strides:
        raise Error("gait cycles are shown of one motion; of several ones choose times, with --start and --end")
    longest = max(float(recording.time[-1] - recording.time[0]) for _, recording, _ in motions if recording.frames)
    frames = max(2, round(longest / look.speed * look.rate))
    check_size("film", frames)
    passed = np.arange(frames) * look.speed / look.rate
    films = []
    for name, recording, scene in motions:
        track, numeric = _prepared(recording, scene, name)
        span = float(recording.time[0]), float(recording.time[-1])
        figure = figure_of_track(track, numeric, len(motions) > FEW)
        films.append(_film(track, numeric, look, np.minimum(span[0] + passed, span[1]), span, figure))
    low = np.min([film.bounds[0] for film in films], axis=0)
    high = np.max([film.bounds[1] for film in films], axis=0)
    camera = _camera(np.stack([low, high]), look)
    return [replace(film, camera=camera) for film in films]


def _prepared(recording: Recording, scene: Scene, name: str) -> tuple[Track, Scene]:
    """What is shown of a motion, and its scene without free parameters."""
    if recording.frames < 2:
        raise Error("a film needs a motion of at least two frames")
    numeric = at_start(scene)
    return track_of(recording, numeric, name), numeric


def check_look(look: Look) -> None:
    """Raise Error for a look that no film can have."""
    if look.width % 2 or look.height % 2 or not (64 <= look.width <= 7680 and 64 <= look.height <= 4320):
        raise Error(f"a film cannot be {look.width} x {look.height}: even numbers of pixels, 64 to 7680 x 4320")
    if not 1.0 <= look.rate <= 240.0:
        raise Error(f"a film cannot have {look.rate:g} frames a second; 1 to 240 are possible")
    if not 0.001 <= look.speed <= 100.0:
        raise Error(f"a film cannot run at {look.speed:g} times the speed of the motion; 0.001 to 100 are possible")
    if not -89.0 <= look.elevation <= 89.0 or not np.isfinite(look.azimuth):
        raise Error(f"the camera cannot look from {look.elevation:g} degrees above; -89 to 89 are possible")


def figure_of_track(track: Track, scene: Scene, coarse: bool = False) -> Triangles:
    """What bodies look like in a film of a scene without free parameters; `coarse` if they are small in it."""
    return triangles_of(look_of(track.doll, scene, coarse, mesh_folder(None, scene)))


def _film(
    track: Track, scene: Scene, look: Look, moments: Floats, span: tuple[float, float], figure: Triangles
) -> Film:  # fmt: skip
    recording = track.recording
    time = recording.time.astype(float)
    places = [recording.body_position, *(one.position[:, None] for one in track.objects)]
    position = at_moments(time, np.concatenate(places, axis=1), moments)
    orientation = at_moments(time, continuous(with_objects(recording.body_orientation, track.objects)), moments)
    force = track.foot_force * (_FORCE_LENGTH / body_weight(scene)) * look.forces
    ground = surface(scene.ground)
    followed, tile = _followed(recording, ground, span if look.strides else None)
    film = Film(
        name=track.label,
        look=look,
        time=moments,
        followed=at_moments(time, followed, moments),
        camera=_camera(np.zeros((2, 3)), look),
        bounds=np.zeros((2, 3)),
        tile=tile,
        ground=ground,
        figure=figure,
        position=position,
        orientation=normalized(orientation),
        bellies=bellies_of(track.doll, scene),
        muscle_points=at_moments(time, track.muscle_points(), moments),
        activation=at_moments(time, recording.muscle_activation, moments),
        force_from=at_moments(time, track.foot_center, moments),
        force_to=at_moments(time, track.foot_center + force, moments),
        water=None if scene.water is None else first_number(scene.water.level),
    )
    bounds = _bounds(film, len(recording.body_names))
    return replace(film, bounds=bounds, camera=_camera(bounds, look))


def _bounds(film: Film, bodies: int) -> Floats:
    """Lowest and highest coordinates (2, 3) of bodies and muscles, m, from what is followed, over the film."""
    own = film.figure.body < bodies  # objects may be far away
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for frame in range(0, len(film.time), max(1, len(film.time) // _WITHIN)):
        for points in (film.corners(frame)[own], film.muscle_points[frame]):
            if len(points):
                low = np.minimum(low, points.min(axis=0) - film.followed[frame])
                high = np.maximum(high, points.max(axis=0) - film.followed[frame])
    return np.stack([low, high]) if np.all(np.isfinite(low)) else np.array([[-0.5] * 3, [0.5] * 3])


def _camera(bounds: Floats, look: Look) -> Camera:
    """A camera that sees all within bounds (2, 3), m, from what it follows."""
    corners = np.stack(np.meshgrid(*bounds.T, indexing="ij"), axis=-1).reshape(-1, 3)
    return camera_on(corners, np.radians(look.azimuth), np.radians(look.elevation), look.width / look.height)


def _followed(recording: Recording, ground: Surface, repeated: tuple[float, float] | None) -> tuple[Floats, float]:
    """What the camera follows (F, 3), m, on the ground, and the length of a tile, m.

    In a film that is repeated it moves evenly, and a whole number of tiles from its begin to its end.
    """
    time, com = recording.time.astype(float), recording.com.astype(float)
    com[:, 1] = ground.height_at(com[:, 0], com[:, 2])
    if repeated is not None:
        first, last = at_moments(time, com, np.array(repeated))
        part = (time - repeated[0]) / (repeated[1] - repeated[0])
        advance = float(abs(last[2] - first[2]))
        tile = advance / max(1, round(advance / (2.0 * TILE))) / 2.0 if advance > TILE else TILE
        return first + part[:, None] * (last - first), tile
    interval = (time[-1] - time[0]) / (len(time) - 1)
    half = min(int(0.5 * _SMOOTH / interval), len(time) - 1)
    if half == 0:
        return com, TILE
    summed = np.concatenate([np.zeros((1, 3)), np.cumsum(mirrored(com, half), axis=0)])
    width = 2 * half + 1
    return (summed[width:] - summed[:-width]) / width, TILE
