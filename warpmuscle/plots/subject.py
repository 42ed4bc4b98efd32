"""What a figure is drawn from: a result, which of its motions, and what of that is wanted."""

from __future__ import annotations

import fnmatch
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.arguments import as_integer, as_number
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import toml
from warpmuscle.gait.cycles import Strides, steady_strides
from warpmuscle.gait.measures import Gait, feet_of, measure
from warpmuscle.gait.quality import runs, support_of
from warpmuscle.gait.relative_to_belts import over_belts
from warpmuscle.optimization.best_scene import recorded_scene
from warpmuscle.results.motion_of_scene import check_motion_of
from warpmuscle.results.partial_motion import demanding
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import ParameterTable, Result
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import straight_legs
from warpmuscle.scene.validation.checks import near


class Absent(Error):
    """A result does not hold what a kind of figure shows."""


@dataclass(frozen=True)
class Choices:
    """What is wanted of a result."""

    replay: int = 0  # number of the motion
    start: float = -np.inf  # s, of the part of the motion that counts
    end: float = np.inf  # s
    joints: tuple[str, ...] = ()  # names or patterns such as `l*`; all if empty
    muscles: tuple[str, ...] = ()  # the same
    norms: bool = True  # whether norms of human walking are drawn

    @classmethod
    def between(cls, replay: int, start: float | None, end: float | None, **further: Any) -> Choices:
        """A part of a motion from `start` to `end`, s, to which None sets no bound; raises ArgumentError."""
        first = -np.inf if start is None else as_number(start, "start")
        last = np.inf if end is None else as_number(end, "end")
        return cls(as_integer(replay, "replay", 0), first, last, **further)

    @property
    def timed(self) -> bool:
        """Whether a part of the motion was chosen."""
        return bool(np.isfinite(self.start) or np.isfinite(self.end))


class Subject:
    """A result to draw, read as far as a figure asks for it."""

    def __init__(
        self, result: Result, choices: Choices | None = None, path: Path | None = None, run: str | None = None
    ):
        """Hold a result, the file that it is from, if any, and which run of it."""
        self.result, self.choices, self.path, self.run = result, choices or Choices(), path, run

    @property
    def source(self) -> str:
        """How errors call the result."""
        return str(self.path) if self.path is not None else "this result"

    @cached_property
    def scene(self) -> Scene:
        """The scene without free parameters, with the values that the motion was made with."""
        return recorded_scene(self.result)

    @cached_property
    def recording(self) -> Recording:
        """The chosen part of the chosen motion, at least two frames.

        Raises:
            Error: there is no such motion, or too little of it between the times wanted.
        """
        replays, wanted = self.result.replays, self.choices.replay
        if not replays:
            raise Absent(
                f"{self.source} holds no motion; `simulate -o`, `optimize -o` and `throw -o` write files that do"
            )
        if not 0 <= wanted < len(replays):
            raise Error(
                f"{self.source} has {number_of(len(replays), 'motion')}, numbered from 0; none has number {wanted}"
            )
        motion = demanding(replays[wanted], self.source)
        check_motion_of(motion, self.scene, f"{self.source}: motion {wanted}")
        if motion.frames < 2:
            held = number_of(motion.frames, "frame") if motion.frames else "no frames"
            raise Absent(f"{self.source}: motion {wanted} has {held}; a figure needs two")
        part = motion.window(self.choices.start, self.choices.end)
        if part.frames < 2:
            whole = f"{number_of(motion.frames, 'frame')}, {motion.time[0]:.4g} to {motion.time[-1]:.4g} s"
            raise Error(
                f"{self.source}: motion {wanted} ({whole}) has {number_of(part.frames, 'frame')} within the times "
                "wanted; "
                "a figure needs two"
            )
        return part

    @property
    def title(self) -> str:
        """What figures of the motion are called: the scene, and which one of several motions."""
        name, scene = "".join(self.result.replay_names[self.choices.replay :][:1]), self.scene.name
        return f"{scene}, {name}" if name not in ("", scene) else scene

    def recorded(self, motion: Recording) -> Recording | None:
        """The motion as it was recorded, if it is one that was fitted: its joints alone."""
        if self.result.fit is None or not motion.has_targets:
            return None
        return motion.changed(joint_orientation=motion.joint_target)

    @cached_property
    def gait(self) -> Gait | None:
        """Measures of the walk; None for a character without feet."""
        if self.scene.feet is None or any(foot not in self.recording.body_names for foot in self._feet):
            return None
        return measure(over_belts(self.recording, self.scene), *self._feet)

    @property
    def _feet(self) -> tuple[str, str]:
        return self.scene.feet or ("lFoot", "rFoot")

    @cached_property
    def strides(self) -> dict[str, Strides]:
        """Gait cycles of the steady part of the motion, by side; raises Absent where there are none."""
        recording = self.recording
        try:
            feet_of(self.scene)
            return steady_strides(recording, self.scene)
        except Error as error:
            raise Absent(f"{self.source}: {error}") from None

    @cached_property
    def runs(self) -> bool:
        """Whether the gait is judged as running; raises Absent where there are no gait cycles."""
        cycles = self.strides
        return runs(self.scene, support_of(self.recording, self.scene, cycles))

    @cached_property
    def norms(self) -> bool:
        """Whether norms of people are drawn: they are wanted, and angles of the legs are measured as people's are."""
        return self.choices.norms and straight_legs(self.scene)

    @property
    def walks(self) -> bool:
        """Whether the motion has whole gait cycles."""
        try:
            return bool(self.strides)
        except Error:
            return False

    def chosen(self, what: str, names: Sequence[str], patterns: Sequence[str]) -> list[str]:
        """Those of the names that a pattern matches, all without patterns.

        Raises:
            Error: a pattern matches none.
        """
        for pattern in patterns:
            if not fnmatch.filter(names, pattern):
                listed = ", ".join(names) or "none"
                raise Error(f"{self.source}: no {what} is called {pattern!r}{near(pattern, names)}; there are {listed}")
        return [name for name in names if not patterns or any(fnmatch.fnmatchcase(name, p) for p in patterns)]

    def about_strides(self) -> str:
        """What the gait cycles of a figure are, as words."""
        counts = sorted({len(cycles) for cycles in self.strides.values()})
        count = " or ".join(map(str, counts))
        begin = min(cycles[0][0] for cycles in self.strides.values())
        end = max(cycles[-1][1] for cycles in self.strides.values())
        cycles = f"mean and standard deviation of {count} gait cycles" if counts[-1] > 1 else "1 gait cycle"
        return f"{cycles} of each leg, {begin:.1f} to {end:.1f} s"


def of_recording(recording: Recording, scene: Scene) -> Result:
    """A result that holds a motion of a scene, and nothing else."""
    none = np.zeros(0)
    return Result(
        toml.dumps(scene), "", "", 0, ParameterTable((), (), none, none, none, none, ()), replays=(recording,)
    )
