"""Computed muscle control: excitations with which a simulation follows recorded motions.

As OpenSim's CMC (Thelen, Anderson, Delp 2003), window by window: accelerations that lead back to the motion,
generalised forces that they need, forces that muscles can come to by the window's end under least and full excitation,
static optimisation within these, and excitations that lead to the forces. Unlike OpenSim's,
it adds to the accelerations what those of the windows before fell short by. All trials are instances of one simulation.

As everything is simulated by the same step, the excitations run the motion again by themselves. `track` does so, and
says how far that run is from the recording.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import SceneLike
from warpmuscle.inverse.activations import ActivationOptions
from warpmuscle.inverse.body_model import BodyLoads, BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.dynamics import Prepared, prepare, wanted_times
from warpmuscle.inverse.static_optimization import activations_of
from warpmuscle.inverse.tracking.driven_body import DrivenBody
from warpmuscle.inverse.tracking.force_sharing import ForceSharing, interpolated
from warpmuscle.inverse.tracking.look_ahead import LookAhead
from warpmuscle.inverse.tracking.state_difference import difference, moved_by
from warpmuscle.inverse.tracking.tracked import Tracked
from warpmuscle.inverse.trial import Coordinates, Loads, TrialWarning
from warpmuscle.scene.muscles import given

MENDED = 0.3  # of what accelerations fell short by, that is added to those of the next window
TRIES = 3  # to find excitations that lead to forces, between least and full ones


@dataclass(frozen=True)
class TrackingOptions:
    """How a motion is followed.

    Attributes:
        window: s, over which excitations are constant. kp: 1/s^2, kv: 1/s, of the accelerations that lead back.
        reserve: N m or N, strength of reserves beside muscles, as of static optimisation.
        reserves: whether what muscles cannot make acts besides, or is only told.
        residuals: whether forces act on the root that nothing makes.
    """

    window: float = 0.01
    kp: float = 100.0
    kv: float = 20.0
    reserve: float = 0.1
    reserves: bool = True
    residuals: bool = True

    def check(self) -> None:
        """Raise ArgumentError where an option is none."""
        for name, least, most in (("window", 1e-3, 0.1), ("kp", 0.0, 1e4), ("kv", 0.0, 1e3), ("reserve", 1e-4, 1e6)):
            value = getattr(self, name)
            if not (np.isfinite(value) and least <= value <= most):
                raise ArgumentError(f"{name} is a number from {least:g} to {most:g}, not {value!r}")


def track(
    model: SceneLike | BodyModel,
    coordinates: Coordinates | Sequence[Coordinates],
    loads: Loads | Sequence[Loads | None] | None = None,
    *,
    filter: float | None = None,
    begin: float | Sequence[float] | None = None,
    end: float | Sequence[float] | None = None,
    device: str | None = None,
    **options: object,
) -> Tracked | list[Tracked]:
    """Excitations that let a model follow motions, of one trial or of many at once.

    Args:
        model, coordinates, loads, filter, device: see `inverse_dynamics`.
        begin, end: s, which part of the motions, by default all; one number or one a trial.
        options: see `TrackingOptions`: window, kp, kv, reserve, reserves, residuals.

    Raises:
        ArgumentError: see `inverse_dynamics`; an option that is none; a part shorter than a window.
        SceneError: the model cannot be read, or has no muscles.
    """
    many = not isinstance(coordinates, Coordinates)
    body = model if isinstance(model, BodyModel) else BodyModel(model, device)
    unknown = next((name for name in options if name not in TrackingOptions.__dataclass_fields__), None)
    if unknown is not None:
        raise ArgumentError(f"no option {unknown!r}; there are {', '.join(TrackingOptions.__dataclass_fields__)}")
    motions = [coordinates] if isinstance(coordinates, Coordinates) else list(coordinates)
    chosen = TrackingOptions(**options)  # type: ignore[arg-type]
    found = track_trials(body, motions, loads, chosen, filter, begin, end)
    return found if many else found[0]


def track_trials(
    body: BodyModel,
    motions: Sequence[Coordinates],
    loads: Loads | Sequence[Loads | None] | None,
    options: TrackingOptions,
    cutoff: float | None = None,
    begin: float | Sequence[float] | None = None,
    end: float | Sequence[float] | None = None,
) -> list[Tracked]:
    """The same of a list of trials."""
    options.check()
    if not body.muscles:
        raise ArgumentError("the model has no muscles")
    step = body.scene.time_step
    window = max(round(options.window / step), 1) * step
    trials = prepare(body, motions, loads, cutoff, window_times(motions, window, begin, end))
    tracker = Tracker(body, trials, options)
    tracker.follow()
    tracker.repeat()
    found = tracker.results()
    lost = [k for k, one in enumerate(found) if one.lost is not None]
    if lost:
        first = found[lost[0]]
        warnings.warn(
            TrialWarning(f"{number_of(len(lost), 'trial')} of {len(found)} could not be followed, trial {lost[0] + 1} "
                         f"only until {first.lost:.3g} s: its simulation diverged, and is left out from there on"),
            stacklevel=3,
        )  # fmt: skip
    return found


def window_times(
    motions: Sequence[Coordinates],
    window: float,
    begin: float | Sequence[float] | None,
    end: float | Sequence[float] | None,
) -> list[Floats]:
    """Times between windows of each motion; raises ArgumentError if there is no whole window."""
    firsts, lasts = (list(one) if isinstance(one, (list, tuple)) else [one] * len(motions) for one in (begin, end))
    if len(firsts) != len(motions) or len(lasts) != len(motions):
        raise ArgumentError(f"begin and end are one number, or one for each of {number_of(len(motions), 'motion')}")
    found = []
    for motion, first, last in zip(motions, firsts, lasts, strict=True):
        start = float(motion.times[0]) if first is None else max(float(first), float(motion.times[0]))
        stop = float(motion.times[-1]) if last is None else min(float(last), float(motion.times[-1]))
        if not stop - start >= 0.999 * window:
            raise ArgumentError(
                f"no window of {window:g} s lies between {start:g} and {stop:g} s; the motion is of "
                f"{motion.times[0]:g} to {motion.times[-1]:g} s"
            )
        count = int((stop - start) / window + 1e-3)
        found.append(wanted_times(motion, np.minimum(start + window * np.arange(count + 1), motion.times[-1])))
    return found


class Tracker:
    """Follows prepared trials, whose frames lie between windows, all at once."""

    def __init__(self, body: BodyModel, trials: Prepared, options: TrackingOptions) -> None:
        self.body, self.trials, self.options = body, trials, options
        counts = np.array([len(times) for times in trials.times])
        self.windows, self.count = int(counts.max()) - 1, len(counts)
        each = np.minimum(np.arange(self.windows + 1)[:, None], counts - 1)
        self._row = np.array(trials.starts[:-1]) + each  # frames of all trials, by window; short ones stay at their end
        duration = (self.windows + 1) * options.window
        self.driven = DrivenBody(body, self.count, options.window, trials.loads.body, duration)
        self._ahead = LookAhead(self.driven)
        self.sharing = ForceSharing(body, np.full(body.topology.speeds, options.reserve))
        speeds, muscles, root = body.topology.speeds, len(body.muscles), body.topology.speed_start[1]
        self._acts = np.zeros(speeds, dtype=bool)  # whether forces act along a speed beside muscles
        self._acts[:root] = options.residuals
        self._acts[root:] = options.reserves | self.sharing.bare[root:]
        model = body.scene.muscle_model
        least = [float(given(body.muscle(name), model, "minimum_activation") or 0.0) for name in body.muscles]
        self._least, self._most = np.tile(least, (self.count, 1)), np.ones((self.count, muscles))
        self._missed, self._before = np.zeros((self.count, speeds)), np.zeros((self.count, speeds))
        self._initial = self._initial_activation()
        shape = self.windows, self.count
        self._excitation, self._force = np.zeros((*shape, muscles)), np.zeros((*shape, muscles))
        self._effort, self._lacking = np.zeros((*shape, speeds)), np.zeros((*shape, speeds))
        self._iterations: Integers = np.zeros(shape, dtype=np.int64)
        self._state = np.zeros((self.windows + 1, self.count, body.topology.coordinates))
        self._activation = np.zeros((self.windows + 1, self.count, muscles))
        self._alive = np.ones((self.windows + 1, self.count), dtype=bool)

    def _initial_activation(self) -> Floats:
        """Activations (n, M) by static optimisation of the first frames."""
        first = self._row[0]
        states, loads = _frames(self.trials.states, first), _loads_of(self.trials.loads, first)
        alone = Prepared([times[:1] for times in self.trials.times], states, loads, self.trials.values[first])
        found = activations_of(self.body, alone, ActivationOptions(passive=True, elastic=True))
        return np.concatenate([one.activation for one in found])

    def _loads(self, window: int) -> BodyLoads:
        return _loads_of(self.trials.loads, self._row[window])

    def _start(self) -> None:
        self.driven.start(_frames(self.trials.states, self._row[0]), self._initial)
        self._state[0], self._activation[0] = self.driven.state()[0], self._initial

    def follow(self) -> None:
        """Follow the motions from their starts."""
        self._start()
        for window in range(self.windows):
            self._follow(window)

    def _follow(self, w: int) -> None:
        """Follow the motions over a window."""
        now, then = (_frames(self.trials.states, self._row[k]) for k in (w, w + 1))
        alive = self._alive[w][:, None]
        q, v = self.driven.state()
        away = difference(self.body, np.where(alive, q, now.coordinates), now.coordinates)
        slower = np.where(alive, now.speeds - v, 0.0)
        rates = then.rates + self.options.kp * away + self.options.kv * slower
        coordinates = moved_by(self.body, then.coordinates, -away)
        expected = States(coordinates, then.speeds - slower, rates + self._missed, then.by_root)
        dynamics = self.body.dynamics(expected, self._loads(w + 1))
        needed = dynamics.effort + dynamics.followed
        self._ahead.begin(
            States(np.where(alive, q, now.coordinates), now.speeds - slower, now.rates, now.by_root), expected
        )
        low, high = self._ahead.reach(self._least), self._ahead.reach(self._most)
        shares = self.sharing.share(expected, needed, low, high)
        wanted = low.force + shares.share * np.maximum(high.force - low.force, 0.0)
        tried = [(self._least, low.force), (self._most, high.force)]
        for _ in range(TRIES):
            excitation = interpolated(wanted, tried)
            tried.insert(-1, (excitation, self._ahead.reach(excitation).force))
        self._excitation[w], self._iterations[w] = interpolated(wanted, tried), shares.iterations
        self._lacking[w] = np.where(self.sharing.bare, needed, shares.reserve)
        self._effort[w] = np.where(self._acts, self._lacking[w], 0.0).astype(np.float32)
        self._run(w)
        got = np.where(alive, self.driven.state()[1] - v, 0.0) / self.driven.window
        asked = rates if w == 0 else 0.5 * (self._before + rates)  # forces rise over the window
        self._missed = np.where(self._alive[w + 1][:, None], self._missed + MENDED * (asked - got), 0.0)
        self._before = rates

    def _tell(self, w: int, effort: Floats) -> None:
        self.driven.tell(effort, self._loads(w), self._loads(w + 1))

    def _run(self, w: int) -> None:
        """Simulate a window with what was found for it."""
        self._tell(w, self._effort[w])
        self.driven.run(self._excitation[w])
        self._alive[w + 1] = self._alive[w] & self.driven.runs()
        alive = self._alive[w + 1][:, None]
        self._state[w + 1] = np.where(alive, self.driven.state()[0], self._state[w])
        self._activation[w + 1] = np.where(alive, self.driven.activation(), self._activation[w])
        self._force[w] = np.where(alive, self.driven.force(), 0.0)

    def repeat(self) -> None:
        """Run the motions from their starts by excitations alone, and whatever acts besides as it was told."""
        self._start()
        for window in range(self.windows):
            self._run(window)

    def results(self) -> list[Tracked]:
        """What was found, by trial."""
        return [self._result(k) for k in range(self.count)]

    def _result(self, k: int) -> Tracked:
        body, times = self.body, self.trials.times[k]
        last = int(self._alive[: len(times), k].sum()) - 1  # the window after which it is lost, or all
        rows, part = self._row[: last + 1, k], slice(0, last)
        before = _frames(self.trials.states, rows[:-1])
        acting, lacking = (body.map.forces(one[part, k], before) for one in (self._effort, self._lacking))
        return Tracked(
            body.muscles, body.map.names, tuple(body.map.units), body.map.roots, times[: last + 1],
            self.trials.values[rows], body.map.values(self._state[: last + 1, k]), self._excitation[part, k],
            self._activation[: last + 1, k], self._force[part, k], acting, lacking, self._iterations[part, k],
            (self.trials.states.coordinates[rows[0]], self.trials.states.speeds[rows[0]]),
            None if last == len(times) - 1 else float(times[last]),
        )  # fmt: skip


def _frames(states: States, rows: Integers) -> States:
    """Some of the frames."""
    by_ball = {name: values[rows] for name, values in states.by_ball.items()}
    return States(states.coordinates[rows], states.speeds[rows], states.rates[rows], states.by_root[rows], by_ball)


def _loads_of(loads: BodyLoads, rows: Integers) -> BodyLoads:
    """Loads of some frames."""
    return BodyLoads(loads.body, loads.force[rows], loads.point[rows], loads.moment[rows])
