"""A replay as one HTML page that needs nothing but a browser: no network, no other file."""

from __future__ import annotations

import html
import pickle
import webbrowser
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.resources import files
from os import PathLike
from pathlib import Path
from tempfile import mkdtemp
from threading import Thread
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace

from warpmuscle.core.arguments import as_path
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, lacking
from warpmuscle.core.files import replace_file
from warpmuscle.core.number_rows import first_number
from warpmuscle.results.partial_motion import demanding
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.ground import plane
from warpmuscle.scene.initial_pose import world_poses
from warpmuscle.scene.parameters import at_start
from warpmuscle.view.access import POLICY, POLICY_OF_FILES
from warpmuscle.view.bones.attachments import attachments
from warpmuscle.view.bones.model_meshes import mesh_folder, with_meshes
from warpmuscle.view.content import doll_content, piece_contents, track_content
from warpmuscle.view.crowd import Facts, facts_content, shades_of
from warpmuscle.view.figure import figure_of
from warpmuscle.view.lanes import BESIDE, lanes
from warpmuscle.view.objects import object_pieces
from warpmuscle.view.packing import LARGEST, Packer, Pool, as_small, encodable, packed_json, without_comments
from warpmuscle.view.pieces import Piece, device_pieces, surface_pieces
from warpmuscle.view.terrain.content import terrain_content
from warpmuscle.view.track import Doll, Track, track_of

SCRIPTS = (
    "unpack.js", "math.js", "meshes.js", "shaders.js", "batches.js", "terrain.js", "floor.js", "water.js",
    "renderer.js", "biped.js", "measured.js", "camera.js", "picking.js", "shades.js", "strides.js", "plots.js",
    "save_curves.js", "controls.js", "pushing.js", "live.js", "editor.js", "curve_editor.js", "waiting.js", "player.js",
)  # fmt: skip
SHOWN = (
    "muscles", "thickness", "yellow", "flesh", "bones", "surfaces", "shapes", "desired", "forces", "markers", "path",
    "labels", "norms", "strides", "follow", "turntable", "split", "dark",
)  # fmt: skip
RATE = 50.0  # frames a second; the page draws what lies between them
FEWEST_STRIDES = 2  # of each foot, of a motion that is shown stride by stride
DRAWN = 8  # figures that are kept, of what was drawn last
CROWD = 16  # tracks beyond which forces and most curves are left out, and muscles of all but near ones
FEW = 4  # tracks up to which all curves are stored, and figures are drawn finely


INSTEAD = {  # of a page, by names that are often tried
    **dict.fromkeys(
        ("show", "view", "display", "browse", "launch"), "open() shows it in the browser, a notebook in place"
    ),
    **dict.fromkeys(("write", "to_html", "export", "path"), "save('page.html') writes it"),
    "html": "text is its HTML",
}


