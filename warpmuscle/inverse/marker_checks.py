"""What can be wrong with recorded markers: no common names, another unit, swapped labels, gaps, axes on their side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.arguments import in_words
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError, SignalError
from warpmuscle.core.plain_text import few_of, number_of
from warpmuscle.inverse.chain import Chain
from warpmuscle.inverse.fit_plan import Recorded, seen_in, squared_lengths
from warpmuscle.inverse.marker_fit import Fit
from warpmuscle.inverse.recorded_markers import BEYOND, NEAR, SUDDEN
from warpmuscle.inverse.trial import Markers
from warpmuscle.markers.files import UNITS

HEAVIEST = 1.0e12  # weight, as of the greatest number in a set-up
FEWEST = 3  # markers, from which a pose follows
ALIKE = 2.5  # times that a recorded body may be larger or smaller than the model
FAR = 0.1  # m, that a marker misses: more than skin moves
OUTLYING = 4.0  # times the median of all markers
SWAPPED = 0.5  # of the error, that is left once two labels are exchanged
LISTED = 6
UPRIGHT = -0.3  # correlation of heights in the model with recorded ones, below which a body is upside down


def chosen_markers(model: Sequence[str], markers: Markers, weights: Mapping[str, float] | None) -> dict[str, float]:
    """Weights of the markers that the model and the recording have in common, and that are seen at all.

    Raises:
        SignalError: a weight is of a marker that neither has, is negative, or fewer than three markers are left.
    """
    if weights is not None and not isinstance(weights, Mapping):
        raise ArgumentError(f"weights must be numbers by the names of markers, not {in_words(weights)}")
    for name, weight in (weights or {}).items():
        if not isinstance(weight, Real) or not 0.0 <= weight <= HEAVIEST:
            shown = f"{weight:g}" if isinstance(weight, Real) else in_words(weight)
            raise SignalError(f"marker {name!r}: a weight must be 0 or more, not {shown}; {HEAVIEST:g} is the greatest")
        if name not in model and name not in markers.names:
            raise SignalError(f"a weight is of the marker {name!r}, which neither the model nor the recording has")
    at_first = seen_in(markers.positions[0]).tolist()
    common = [
        name
        for k, name in enumerate(markers.names)
        if name in model and (at_first[k] or seen_in(markers.positions[:, k]).any())
    ]
    found = {name: 1.0 if weights is None else weights.get(name, 0.0) for name in common}
    found = {name: weight for name, weight in found.items() if weight > 0.0}
    if len(found) < FEWEST:
        raise SignalError(
            f"{number_of(len(found), 'marker')} of a weight in both the model and the recording; {FEWEST} at least are "
            "needed. "
            f"The model has {few_of(model, LISTED)}; the recording {few_of(markers.names, LISTED)}"
        )
    return found


def check_size(chain: Chain, names: Sequence[str], positions: Floats) -> None:
    """SignalError if the recorded body is of another size than the model, as in another unit.

    Args:
        names: (K,) of the markers. positions: (F, K, 3), NaN where one is missing.
    """
    far_away = max(-np.fmin.reduce(positions, axis=None), np.fmax.reduce(positions, axis=None)) > BEYOND
    for frame, marker, _ in np.argwhere(np.abs(positions) > BEYOND)[:1].tolist() if far_away else ():
        far = f"{np.nanmax(np.abs(positions[frame, marker])):.3g} m"
        raise SignalError(f"marker {names[marker]!r} is {far} away in frame {frame + 1}: cut it out, or give the unit")
    body = chain.resting(names)
    full = seen_in(positions)
    frame = int(full.sum(axis=1).argmax())
    there, own = positions[frame, full[frame]], body[full[frame]]
    size, expected = (float(np.sqrt(np.mean(np.var(p, axis=0)))) for p in (there, own))
    if expected / ALIKE < size < expected * ALIKE:
        return
    hint = "are its axes, labels and unit right?"
    for unit, metres in UNITS.items():
        if expected / ALIKE < size * metres < expected * ALIKE:
            hint = f"its numbers fit if they are in {unit}; give the unit"
        elif expected / ALIKE < size / metres < expected * ALIKE:
            hint = f"its numbers fit if they are in m rather than in {unit}; give the unit"
    raise SignalError(f"the recorded body is {size / max(expected, 1e-12):.3g} times as large as the model: {hint}")


def misfits(
    chain: Chain, names: Sequence[str], recordings: Sequence[Recorded], seen: Integers, far: NDArray[np.bool_],
    starts: Integers,
) -> Integers:  # fmt: skip
    """Recordings of which `check_size` has something to say, (n,), by the sizes of bodies in their fullest frames.

    Args:
        recordings: (T,). seen: (F,) how many markers a frame shows. far: (F,) whether one is far away.
        starts: (T,) first frames.
    """
    ends = [*starts[1:].tolist(), len(seen)]
    fullest = [int(seen[first:end].argmax()) for first, end in zip(starts.tolist(), ends, strict=True)]
    there = np.stack([one.chosen(frame) for one, frame in zip(recordings, fullest, strict=True)])
    body = chain.resting(names)
    known = seen_in(there)[..., None]
    sizes = []
    for places in (there, np.broadcast_to(body, there.shape)):
        count = known.sum(axis=1)
        off = np.where(known, places, 0.0)
        off = np.where(known, off - (off.sum(axis=1) / count)[:, None], 0.0)
        sizes.append(np.sqrt((np.square(off).sum(axis=1) / count).mean(axis=1)))
    usual = (sizes[1] / ALIKE * (1.0 + NEAR) < sizes[0]) & (sizes[0] < sizes[1] * ALIKE * (1.0 - NEAR))
    return np.flatnonzero(~usual | np.logical_or.reduceat(far, starts))


class Doubts(NamedTuple):
    """Where there may be something to note, by recording (T,): sums over its frames tell that cheaply."""

    loose: NDArray[np.bool_]  # of coordinates that markers do not tell
    turned: NDArray[np.bool_]  # of a body that is upside down
    slow: NDArray[np.bool_]  # of frames that did not converge
    missed: NDArray[np.bool_]  # of markers that miss by far

    @property
    def any(self) -> NDArray[np.bool_]:
        """Whether anything is in doubt."""
        return self.loose | self.turned | self.slow | self.missed


def doubts(chain: Chain, names: Sequence[str], fit: Fit, starts: Integers) -> Doubts:
    """What may be to be noted of each recording; `notes_on` looks closer.

    Args:
        fit: of all frames of all recordings. starts: (T,) first frames.
    """
    sums = fit.sums
    loose = np.logical_or.reduceat(fit.loose.any(axis=1), starts)
    slow = np.logical_or.reduceat(fit.iterations < 0, starts)
    with np.errstate(all="ignore"):
        rms = np.sqrt(sums.squares / sums.seen)
        usual = np.nanmedian(rms, axis=1)
        limit = np.maximum(FAR, OUTLYING * usual)[:, None] * (1.0 - NEAR)
        # the worst frame is far beyond the median one only if half of all are near beside it
        jumps = (np.sqrt(sums.most) > limit) & (2 * sums.near >= sums.seen)
        missed = (jumps | (rms > limit)).any(axis=1) | ~(usual <= FAR * (1.0 - NEAR))
    recorded, model = sums.height / np.maximum(sums.seen, 1), chain.resting(names)[:, 1]
    recorded, model = recorded - recorded.mean(axis=1, keepdims=True), model - model.mean()
    along, sizes = recorded @ model, np.sqrt(np.square(recorded).sum(axis=1) * np.square(model).sum())
    return Doubts(loose, ~(along > (UPRIGHT + NEAR) * sizes), slow, missed)


def notes_on(
    names: Sequence[str], chain: Chain, doubt: Doubts, number: int, recorded: Recorded, errors: Floats,
    iterations: Integers, loose: NDArray[np.bool_],
) -> list[str]:  # fmt: skip
    """What is to be known of a fit: coordinates that no marker tells, markers that miss, labels that seem swapped.

    Args:
        doubt: of all recordings, and this one's number. errors: (F, K, 3) m, in the axes recorded. iterations: (F,).
        loose: (F, C).
    """
    notes = _loose(chain, loose) if doubt.loose[number] else []
    if doubt.turned[number]:
        notes += _upside_down(names, chain, recorded.chosen())
    slow = np.flatnonzero(iterations < 0)
    if len(slow):
        notes.append(
            f"{number_of(len(slow), 'frame')} did not converge, the first is number {slow[0] + 1}; "
            "their markers fit badly"
        )
    if doubt.missed[number]:
        notes += _missed(names, recorded.chosen(), errors.astype(np.float64))
    return notes


def _missed(names: Sequence[str], positions: Floats, errors: Floats) -> list[str]:
    """Markers that miss by far: everywhere, under another's label, or in some frames."""
    squares = squared_lengths(errors)
    with np.errstate(all="ignore"):
        rms = np.sqrt(np.nanmean(squares, axis=0))
    usual = float(np.nanmedian(rms))
    if usual > FAR:
        return [
            f"half of all markers miss by {100 * usual:.0f} cm or more: are the axes and labels right, is the model of "
            "this subject?"
        ]
    notes, limit = [], max(FAR, OUTLYING * usual)
    bad = [k for k in np.argsort(-rms) if rms[k] > limit]
    swaps = _swaps(names, positions, errors, bad)
    if bad and not swaps:
        notes.append(f"markers miss by far, {_worst(names, rms, bad)}: is a label wrong?")
    return notes + swaps + _sudden(names, np.sqrt(squares), rms, limit)


