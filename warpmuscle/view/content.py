"""What a page is sent about a track and of a doll: numbers for its JSON, and arrays for its packer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import normalized
from warpmuscle.gait.cycles import body_weight, leg_angles, strides
from warpmuscle.gait.likeness import norms_of
from warpmuscle.gait.quality import runs, support_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import straight_legs
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.norms import LEG_ANGLES, Band
from warpmuscle.view.curves import LEG_TITLES, Line, Panel, panels_of
from warpmuscle.view.measured.content import measured_arrays, measured_content
from warpmuscle.view.muscle_lines import in_bodies
from warpmuscle.view.objects import with_objects
from warpmuscle.view.packing import Packer, Pool
from warpmuscle.view.pieces import Block, Ellipsoid, Hull, Limb, Piece
from warpmuscle.view.track import Doll, Track

NORM_PERCENT = np.linspace(0.0, 100.0, 51)  # of the gait cycle, where bands of norms have their samples
FEWEST_FIBRES = 0.7  # of a muscle's length that is drawn as its belly, at least: pennate fibres lie beside one another
TENSION = 5.0e5  # Pa, of muscles that fit beside one another
BELLY = 8.0 / 15.0  # volume of a drawn belly in that of a cylinder around it: the integral of (1 - x^2)^2 from 0 to 1
THINNEST, THICKEST = 0.005, 0.04  # m, radii of bellies of a body of 75 kg
STOUTEST = 0.115  # radius of a belly in the length of its muscle, at most
SHADES = 15.0  # steps of an activation from 0 to 1 in a crowd: few compress well
FINE, COARSE = 2e-4, 4e-4  # m, or parts of a unit quaternion: steps in which places and turns are stored
SAME_ANGLE = 6.0  # degrees, mean difference of two curves that are the same angle
SPARED = ("excitations", "fibre lengths", "desired torques")  # groups of curves that pages of many motions do without


class LegNorm(NamedTuple):
    """The angle of a joint of a leg, and the norm of it."""

    side: str
    angle: Floats  # (F,) degrees
    source: str
    band: Band


def track_arrays(track: Track) -> dict[str, tuple[Floats, float]]:
    """All that is drawn of a track but its curves: arrays (F, ...), and how finely to store them, see `Packer.add`."""
    r = track.recording
    arrays = {
        "time": (r.time, 16),
        "root": (r.root_position, FINE),
        "orientation": (continuous(with_objects(r.body_orientation, track.objects)), FINE),
        "com": (r.com, FINE),
        "force": (track.foot_force, 12),
        "center": (track.foot_center, FINE),
    }
    if track.doll.sliding or track.objects:
        arrays["slid"] = (np.concatenate([track.slid, *(one.position[:, None] for one in track.objects)], axis=1), FINE)
    if track.desired is not None:
        arrays["desired"] = (continuous(with_objects(track.desired, track.objects)), COARSE)
    if r.muscle_names:
        arrays["activation"] = (r.muscle_activation, 8)
        arrays["load"] = (track.muscle_load, 8)
    if track.point_weight.size:
        arrays["weight"] = (track.point_weight, 8)
    if track.doll.muscles.routes:
        arrays["routed"] = (track.routes.all() - r.root_position[:, None], 16)
    return arrays | measured_arrays(track.measured)


def crowd_arrays(track: Track) -> dict[str, tuple[Floats, float]]:
    """The same of one of many, small in the picture: how its bodies move, and roughly how active its muscles are.

    Ways of muscles that wrap are left out, and so are these muscles.
    """
    all_arrays = track_arrays(track)
    kept: dict[str, tuple[Floats, float]] = {}
    kept |= {name: all_arrays[name] for name in ("time", "root", "slid", "weight") if name in all_arrays}
    if "activation" in all_arrays:
        kept["activation"] = (np.rint(all_arrays["activation"][0] * SHADES) / SHADES, 8)
    return kept | {"orientation": (all_arrays["orientation"][0], 8)}


def curve_arrays(panels: Sequence[Panel]) -> dict[str, tuple[Floats, float]]:
    """Curves of panels that are in no array of `track_arrays`, in the order of their columns."""
    loose = [line.values for panel in panels for line in panel.lines if line.stored is None]
    arrays: dict[str, tuple[Floats, float]] = {"curves": (np.column_stack(loose), 12)} if loose else {}
    for name in ("wanted", "excitation", "fibre"):
        columns = {line.stored.column: line.values for panel in panels for line in panel.lines
                   if line.stored is not None and line.stored.array == name}  # fmt: skip
        if columns:
            arrays[name] = (np.column_stack([columns[k] for k in sorted(columns)]), 8)
    return arrays


def track_content(
    track: Track, scene: Scene, packer: Packer | Pool, every_curve: bool = True, live: bool = False
) -> dict[str, Any]:
    """What the page is sent about a track; its arrays go to the packer, or to a pool of what many have."""
    panels = [p for p in panels_of(track.recording, scene, live) if every_curve or p.group not in SPARED]
    if isinstance(packer, Pool):
        panels = [loose(panel) for panel in panels if panel.title in LEG_TITLES and panel.group == "angles"]
    arrays = crowd_arrays(track) if isinstance(packer, Pool) else track_arrays(track)
    arrays |= curve_arrays(panels)
    fixed: dict[str, Any] = {}
    if "routed" in arrays and not live:
        r = track.recording
        bodies, places = in_bodies(track.routes.all(), r.body_position, normalized(r.body_orientation))
        fixed, arrays["routed"] = {"routed_on": bodies.tolist()}, (places, FINE)
    if not every_curve and "curves" in arrays:
        arrays["curves"] = (arrays["curves"][0], 8)
    numbers = packer.add_all(arrays)
    cycles = cycles_of(track.recording, scene)
    return {
        "label": track.label,
        "frames": track.frames,
        "arrays": numbers,
        **fixed,
        "cycles": {side: np.round(np.array(one).reshape(-1, 2), 4).tolist() for side, one in cycles.items()},
        "panels": panel_contents(panels, leg_norms(track.recording, scene, cycles)),
        **measured_content(track.measured, scene),
    }


def panel_contents(panels: Sequence[Panel], norms: Sequence[LegNorm]) -> list[dict[str, Any]]:
    """What the page is sent about panels; curves that are stored nowhere else are columns of the array `curves`."""
    columns, found = iter(range(10**9)), _norms_of(panels, norms)
    return [
        {
            "group": panel.group,
            "title": panel.title,
            "unit": panel.unit,
            "lines": [_line(line, columns) for line in panel.lines],
            **found.get(number, {}),
        }
        for number, panel in enumerate(panels)
    ]


def loose(panel: Panel) -> Panel:
    """A panel whose curves are stored by themselves."""
    return replace(panel, lines=tuple(replace(line, stored=None) for line in panel.lines))


def _line(line: Line, columns: Any) -> dict[str, Any]:
    array, column, factor = line.stored if line.stored is not None else ("curves", next(columns), 1.0)
    return {"name": line.name, "side": line.side, "from": array, "column": column, "factor": factor}


def cycles_of(recording: Recording, scene: Scene) -> dict[str, list[tuple[float, float]]]:
    """Gait cycles of both feet, s; none where nothing walks."""
    if scene.feet is None or recording.frames < 3:
        return {}
    weight = body_weight(scene)
    return {side: strides(recording, side, 0.0, weight) for side in ("left", "right")}


def leg_norms(recording: Recording, scene: Scene, cycles: dict[str, Any]) -> list[LegNorm]:
    """Angles of legs that have a hip, a knee and an ankle, with their measured norms of walking, or of running.

    There are none for legs that are bent where their angles are 0, such as a bird's.
    """
    if not cycles or not all(cycles.values()) or not straight_legs(scene):
        return []
    try:
        norm = norms_of(runs(scene, support_of(recording, scene, cycles)))[-1]
        angles = leg_angles(recording, scene)
    except Error:
        return []
    what = f"{norm.source}, {norm.what}"
    return [
        LegNorm(side, angles[title][side], what, norm.angles[title]) for title in LEG_ANGLES for side in angles[title]
    ]


def _norms_of(panels: Sequence[Panel], norms: Sequence[LegNorm]) -> dict[int, dict[str, Any]]:
    """What the page is sent about norms, by number of the panel.

    The panel of an angle of the legs is the one whose curve is nearest to it, perhaps with the other sign: a motion of
    next to no movement has others that are near, too.
    """
    found = {}
    for norm in norms:
        near = [
            (float(np.sqrt(np.mean((sign * norm.angle - line.values) ** 2))), number, sign)
            for number, panel in enumerate(panels)
            if panel.group == "angles" and panel.joint
            for line in panel.lines
            if line.side in (norm.side, "middle")
            for sign in (1.0, -1.0)
        ]
        off, number, sign = min(near, default=(np.inf, 0, 1.0))
        if off < SAME_ANGLE:
            mean, sd = sign * norm.band.mean(NORM_PERCENT), norm.band.sd(NORM_PERCENT)
            found[number] = {
                "norm": {"source": norm.source, "mean": np.round(mean, 1).tolist(), "sd": np.round(sd, 1).tolist()}
            }
    return found


def continuous(orientation: Any) -> Any:
    """The same orientations (F, B, 4) with signs that change nowhere, so that their differences are small."""
    product = np.sum(orientation[1:] * orientation[:-1], axis=-1)
    sign = np.cumprod(np.where(product < 0.0, -1.0, 1.0), axis=0)
    return np.concatenate([orientation[:1], orientation[1:] * sign[..., None]])


def doll_content(doll: Doll, scene: Scene, pieces: list[dict[str, Any]]) -> dict[str, Any]:
    """What the page is sent about a doll that looks like these pieces."""
    content = moving_content(doll, scene)
    fixed = {
        "names": doll.muscles.names,
        "start": doll.muscles.start.tolist(),
        "body": doll.muscles.body.tolist(),
        "conditional": doll.muscles.conditional.tolist(),
        "routed": doll.muscles.routed.tolist(),
    }
    return {
        **content,
        "muscles": {**content["muscles"], **fixed},
        "pieces": pieces,
        "names": [*doll.names.bodies, *doll.objects],
        "parent": [*doll.parent.tolist(), *(-1 for _ in doll.objects)],
        "sliding": [*doll.sliding, *range(len(doll.parent), len(doll.parent) + len(doll.objects))],
    }


def moving_content(doll: Doll, scene: Scene) -> dict[str, Any]:
    """The part of it that free parameters may change."""
    muscles = [scene.character.muscles[name] for name in doll.muscles.names]
    lengths = np.array([(plain_number(m.l_opt), plain_number(m.l_slack)) for m in muscles]).reshape(-1, 2)
    whole_length = np.maximum(lengths.sum(axis=1), 1e-9)
    share = np.clip(lengths[:, 0] / whole_length, FEWEST_FIBRES, 1.0)
    scale = round(float(np.clip((doll.weight / 9.81 / 75.0) ** (1.0 / 3.0), 0.3, 1.4)), 3)
    area = np.array([plain_number(m.f_max) for m in muscles]) / TENSION
    belly = np.sqrt(area * lengths[:, 0] / (np.pi * BELLY * share * whole_length))
    belly = np.clip(belly, THINNEST * scale, np.minimum(THICKEST * scale, STOUTEST * whole_length))
    nowhere = np.zeros((len(doll.objects), 3))
    return {
        "in_parent": _rounded(np.concatenate([doll.in_parent, nowhere])),
        "in_child": _rounded(np.concatenate([doll.in_child, nowhere])),
        "weight": doll.weight,
        "scale": scale,
        "muscles": {
            "place": _rounded(doll.muscles.place),
            "f_max": [round(plain_number(m.f_max), 1) for m in muscles],
            "share": np.round(share, 3).tolist(),
            "belly": np.round(belly, 4).tolist(),
            "length": np.round(whole_length, 4).tolist(),
        },
    }


def piece_contents(pieces: Sequence[Piece], packer: Packer) -> list[dict[str, Any]]:
    """What the page is sent about pieces; meshes of hulls go to the packer."""
    return [{"kind": _kind(one), "body": one.body, "side": one.side, "layer": one.layer,
             **_form(one, packer)} for one in pieces]  # fmt: skip


def _form(piece: Piece, packer: Packer) -> dict[str, Any]:
    if isinstance(piece, Limb):
        return {"start": _rounded(piece.start), "end": _rounded(piece.end), "radii": _rounded(piece.radii)}
    if isinstance(piece, Ellipsoid):
        turn = _rounded(piece.orientation)
        return {"position": _rounded(piece.position), "orientation": turn, "radii": _rounded(piece.radii)}
    if isinstance(piece, Hull):
        kept = [] if piece.layer == "bone" else [packer.add(piece.normals, 8)]  # those of bones follow from their faces
        return {"arrays": [packer.add(piece.corners, FINE), packer.add(piece.faces.astype(float)), *kept]}
    return {"position": _rounded(piece.position), "radii": _rounded(piece.radii)}


def _rounded(numbers: Any) -> Any:
    return np.round(numbers, 4).tolist()


def _kind(piece: Piece) -> str:
    if isinstance(piece, Limb):
        return "tube" if piece.flat else "limb"
    return "box" if isinstance(piece, Block) else type(piece).__name__.lower()
