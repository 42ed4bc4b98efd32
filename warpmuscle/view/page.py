"""A replay as one HTML page that needs nothing but a browser: no network, no other file."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.arguments import as_path
from warpmuscle.core.files import replace_file
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.ground import plane
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.view.curves import panels_of
from warpmuscle.view.lanes import camera_of, lanes
from warpmuscle.view.packing import Packer, script_json, whole
from warpmuscle.view.track import Doll, Track, track_of

SCRIPTS = ("unpack.js", "math.js", "draw.js", "renderer.js", "scene.js", "plots.js", "player.js")
RATE = 50.0  # frames a second; the page draws what lies between them
MANY = 4  # tracks beyond which curves are stored coarsely


@dataclass(frozen=True, repr=False)
class Page:
    """An HTML page, which a notebook shows where it stands."""

    text: str
    height: int = 620  # px, in a notebook

    def save(self, path: str | Path) -> None:
        """Write the page to a file, whole or not at all; raises Error if it cannot be written."""
        replace_file(as_path(path, "path"), self.text)

    def __repr__(self) -> str:
        return f"Page({len(self.text.encode()) / 1e3:.0f} kB of HTML; save(path) writes it, a notebook shows it)"

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
) -> str:
    """The page of one or several motions, side by side.

    Args:
        recordings: one or several, of at least a frame each.
        scenes: that made them, or one of them all; free parameters count with their start values.
        labels: names of the motions, by default those of the scenes.
        rate: stored frames per second; more than were recorded are not made up.
        autoplay: whether it plays when it is opened. plots: whether curves are shown below.

    Raises:
        Error: a motion without frames, or of another character than its scene's.
    """
    motions = [recordings] if isinstance(recordings, Recording) else list(recordings)
    given = [scenes] * len(motions) if isinstance(scenes, Scene) else list(scenes)
    numeric = {id(scene): substitute(scene, start_values(scene)) for scene in given}
    dolls: dict[tuple[int, tuple[str, ...]], Doll] = {}
    tracks = []
    for number, (motion, scene) in enumerate(zip(motions, given, strict=True)):
        key = (id(scene), motion.muscle_names)
        track = track_of(motion, numeric[id(scene)], labels[number] if labels else "", rate, dolls.get(key))
        dolls[key] = track.doll
        tracks.append(track)
    return page_of(tracks, [numeric[id(scene)] for scene in given], title or given[0].name, autoplay, plots)


def page_of(tracks: Sequence[Track], scenes: Sequence[Scene], title: str, autoplay: bool, plots: bool) -> str:
    """The page of tracks and of their scenes without free parameters."""
    packer, title = Packer(), whole(title)
    distinct = list({id(track.doll): track.doll for track in tracks}.values())
    offsets = lanes(len(tracks))
    bits = 16 if len(tracks) <= MANY else 8
    contents = []
    for track, scene, offset in zip(tracks, scenes, offsets, strict=True):
        number = next(k for k, doll in enumerate(distinct) if doll is track.doll)
        contents.append({**_track_content(track, scene, packer, bits), "doll": number, "offset": offset.tolist()})
    shown = {"muscles": True, "shapes": True, "bones": True, "desired": False, "forces": True, "path": True}
    if not any(track.doll.muscles.names for track in tracks):
        del shown["muscles"]
    if all(track.desired is None for track in tracks):
        del shown["desired"]
    ground = scenes[0].ground
    normal, height = plane(ground)
    content = {
        "title": title,
        "autoplay": autoplay,
        "camera": dict(zip(("distance", "yaw", "pitch"), camera_of(offsets), strict=True)),
        "shown": {**shown, "follow": True, "plots": plots},
        "ground": {
            "normal": normal.tolist(),
            "height": height,
            "visible": bool(np.asarray(ground.stiffness) > 0.0),
        },
        "tracks": contents,
        "dolls": [_doll_content(doll) for doll in distinct],
        "table": packer.table(),
    }
    folder = files("warpmuscle.view") / "assets"
    fields = {
        "title": html.escape(title),
        "style": (folder / "page.css").read_text(encoding="utf-8"),
        "script": "\n".join((folder / name).read_text(encoding="utf-8") for name in SCRIPTS),
        "content": script_json(content),
        "arrays": packer.text(),
    }
    page = (folder / "page.html").read_text(encoding="utf-8")
    head, *rest = page.split("{{")
    return head + "".join(fields[name] + text for name, text in (part.split("}}", 1) for part in rest))


def _track_content(track: Track, scene: Scene, packer: Packer, bits: int) -> dict[str, Any]:
    """What the page is told of a track; its arrays go to the packer."""
    r = track.recording
    panels = panels_of(r, scene)
    arrays = {
        "time": packer.add(r.time),
        "root": packer.add(r.root_position),
        "orientation": packer.add(continuous(r.body_orientation)),
        "com": packer.add(r.com),
        "force": packer.add(track.foot_force),
        "center": packer.add(track.foot_center),
    }
    curves = [line.values for panel in panels for line in panel.lines]
    if curves:
        arrays["curves"] = packer.add(np.column_stack(curves), bits)
    if track.doll.sliding:
        arrays["slid"] = packer.add(track.slid)
    if track.desired is not None:
        arrays["desired"] = packer.add(continuous(track.desired))
    if r.muscle_names:
        arrays["activation"] = packer.add(r.muscle_activation, 8)
        arrays["load"] = packer.add(track.muscle_load, 8)
    if track.point_weight.size:
        arrays["weight"] = packer.add(track.point_weight, 8)
    if track.doll.muscles.routes:
        arrays["routed"] = packer.add(track.routes.all() - r.root_position[:, None])
    columns = iter(range(10**9))
    listed = [
        {
            "group": panel.group,
            "title": panel.title,
            "unit": panel.unit,
            "lines": [{"name": line.name, "side": line.side, "column": next(columns)} for line in panel.lines],
        }
        for panel in panels
    ]
    return {"label": track.label, "frames": track.frames, "arrays": arrays, "panels": listed, "curves": len(curves)}


def continuous(orientation: Any) -> Any:
    """The same orientations (F, B, 4) with signs that change nowhere, so that their differences are small."""
    product = np.sum(orientation[1:] * orientation[:-1], axis=-1)
    sign = np.cumprod(np.where(product < 0.0, -1.0, 1.0), axis=0)
    return np.concatenate([orientation[:1], orientation[1:] * sign[..., None]])


def _doll_content(doll: Doll) -> dict[str, Any]:
    return {
        "parts": [
            {
                "kind": part.kind,
                "body": part.body,
                "side": part.side,
                "bone": part.bone,
                "position": _rounded(part.position),
                "orientation": _rounded(part.orientation),
                "size": _rounded(part.size),
            }
            for part in doll.parts
        ],
        "parent": doll.parent.tolist(),
        "in_parent": _rounded(doll.in_parent),
        "in_child": _rounded(doll.in_child),
        "sliding": list(doll.sliding),
        "weight": doll.weight,
        "muscles": {
            "names": doll.muscles.names,
            "start": doll.muscles.start.tolist(),
            "body": doll.muscles.body.tolist(),
            "place": _rounded(doll.muscles.place),
            "conditional": doll.muscles.conditional.tolist(),
            "routed": doll.muscles.routed.tolist(),
        },
    }


def _rounded(numbers: Any) -> Any:
    return np.round(numbers, 5).tolist()
