"""Forces on bodies from files: OpenSim's external loads, plain tables of force plates, and which foot stood on which.

A table has three columns a vector: `..._vx` or `..._force_x` and so on. The `.xml` of external loads says which columns
belong together and on which body they act; without it that follows from the columns' names, and from the motion.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError, SignalError
from warpmuscle.core.pose import rotate
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.formats.osim.elements import Element, parse
from warpmuscle.inverse.body_model import BodyLoads, BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.laboratory.c3d_plates import loads_of_c3d
from warpmuscle.inverse.plausibility.ground_forces import Applied
from warpmuscle.inverse.reactions.joint_frames import body_frames
from warpmuscle.inverse.trial import Loads, Plate, of_file
from warpmuscle.scene.anatomy import foot_bodies
from warpmuscle.synergy.tables import Table, check_rising, finite_columns, read_table

AXES = "xyz"
TOUCHING = 20.0  # N, from which on a foot is said to stand on a plate
FEET = ("calcn", "foot", "talus")  # what names of feet begin with, or have in them, in this order of preference
ENDINGS = (("v", "p"), ("force_v", "force_p"), ("_f", "_p"), ("_v", "_p"), ("f", "p"))  # of a plate's columns
LOOKED_AT = 40  # frames of a trial at most, whose loads are held against the motion
GROUND = ("ground", "/ground", "")


class _Described(NamedTuple):
    """A force as a file of external loads describes it."""

    name: str
    body: str | None
    force: str  # what names of its columns begin with; empty: there are none
    point: str
    moment: str
    axes_of: str | None = None  # body in whose axes force and moment are; None: the ground's
    point_on: str | None = None


def read_loads(
    path: str | Path, data: str | Path | None = None, *, up: str | None = None, forward: str | None = None
) -> Loads:
    """Forces of an external-loads `.xml`, or of a `.mot`, `.sto`, `.csv` or `.c3d` whose plates have no bodies yet.

    Args:
        data: the table in place of that which the `.xml` names, which is looked for there and beside it.
        up, forward: axes of a `.c3d`, see `files.read_markers`; others are in ground axes.

    Raises:
        SceneError: the `.xml` cannot be read. SignalError: the table cannot be read, lacks columns of a force or holds
            something else than numbers; a `.c3d` has no force plates, or some of a kind that is not known.
    """
    path = Path(path)
    if path.suffix.lower() == ".c3d":
        plates = loads_of_c3d(path, up, forward)
        if plates is None:
            raise SignalError("has no force plates; give a file that has the forces", file=path)
        return plates
    if path.suffix.lower() != ".xml":
        table = read_table(path)
        return _loads(table, _guessed(table))
    root = parse(path)
    top = root if root.tag == "ExternalLoads" else root.child("ExternalLoads")
    if top is None:
        root.fail("there is no <ExternalLoads> in it")
    described = [found for member in top.objects() if (found := _described(member)) is not None]
    names = [one.name for one in described]
    if twice := next((name for name in names if names.count(name) > 1), ""):
        top.fail(f"two forces are called {twice!r}; rename one")
    if not described:
        top.fail("it describes no force that is applied")
    if data is None:
        named = top.child("datafile")
        if named is None or not named.word():
            top.fail("it names no <datafile> with the numbers")
        stated = Path(named.word().replace("\\", "/"))
        data = next((one for one in (path.parent / stated, path.parent / stated.name) if one.is_file()), None)
        if data is None:
            raise SignalError(f"it names the table {stated.name!r}, and there is no such file beside it", file=path)
    return _loads(read_table(data), described)


def _described(element: Element) -> _Described | None:
    """A force that is applied."""
    if element.tag != "ExternalForce":
        element.fail("only an ExternalForce is read; remove it")

    def word(tag: str) -> str:
        child = element.child(tag)
        text = "" if child is None else child.word()
        return "" if text.lower() == "unassigned" else text

    for tag, off in (("isDisabled", True), ("appliesForce", False)):
        child = element.child(tag)
        if child is not None and child.truth() is off:
            return None
    frames = [word(f"{what}_expressed_in_body") for what in ("force", "point")]
    body = word("applied_to_body").rpartition("/")[2]
    if word("force_identifier") and not word("point_identifier"):
        frames[1] = body  # where OpenSim lets it act at the origin
    if not body:
        element.fail("names no <applied_to_body>")
    found = _Described(
        element.name or body,
        body,
        *map(word, ("force_identifier", "point_identifier", "torque_identifier")),
        *(None if frame.lower() in GROUND else frame.rpartition("/")[2] for frame in frames),
    )
    if not found.force and not found.moment:
        element.fail("has neither <force_identifier> nor <torque_identifier>")
    return found


def _guessed(table: Table) -> list[_Described]:
    """Plates by the names of columns: three of forces, of the points and perhaps of moments each."""
    names = [name.strip() for name in table.names]
    found: list[_Described] = []
    for name in names:
        for force, point in ENDINGS:
            start = name[: -len(force) - 1]
            if name != f"{start}{force}x" or f"{start}{point}x" not in names or any(start == one.name for one in found):
                continue
            moment = next((m for m in _moments(start) if f"{m}x" in names), "")
            found.append(_Described(start, None, start + force, start + point, moment))
            break
    if not found:
        raise SignalError(
            "no columns of a force and its point, such as `ground_force_vx` and `ground_force_px`; give the external "
            "loads' .xml, which says what columns are",
            file=table.path,
        )
    return found


def _moments(start: str) -> list[str]:
    """What columns of moments may begin with beside those of a plate's forces."""
    torque, moment = (start.replace("force", word).replace("Force", word.title()) for word in ("torque", "moment"))
    own = [f"{start}m", f"{start}_m", f"{start}torque_", f"{start}moment_", f"{torque}_", torque, f"{start}t"]
    return own + [f"{moment}{end}" for end in ("m", "_m", "_", "")] + [f"{torque}{end}" for end in ("m", "t")]


