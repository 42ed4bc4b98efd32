"""One simulation of a scene in one line of Python, and what is looked at and kept of it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec
import numpy as np

from warpmuscle.core.arguments import answering, as_kind, as_number, as_path, in_words, obtained_by
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError, CommandWarning, Error, lacking
from warpmuscle.core.extras import imported
from warpmuscle.core.html_table import html_table
from warpmuscle.core.status import Status
from warpmuscle.formats import SceneLike, scene_of, toml
from warpmuscle.formats.overrides import with_values
from warpmuscle.gait.measures import Gait, measure
from warpmuscle.learning.player import beyond, commanded, lasting, learned_in, replay, task_of
from warpmuscle.plots import curve_of, plot
from warpmuscle.plots.names import plain
from warpmuscle.plots.one_curve import labelled_curve
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result, parameter_table
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters, start_values, substitute
from warpmuscle.scene.validation.checks import near
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.session.guesses import ARGUMENTS, INSTEAD, PLOTTED
from warpmuscle.session.keeping import keep
from warpmuscle.simulation.commands import checked_commands
from warpmuscle.simulation.devices import find_device
from warpmuscle.simulation.kernel_cache import said
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.view.page import Page
from warpmuscle.view.sources import of_replays, page_of_sights

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure


FORCES = ("foot force", "grf", "ground force", "ground forces", "ground reaction force", "ground reaction forces")


@obtained_by('wm.simulate("walk56") makes one')
@dataclass(frozen=True, repr=False)
class Run:
    """One simulation of a scene: its motion and how it ended; see `simulate`."""

    scene: Scene  # without free parameters, as it was simulated
    recording: Recording
    status: Status
    duration: float  # s, simulated time at which it ended
    cause: str  # what ended it before its time, in words; empty where nothing more is known
    terms: Mapping[str, float]  # of the objective; empty where a policy acted
    result: Result  # what `save` writes
    folder: Path | None = None  # of the scene's file, where meshes of a model may be

    @property
    def time(self) -> Floats:
        """Time of the frames (F,), s."""
        return np.asarray(self.recording.time)

    @property
    def gait(self) -> Gait | None:
        """Measures of the gait; None for a character without feet."""
        if self.scene.feet is None or not self.recording.frames:
            return None
        return measure(self.recording, self.scene)

    @answering(
        {
            **dict.fromkeys(("speed", "fps", "loop", "size", "camera"), "the page has buttons for it"),
            **dict.fromkeys(("path", "save", "output", "file", "filename"), "run.save('page.html') writes it"),
            **dict.fromkeys(("block", "browser", "open"), "run.show().open() opens it in the browser"),
        }
    )
    def show(self, meshes: str | PathLike[str] | None = None) -> Page:
        """The motion as a page, which notebooks show and `save` writes.

        Args:
            meshes: folder with the files that a model of OpenSim is drawn with; by default that of the model.

        Raises:
            Error: the folder has no files of the model.
        """
        if meshes is not None and str(meshes).lower().endswith((".html", ".htm")):
            raise ArgumentError(f"meshes is a folder; run.save({str(meshes)!r}) writes the page")
        return page_of_sights(of_replays(self.result), meshes=meshes, beside=self.folder)

    @answering(PLOTTED)
    def plot(
        self,
        what: str | Sequence[str] | None = "",
        path: str | PathLike[str] | None = None,
        *,
        joints: Sequence[str] = (),
        muscles: Sequence[str] = (),
        norms: bool = True,
        start: float | None = None,
        end: float | None = None,
    ) -> Figure:
        """A figure of the motion; see `warpmuscle.plot` for what there is, such as "hip flexion" or "sticks".

        Args:
            what: a figure or a curve, or a list of curves; by default the angles of legs over the gait cycle, or all
                over time of what does not walk.
            path: picture to write. joints, muscles: names or patterns of what is shown, such as `l*`. norms: whether
                people's curves stand behind. start, end: s, of the part that counts.

        Raises:
            Error: there is no such figure, matplotlib is not installed, or the file cannot be written.
        """
        return plot(
            self.result, what or "", None if path is None else as_path(path, "path"), joints=joints, muscles=muscles,
            norms=norms, start=start, end=end,
        )  # fmt: skip

    @answering(
        {
            **dict.fromkeys(
                ("fps", "rate", "size", "quality"), "`warpmuscle video run.h5 -o run.mp4` has such options"
            ),
            **dict.fromkeys(("format", "kind", "type"), "the ending of the name says it: .h5, .html, .mot, .csv, .mp4"),
            **dict.fromkeys(("title", "name"), "the page is called as its scene is"),
        }
    )
    def save(self, path: str | PathLike[str]) -> None:
        """Write scene and motion to an HDF5 file (`.h5`), or the motion in the format of the file's suffix.

        That is a page (`.html`), a table (`.mot`, `.sto`, `.csv`; see `warpmuscle export`), or a film (`.mp4`, `.gif`).

        Raises:
            Error: another ending, or it cannot be written.
        """
        keep(self.result, path, self.show)

    def to_xarray(self) -> xarray.Dataset:
        """The motion as an `xarray.Dataset`, see `Recording.to_xarray`; a table of it is `run.to_dataframe()`."""
        return self.recording.to_xarray()

    def to_dataframe(self, quantities: Sequence[str] | None = None) -> pandas.DataFrame:
        """The motion as a `pandas.DataFrame`, a row a frame, see `Recording.to_dataframe`.

        Args:
            quantities: names of those that are wanted; all by default.

        Raises:
            ArgumentError: an unknown name. Error: pandas is not installed.
        """
        return self.recording.to_dataframe(quantities)

    def __getitem__(self, name: str) -> Any:
        """A quantity of `to_xarray`, such as run["joint_angle"], or a curve by its name, as `plot` draws it over time.

        An `xarray.DataArray` over time with its unit; curves of legs are over `side`, too, left and right.

        Raises:
            ArgumentError: nothing, or several curves, are called so.
        """
        table = self.to_xarray()
        if not isinstance(name, str):
            what = "a part of the motion is run.recording.window(begin, end), in s; " if isinstance(name, slice) else ""
            if isinstance(name, list | tuple):
                what = f"run.plot({list(name)!r}) draws several; "
            raise ArgumentError(f"{what}a run is asked by names, such as run['hip flexion'] or run['com']")
        if name in table:
            return table[name]
        if plain(name) in FORCES and "foot_force_left" in table:
            both = [table["foot_force_left"], table["foot_force_right"]]
            joined = imported("xarray", "a quantity needs").concat(both, "side").assign_coords(side=["left", "right"])
            return joined.transpose("time", "side", ...).rename("foot_force")
        try:
            title, unit, lines = curve_of(self.result, name, [str(one) for one in table])
        except Error as error:
            hint = INSTEAD.get(plain(name).replace(" ", "_"))
            elsewhere = hint and f"run[{name!r}]" not in hint  # rather than what was asked just now
            raise ArgumentError(f"no quantity is called {name!r}; {hint}" if elsewhere else str(error)) from None
        return labelled_curve(title, unit, self.recording.time, lines)

    def keys(self) -> list[str]:
        """Names of the recorded quantities; curves such as "hip flexion" and muscles go by their names, too."""
        return [str(name) for name in self.to_xarray()]

    def __iter__(self) -> Iterator[str]:
        """Name by name of `keys`."""
        return iter(self.keys())

    def __contains__(self, name: object) -> bool:
        """Whether there is a quantity or a curve of this name."""
        try:
            return isinstance(name, str) and self[name] is not None
        except ArgumentError:
            return False

    def __getattr__(self, name: str) -> Any:
        """Say where it is, of what its recording or its scene has."""
        for part in ("recording", "scene") if not name.startswith("_") and name not in INSTEAD else ():
            if name in dir(self.__dict__.get(part)):
                raise AttributeError(f"a run has no {name!r}, but its {part} has: run.{part}.{name}")
        raise lacking("a run", name, dir(type(self)), INSTEAD)

    def __repr__(self) -> str:
        facts = "".join(f", {name} {value}" for name, value in self._facts() if name != "scene")
        return f"Run({self.scene.name}{facts})"

    def _repr_html_(self) -> str:
        seen = self.show()._repr_html_() if self.recording.frames else ""  # none where it diverged at once
        return html_table(("", ""), self._facts()) + seen

    def _facts(self) -> list[tuple[str, str]]:
        """What is said of the run, by name."""
        ended = f"{self.status.meaning}: {self.cause}" if self.cause else self.status.meaning
        found = [("scene", self.scene.name), ("ended", f"after {self.duration:.4g} s, {ended}")]
        gait = self.gait
        if gait is not None:
            found.append(("speed", f"{gait.speed_forward:.3g} m/s"))
            if gait.step_length is not None and gait.cadence is not None:
                found.append(("steps", f"{gait.step_length:.3g} m, {gait.cadence:.4g} a minute"))
        return found


class _End(NamedTuple):
    """How a simulation ended; see `Run`."""

    status: Status
    duration: float
    cause: str


@answering(ARGUMENTS)
def simulate(
    scene: SceneLike,
    duration: float | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    commands: Mapping[str, float] | None = None,
    excitations: Mapping[str, float] | None = None,
    policy: str | PathLike[str] | None = None,
    device: str | None = None,
    record_rate: float = 100.0,
    trust: bool = False,
) -> Run:
    """Simulate a scene once, and keep its motion.

    Args:
        scene: a scene, its name, or its file; also a model of OpenSim.
        duration: s; by default the scene's.
        set: other values in the scene, see `load`.
        commands: what a scene with commands, or a policy, is asked for, by name: {"speed": 1.5}.
        excitations: constant ones of muscles by name, 0 to 1; those that are not named have 0. Without, the scene's
            controller excites them.
        policy: file of a policy that moves the body.
        device: see `Rollout`. record_rate: frames a second of simulated time.
        trust: let code run that the scene names.

    Raises:
        SceneError, RolloutError, ArgumentError: the scene or an argument cannot be used.
    """
    with said("preparing a run"):
        given = with_values(scene_of(scene, trust=trust), set)
        if duration is not None:
            given = msgspec.structs.replace(given, duration=as_number(duration, "duration", above=0.0))
        check_scene(given)
        asked = {
            str(name): as_number(value, f"command {name}")
            for name, value in ({} if commands is None else as_kind(dict, commands, "commands")).items()
        }
        if policy is not None:
            if excitations is not None:
                raise ArgumentError("a policy excites the muscles itself; give it, or excitations")
            run = _by_policy(given, as_path(policy, "policy"), asked, device, record_rate)
            return replace(run, folder=_folder(scene))
        given = _commanded(given, asked)
        rollout = Rollout(given, 1, device, record=[0], record_rate=record_rate)
        if excitations is not None:
            rollout.set_excitations([0.0], _excitations(excitations, rollout.muscle_names)[None, :, None])
        rollout.run()
        terms = {name: float(values[0]) for name, values in rollout.terms().items()}
        status = Status(int(rollout.status()[0]))
        ended = _End(status, float(rollout.end_time()[0]), rollout.causes()[0])
        made = _kept(rollout.numeric, given, rollout.recording(), ended, terms, str(rollout.device))
        return replace(made, folder=_folder(scene))


def _folder(scene: SceneLike) -> Path | None:
    """Where the file of a scene is, None of one without a file of its own."""
    path = None if isinstance(scene, Scene) else Path(scene)
    return path.absolute().parent if path is not None and path.suffix and path.is_file() else None


def _excitations(given: Mapping[str, float], muscles: tuple[str, ...]) -> Floats:
    """Excitations (M,) of all muscles of a scene, in order."""
    values = np.zeros(len(muscles))
    if not isinstance(given, Mapping):
        raise ArgumentError(f"excitations are by muscle, such as {{{muscles[0]!r}: 0.3}}, not {in_words(given)}")
    for name, value in given.items():
        if name not in muscles:
            raise ArgumentError(f"excitations: no muscle is called {name!r}{near(str(name), muscles)}")
        values[muscles.index(name)] = as_number(value, f"excitation of {name}", least=0.0, most=1.0)
    return values


def _by_policy(scene: Scene, policy: Path, asked: dict[str, float], device: str | None, rate: float) -> Run:
    """A run that a policy acts in; commands that the scene has and the policy does not are the scene's."""
    learned = learned_in(policy)
    task = task_of(learned)
    own = {name: value for name, value in asked.items() if name in scene.commands and name not in task.command_names}
    scene = _commanded(scene, own)
    facts = [f"{name}={value!r}" for name, value in asked.items() if name not in own]
    for doubt in beyond(task, facts):
        warnings.warn(doubt, CommandWarning, stacklevel=4)
    place = str(find_device(device))
    task = lasting(commanded(task, facts))
    recording, status = replay(learned.policy, scene, place, task, rate=rate)
    ended = _End(status, recording.end, "")
    return _kept(substitute(scene, start_values(scene)), scene, recording, ended, {}, place)


def _commanded(scene: Scene, asked: Mapping[str, float]) -> Scene:
    """The scene with these commands."""
    if not asked:
        return scene
    checked = checked_commands(dict(asked), scene, 1)
    changed = {
        name: msgspec.structs.replace(scene.commands[name], value=float(v), over=[]) for name, v in checked.items()
    }
    return msgspec.structs.replace(scene, commands={**scene.commands, **changed})


def _kept(
    numeric: Scene, scene: Scene, recording: Recording, ended: _End, terms: Mapping[str, float], device: str
) -> Run:  # fmt: skip
    """A run with the result that it is kept as."""
    table = parameter_table(free_parameters(scene))
    result = Result(toml.dumps(scene), device, "warpmuscle.simulate", 0, table, replays=(recording,))
    return Run(numeric, recording, *ended, terms, result)
