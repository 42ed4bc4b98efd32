"""What a patient's file says.

Example:
    title = "A stiff brace on the left ankle"
    scene = "walker.toml"               # that walks in the patient's place: a model of the patient, or one scaled to it
    seeds = 6

    [[recording]]                       # several strides; more make the patient's spread better known
    motion = "walk1.h5"                 # of `warpmuscle inverse -o`; or coordinates or markers, and their model
    events = { left = [0.5, 1.6, 2.7], right = [1.0, 2.1] }     # touch-downs, s; by default from the forces on the feet

    [match]                             # the search for a walk like the patient's, and what it changes in the scene
    candidates = 300
    set = { "objective.cost_of_transport" = 1 }

    [adapt]                             # the search that goes on from there with each change, and without one
    candidates = 150
    habit = 0.1

    [[change]]
    name = "brace"
    "forces.left_brace" = { type = "bilinear_spring", joint = "lAnkle", parameters = { stiffness_below = 200 } }
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.plain_text import readable
from warpmuscle.formats.toml import Source
from warpmuscle.optimization.options import check_options
from warpmuscle.results.records import SearchOptions
from warpmuscle.scene.validation.checks import near
from warpmuscle.search.strategies import make_searches

UNCHANGED = "no change"  # name of the walks that are searched for as those with a change are, without one
PARAMETERS = 8  # of a search that is made to see whether its options can be used
LEAST_SPREAD = 2.0  # deg; errors of gait analysis up to 2 degrees count as none (McGinley 2009, Gait Posture 29:360)


class Recording(msgspec.Struct, forbid_unknown_fields=True):
    """Strides of the patient."""

    motion: str
    model: str = ""  # that coordinates or markers are of
    loads: str = ""  # forces on its feet
    filter: float | None = None  # Hz
    begin: float = 0.0  # s; strides that begin earlier do not count
    events: dict[str, list[float]] = {}  # touch-downs, s, of `left` and `right`


class Match(msgspec.Struct, forbid_unknown_fields=True):
    """The search for a walk like the patient's."""

    candidates: int = 300
    walk: int | None = None  # candidates of a search for any walk that goes before, if the scene falls; as many
    population: int | None = None
    sigma: float | None = 0.03
    until: float | None = None
    strategy: str = "cma"
    duration: float = 6.0  # s, of each simulation
    speed: float = 10.0  # weight of the error of the speed
    feed_forward: float | None = None  # most that curves over stance and swing add to each leg muscle's excitation
    reach: float | None = None  # free numbers of the controller change by so many times their values at most
    set: dict[str, Any] = {}


class Adapt(msgspec.Struct, forbid_unknown_fields=True):
    """The search that goes on with a change."""

    candidates: int = 150
    population: int | None = None
    sigma: float | None = 0.02
    until: float | None = None
    strategy: str = "cma"
    habit: float = 0.1  # weight of staying like the patient, 1 as in the first search
    set: dict[str, Any] = {}


class _File(msgspec.Struct, forbid_unknown_fields=True):
    scene: str
    recording: list[Recording]
    change: list[dict[str, Any]]
    title: str = ""
    text: str = ""
    seeds: int = 6
    speed: float | None = None  # m/s, of the patient
    scaled: bool = True  # whether the scene's body gets the sizes and the mass of the patient's model
    least_spread: float = LEAST_SPREAD
    hip_offset: float | None = None  # deg, that hips of the scene are flexed more than the patient's for equal thighs
    match: Match = msgspec.field(default_factory=Match)
    adapt: Adapt = msgspec.field(default_factory=Adapt)


@dataclass(frozen=True)
class PatientFile:
    """What is asked for, and where it stands."""

    path: Path
    source: Source
    asked: _File

    @property
    def name(self) -> str:
        """What the file is called, without folder and suffix."""
        return readable(self.path.stem)

    @property
    def title(self) -> str:
        return self.asked.title or self.name

    @property
    def changes(self) -> dict[str, dict[str, Any]]:
        """What each change sets, by its name."""
        return {one["name"]: {key: value for key, value in one.items() if key != "name"} for one in self.asked.change}

    def beside(self, name: str) -> Path:
        """A file that it names, relative to it."""
        return self.path.parent / name

    def error(self, message: str, key: str) -> SceneError:
        """An error at the place of a key."""
        return self.source.placed(SceneError(message, key))


def read(path: str | Path, seeds: int | None = None) -> PatientFile:
    """The file of a patient.

    Args:
        seeds: so many in place of those of the file.

    Raises:
        SceneError: it cannot be read or used, with file, line and key.
    """
    path = Path(path)
    source = Source.read(path)
    try:
        asked = to_type(source.data, _File)
        if seeds is not None:
            asked.seeds = seeds
        _check(asked)
    except SceneError as error:
        raise source.placed(error) from None
    return PatientFile(path, source, asked)