def _columns(path: Path, names: list[str], force: str, start: str) -> list[int]:
    """Numbers of the three columns of a force whose names begin so."""
    wanted = [f"{start}{axis}" for axis in AXES]
    lacking = next((name for name in wanted if name not in names), None)
    if lacking is not None:
        raise SignalError(f"no column {lacking!r}, which the force {force!r} asks for", file=path)
    twice = next((name for name in wanted if names.count(name) > 1), None)
    if twice is not None:
        raise SignalError(f"two columns are called {twice!r}; rename or remove one", file=path)
    return [names.index(name) for name in wanted]


def _loads(table: Table, described: Sequence[_Described]) -> Loads:
    names = [name.strip() for name in table.names]
    if "time" not in [name.lower() for name in names]:
        raise SignalError("no column of time; name one `time`", file=table.path)
    time = [name.lower() for name in names].index("time")

    wanted = [
        [_columns(table.path, names, one.name, start) if start else [] for start in (one.force, one.point, one.moment)]
        for one in described
    ]
    every = sorted({time, *(k for one in wanted for part in one for k in part)})
    values = finite_columns(table, every, [names[k] for k in every])
    times = values[:, every.index(time)]
    check_rising(table, times)

    def vectors(part: list[int]) -> Floats:
        return values[:, [every.index(k) for k in part]] if part else np.zeros((len(times), 3))

    plates = [
        Plate(one.name, one.body, vectors(force), vectors(point), vectors(moment), one.axes_of, one.point_on)
        for one, (force, point, moment) in zip(described, wanted, strict=True)
    ]
    with of_file(table.path):
        return Loads(times, tuple(plates))


def in_world(body: BodyModel, plates: Sequence[Plate], values: Floats, states: States, part: slice) -> Floats:
    """Forces, points and moments (n, P, 3, 3) of plates in world axes, from those that they are told in.

    Raises:
        ArgumentError: they are told in axes of a body, and the model is no file of OpenSim or has no such body.
    """
    found = np.asarray(values @ TO_OPENSIM)
    wanted = {name for plate in plates for name in (plate.axes_of, plate.point_on) if name is not None}
    if not wanted:
        return found
    if body.file is None:
        raise ArgumentError(f"a force is given in the axes of {min(wanted)!r}, which only the `.osim` of the model has")
    frames, places = body_frames(body.file), _poses(body, states, part)
    for k, plate in enumerate(plates):
        for name in (plate.axes_of, plate.point_on):
            if name is not None and name not in frames:
                raise ArgumentError(f"the force {plate.name!r} is given in the axes of {name!r}, which the model does "
                                    f"not have; it has {', '.join(list(frames)[:8])}, ...")  # fmt: skip
        if plate.axes_of is not None:
            frame = frames[plate.axes_of]
            for what in (0, 2):
                found[:, k, what] = rotate(places[frame.body][1], values[:, k, what] @ frame.axes.T)
        if plate.point_on is not None:
            frame = frames[plate.point_on]
            place, orientation = places[frame.body]
            found[:, k, 1] = place + rotate(orientation, (values[:, k, 1] - frame.center) @ frame.axes.T)
    return found


class Placed(NamedTuple):
    """A plate on a body, and how much of its force acts there."""

    plate: int
    body: int  # number
    share: Floats  # (n,) 0 or 1