def _upside_down(names: Sequence[str], chain: Chain, positions: Floats) -> list[str]:
    """A note where markers that are high up in the model are low in the recording; y is up in the axes of both."""
    model = chain.resting(names)[:, 1]
    seen = seen_in(positions)
    recorded = np.where(seen, positions[..., 1], 0.0).sum(axis=0) / np.maximum(seen.sum(axis=0), 1)
    if np.ptp(model) == 0.0 or np.ptp(recorded) == 0.0 or np.corrcoef(model, recorded)[0, 1] > UPRIGHT:
        return []
    return ["the body is upside down: is y the axis that points up? Moments and loads are wrong if it is another"]


def _worst(names: Sequence[str], rms: Floats, bad: list[int]) -> str:
    return ", ".join(f"{names[k]} by {100 * rms[k]:.0f} cm" for k in bad[:LISTED])


def _sudden(names: Sequence[str], far: Floats, rms: Floats, limit: float) -> list[str]:
    """Markers that are in their places but for some frames, where they miss (F, K) by more than a limit, m."""
    notes = []
    for k in np.flatnonzero((np.fmax.reduce(far, axis=0) > limit) & (rms <= limit)).tolist():
        beyond = max(limit, SUDDEN * float(np.nanmedian(far[:, k])))
        frames = np.flatnonzero(far[:, k] > beyond)
        if len(frames):
            notes.append(
                f"{names[k]}: off by {100.0 * far[frames, k].max():.0f} cm in {number_of(len(frames), 'frame')}, the "
                f"first is number {frames[0] + 1}: a wrong place turns bodies near it; cut it out there"
            )
    return notes[:LISTED]


