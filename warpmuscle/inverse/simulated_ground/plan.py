"""A motion near a recorded one that the ground alone carries, and efforts of its joints with which it runs forward.

Multiple shooting: states between windows and efforts there, even over each window, are all unknown; gaps between the
end of a window and the start of the next close as the cost falls (Bock and Plitt 1984). Each iteration of Gauss and
Newton simulates all windows and their differences at once, and solves a linear-quadratic problem (Giftthaler et al.
2018, IROS). The same differences give gains of a feedback with which a run by muscles stays near the motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.number_rows import first_number
from warpmuscle.inverse.simulated_ground.linear_quadratic import Costs, solve
from warpmuscle.inverse.simulated_ground.windows import Windows
from warpmuscle.inverse.tracking.state_difference import difference, moved_by
from warpmuscle.scene.joints import root_type

ANGLE, PLACE = np.radians(2.0), 0.04  # rad or m of joints and turns of the root, and m of its place, that cost 1/2
TURNING, MOVING = 0.5, 0.3  # rad/s or m/s, and m/s, the same of speeds
EFFORT, CHANGE = 0.08, 0.027  # of the weight times m: efforts beside the recorded ones, and change by a window
GAP = 20.0  # what a gap of one of these costs, in the search along a step
MOST, SHARES = 25, (1.0, 0.5, 0.25, 0.1, 0.03)  # iterations, and shares of a step that are tried
SETTLED = 3e-3  # the part of costs and gaps that an iteration gains, in the end
FEEDBACK, CHANGED = 0.0136, 0.0068  # of the weight times m: effort that a feedback spends, and its change, at most,
SWIFT = 4.0, 2.0  # or as many times what changes a speed by TURNING in a window


@dataclass(frozen=True)
class Plan:
    """N windows.

    Attributes:
        coordinates: (N + 1, C) of the state. speeds: (N + 1, S). effort: (N + 1, m) N m or N, between windows.
        by_state, by_effort: (N, 2S, 2S) and (N, 2S, m), how ends of windows change with starts and efforts over them.
        gain: (N, m, 2S + m), what is added to the effort at a window's end for a way, a speed and an effort beside the
            plan at its start. gap: the greatest, 1 being one of the costs' lengths. iterations: that were needed.
    """

    coordinates: Floats
    speeds: Floats
    effort: Floats
    by_state: Floats
    by_effort: Floats
    gain: Floats
    gap: float
    iterations: int


class _Lengths(NamedTuple):
    """What costs 1/2 each, along states and efforts."""

    state: Floats  # (2S,) of ways and speeds
    effort: Floats  # (m,) beside the recorded ones
    change: Floats  # (m,) of that, over a window


class _Try(NamedTuple):
    """States and efforts between windows, the windows' ends, and what they cost."""

    q: Floats
    v: Floats
    effort: Floats
    end: tuple[Floats, Floats]
    gap: Floats  # (N, 2S)
    away: Floats  # (N + 1, 2S) from the recording
    more: Floats  # (N + 1, m) than recorded
    cost: float
    merit: float  # cost and gaps; infinite where a window diverges

    def greatest_gap(self, lengths: _Lengths) -> float:
        return float(np.abs(self.gap / lengths.state).max())