def on_feet(
    body: BodyModel, named: Sequence[str | None], plates: Sequence[str], force: Floats, point: Floats, states: States,
    part: slice,
) -> list[Placed]:  # fmt: skip
    """On which bodies plates act: those that are named; else the foot that is nearest, contact by contact.

    Args:
        named: bodies of the plates, by name. force, point: (n, P, 3) N and m, world axes. states: of frames `part`.

    Raises:
        ArgumentError: a body that the model does not have, or no feet to choose from.
    """
    bodies = body.topology.bodies
    for name, plate in zip(named, plates, strict=True):
        if name is not None and name not in bodies:
            raise ArgumentError(f"the force {plate!r} acts on {name!r}, which the model does not have; it has "
                                f"{', '.join(bodies[:8])}, ...")  # fmt: skip
    found = [Placed(k, bodies.index(name), np.ones(len(force))) for k, name in enumerate(named) if name is not None]
    loose = [k for k, name in enumerate(named) if name is None]
    if not loose:
        return found
    feet = _feet(body)
    places = _places(body, states, part)[:, feet]
    for k in loose:
        share = np.zeros((len(force), len(feet)))
        for first, last in _contacts(force[:, k]):
            near = slice(first, last)
            away = np.linalg.norm((places[near] - point[near, None, k])[:, :, [0, 2]], axis=2)
            weight = np.linalg.norm(force[near, k], axis=1)
            share[near, int(np.argmin(weight @ away))] = 1.0
        found += [Placed(k, foot, share[:, f]) for f, foot in enumerate(feet) if share[:, f].any()]
    return found


class Places(NamedTuple):
    """Where bodies are, and how fast, in some frames of a trial."""

    rows: Integers  # (n,) numbers of the frames
    at: Floats  # (n, B, 3) m, centres of mass, world axes
    speeds: Floats  # (n, B) m/s


def places_of(body: BodyModel, states: States, starts: Sequence[int], times: Sequence[Floats]) -> list[Places]:
    """Places of bodies in some frames of trials, evenly over each, all found at once.

    Args:
        starts: first frames of the trials. times: (F,) s, of their frames.
    """
    chosen = [np.unique(np.linspace(0, len(own) - 1, LOOKED_AT).astype(int)) for own in times]
    around = [
        np.concatenate([np.maximum(rows - 1, 0), rows, np.minimum(rows + 1, len(own) - 1)])
        for rows, own in zip(chosen, times, strict=True)
    ]
    if not chosen:
        return []
    every = np.concatenate([first + rows for first, rows in zip(starts, around, strict=True)])
    at, found, done = _places(body, states, slice(0, len(states.coordinates)), every), [], 0
    for rows, near, own in zip(chosen, around, times, strict=True):
        before, here, after = at[done : done + len(near)].reshape(3, len(rows), *at.shape[1:])
        early, _, late = own[near].reshape(3, -1)
        speeds = np.linalg.norm(after - before, axis=2) / np.maximum(late - early, 1e-9)[:, None]
        found.append(Places(rows, here, speeds))
        done += len(near)
    return found


def placed_forces(body: BodyModel, plates: Sequence[str], loads: BodyLoads, places: Places) -> list[Applied]:
    """Loads and the bodies they act on in some frames, to be held against each other."""
    bodies, rows = body.topology.bodies, places.rows
    acted_on = dict.fromkeys(loads.body)
    where = {bodies[number]: places.at[:, number] for number in acted_on}
    fast = {bodies[number]: places.speeds[:, number] for number in acted_on}
    names = plates if len(plates) == len(loads.body) else [bodies[number] for number in loads.body]
    return [
        Applied(name, bodies[number], loads.force[rows, k], loads.point[rows, k], loads.moment[rows, k], where, fast)
        for k, (name, number) in enumerate(zip(names, loads.body, strict=True))
    ]


def _feet(body: BodyModel) -> list[int]:
    """Numbers of the bodies that plates may be under."""
    scene, bodies = body.scene, body.topology.bodies
    if scene.feet:
        return [bodies.index(foot_bodies(scene.character, foot)[0]) for foot in scene.feet]
    for word in FEET:
        feet = [k for k, name in enumerate(bodies) if word in name.lower()]
        if len(feet) >= 2:
            return feet
    raise ArgumentError("the model's feet are not known by their names; say in the loads which body each force acts on")


def _poses(
    body: BodyModel, states: States, part: slice, rows: Integers | slice = slice(None)
) -> dict[str, tuple[Floats, Floats]]:
    """Centres of mass (n, 3) m and orientations (n, 4) of all bodies by name, in some rows of some frames."""
    from warpmuscle.studies.inverse_dynamics import points_of

    found = points_of(body.scene.character, states.coordinates[part][rows])
    for number, name in enumerate(body.topology.bodies):
        place, orientation = found[name]
        if number > 0:
            joint = body.scene.character.joints[body.topology.joints[number - 1]]
            place = place - rotate(orientation, np.array([joint.position_in_child], dtype=np.float64))
            found[name] = place, orientation
    return found


def _places(body: BodyModel, states: States, part: slice, rows: Integers | slice = slice(None)) -> Floats:
    """Where centres of mass of all bodies are in some rows of some frames, (n, B, 3) m."""
    return np.stack([place for place, _ in _poses(body, states, part, rows).values()], axis=1)


def _contacts(force: Floats) -> list[tuple[int, int]]:
    """First frames of contacts with a plate, and those after their last; the rest goes to the nearer contact."""
    on = np.linalg.norm(force, axis=1) > TOUCHING
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    spans = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
    if not spans:
        return []
    cuts = [0, *((one[1] + other[0]) // 2 for one, other in itertools.pairwise(spans)), len(force)]
    return list(itertools.pairwise(cuts))
