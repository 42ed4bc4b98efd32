"""Inverse dynamics of recorded motions: the generalised forces that a model's coordinates need.

As OpenSim's InverseDynamicsTool does it: coordinates are filtered, splines of fifth degree through them give speeds and
accelerations, loads are splines of third degree. Muscles and other forces of the model play no part.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple, overload

import numpy as np

from warpmuscle.core.arguments import answering, as_array, as_number, as_truth
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.sequences import reaches_over
from warpmuscle.formats import SceneLike
from warpmuscle.inverse.as_opensim.turned_axes import seeming_loads
from warpmuscle.inverse.body_model import BodyLoads, BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.loads import Places, in_world, on_feet, placed_forces, places_of
from warpmuscle.inverse.plausibility.ground_forces import place_notes, push_notes, swing_notes, weight_notes
from warpmuscle.inverse.plausibility.motions import locked_notes, range_notes, side_notes, time_notes, value_notes
from warpmuscle.inverse.smoothing import low_pass, spline
from warpmuscle.inverse.trial import ByCoordinate, Coordinates, Loads, TrialWarning, each_of
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.masses import body_mass
from warpmuscle.simulation.kernel_cache import said

MARGIN = 50  # rows of loads beside those that a motion needs, which a spline through them still feels
FEW = 0.5  # of a model's coordinates: with less a motion is taken for one of another model
MOST = 20.0  # rad, that no angle comes to
FARTHEST = 1.0e5  # m, that no unit brings a body away from the origin
FREE = 3  # coordinates of a root at least, with which a body may fall


INSTEAD = {  # of arguments that are often tried
    **dict.fromkeys(("cutoff", "lowpass", "lowpass_cutoff"), "filter=6.0 is the cut-off, Hz"),
    **dict.fromkeys(("motion", "mot", "ik", "kinematics"), "coordinates='walk.mot' names the motion"),
    **dict.fromkeys(("external_loads", "grf", "forces"), "loads=read_loads('grf.xml') of warpmuscle.inverse.loads"),
}
CoordinatesLike = Coordinates | str | PathLike[str]  # of a trial, or the name of its file
Several = list[Any] | tuple[Any, ...]  # of these
LoadsLike = Loads | Sequence[Loads | None] | None


@dataclass(frozen=True, repr=False)
class Moments(ByCoordinate):
    """Generalised forces of K coordinates in F frames.

    Attributes:
        residuals: how many coordinates at the front are those of the root, whose forces nothing makes: the residuals.
    """

    names: tuple[str, ...]  # (K,) of coordinates
    units: tuple[str, ...]  # (K,) N m or N
    times: Floats  # (F,) s
    values: Floats  # (F, K)
    residuals: int = 0


class Prepared(NamedTuple):
    """Trials of one model, their frames one behind the other."""

    times: list[Floats]  # by trial (F,) s
    states: States  # of all frames
    loads: BodyLoads
    values: Floats  # (n, K) rad and m
    speed_rates: Floats | None = None  # (n, S) of the speeds, as `of_speeds` has them

    @property
    def of_speeds(self) -> Prepared:
        """The same with accelerations that are slopes of a spline through the speeds of all recorded frames.

        OpenSim's StaticOptimization and what follows it take those, its InverseDynamicsTool those of a spline through
        coordinates. Both differ where a motion is noisy.
        """
        if self.speed_rates is None:
            return self
        return self._replace(states=replace(self.states, rates=self.speed_rates))

    @property
    def starts(self) -> list[int]:
        """First frames of all trials, and the number of all frames."""
        return [0, *np.cumsum([len(times) for times in self.times]).tolist()]

    def split(self, array: Floats) -> list[Floats]:
        """Rows of all frames, by trial."""
        return np.split(array, self.starts[1:-1])


@overload
def inverse_dynamics(
    model: SceneLike | BodyModel, coordinates: CoordinatesLike, loads: LoadsLike = None, *,
    filter: float | None = None, times: Floats | Sequence[Floats] | None = None, exact_rates: bool = False,
    device: str | None = None,
) -> Moments: ...  # fmt: skip
@overload
def inverse_dynamics(
    model: SceneLike | BodyModel, coordinates: Several, loads: LoadsLike = None, *,
    filter: float | None = None, times: Floats | Sequence[Floats] | None = None, exact_rates: bool = False,
    device: str | None = None,
) -> list[Moments]: ...  # fmt: skip
@answering(INSTEAD)
@said("finding moments")
def inverse_dynamics(
    model: SceneLike | BodyModel,
    coordinates: CoordinatesLike | Sequence[CoordinatesLike],
    loads: Loads | Sequence[Loads | None] | None = None,
    *,
    filter: float | None = None,
    times: Floats | Sequence[Floats] | None = None,
    exact_rates: bool = False,
    device: str | None = None,
) -> Moments | list[Moments]:
    """Generalised forces of inverse dynamics, for one trial or many at once.

    Args:
        model: a scene, its name or its file, such as a `.osim`.
        coordinates: of one trial or a list of trials; or the names of their files, see `files.read_coordinates`.
        loads: of the same trials, None of one without.
        filter: Hz, the cut-off of a low-pass filter of the coordinates; None for none.
        times: s, of the frames that are wanted, or a list of them by trial; by default all of the motion's.
        exact_rates: whether bodies beyond a joint of an OpenSim model whose coordinate turns it about three axes, such
            as a knee, speed up as their velocities change; OpenSim's do not (see `as_opensim.turned_axes`).
        device: "cpu", "cuda:0", ...; by default the first GPU, or the CPU without one.

    Warns:
        TrialWarning: what cannot well be, such as holes between frames, or loads that do not carry the body.

    Raises:
        ArgumentError: a motion of another model, loads of another time, or a cut-off that is none.
        SceneError: the model cannot be read.
    """
    many = are_several(coordinates)
    body = model if isinstance(model, BodyModel) else BodyModel(model, device)
    trials = prepare(body, coordinates, loads, filter, times, exact_rates)
    found = moments_of(body, trials)
    return found if many else found[0]


def moments_of(body: BodyModel, trials: Prepared) -> list[Moments]:
    """Generalised forces of prepared trials."""
    effort = body.dynamics(trials.states, trials.loads).effort
    forces = body.map.forces(effort, trials.states)
    units = tuple("N m" if unit == "rad" else "N" for unit in body.map.units)
    return [
        Moments(body.map.names, units, own, values, body.map.roots)
        for own, values in zip(trials.times, trials.split(forces), strict=True)
    ]


def prepare(
    body: BodyModel,
    coordinates: CoordinatesLike | Sequence[CoordinatesLike],
    loads: Loads | Sequence[Loads | None] | None,
    cutoff: float | None,
    times: Floats | Sequence[Floats] | None,
    exact_rates: bool = True,
    of_speeds: bool = False,
) -> Prepared:
    """Trials as states and loads of a model in all frames that are wanted; raises ArgumentError, see there.

    Args:
        of_speeds: whether `Prepared.of_speeds` is wanted, too.
    """
    as_truth(exact_rates, "exact_rates")
    motions = trials_of(coordinates, body.scene)
    given: list[Loads | None] = [None] * len(motions)
    if loads is not None:
        given = each_of(Loads, loads, "loads", " that warpmuscle.inverse.loads.read_loads reads, or None", none=True)
    if len(given) != len(motions):
        raise ArgumentError(f"there are loads of {number_of(len(given), 'trial')}, and coordinates of {len(motions)}")
    if not motions:
        raise ArgumentError("no trials are given")
    if not body_mass(body.scene.character) > 0.0:
        raise ArgumentError(f"the bodies of {body.scene.name!r} have no mass: no motion of it needs a force")
    parts, moving = [], []
    wanted: list[Floats | None] = [*times] if isinstance(times, (list, tuple)) else [times] * len(motions)  # type: ignore[list-item]
    if len(wanted) != len(motions):
        raise ArgumentError(f"there are times of {number_of(len(wanted), 'trial')}, and coordinates of {len(motions)}")
    for motion, one in zip(motions, wanted, strict=True):
        at = wanted_times(motion, one)
        moving.append((at, moved(body, motion, cutoff, at, of_speeds)))
    rates = [np.concatenate(arrays) for arrays in zip(*(motion for _, motion in moving), strict=True)]
    states = body.map.states(rates[0], rates[1], rates[2])
    speed_rates = body.map.states(rates[0], rates[1], rates[3]).rates if of_speeds else None
    starts = [0, *np.cumsum([len(at) for at, _ in moving]).tolist()]
    for k, load in enumerate(given):
        part = slice(starts[k], starts[k + 1])
        try:
            parts.append(loads_at(body, load, moving[k][0], states, part))
        except ArgumentError as error:
            raise ArgumentError(f"trial {k + 1}: {error}" if len(given) > 1 else str(error)) from None
    _warn(body, motions, given, states, starts, parts, [at for at, _ in moving])
    found = joined(parts)
    if not exact_rates and (seeming := seeming_loads(body, states, rates[0], rates[1])) is not None:
        found = found.beside(seeming)
    return Prepared([at for at, _ in moving], states, found, rates[0], speed_rates)


def are_several(coordinates: Any) -> bool:
    """Whether coordinates are those of a list of trials, rather than of one or the name of its file."""
    return not isinstance(coordinates, Coordinates | str | PathLike)


def trials_of(coordinates: Any, scene: Scene) -> list[Coordinates]:
    """Coordinates of one trial or several as a list, those of named files read; raises ArgumentError for others."""
    given = [coordinates] if isinstance(coordinates, str | PathLike) else coordinates
    if isinstance(given, list | tuple):
        given = [read_coordinates(Path(one), scene) if isinstance(one, str | PathLike) else one for one in given]
    return each_of(Coordinates, given, "coordinates", " or the name of its .mot file")


def _warn(
    body: BodyModel, motions: Sequence[Coordinates], given: Sequence[Loads | None], states: States,
    starts: Sequence[int], parts: Sequence[BodyLoads], times: Sequence[Floats],
) -> None:  # fmt: skip
    """Warn of what cannot well be in trials, whose frames have these times."""
    limits = _ranges(body)
    loaded = [k for k, loads in enumerate(given) if loads is not None and loads.plates]
    places = dict(zip(loaded, places_of(body, states, [starts[k] for k in loaded], [times[k] for k in loaded]),
                      strict=True))  # fmt: skip
    units = dict(zip(body.map.names, body.map.units, strict=True))
    for k, (motion, loads) in enumerate(zip(motions, given, strict=True)):
        known = [name for name in motion.names if name in units]
        values = np.stack([motion.of(name) for name in known], axis=1)
        notes = time_notes("the motion", motion.times)
        notes += value_notes(known, [units[name] for name in known], motion.times, values)
        notes += range_notes(known, values, limits)
        notes += side_notes(known, values)
        if body.scene.opensim is not None:
            notes += locked_notes(motion.names, motion.values, body.scene.opensim.locked)
        if loads is not None and loads.plates:
            notes += time_notes("the loads", loads.times)
            notes += _load_notes(body, loads, states.speeds[starts[k] : starts[k + 1]], times[k], parts[k], places[k])
        for note in notes:
            warnings.warn(f"trial {k + 1}: {note}" if len(motions) > 1 else note, TrialWarning, stacklevel=4)


def _ranges(body: BodyModel) -> dict[str, tuple[float, float]]:
    """Ranges of the coordinates that have one, rad or m, clamped or not."""
    found = dict(body.scene.opensim.ranges) if body.scene.opensim is not None else {}
    for name, joint in body.scene.character.joints.items():
        if name in body.map.names and len(joint.limits) == 1:
            found.setdefault(name, (first_number(joint.limits[0][0]), first_number(joint.limits[0][1])))
    units = dict(zip(body.map.names, body.map.units, strict=True))
    return {name: span for name, span in found.items() if units.get(name) == "rad"}


def _load_notes(
    body: BodyModel, loads: Loads, speeds: Floats, times: Floats, own: BodyLoads, places: Places
) -> list[str]:
    """Notes on loads of a trial with these speeds (n, S) at times (n,), some of whose frames are looked at."""
    notes = []
    mass = body_mass(body.scene.character)
    if body.map.roots >= FREE:
        moving, force = root_type(body.scene.character).moving, own.force.sum(axis=1)
        notes += weight_notes(force, mass)
        notes += push_notes(times, force, {"xyz"[axis]: speeds[:, k] for k, axis in enumerate(moving)}, mass)
    forces = placed_forces(body, [plate.name for plate in loads.plates], own, places)
    placed = place_notes(forces)
    return notes + (placed or swing_notes(forces, mass))


def wanted_times(motion: Coordinates, times: Floats | None) -> Floats:
    """Times of the frames that are wanted of a motion."""
    if times is None:
        return motion.times
    at = as_array(times, "times").astype(np.float64)
    late = 1e-6 + 1e-9 * abs(float(motion.times[-1]))
    inside = at.ndim == 1 and len(at) > 0 and (at >= motion.times[0] - late) & (at <= motion.times[-1] + late)
    if not np.all(inside):
        raise ArgumentError(f"times must be within the motion, from {motion.times[0]:g} to {motion.times[-1]:g} s")
    return at


def moved(
    body: BodyModel, motion: Coordinates, cutoff: float | None, at: Floats, of_speeds: bool = False
) -> list[Floats]:
    """Values (n, K) of a model's coordinates in their order, and their first and second derivatives.

    Args:
        of_speeds: whether the second derivative comes again, as the slope of a spline through speeds.
    """
    names = body.map.names
    known = [name for name in names if name in motion.names]
    missing = [name for name in names if name not in motion.names]
    if len(known) < FEW * len(names):
        raise ArgumentError(
            f"the motion has {len(known)} of the model's {number_of(len(names), 'coordinate')}, not "
            f"{', '.join(missing[:5])}; "
            f"it has {', '.join(motion.names[:5])}"
        )
    if missing:
        warnings.warn(
            f"the motion lacks {', '.join(missing[:5])}{' and others' if len(missing) > 5 else ''}, which "
            f"{'stay' if len(missing) > 1 else 'stays'} where the model has {'them' if len(missing) > 1 else 'it'}",
            stacklevel=4,
        )
    values = motion.values[:, [motion.names.index(name) for name in known]]
    for name, column in zip(known, values.T, strict=True):
        unit = body.map.units[names.index(name)]
        if (far := float(np.abs(column).max())) > (MOST if unit == "rad" else FARTHEST):
            asked = "in degrees" if unit == "rad" else "in another unit than m"
            raise ArgumentError(f"coordinate {name!r} comes to {far:.3g} {unit}; is the motion {asked}?")
    through = motion.times
    if cutoff is not None:
        cutoff = as_number(cutoff, "filter")
        through, values = low_pass(motion.times, values, cutoff)
    curves = spline(through, values, at, orders=3)
    if of_speeds:
        curves.append(spline(through, spline(through, values, through, orders=2)[1], at, orders=2)[1])
    found: list[Floats] = [np.zeros((len(at), len(names))) for _ in curves]
    found[0][:] = body.map.default
    places = [names.index(name) for name in known]
    for array, rates in zip(found, curves, strict=True):
        array[:, places] = rates
    return found


def loads_at(body: BodyModel, loads: Loads | None, at: Floats, states: States, part: slice) -> BodyLoads:
    """Loads of a trial at some times, on bodies of a model, world axes."""
    nothing = BodyLoads([], *(np.zeros((len(at), 0, 3)) for _ in range(3)))
    if loads is None or not loads.plates:
        return nothing
    if not reaches_over(loads.times, at[0], at[-1]):
        raise ArgumentError(
            f"the loads reach from {loads.times[0]:g} to {loads.times[-1]:g} s, the motion from {at[0]:g} to "
            f"{at[-1]:g} s; cut the motion, or give loads of its time"
        )
    first = max(int(np.searchsorted(loads.times, at[0])) - MARGIN, 0)
    rows = slice(first, int(np.searchsorted(loads.times, at[-1])) + MARGIN)
    columns = np.stack([[plate.force[rows], plate.point[rows], plate.moment[rows]] for plate in loads.plates])
    inside = np.clip(at, loads.times[0], loads.times[-1])
    values = spline(loads.times[rows], np.moveaxis(columns, 2, 0), inside, degree=3)[0]  # (n, P, 3, 3)
    force, point, moment = np.moveaxis(in_world(body, loads.plates, values, states, part), 2, 0)
    placed = on_feet(body, [plate.body for plate in loads.plates], [plate.name for plate in loads.plates],
                     force, point, states, part)  # fmt: skip
    number = [one.body for one in placed]
    chosen = [one.plate for one in placed]
    share = np.stack([one.share for one in placed], axis=1)[:, :, None] if placed else np.zeros((len(at), 0, 1))
    return BodyLoads(number, force[:, chosen] * share, point[:, chosen], moment[:, chosen] * share)


def joined(parts: Sequence[BodyLoads]) -> BodyLoads:
    """Loads of several trials one behind the other; what a trial does not have is zero there."""
    most: dict[int, int] = {}  # of each body, in any trial
    for part in parts:
        for body in set(part.body):
            most[body] = max(most.get(body, 0), part.body.count(body))
    bodies = [body for body, count in sorted(most.items()) for _ in range(count)]
    return BodyLoads(bodies, *(np.concatenate([_placed(part, field, bodies) for part in parts]) for field in (1, 2, 3)))


def _placed(part: BodyLoads, field: int, bodies: Sequence[int]) -> Floats:
    """Vectors (n, L, 3) of a trial in the places of its bodies among all, each of which is taken once."""
    values = (part.force, part.point, part.moment)[field - 1]
    found, free = np.zeros((len(values), len(bodies), 3)), list(range(len(bodies)))
    for k, body in enumerate(part.body):
        place = next(place for place in free if bodies[place] == body)
        free.remove(place)
        found[:, place] = values[:, k]
    return found