def _swaps(names: Sequence[str], positions: Floats, errors: Floats, bad: list[int]) -> list[str]:
    """Pairs of markers that miss, and would miss by half as much under each other's names."""
    found = []
    fitted = positions - errors
    for i, a in enumerate(bad):
        for b in bad[i + 1 :]:
            with np.errstate(all="ignore"):
                now = np.nanmean(np.sum(errors[:, a] ** 2 + errors[:, b] ** 2, axis=1))
                crossed = (positions[:, a] - fitted[:, b]) ** 2 + (positions[:, b] - fitted[:, a]) ** 2
                then = np.nanmean(np.sum(crossed, axis=1))
            if then < SWAPPED**2 * now:
                found.append(f"the labels {names[a]} and {names[b]} seem to be swapped")
    return found


def _loose(chain: Chain, loose: NDArray[np.bool_]) -> list[str]:
    """Coordinates that markers do not tell: everywhere, or in some frames."""
    if not loose.any():
        return []
    everywhere, whole = np.asarray(loose.all(axis=0)), np.asarray(loose.all(axis=1))
    always = [name for name, nowhere in zip(chain.coordinates, everywhere.tolist(), strict=True) if nowhere]
    notes = []
    if always:
        notes.append(f"no marker tells {few_of(always, LISTED)}: they stay as the model starts")
    gaps: dict[bytes, list[str]] = {}  # coordinates by the frames in which they are not told
    for k, name in enumerate(chain.coordinates):
        only = loose[:, k] & ~whole
        if not everywhere[k] and only.any():
            gaps.setdefault(only.tobytes(), []).append(name)
    for pattern, names in gaps.items():
        frames = np.flatnonzero(np.frombuffer(pattern, bool))
        notes.append(_gap(f"markers that tell {few_of(names, LISTED)} are missing", frames))
    nothing = np.flatnonzero(whole)
    if len(nothing):
        notes.append(_gap("no marker is seen", nothing))
    return notes


def _gap(what: str, frames: Integers) -> str:
    count = number_of(len(frames), "frame")
    return f"{what} in {count}, the first is number {frames[0] + 1}: there it is as between those around"
