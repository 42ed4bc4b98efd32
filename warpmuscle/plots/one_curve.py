"""One curve of a motion by its name: an angle, a moment, a muscle; over the gait cycle, or over time."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.extras import imported
from warpmuscle.gait.curves import frame_curves, gait_curves
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.plots.angles import angle_bands, legend_below
from warpmuscle.plots.style import BAND_COLOR, PALETTE, SIDE_COLORS, cycle_curves, heading, page
from warpmuscle.plots.subject import Subject
from warpmuscle.results.degrees_of_freedom import degrees_of_freedom
from warpmuscle.scene.norms import LEG_ANGLES

if TYPE_CHECKING:
    import xarray

    from warpmuscle.results.recording import Recording

HEIGHT = 3.0  # inches
SIDES = ("left", "right")
SIDE = re.compile(r"^[lr](?=[A-Z])|_[lrLR]$")  # in names of muscles


def draw(subject: Subject, names: Sequence[str]) -> Any:
    """Curves below one another: over the gait cycle, both sides, with people's; or over time, of what has no cycles.

    Args:
        names: of `curve_names`, in any case.
    """
    figure = page(HEIGHT * len(names))
    cyclic = gait_curves(subject.recording, subject.scene, subject.strides) if subject.walks else {}
    titles = {title.lower(): title for title in cyclic}
    timed = over_time(subject)
    for name, axes in zip(names, figure.subplots(len(names), squeeze=False)[:, 0], strict=True):
        wanted = name.strip().lower()
        if wanted in titles:
            _over_cycle(subject, titles[wanted], cyclic[titles[wanted]], axes)
        else:
            _lines(subject, *timed[wanted], axes)
        if len(names) > 1:
            axes.set_title(name.strip(), loc="left")
    legend_below(figure, axes)
    heading(figure, f"{subject.scene.name}: {', '.join(name.strip().lower() for name in names)}")
    return figure


def over_time(subject: Subject) -> dict[str, tuple[str, str, dict[str, Floats]]]:
    """Curves over time by their names in small letters: name, unit, and a line (F,) or one a side."""
    found: dict[str, tuple[str, str, dict[str, Floats]]] = {}
    for title, unit, lines in _over_time(subject):
        found.setdefault(title.lower(), (title, unit, lines))
    return found


def labelled_curve(title: str, unit: str, time: Floats, lines: Mapping[str, Floats]) -> xarray.DataArray:
    """A curve over time (F,), s, as an `xarray.DataArray` with its unit; lines of both sides are over `side`, too.

    Raises:
        Error: xarray is not installed.
    """
    package = imported("xarray", "a curve with names needs")
    sides = [side for side in lines if side]
    seconds = package.Variable("time", time, {"units": "s"})
    about = {"units": "1" if unit == "activation" else unit, "long_name": title}
    if not sides:
        return package.DataArray(lines[""], {"time": seconds}, ("time",), title, about)
    values = np.stack([lines[side] for side in sides], axis=1)
    return package.DataArray(values, {"time": seconds, "side": sides}, ("time", "side"), title, about)


def curve_names(subject: Subject) -> list[str]:
    """Names of all curves of a motion: over the gait cycle, degrees of freedom, muscles, and what else is recorded."""
    cyclic = gait_curves(subject.recording, subject.scene, subject.strides) if subject.walks else {}
    return list(dict.fromkeys([*cyclic, *(title for title, _, _ in _over_time(subject))]))


def _over_cycle(subject: Subject, title: str, curve: Any, axes: Any) -> None:
    if subject.norms:
        if title in LEG_ANGLES:
            angle_bands(axes, title, subject.runs)
        elif curve.people is not None and not subject.runs:
            mean, deviation = curve.people
            axes.fill_between(
                PERCENT, mean - deviation, mean + deviation, color=BAND_COLOR, lw=0.0, label="norm (people)"
            )
    cycle_curves(axes, curve.sides)
    axes.set(xlabel="gait cycle (%)", ylabel=f"{title.split()[-1]} ({curve.unit})")


def _over_time(subject: Subject) -> Iterator[tuple[str, str, dict[str, Floats]]]:
    """Curves over time: name, unit, and a line or one a side."""
    recording, scene = subject.recording, subject.scene
    try:
        for title, (unit, sides) in frame_curves(recording, scene).items():
            yield title, unit, sides
    except Error:
        pass  # no feet
    for degree in degrees_of_freedom(recording, scene):
        turns = degree.unit == "rad"
        yield degree.name, "deg" if turns else degree.unit, {"": np.degrees(degree.values) if turns else degree.values}
    for k, muscle in enumerate(recording.muscle_names):
        yield muscle, "activation", {"": recording.muscle_activation[:, k]}
        if len(recording.muscle_force):
            yield f"{muscle} force", "N", {"": recording.muscle_force[:, k]}
    yield from _both_sides(recording)
    for k, axis in enumerate("xyz" if len(recording.com) else ""):
        yield f"centre of mass {axis}", "m", {"": recording.com[:, k]}
    for k, (name, unit) in enumerate(zip(recording.recorded_names, recording.recorded_units, strict=True)):
        yield name, unit, {"": recording.recorded[:, k]}


def _both_sides(recording: Recording) -> Iterator[tuple[str, str, dict[str, Floats]]]:
    """Muscles that there are on both sides, by what they are called on either: `SOL` of `lSOL` and `rSOL`."""
    found: dict[str, dict[str, int]] = {}
    for k, muscle in enumerate(recording.muscle_names):
        side = SIDE.search(muscle)
        if side is not None:
            found.setdefault(SIDE.sub("", muscle), {})["left" if "l" in side[0].lower() else "right"] = k
    names = {name.lower() for name in recording.muscle_names}
    for name, sides in found.items():
        if len(sides) == len(SIDES) and name.lower() not in names:
            yield name, "activation", {side: recording.muscle_activation[:, sides[side]] for side in SIDES}
            if len(recording.muscle_force):
                yield f"{name} force", "N", {side: recording.muscle_force[:, sides[side]] for side in SIDES}


def _lines(subject: Subject, title: str, unit: str, lines: dict[str, Floats], axes: Any) -> None:
    for side, values in lines.items():
        axes.plot(subject.recording.time, values, color=SIDE_COLORS.get(side, PALETTE[0]), label=side or None)
    axes.margins(x=0.0)
    axes.set(xlabel="time (s)", ylabel=unit if unit == "activation" else f"{title.split()[-1]} ({unit})")