@dataclass(frozen=True, repr=False)
class Page:
    """An HTML page, which a notebook shows where it stands."""

    text: str
    height: int = 620  # px, in a notebook

    def save(self, path: str | Path) -> None:
        """Write the page to a file, whole or not at all; raises Error if it cannot be written."""
        replace_file(as_path(path, "path"), self.text)

    def open(self) -> Path:
        """Show it in the browser, from a file of a temporary folder, which it returns.

        Raises:
            Error: there is no browser.
        """
        path = Path(mkdtemp(prefix="warpmuscle-")) / "page.html"
        self.save(path)
        if not webbrowser.open(path.as_uri()):
            raise Error(f"no browser was found; open {path} in one, or save('page.html') writes it elsewhere")
        return path

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Say what to type instead of what is often tried."""
            raise lacking("a page", name, dir(type(self)), INSTEAD)

    def __repr__(self) -> str:
        size = len(self.text.encode()) / 1e3
        return f"Page({size:.0f} kB of HTML; open() shows it in the browser, save(path) writes it)"

    def _repr_html_(self) -> str:
        return iframe(self.text, self.height)


def iframe(page: str, height: int = 620) -> str:
    """An element that holds a whole page within another one, `height` pixels high."""
    return (
        f'<iframe srcdoc="{html.escape(page, quote=True)}" style="width:100%;height:{height}px;border:0" '
        f'loading="lazy" title="replay"></iframe>'
    )


def replay_html(
    recordings: Recording | Sequence[Recording],
    scenes: Scene | Sequence[Scene],
    labels: Sequence[str] = (),
    *,
    title: str = "",
    rate: float = RATE,
    autoplay: bool = True,
    plots: bool = True,
    split: bool = False,
    meshes: str | PathLike[str] | None = None,
    facts: Sequence[Facts] = (),
    largest: int = LARGEST,
) -> str:
    """The page of one or several motions, side by side.

    Args:
        recordings: one or several, of at least a frame each.
        scenes: that made them, or one of them all; free parameters count with their start values.
        labels: names of the motions, by default those of the scenes.
        rate: stored frames per second, at most; more than were recorded are not made up.
        autoplay: whether it plays when it is opened. plots: whether curves are shown below.
        split: whether each of a few motions has a picture of its own at first, in which it stays.
        meshes: folder with the files of triangles that models of OpenSim are drawn with.
        facts: what is known of each motion; the label of one that failed says so from then on.
        largest: bytes of the page, which has fewer frames where it would be larger.

    Raises:
        Error: a motion without frames, or of another character than its scene's; a folder without such files.
    """
    motions = [recordings] if isinstance(recordings, Recording) else list(recordings)
    motions = [demanding(motion, "this recording") for motion in motions]
    given = [scenes] * len(motions) if isinstance(scenes, Scene) else list(scenes)
    numeric = {id(scene): at_start(scene) for scene in given}
    plain = [numeric[id(scene)] for scene in given]
    folder, name = mesh_folder(meshes, plain[0]), title or given[0].name
    dolls: dict[tuple[int, tuple[str, ...]], Doll] = {}

    def at(rate: float) -> str:
        tracks = []
        for number, (motion, scene) in enumerate(zip(motions, given, strict=True)):
            key = (id(scene), motion.muscle_names)
            label = labels[number] if labels else ""
            track = track_of(motion, numeric[id(scene)], label, rate, dolls.get(key))
            dolls[key] = track.doll
            tracks.append(track)
        return page_of(tracks, plain, name, autoplay, plots, split, meshes=folder, facts=facts)

    return as_small(at, rate, largest)


def page_of(
    tracks: Sequence[Track], scenes: Sequence[Scene], title: str, autoplay: bool, plots: bool,
    split: bool = False, live: Any = None, waiting: Any = None, meshes: Path | None = None,
    facts: Sequence[Facts] = (), over: bool = False,
) -> str:  # fmt: skip
    """The page of tracks and of their scenes without free parameters.

    Args:
        live, waiting: what `assets/live.js` and `assets/waiting.js` receive.
        meshes: folder with the files that models are drawn with. facts: what is known of each track, if anything.
        over: whether they are shown over one another, starting in one place, rather than side by side.
    """
    packer, title = Packer(), encodable(title)
    pool = Pool() if len(tracks) > CROWD else None
    dolls = _Dolls(packer, len(tracks) > FEW, meshes)
    contents: list[dict[str, Any]] = []
    panels: list[Any] = []
    offsets = over_one_another(tracks) if over else lanes(len(tracks))
    for track, scene, offset in zip(tracks, scenes, offsets, strict=True):
        content = track_content(track, scene, pool or packer, every_curve=len(tracks) <= FEW, live=live is not None)
        if content["panels"] not in panels:
            panels.append(content["panels"])
        parts = {"doll": dolls.number(track.doll, scene), "panels": panels.index(content["panels"])}
        contents.append({**content, **parts, "offset": offset.tolist()})
    motions = [track.recording for track in tracks] if live is None else None
    width = BESIDE if len(tracks) > 1 and not over else 0.0
    terrain = terrain_content([scene.ground for scene in scenes], motions, list(offsets), width)
    if pool is not None:
        for content, places in zip(contents, pool.pack(packer, [one["arrays"] for one in contents]), strict=True):
            content["arrays"] = {name: number for name, (number, _) in places.items()}
            content["rows"] = {name: row for name, (_, row) in places.items()}
    striding = live is None and any(map(_strides, contents))
    known = list(facts) or [Facts()] * len(tracks)
    contents = [{**content, **more} for content, more in zip(contents, facts_content(known), strict=True)]
    content = {
        "title": title,
        "autoplay": autoplay,
        "shown": _shown(tracks, panels, plots, striding, split, over, any(one.ended for one in facts)),
        "over": over and len(tracks) > 1,
        "ground": plane_content(scenes[0]) | {"terrain": terrain},
        "shades": shades_of(known, pool is None and any(track.doll.muscles.names for track in tracks), FEW),
        "tracks": contents,
        "panels": panels,
        "dolls": dolls.contents,
        "table": packer.table(),
        "live": live,
        "waiting": waiting,
    }
    folder = files("warpmuscle.view") / "assets"
    fields = {
        "title": html.escape(title),
        "policy": f'<meta http-equiv="{POLICY}" content="{POLICY_OF_FILES}">' if live is waiting is None else "",
        "style": without_comments((folder / "page.css").read_text(encoding="utf-8")),
        "script": "\n".join(without_comments((folder / name).read_text(encoding="utf-8")) for name in SCRIPTS),
        "content": packed_json(content),
        "arrays": packer.text(),
    }
    return _filled((folder / "page.html").read_text(encoding="utf-8"), fields)


def _filled(page: str, fields: dict[str, str]) -> str:
    """A page with texts in place of their names in double braces."""
    head, *rest = page.split("{{")
    return head + "".join(fields[name] + text for name, text in (part.split("}}", 1) for part in rest))


def over_one_another(tracks: Sequence[Track]) -> Floats:
    """Offsets (count, 3), m, with which all bodies start where the first one does, on the ground as they are."""
    starts = np.array([track.recording.com[0] for track in tracks], dtype=np.float64)
    return np.asarray((starts[0] - starts) * np.array([1.0, 0.0, 1.0]))


def ground_content(scene: Scene) -> dict[str, Any]:
    """What the page is sent about the ground of a scene without free parameters, where a biped may go anywhere."""
    return plane_content(scene) | {"terrain": terrain_content([scene.ground])}


def _hangs_through(scene: Scene) -> bool:
    """Whether a body starts below the plane, and none has a shape that touches it: the plane would only cover it."""
    normal, height = plane(scene.ground)
    if any(body.shapes for body in scene.character.bodies.values()):
        return False
    return any(float(np.dot(normal, place)) < height for place, _ in world_poses(scene).values())


def plane_content(scene: Scene) -> dict[str, Any]:
    """What the page is sent about the plane of the ground, and how high water stands, m."""
    normal, height = plane(scene.ground)
    visible = bool(np.asarray(scene.ground.stiffness) > 0.0) and not _hangs_through(scene)
    level = None if scene.water is None else first_number(scene.water.level)
    return {"normal": normal.tolist(), "height": float(height), "visible": visible, "water": level}


def _strides(content: dict[str, Any]) -> bool:
    """Whether a track has several strides of both feet, whose mean and spread say something."""
    return bool(content["cycles"]) and all(len(one) >= FEWEST_STRIDES for one in content["cycles"].values())


def _shown(
    tracks: Sequence[Track], panels: Sequence[Any], plots: bool, striding: bool, split: bool, over: bool, failed: bool
) -> dict[str, bool]:
    """What can be shown of these tracks, and whether it is at first."""
    few = len(tracks) <= CROWD
    there = {
        "muscles": any(track.doll.muscles.names for track in tracks),
        "thickness": few and any(track.doll.muscles.names for track in tracks),
        "yellow": few and any(track.doll.muscles.names for track in tracks),
        "desired": few and any(track.desired is not None for track in tracks),
        "forces": few,
        "path": few,
        "markers": few and any(track.measured is not None and track.measured.markers for track in tracks),
        "surfaces": any(track.doll.wraps for track in tracks),
        "labels": (len(tracks) > 1 or failed) and not over,
        "split": 1 < len(tracks) <= FEW and not over,
        "norms": any("norm" in panel for listed in panels for panel in listed),
        "strides": striding,
    }
    off = {
        "surfaces": False,
        "shapes": False,
        "desired": False,
        "path": False,
        "thickness": False,
        "yellow": False,
        "dark": False,
    }
    off |= {"turntable": False, "split": split}
    return {name: off.get(name, True) for name in SHOWN if there.get(name, True)} | {"plots": plots}


def look_of(doll: Doll, scene: Scene, coarse: bool, meshes: Path | None) -> list[Piece]:
    """All that is drawn of a doll and of the objects beside it.

    Args:
        scene: without free parameters. coarse: whether it is small in the picture, one of many.
        meshes: folder with the files that models are drawn with.
    """
    bodies, muscles = doll.names.bodies, doll.muscles.names
    look = figure_of(scene.character, scene.feet or (), bodies, coarse)
    if meshes is not None and not coarse and scene.opensim is not None:
        look = with_meshes(look, scene, bodies, meshes)
    if not coarse:
        look += attachments(scene, muscles, bodies, look)
    look += surface_pieces(scene.character, muscles, bodies)
    look += device_pieces(scene, bodies)
    return [*look, *object_pieces(scene)]


_drawn: dict[Any, list[Piece]] = {}  # what was drawn last, by what of


def _drawn_look(made_of: bytes, doll: Doll, scene: Scene, coarse: bool, meshes: Path | None) -> list[Piece]:
    """The same, kept until some others are drawn; not that of files, which may change."""
    if meshes is not None:
        return look_of(doll, scene, coarse, meshes)
    key = made_of, coarse
    look = _drawn.pop(key, None)
    if look is None:
        look = look_of(doll, scene, coarse, None)
    _drawn[key] = look
    for oldest in list(_drawn)[:-DRAWN]:
        _drawn.pop(oldest, None)
    return look


@contextmanager
def drawn_meanwhile(motion: Recording, scene: Scene) -> Iterator[None]:
    """While other work is done, draw the figure of a motion, for a page of few that is made next.

    Args:
        scene: that made it, without free parameters.
    """

    def draw() -> None:
        with suppress(Exception):  # whoever makes the page says what is wrong
            doll = track_of(motion, scene).doll
            _drawn_look(_made_of(doll, scene), doll, scene, False, mesh_folder(None, scene))

    thread = Thread(target=draw, name="figure", daemon=True)
    thread.start()
    try:
        yield
    finally:
        thread.join()


class _Dolls:
    """Contents of dolls, those that look alike once."""

    def __init__(self, packer: Packer, coarse: bool, meshes: Path | None) -> None:
        self.contents: list[dict[str, Any]] = []
        self._packer, self._coarse, self._meshes = packer, coarse, meshes
        self._known: dict[int, int] = {}
        self._alike: dict[bytes, int] = {}
        self._made_of: dict[bytes, int] = {}

    def number(self, doll: Doll, scene: Scene) -> int:
        """The number of a doll, whose content is made when it is needed."""
        if id(doll) in self._known:
            return self._known[id(doll)]
        made_of = _made_of(doll, scene)
        if made_of not in self._made_of:
            look = _drawn_look(made_of, doll, scene, self._coarse, self._meshes)
            key = pickle.dumps((look, doll_content(doll, scene, [])))
            if key not in self._alike:
                self._alike[key] = len(self.contents)
                self.contents.append(doll_content(doll, scene, piece_contents(look, self._packer)))
            self._made_of[made_of] = self._alike[key]
        self._known[id(doll)] = self._made_of[made_of]
        return self._known[id(doll)]


def _made_of(doll: Doll, scene: Scene) -> bytes:
    """What the content of a doll depends on: its names, and a scene but for its control, its judges and its time."""
    names = (doll.muscles.names, doll.names.bodies, doll.objects)
    looks = replace(scene, controller=None, objective=None, learning=None, stages=[], duration=1.0, description="")
    return pickle.dumps((names, looks))
