"""EMG-driven estimation: parameters of muscles with which measured EMG makes the moments of recordings.

As Lloyd and Besier (2003) and Buchanan et al. (2004): EMG with a delay and a gain excites a muscle, whose activation is
shaped, and moves a Hill-type muscle on a rigid tendon along its path; parameters within bounds are searched so that
moments of all trials agree with those of inverse dynamics. Muscles without EMG have the activations of static
optimisation beside the EMG of the others. Members of an ensemble weigh parts of the trials by chance (a bootstrap), so
their spread says what the recordings tell of a parameter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from warpmuscle.core.arguments import as_integer, as_kind, as_number
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.html_table import Tabulated
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import SceneLike
from warpmuscle.inverse.activations import ActivationOptions
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import Prepared, prepare
from warpmuscle.inverse.emg import Emg
from warpmuscle.inverse.emg_driven.moments import EmgMoments
from warpmuscle.inverse.emg_driven.parameters import Bounds, ParameterCube
from warpmuscle.inverse.static_optimization import activations_of
from warpmuscle.inverse.trial import Coordinates, Loads, each_of
from warpmuscle.scene import Scene
from warpmuscle.search.cma import CmaSearch

EMG_WEIGHT = 10.0  # of EMG where activations of muscles without it are found
BLOCKS = 20  # parts of all frames, which members of an ensemble weigh by chance
AT_BOUND = 0.01  # of the width of bounds, below which a parameter is at an end of them
PRIOR = 0.001  # cost of parameters that are at their bounds all, beside 1 for moments that are not made at all


@dataclass(frozen=True, repr=False)
class Calibration(Tabulated):
    """What E members of an ensemble say of a model's muscles; the first one counts all frames alike.

    Attributes:
        measured: muscles with EMG. coordinates: (K,) whose moments were to be made.
        parameters: delay (E,), and gain, shape, f_max, l_opt, l_slack (E, M) by name; factors of the model's own.
        wanted: by trial (F, K) N m, of inverse dynamics. moments: by trial (E, F, K), by EMG.
        activations: by trial (E, F, M). cost: (E,) the part of the moments' squares that is not made, and the prior.
    """

    body: BodyModel
    measured: tuple[str, ...]
    coordinates: tuple[str, ...]
    bounds: Bounds
    parameters: dict[str, Floats]
    times: list[Floats]
    wanted: list[Floats]
    moments: list[Floats]
    activations: list[Floats]
    cost: Floats

    @property
    def rms(self) -> Floats:
        """Root mean square (K,), N m, of the first member's moments less those wanted, over all trials."""
        away = np.concatenate([own[0] for own in self.moments]) - np.concatenate(self.wanted)
        return np.asarray(np.sqrt(np.mean(np.square(away), axis=0)))

    def band(self, name: str, low: float = 5.0, high: float = 95.0) -> tuple[Floats, Floats, Floats]:
        """Low percentile, median and high percentile of a parameter: of the delay numbers, of others (M,)."""
        if name not in self.parameters:
            raise ArgumentError(f"no parameter {name!r}; there are {', '.join(self.parameters)}")
        found = np.percentile(self.parameters[name], [low, 50.0, high], axis=0)
        return found[0], found[1], found[2]

    @property
    def at_bounds(self) -> list[str]:
        """Parameters whose median is at an end of its bounds, as `delay` or `f_max of soleus_r`: look at wider ones."""
        found = []
        for name, values in self.parameters.items():
            low, high = getattr(self.bounds, name)
            median = np.atleast_1d(np.median(values, axis=0))
            near = (high > low) & (np.minimum(median - low, high - median) < AT_BOUND * (high - low))
            names = self.body.muscles if values.ndim == 2 else ("",)
            found += [
                f"{name} of {muscle}" if muscle else name
                for muscle, ended in zip(names, near, strict=True)
                if ended and (not muscle or muscle in self.measured)
            ]
        return found

    def scene(self) -> Scene:
        """The model with the medians of f_max, l_opt and l_slack, for static optimisation, tracking or a file."""
        scene = self.body.scene
        muscles = dict(scene.character.muscles)
        for name in self.measured:
            k = self.body.muscles.index(name)
            changes: dict[str, Any] = {
                field: float(np.median(self.parameters[field][:, k])) * float(getattr(muscles[name], field))
                for field in ("f_max", "l_opt", "l_slack")
            }
            muscles[name] = msgspec.structs.replace(muscles[name], **changes)
        return msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character, muscles=muscles))

    def predict(
        self,
        coordinates: Coordinates | Sequence[Coordinates],
        emg: Emg | Sequence[Emg],
        loads: Loads | Sequence[Loads | None] | None = None,
        *,
        filter: float | None = None,
    ) -> list[tuple[Floats, Floats]]:
        """Moments that EMG of other trials makes (E, F, K), and those of inverse dynamics (F, K), by trial.

        Raises:
            ArgumentError: see `calibrate`.
        """
        trials = prepare(self.body, coordinates, loads, filter, None)
        on_device = _with_emg(self.body, trials, each_of(Emg, emg, "emg"), self.coordinates)
        moments = on_device.moments(self.parameters)[1].numpy().astype(np.float64)
        cuts = trials.starts[1:-1]
        return list(zip(np.split(moments, cuts, axis=1), np.split(on_device.wanted, cuts), strict=True))


