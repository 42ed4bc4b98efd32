"""One simulated instance over time, as it is stored, measured and drawn."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.arguments import as_kind, as_number, as_texts, in_words, obtained_by
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError, lacking
from warpmuscle.core.html_table import html_table
from warpmuscle.core.labelled import Labelled, to_dataframe, to_xarray
from warpmuscle.core.plain_text import number_of
from warpmuscle.results.quantity import RawFrames
from warpmuscle.results.recorded_quantities import (
    INTEGER_QUANTITIES,
    NAMED,
    QUANTITIES,
    UNITS,
    RecordedQuantities,
    attributes_of,
    dimension,
    empty,
    has_place,
    is_missing,
)

if TYPE_CHECKING:
    import pandas
    import xarray

    from warpmuscle.scene import Scene

INSTEAD = {
    "plot": "wm.plot(recording, 'hip flexion', scene=scene) draws a curve",
    "show": "wm.show(recording) shows it",
    "to_csv": "to_dataframe().to_csv(path) writes one",
    "to_pandas": "to_dataframe() is a table of pandas",
    "positions": "body_position has them",
    "angles": "joint_angle has them",
    "activation": "muscle_activation has those of all, in the order of muscle_names",
    "activations": "muscle_activation has those of all, in the order of muscle_names",
    "muscles": "muscle_names has their names, muscle_activation, muscle_force and others their arrays",
    "grf": "foot_force_left and foot_force_right have them",
    "ground_force": "foot_force_left and foot_force_right have them",
    **dict.fromkeys(("slice", "sel", "isel", "crop", "cut"), "window(begin, end) is a part, in s; to_xarray() has sel"),
    **dict.fromkeys(("dt", "fps", "rate", "frequency", "sample_rate"), "time has the times of all frames, s"),
    **dict.fromkeys(("t", "times", "timestamps"), "time has those of all frames, s"),
    **dict.fromkeys(("resample", "interp", "interpolate"), "to_xarray().interp(time=...) does it"),
    **dict.fromkeys(("df", "to_frame", "dataframe"), "to_dataframe() is a table of pandas"),
    **dict.fromkeys(("xr", "to_dataset", "dataset"), "to_xarray() is a dataset of xarray"),
    **dict.fromkeys(("bodies", "body"), "body_names has their names, body_position where they are"),
    "units": "to_xarray() has the units of all",
    **dict.fromkeys(("names", "keys", "columns", "variables"), "list(recording.to_xarray()) names the quantities"),
    **dict.fromkeys(("shape", "size", "n_frames", "nframes"), "frames are as many"),
    "joints": "joint_names has their names, joint_angle and others their arrays",
    "to_numpy": "recording['joint_angle'] and others are arrays",
    "qvel": "speed has the speeds by speed_names",
    "to_netcdf": "to_xarray().to_netcdf(path) writes one",
    "qpos": "coordinate has the coordinates by coordinate_names, joint_angle angles",
    "save": "wm.write(result, 'a.h5') writes results; a run of wm.simulate has save('a.h5')",
}  # by what is often tried
LISTED = 8  # bodies, joints and muscles that a notebook's table names


@obtained_by('wm.simulate(scene).recording is one, and wm.read("walk.h5") reads what files have')
@dataclass(frozen=True, repr=False)
class Recording(RecordedQuantities):
    """The motion of one instance: F frames, J joints, B bodies, M muscles; `QUANTITIES` lists the arrays.

    Joints are in breadth-first order from the root; bodies are the root followed by the children of those joints.
    Coordinates and speeds have the names of `topology.coordinate_names`, angles those of `degrees_of_freedom`; what was
    recorded before they were has none. A quantity that was not kept is an array without frames, see `missing`.
    Raises ArgumentError, a ValueError, if a shape does not fit.
    """

    _origin: ClassVar[tuple[Callable[[], Scene], ...]] = ()  # what makes the scene that made it; files keep none

    def __post_init__(self) -> None:
        counts = {axis: len(getattr(self, name)) for axis, name in NAMED.items()} | {"frame": len(self.time)}
        for name, about in QUANTITIES.items():
            array = as_kind(np.ndarray, self[name], name)
            expected = tuple(counts.get(axis, len(axis.split())) for axis in about.axes)
            if array.shape not in (expected, (0 if name != "time" else expected[0], *expected[1:])):
                raise ArgumentError(f"{name} has shape {array.shape}, not {expected} ({', '.join(about.axes)})")
        for axis, name in UNITS.items():
            if len(getattr(self, name)) not in (0, counts[axis]):
                raise ArgumentError(f"{name} has {number_of(len(getattr(self, name)), 'entry')}, not {counts[axis]}")

    def _repr_html_(self) -> str:
        """What notebooks show: a table, long lists of names cut."""
        span = f"{self.time[0]:.4g} to {self.time[-1]:.4g} s" if self.frames else "none"
        lists = {"bodies": self.body_names, "joints": self.joint_names, "muscles": self.muscle_names}
        rows = [("frames", f"{self.frames}: {span}" if self.frames else span)]
        rows += [(f"{len(names)} {what}", ", ".join(names[:LISTED]) + (", ..." if len(names) > LISTED else ""))
                 for what, names in lists.items() if names]  # fmt: skip
        return html_table(("recording", ""), rows)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Say what to type instead of what is often tried."""
            raise lacking("a recording", name, dir(type(self)), INSTEAD)

    def __repr__(self) -> str:
        span = f", {self.time[0]:.4g} to {self.time[-1]:.4g} s" if self.frames else ""
        counts = {"bodies": self.body_names, "joints": self.joint_names, "muscles": self.muscle_names}
        parts = "".join(f", {len(names)} {what}" for what, names in counts.items())
        return f"Recording({number_of(self.frames, 'frame')}{span}{parts})"

    def __getitem__(self, name: str) -> NDArray[Any]:
        """The array of a quantity; raises ArgumentError for an unknown name."""
        if not isinstance(name, str):
            what = "a part of the motion is recording.window(begin, end), in s; " if isinstance(name, slice) else ""
            raise ArgumentError(f"{what}a recording is asked by names, such as recording['joint_angle']")
        if name not in QUANTITIES:
            nearest = difflib.get_close_matches(name, QUANTITIES, n=1)
            hint = f"did you mean {nearest[0]!r}?" if nearest else "a run has curves: run['hip flexion']"
            hint = INSTEAD.get(name, hint)
            raise ArgumentError(f"no quantity is called {in_words(name)}; {hint}; there are {', '.join(QUANTITIES)}")
        array: NDArray[Any] = getattr(self, name)
        return array

    @classmethod
    def of(
        cls,
        arrays: Mapping[str, NDArray[Any]],
        joint_names: tuple[str, ...],
        body_names: tuple[str, ...],
        muscle_names: tuple[str, ...] = (),
        coordinate_names: tuple[str, ...] = (),
        speed_names: tuple[str, ...] = (),
        joint_angle_names: tuple[str, ...] = (),
        controller_value_names: tuple[str, ...] = (),
        recorded_names: tuple[str, ...] = (),
        coordinate_units: tuple[str, ...] = (),
        speed_units: tuple[str, ...] = (),
        controller_value_units: tuple[str, ...] = (),
        recorded_units: tuple[str, ...] = (),
        *,
        kept: Sequence[str] | None = None,
    ) -> Self:
        """A recording from arrays by name of their quantity; raises ArgumentError if one is missing.

        What has no names may be missing, and so may the desired torque, which then is the torque.

        Args:
            kept: names of the quantities that the arrays hold; others are missing. By default they hold all.
        """
        present: dict[str, Any] = {**arrays}
        every = (
            joint_names, body_names, muscle_names, coordinate_names, speed_names, joint_angle_names,
            controller_value_names, recorded_names,
        )  # fmt: skip
        texts: dict[str, Any] = dict(zip(NAMED.values(), every, strict=True))
        for name in QUANTITIES:
            if not has_place(name, texts):
                present.setdefault(name, empty(name, texts, len(arrays.get("time", ()))))
            elif kept is not None and name not in (*kept, "time"):
                present.setdefault(name, empty(name, texts, 0))
        if kept is None:
            present.setdefault("joint_torque_desired", arrays.get("joint_torque"))
        if missing := [name for name in QUANTITIES if present.get(name) is None]:
            raise ArgumentError(f"arrays of a recording lack {', '.join(missing)}")
        given = {name: present[name] for name in QUANTITIES}
        texts |= {"coordinate_units": coordinate_units, "speed_units": speed_units, "recorded_units": recorded_units}
        texts |= {"controller_value_units": controller_value_units}
        return cls(**given, **texts)

    @classmethod
    def from_frames(
        cls,
        raw: RawFrames,
        joint_names: tuple[str, ...],
        body_names: tuple[str, ...],
        muscle_names: tuple[str, ...],
        coordinate_names: tuple[str, ...],
        speed_names: tuple[str, ...],
        coordinate_units: tuple[str, ...],
        speed_units: tuple[str, ...],
        controller_value_names: tuple[str, ...] = (),
        controller_value_units: tuple[str, ...] = (),
        recorded_names: tuple[str, ...] = (),
        recorded_units: tuple[str, ...] = (),
    ) -> Self:
        """Make a recording from the frames that a device wrote."""
        arrays: dict[str, Any] = {name: quantity.of(raw) for name, quantity in QUANTITIES.items()}
        arrays |= {name: arrays[name].astype(np.int32) for name in INTEGER_QUANTITIES}
        return cls(
            joint_names, body_names, muscle_names, **arrays, coordinate_names=coordinate_names, speed_names=speed_names,
            controller_value_names=controller_value_names, coordinate_units=coordinate_units, speed_units=speed_units,
            controller_value_units=controller_value_units,
            recorded_names=recorded_names, recorded_units=recorded_units,
        )  # fmt: skip

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.time)

    @property
    def end(self) -> float:
        """Time of the last frame, s; 0 without frames."""
        return float(self.time[-1]) if self.frames else 0.0

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of the quantities that were not recorded; their arrays have no frames."""
        return tuple(name for name in QUANTITIES if is_missing(self.__dict__[name], len(self.__dict__["time"])))

    @property
    def has_targets(self) -> bool:
        """Whether the controller had targets other than the reference pose."""
        return bool(np.any(self.joint_target[..., :3]))

    def window(self, start: float, end: float = np.inf) -> Recording:
        """The frames with start <= time <= end, s, either of which may be infinite; raises ArgumentError."""
        start, end = as_number(start, "start", infinite=True), as_number(end, "end", infinite=True)
        chosen = (self.time >= start) & (self.time <= end)
        return self.at(chosen)

    def at(self, frames: Any) -> Self:
        """The recording restricted to some frames, given by a slice, indices or a mask."""
        gone = self.missing
        there = {name: self[name] for name in QUANTITIES if name not in gone}
        return self.changed(**{name: array[frames] for name, array in there.items() if len(array) == self.frames})

    def changed(self, **arrays: NDArray[Any]) -> Self:
        """A copy of the recording with some arrays replaced."""
        changes: dict[str, Any] = {**arrays}
        return replace(self, **changes).made_by(self.origin)

    @property
    def origin(self) -> Callable[[], Scene] | None:
        """A function that returns the scene of the recording, without free parameters; None if read from a file."""
        return self._origin[0] if self._origin else None

    def made_by(self, origin: Callable[[], Scene] | None) -> Self:
        """Attach the scene that made the recording, and return the recording."""
        if origin is not None:
            object.__setattr__(self, "_origin", (origin,))
        return self

    def to_xarray(self) -> xarray.Dataset:
        """All quantities as an `xarray.Dataset`, with units, over `time`, `muscle_names`, `joint_names` and so on.

        The attribute `at` says when in a step a quantity is.

        The dataset's own `to_dataframe()` would have a row for each combination of all axes, which is more than memory
        holds: take that of the recording, a row a frame, or that of one quantity, `dataset["com"].to_dataframe()`.

        It is what `xarray.open_dataset` makes of the motion in a result file. Raises Error without xarray.
        """
        time, arrays = self._labelled(list(QUANTITIES))
        for axis, name in UNITS.items():
            if units := getattr(self, name):
                arrays.append(Labelled(name, (dimension(axis),), np.array(units, dtype=str)))
        return to_xarray(time, arrays, {dimension(axis): words for axis, words in self._words().items()})

    def to_dataframe(self, quantities: Sequence[str] | None = None) -> pandas.DataFrame:
        """A `pandas.DataFrame` indexed by time, s, one row per frame; columns such as `com.x`, `muscle_force.rSOL`.

        Args:
            quantities: names of those that are wanted; all by default.

        Raises:
            ArgumentError: an unknown name. Error: pandas is not installed.
        """
        chosen = list(QUANTITIES) if quantities is None else as_texts(quantities, "quantities")
        time, arrays = self._labelled(chosen)
        return to_dataframe(time, arrays, {dimension(axis): words for axis, words in self._words().items()})

    def _words(self) -> dict[str, Sequence[str]]:
        """What stands along the axes, by axis; not along those of which there is nothing."""
        axes = dict.fromkeys(axis for quantity in QUANTITIES.values() for axis in quantity.axes[1:])
        words = {axis: getattr(self, NAMED[axis]) if axis in NAMED else axis.split() for axis in axes}
        return {axis: along for axis, along in words.items() if along}

    def _labelled(self, quantities: Sequence[str]) -> tuple[Labelled, list[Labelled]]:
        """The time, and the arrays of quantities with their names of axes and units."""
        words, gone = self._words(), self.missing
        found = []
        for name in ("time", *(name for name in quantities if name != "time" and name not in gone)):
            values, quantity = self[name], QUANTITIES[name]
            if all(axis in words for axis in quantity.axes[1:]):
                found.append(Labelled(name, tuple(map(dimension, quantity.axes)), values, attributes_of(name)))
        return found[0], found[1:]

    def position_of(self, body: str) -> Floats:
        """Centre of mass (F, 3) of a body by name, m; raises ArgumentError for an unknown name."""
        if not isinstance(body, str) or body not in self.body_names:
            raise ArgumentError(f"no body is called {in_words(body)}; there are {', '.join(self.body_names)}")
        return self.body_position[:, self.body_names.index(body)]
