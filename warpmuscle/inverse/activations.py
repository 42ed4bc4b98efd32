"""How activations are asked for, and what is found of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from warpmuscle.core.arguments import as_number, as_truth
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.html_table import Tabulated
from warpmuscle.core.number_rows import first_number
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import Moments
from warpmuscle.inverse.trial import column_of, columns_to_dataframe
from warpmuscle.scene.muscles import given
from warpmuscle.scene.muscles.curves import DeGrooteCurves, MillardCurves

if TYPE_CHECKING:
    import pandas

POWERS = (1, 2, 3, 4)
FLAGGED = 0.05  # of the peak moment, that a reserve may not exceed (Hicks et al. 2015)
RESERVE = 0.1  # N m or N, of a reserve at which it costs as much as a full activation


@dataclass(frozen=True)
class ActivationOptions:
    """How activations are found.

    Attributes:
        power: p of costs a^p, 1 to 4. weight: "" for one each, or "volume" for the muscles' volumes over their mean.
        physiology: whether forces at full activation depend on length and speed; else they are f_max.
        passive: whether passive forces of muscles make moments, too; OpenSim's do not. Ligaments pull in any case.
        reserve: strength of the reserve of every coordinate, N m or N, or by name, "" for all others.
        least: least activation; None for each muscle's own.
        emg_weight: of (a - e)^2 beside costs a^2, for muscles with EMG.
        rates: whether an activation changes no faster from frame to frame than its time constants let it.
        elastic: whether tendons stretch by the forces of a first pass with rigid ones.
        pennation: whether fibres of Millard's and De Groote's muscles of an OpenSim model pull at their angle to the
            tendon; OpenSim's static optimisation leaves it out. It counts in any case where tendons stretch.
    """

    power: int = 2
    weight: str = ""
    physiology: bool = True
    passive: bool = False
    reserve: float | Mapping[str, float] = RESERVE
    least: float | None = None
    emg_weight: float = 0.0
    rates: bool = False
    elastic: bool = False
    pennation: bool = False

    def check(self, body: BodyModel) -> None:
        """Raise ArgumentError where an option is none, or options do not go together."""
        if not isinstance(self.power, int | np.integer) or isinstance(self.power, bool) or self.power not in POWERS:
            raise ArgumentError(f"power is 1, 2, 3 or 4, not {self.power!r}")
        for name in ("physiology", "passive", "rates", "elastic", "pennation"):
            as_truth(getattr(self, name), name)
        if not isinstance(self.weight, str) or self.weight not in ("", "volume"):
            raise ArgumentError(f'weight is "" or "volume", not {self.weight!r}')
        named = self.reserve if isinstance(self.reserve, Mapping) else {}
        unknown = next((name for name in named if name and name not in body.map.names), None)
        if unknown is not None:
            raise ArgumentError(f"reserve: no coordinate {unknown!r}; there are {', '.join(body.map.names)}")
        for strength in named.values() if isinstance(self.reserve, Mapping) else [self.reserve]:
            as_number(strength, "reserve: a strength, N m or N,", least=1e-4, most=1e6)
        if self.least is not None and as_number(self.least, "least, an activation,", least=0.0, most=1.0) == 1.0:
            raise ArgumentError("least, an activation, must be below 1")
        as_number(self.emg_weight, "emg_weight", least=0.0, most=1e6)
        if self.emg_weight > 0.0 and self.power != 2:
            raise ArgumentError("EMG counts beside squares of activations; use power = 2")


def widths_left_out(body: BodyModel) -> Floats:
    """Optimal lengths, widths, and optimal lengths as OpenSim takes them for an angle (3, M), m.

    The width is 0 of muscles whose pennation OpenSim counts, the last length 0 of those of which it asks for no angle.
    """
    model, found = body.scene.muscle_model, np.ones((3, len(body.muscles)))
    for k, name in enumerate(body.muscles):
        muscle = body.muscle(name)
        shape = given(muscle, model, "curve_shape")
        millard = isinstance(shape, MillardCurves) if shape is not None else model.curves == "millard"
        fregly = isinstance(shape, DeGrooteCurves) if shape is not None else model.curves == "de_groote"
        found[0, k] = first_number(muscle.l_opt)
        left_out = (millard or fregly) and body.scene.opensim is not None and body.pulls[k]
        found[1, k] = found[0, k] * np.sin(first_number(muscle.pennation)) if left_out else 0.0
        found[2, k] = 0.0 if fregly else 1.0
    return found


@dataclass(frozen=True, repr=False)
class Activations(Tabulated):
    """What M muscles of a model do in F frames, and what they cannot.

    Attributes:
        reserve: (F, K) N m or N, that coordinates need beside their muscles. unmuscled: coordinates that no muscle
            acts on, whose reserve is all of their moment, such as those of the root.
        iterations: (F,) of Newton's method, of the slowest group of coordinates; -1 where it did not converge.
    """

    muscles: tuple[str, ...]
    times: Floats  # (F,) s
    activation: Floats  # (F, M)
    force: Floats  # (F, M) N, along the tendon
    fibre_length: Floats  # (F, M) m
    fibre_velocity: Floats  # (F, M) m/s
    path_speed: Floats  # (F, M) m/s, of the whole unit
    moments: Moments  # that were needed
    reserve: Floats
    unmuscled: frozenset[str]
    iterations: Integers

    def of(self, name: str) -> Floats:
        """The activation (F,) of one muscle.

        Raises:
            ArgumentError: none has that name.
        """
        return column_of(self.muscles, self.activation, name, "muscle")

    __getitem__ = of

    def to_dataframe(self) -> pandas.DataFrame:
        """Activations: a row for each time, a column for each muscle; needs pandas."""
        return columns_to_dataframe(self.times, self.muscles, self.activation)

    @property
    def unconverged(self) -> list[int]:
        """Frames whose moments were not balanced."""
        return np.flatnonzero(self.iterations < 0).tolist()

    @property
    def power(self) -> Floats:
        """Power (F, M), W, of the muscles upon the skeleton: positive while they shorten."""
        return -self.force * self.path_speed

    @property
    def work(self) -> Floats:
        """Work (F, M), J, since the first frame."""
        step = np.diff(self.times)[:, None] * 0.5 * (self.power[1:] + self.power[:-1])
        return np.concatenate([np.zeros((1, len(self.muscles))), np.cumsum(step, axis=0)])

    def flagged(self, part: float = FLAGGED) -> list[tuple[int, str, float]]:
        """Frames in which a reserve is more than a part of its moment's peak: frame, coordinate, and that part."""
        peak = np.maximum(np.abs(self.moments.values).max(axis=0, initial=0.0), 1e-9)
        share = np.abs(self.reserve) / peak
        known = [k for k, name in enumerate(self.moments.names) if name not in self.unmuscled]
        found = np.argwhere(share[:, known] > part)
        return [(int(f), self.moments.names[known[k]], float(share[f, known[k]])) for f, k in found]