class Planner:
    """Plans for recorded motions of one body."""

    def __init__(self, windows: Windows) -> None:
        self.windows, self.body = windows, windows.body
        places = len(root_type(self.body.scene.character).moving)
        ways, speeds = np.full(windows.speeds, ANGLE), np.full(windows.speeds, TURNING)
        ways[:places], speeds[:places] = PLACE, MOVING
        masses = [first_number(one.mass) for one in self.body.scene.character.bodies.values()]
        self._weight = sum(masses) * first_number(self.body.scene.gravity)
        spent, changed = (np.full(windows.efforts, part * self._weight) for part in (EFFORT, CHANGE))
        self._lengths = _Lengths(np.concatenate([ways, speeds]), spent, changed)

    def plan(self, q: Floats, v: Floats, effort: Floats) -> Plan:
        """The plan near states (N + 1, C) and (N + 1, S) and efforts (N + 1, m).

        Raises:
            ArgumentError: windows that begin at the recording diverge.
        """
        recorded = q, v, effort
        now = self._try(*recorded, recorded)
        a, b = self._derivatives(now)
        iterations, settled = 0, False
        while iterations < MOST and not settled:
            iterations += 1
            step = solve(*_with_efforts(a, b), _padded(now.gap, self.windows.efforts), self._costs(now))
            tries = (self._moved(now, share * step.state, recorded) for share in SHARES)
            better = next((one for one in tries if one.merit < now.merit), None)
            if better is None:
                break
            settled = better.merit > (1.0 - SETTLED) * now.merit
            now = better
            a, b = self._derivatives(now)
        gap = now.greatest_gap(self._lengths)
        return Plan(now.q, now.v, now.effort, a, b, self._gains(a, b), gap, iterations)

    def _derivatives(self, now: _Try) -> tuple[Floats, Floats]:
        a, b = self.windows.derivatives(now.q[:-1], now.v[:-1], _middle(now.effort), now.end)
        if not (np.isfinite(a).all() and np.isfinite(b).all()):
            raise ArgumentError("the motion cannot be put onto the ground: its simulation diverges within a window; "
                                "look whether loads and motion are of one trial")  # fmt: skip
        return a, b

    def _moved(self, now: _Try, change: Floats, recorded: tuple[Floats, Floats, Floats]) -> _Try:
        speeds = self.windows.speeds
        q, v = moved_by(self.body, now.q, change[:, :speeds]), now.v + change[:, speeds : 2 * speeds]
        return self._try(q, v, now.effort + change[:, 2 * speeds :], recorded)

    def _try(self, q: Floats, v: Floats, effort: Floats, recorded: tuple[Floats, Floats, Floats]) -> _Try:
        end = self.windows.run(q[:-1], v[:-1], _middle(effort))
        gap = np.concatenate([difference(self.body, q[1:], end[0]), end[1] - v[1:]], axis=1)
        away = np.concatenate([difference(self.body, recorded[0], q), v - recorded[1]], axis=1)
        more, lengths = effort - recorded[2], self._lengths
        parts = away / lengths.state, more / lengths.effort, np.diff(more, axis=0) / lengths.change
        cost = 0.5 * sum(float(np.square(part).sum()) for part in parts)
        merit = cost + GAP * float(np.abs(gap / lengths.state).sum())
        return _Try(q, v, effort, end, gap, away, more, cost, merit if np.isfinite(merit) else np.inf)

    def _costs(self, now: _Try) -> Costs:
        """Of changes of states and of efforts at a window's start, and of efforts at its end."""
        lengths = self._lengths
        slope = np.concatenate([now.away / lengths.state**2, now.more / lengths.effort**2], axis=1)
        push = np.diff(now.more, axis=0) / lengths.change**2
        slope[:-1, len(lengths.state) :] -= push
        return _bends(lengths)._replace(slope=slope, push=push)

    def _gains(self, a: Floats, b: Floats) -> Floats:
        """Gains of the feedback, which spends little where little is needed."""
        steps, two, efforts = b.shape
        own = np.arange(efforts)
        swift = np.median(np.abs(b[:, two - efforts + own, own]), axis=0)  # of a speed by its own effort
        spent, changed = (
            np.minimum(part * self._weight, times * TURNING / np.maximum(swift, 1e-9))
            for part, times in zip((FEEDBACK, CHANGED), SWIFT, strict=True)
        )
        costs = _bends(self._lengths._replace(effort=spent, change=changed))._replace(
            slope=np.zeros((steps + 1, two + efforts)), push=np.zeros((steps, efforts))
        )
        return solve(*_with_efforts(a, b), np.zeros((steps, two + efforts)), costs).gain


def _bends(lengths: _Lengths) -> Costs:
    """Second derivatives of the costs."""
    last = np.diag(np.concatenate([lengths.state, lengths.effort]) ** -2.0)
    state, control, efforts = last.copy(), np.diag(lengths.change**-2.0), slice(len(lengths.state), None)
    state[efforts, efforts] += control
    cross = np.zeros((len(control), len(last)))
    cross[:, efforts] = -control
    return Costs(state, last, control, cross, np.zeros(0), np.zeros(0))


def _middle(effort: Floats) -> Floats:
    """Efforts over windows, that change evenly from one end to the other."""
    return 0.5 * (effort[:-1] + effort[1:])


def _padded(gap: Floats, efforts: int) -> Floats:
    return np.concatenate([gap, np.zeros((len(gap), efforts))], axis=1)


def _with_efforts(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """The system whose states have the efforts at a window's start, and whose controls are those at its end."""
    steps, size, efforts = b.shape
    whole = np.zeros((steps, size + efforts, size + efforts))
    whole[:, :size, :size], whole[:, :size, size:] = a, 0.5 * b
    by = np.zeros((steps, size + efforts, efforts))
    by[:, :size], by[:, size:] = 0.5 * b, np.eye(efforts)
    return whole, by