def calibrate(
    model: SceneLike | BodyModel,
    coordinates: Coordinates | Sequence[Coordinates],
    emg: Emg | Sequence[Emg],
    loads: Loads | Sequence[Loads | None] | None = None,
    *,
    of: Sequence[str],
    filter: float | None = None,
    times: Floats | Sequence[Floats] | None = None,
    bounds: Bounds | None = None,
    members: int = 8,
    generations: int = 150,
    seed: int = 0,
    device: str | None = None,
) -> Calibration:
    """Parameters of muscles with EMG, from moments of one trial or, better, of several together.

    Args:
        model, coordinates, loads, filter, times, device: see `inverse_dynamics`.
        emg: of the same trials and of the same muscles. of: names of the coordinates whose moments count.
        bounds: of the parameters. members: of the ensemble. generations: of each member's search.

    Raises:
        ArgumentError: see `inverse_dynamics`; EMG of other muscles or another time; a coordinate that no muscle with
            EMG acts on; numbers or bounds that are none.
    """
    body = model if isinstance(model, BodyModel) else BodyModel(model, device)
    bounds = Bounds() if bounds is None else as_kind(Bounds, bounds, "bounds")
    bounds.check()
    for name, count, most in (("members", members, 1000), ("generations", generations, 100000)):
        if not 1 <= as_number(count, name) <= most or count % 1:
            raise ArgumentError(f"{name} are 1 to {most}, not {count!r}")
    members, generations, seed = int(members), int(generations), as_integer(seed, "seed", least=0)
    trials = prepare(body, coordinates, loads, filter, times)
    on_device = _with_emg(body, trials, each_of(Emg, emg, "emg"), of)
    cube = ParameterCube(bounds, on_device.measured)
    points, cost = _searched(on_device, cube, members, generations, seed)
    parameters = cube.values(points)
    activation, moment = (array.numpy().astype(np.float64) for array in on_device.moments(parameters))
    cuts = trials.starts[1:-1]
    measured = tuple(name for name, known in zip(body.muscles, on_device.measured, strict=True) if known)
    return Calibration(
        body, measured, tuple(of), bounds, parameters, trials.times, np.split(on_device.wanted, cuts),
        np.split(moment, cuts, axis=1), np.split(activation, cuts, axis=1), cost,
    )  # fmt: skip


def _with_emg(body: BodyModel, trials: Prepared, emg: list[Emg], of: Sequence[str]) -> EmgMoments:
    """Trials with EMG on the device; ArgumentError where these do not go together."""
    if len(emg) != len(trials.times):
        raise ArgumentError(f"there is EMG of {number_of(len(emg), 'trial')}, and coordinates of {len(trials.times)}")
    speeds = _speeds(body, of, emg[0])
    dynamics = body.dynamics(trials.states, trials.loads)
    effort = dynamics.effort + dynamics.followed
    options = ActivationOptions(emg_weight=EMG_WEIGHT, passive=True, pennation=True)
    estimated = np.concatenate([one.activation for one in activations_of(body, trials, options, emg, effort)])
    return EmgMoments(body, trials, emg, estimated, speeds, effort[:, speeds])


def _speeds(body: BodyModel, of: Sequence[str], emg: Emg) -> Integers:
    """Numbers of the speeds of coordinates."""
    if isinstance(of, str) or not isinstance(of, Sequence) or not len(of):
        raise ArgumentError("of: name the coordinates whose moments count, as in of=['knee_angle_r']")
    found = []
    for name in of:
        if name not in body.map.names:
            raise ArgumentError(f"no coordinate {name!r}; there are {', '.join(body.map.names)}")
        speed = int(body.map.speed[body.map.names.index(name)])
        across = {body.muscles[m] for m in body.lever_muscle[body.lever_speed == speed]}
        if speed < 0 or not across & set(emg.muscles):
            raise ArgumentError(f"no muscle with EMG acts on {name!r} alone")
        found.append(speed)
    return np.array(found, dtype=np.int64)


def _searched(
    trials: EmgMoments, cube: ParameterCube, members: int, generations: int, seed: int
) -> tuple[Floats, Floats]:
    """The best points (E, D) and costs (E,) of all members, whose generations are evaluated together."""
    if cube.size < 2:
        raise ArgumentError("bounds leave less than two parameters to search")
    n = len(trials.wanted)
    blocks = np.unique(np.linspace(0, n, min(BLOCKS, n) + 1).astype(np.int64))
    random = np.random.default_rng(seed)
    count = len(blocks) - 1
    weight = random.multinomial(count, np.full(count, 1.0 / count), size=members).astype(np.float64)
    weight[0] = 1.0
    squares = np.add.reduceat(np.square(trials.wanted), blocks[:-1], axis=0)  # (B, K)
    total = np.maximum(np.einsum("eb,bk->ek", weight, squares), 1e-12)
    searches = [CmaSearch(cube.start, seed + 1 + k) for k in range(members)]
    best, cost = np.tile(cube.start, (members, 1)), np.full(members, np.inf)
    for _ in range(generations):
        running = [k for k, search in enumerate(searches) if not search.finished()]
        if not running:
            break
        asked = [searches[k].ask() for k in running]
        points = np.concatenate(asked)
        errors = trials.errors(cube.values(points), blocks)
        first = 0
        for k, own in zip(running, asked, strict=True):
            part = errors[first : first + len(own)]
            first += len(own)
            costs = np.mean(np.einsum("cbk,b->ck", part, weight[k]) / total[k], axis=1)
            costs = costs + PRIOR * np.mean(np.square(2.0 * (own - cube.start)), axis=1)
            least = int(np.argmin(costs))
            if costs[least] < cost[k]:
                best[k], cost[k] = own[least], costs[least]
            searches[k].tell(costs)
    return best, cost