def _check(asked: _File) -> None:
    """Raise SceneError with the key of what makes no sense."""
    if not asked.scene:
        raise SceneError("name the scene that walks", key="scene")
    for key in ("recording", "change"):
        if not getattr(asked, key):
            raise SceneError(f"there is no [[{key}]]; give one at least", key=key)
    if not 1 <= asked.seeds <= 1000:
        raise SceneError(f"are 1 to 1000, not {asked.seeds}", key="seeds")
    for key, value in (("least_spread", asked.least_spread), ("speed", asked.speed)):
        if value is not None and not 0.0 < value < 100.0:
            raise SceneError(f"is greater than 0 and less than 100, not {value:g}", key=key)
    if asked.hip_offset is not None and not abs(asked.hip_offset) <= 90.0:
        raise SceneError(f"is -90 to 90 degrees, not {asked.hip_offset:g}", key="hip_offset")
    if asked.match.walk is not None and asked.match.walk < 1:
        raise SceneError(f"is a number of candidates, 1 or more, not {asked.match.walk}", key="match.walk")
    if not 2.0 <= asked.match.duration <= 600.0:
        raise SceneError(f"is 2 to 600 s, not {asked.match.duration:g}", key="match.duration")
    for key, most, end in (("feed_forward", asked.match.feed_forward, 1.0), ("reach", asked.match.reach, 1000.0)):
        if most is not None and not 0.0 < most <= end:
            raise SceneError(f"is greater than 0 and at most {end:g}, not {most:g}", key=f"match.{key}")
    for key, weight in (("match.speed", asked.match.speed), ("adapt.habit", asked.adapt.habit)):
        if not 0.0 <= weight <= 1e6:
            raise SceneError(f"is a weight from 0 to 1e6, not {weight:g}", key=key)
    for table in ("match", "adapt"):
        _check_search(getattr(asked, table), table)
    for index, recording in enumerate(asked.recording):
        _check_recording(recording, f"recording.{index}")
        if recording in asked.recording[:index]:
            raise SceneError("is there twice, and its strides would count twice", key=f"recording.{index}")
    _check_changes(asked.change)


def _check_changes(changes: list[dict[str, Any]]) -> None:
    """Raise SceneError for a change without a name of its own, or of nothing."""
    names: list[str] = [UNCHANGED]
    for index, change in enumerate(changes):
        name, key = change.get("name"), f"change.{index}"
        if not isinstance(name, str) or not name.strip() or not name.isprintable():
            raise SceneError("a change has a name, text in one line", key=key)
        if name in names:
            raise SceneError(f"{name!r} is the name of another one", key=f"{key}.name")
        if len(change) < 2:
            raise SceneError("changes nothing; name keys of the scene and their values", key=key)
        names.append(name)


def _check_search(options: Match | Adapt, table: str) -> None:
    """Raise SceneError for options that no search takes: those of `adapt` are used minutes after the file is read."""
    names = ("strategy", "candidates", "population", "sigma", "until")
    given = {name: getattr(options, name) for name in names}
    try:
        check_options(SearchOptions(**given))
        make_searches(
            options.strategy, PARAMETERS, np.full(PARAMETERS, 0.5), 1, 1, population=options.population,
            sigma=options.sigma,
        )  # fmt: skip
    except Error as error:
        text = str(error)
        named = "sigma" if "step size" in text else next((name for name in names if name in text.split()), "strategy")
        raise SceneError(text, key=f"{table}.{named}") from None


def _check_recording(recording: Recording, key: str) -> None:
    """Raise SceneError if a recording is not told completely."""
    if not recording.motion.strip():
        raise SceneError("name the file of the recording", key=f"{key}.motion")
    if recording.filter is not None and not 0.0 < recording.filter < math.inf:
        raise SceneError(f"is a frequency greater than 0, not {recording.filter:g} Hz", key=f"{key}.filter")
    if not 0.0 <= recording.begin < math.inf:
        raise SceneError(f"is a time of 0 or more, not {recording.begin:g} s", key=f"{key}.begin")
    result = Path(recording.motion).suffix.lower() in (".h5", ".hdf5")
    for field in ("model", "loads", "filter"):
        if result and getattr(recording, field):
            raise SceneError("a result file has its own; leave this out", key=f"{key}.{field}")
    if not result and not recording.model:
        raise SceneError("coordinates and markers are of a model: name its file", key=f"{key}.model")
    if not result and not recording.loads and not recording.events:
        raise SceneError("name the forces on the feet, or give `events`", key=f"{key}.loads")
    for side, times in recording.events.items():
        if side not in ("left", "right"):
            raise SceneError(f"no side is called {side!r}{near(side, ('left', 'right'))}", key=f"{key}.events")
        if len(times) < 2 or not all(map(math.isfinite, times)) or any(b <= a for a, b in pairwise(times)):
            raise SceneError("are two or more times, in order", key=f"{key}.events.{side}")
    if recording.events and len(recording.events) < 2:
        raise SceneError("name touch-downs of both sides", key=f"{key}.events")
