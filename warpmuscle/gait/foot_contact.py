"""When feet are on the ground, from the vertical force on them: touch-downs, lift-offs, and the gait cycles between.

`kernels.contact.gait_cycle` follows the same rule step by step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.results.recording import Recording
from warpmuscle.scene.ground import HELD, LIFTED, LOADED

SIDES = ("left", "right")


class Contact(NamedTuple):
    """A time on the ground, s; None where it began before the recording, or lasted beyond it."""

    touch_down: float | None
    lift_off: float | None


def contacts(time: Floats, force: Floats, weight: float) -> list[Contact]:
    """Times that a foot spends on the ground, in order.

    The foot is loaded while the vertical force on it is over 3 % of the body weight. A load of less than 20 ms is no
    contact; a gap of less than 0.2 s, in which it bounces or drags, does not end one. A foot lifts off where the force
    crosses the bound, linearly interpolated between samples; it touches down, which is sudden, in the middle between
    two samples.

    Args:
        time: (F,) s. force: (F,) N, vertical. weight: N, of the body.
    """
    clock, bound = np.asarray(time, dtype=float), LOADED * weight
    excess = np.asarray(force, dtype=float) - bound
    spells = [Contact(*edges) for edges in _above(clock, excess)]
    lasting = [spell for spell in spells if _lasts(spell)]
    merged: list[Contact] = []
    for spell in lasting:
        if merged and spell.touch_down is not None and spell.touch_down - (merged[-1].lift_off or 0.0) < LIFTED:
            merged[-1] = Contact(merged[-1].touch_down, spell.lift_off)
        else:
            merged.append(spell)
    return merged


def _above(clock: Floats, excess: Floats) -> list[tuple[float | None, float | None]]:
    """Begin and end, s, of every time in which values (F,) are above 0; None at the ends of the recording."""
    on = excess > 0.0
    edges = np.flatnonzero(on[1:] != on[:-1])
    part = np.where(on[edges], excess[edges] / (excess[edges] - excess[edges + 1]), 0.5)
    times: list[float | None] = (clock[edges] + part * (clock[edges + 1] - clock[edges])).tolist()
    if len(on) and on[0]:
        times.insert(0, None)
    if len(on) and on[-1]:
        times.append(None)
    return list(zip(times[::2], times[1::2], strict=True))


def _lasts(spell: Contact) -> bool:
    begin, end = spell
    return begin is None or end is None or end - begin >= HELD


def mean_load(recording: Recording) -> float:
    """Mean vertical force on both feet, N: over whole cycles of a gait, the body weight."""
    both = recording["foot_force_left"][:, 1] + recording["foot_force_right"][:, 1]
    return float(np.mean(both, dtype=float)) if recording.frames else 0.0


def contacts_of(recording: Recording, side: str, weight: float | None = None) -> list[Contact]:
    """Times that the left or right foot spends on the ground, see `contacts`.

    A foot that is loaded in the first step of a motion stood on the ground before it.

    Args:
        weight: N, of the body; by default the mean load of both feet.
    """
    known = mean_load(recording) if weight is None else weight
    force = recording[f"foot_force_{side}"][:, 1].astype(float)
    if len(force) > 1 and recording.time[0] == 0.0:
        force[0] = force[1]  # there is no step before the first frame, whose force that would be
    return contacts(recording.time, force, max(known, 1.0))


def touch_downs(recording: Recording, side: str, weight: float | None = None) -> Floats:
    """Times (n,), s, at which a foot, left or right, comes down on the ground; see `contacts_of`."""
    return np.array([one.touch_down for one in contacts_of(recording, side, weight) if one.touch_down is not None])


class Support(NamedTuple):
    """Parts of the gait cycle, %, the mean of both sides."""

    stance: float  # a foot is on the ground
    double: float  # both feet are, in all
    flight: float  # no foot is, in all


def support(recording: Recording, start: float, end: float, weight: float | None = None) -> Support:
    """Shares of a time of walking, which should be whole gait cycles, that one, both or no feet are on the ground.

    Args:
        start, end: s, within the recording.

    Raises:
        Error: the time is empty.
    """
    if not end > start:
        raise Error(f"no support between {start:g} and {end:g} s: the time is empty")
    left, right = (_within(contacts_of(recording, side, weight), start, end) for side in SIDES)
    both = sum(max(min(a[1], b[1]) - max(a[0], b[0]), 0.0) for a in left for b in right)
    on = [float(np.sum(np.diff(spans, axis=1))) for spans in (left, right)]
    whole = end - start
    flight = max(whole - sum(on) + both, 0.0)
    return Support(50.0 * sum(on) / whole, 100.0 * both / whole, 100.0 * flight / whole)


def _within(spells: list[Contact], start: float, end: float) -> Floats:
    """Begin and end, s, (K, 2), of what lies within a time."""
    spans = [
        (max(start, begin if begin is not None else start), min(end, stop if stop is not None else end))
        for begin, stop in spells
    ]
    return np.array([span for span in spans if span[1] > span[0]]).reshape(-1, 2)
