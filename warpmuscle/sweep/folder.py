"""The folder of a sweep, `NAME.sweep` beside its output: a result file a run, and what the sweep consists of.

Each run is kept as any optimisation is, `RUN.h5` with a journal beside it while it goes on; so all that was evaluated
is on the disk at any moment, and what a run has come to can be read while another process works on it.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import secrets
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from warpmuscle.core.errors import Error, OccupiedError, ResultError, SceneError
from warpmuscle.core.files import replace_file, unreadable, unwritable
from warpmuscle.core.names import is_file_name
from warpmuscle.optimization.search_loop import INTERRUPTED
from warpmuscle.results.journal import Journal, journal_path
from warpmuscle.results.result import glance
from warpmuscle.scene import Scene
from warpmuscle.sweep.finished import FinishedRuns
from warpmuscle.sweep.origin import origin
from warpmuscle.sweep.plan import Plan
from warpmuscle.sweep.plan.digest import OlderDigests, Texts, digest, named_from
from warpmuscle.sweep.rounds import Known, known_of

if sys.platform != "win32":
    import fcntl

MANIFEST = "sweep.json"
INDEX = "index.json"
LOCK = "lock"
ENDINGS = (".h5", ".journal")
GOES_ON = ("", INTERRUPTED)  # why a run ended that is to go on


class RunEntry(msgspec.Struct, frozen=True):
    """A run as the manifest has it."""

    name: str
    digest: str  # of scene, seed and options
    candidates: int
    seed: int
    axes: dict[str, float | str]
    units: dict[str, str] = {}  # of the axes that have any


class Manifest(msgspec.Struct, frozen=True):
    """What a sweep consists of."""

    name: str
    text: str  # of the sweep file
    token: str  # by which a worker knows that it sees the same folder
    device: str  # kind that it was begun on, cpu or cuda; their results differ in the last bits
    runs: tuple[RunEntry, ...]
    trains: bool = False  # whether runs are trainings
    origin: dict[str, str] = {}  # when, where and by which commit it began


@dataclass(frozen=True)
class RunState:
    """What a run has come to."""

    name: str
    begun: bool
    ended: str  # why; empty if it is to go on
    evaluated: int  # candidates
    candidates: int  # in all
    best: float  # least cost, of the last stage if there are any; infinite if there is none
    kept: bool = True  # whether it has a file of its own


class _Mark(msgspec.Struct, frozen=True, array_like=True):
    """What the index says of a run that has ended."""

    file: tuple[int, int]  # size and time of its result file
    ended: str
    evaluated: int
    best: float | None


class _Index(msgspec.Struct, frozen=True):
    """What was found in the files of runs when they were gathered."""

    runs: dict[str, _Mark] = {}
    output: tuple[int, int] | None = None  # size and time of the file that they were gathered into
    made: str = ""  # a digest of what else that file holds


class Folder:
    """The folder of one sweep."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    def of(cls, output: Path) -> Folder:
        """The folder of a sweep by the file that its results are gathered into."""
        return cls(output.with_name(f"{output.stem}.sweep"))

    def result(self, run: str) -> Path:
        """Result file of a run."""
        return self.path / f"{run}.h5"

    def manifest(self) -> Manifest:
        """What the sweep consists of; raises ResultError."""
        path = self.path / MANIFEST
        try:
            found = msgspec.json.decode(path.read_bytes(), type=Manifest)
        except OSError as error:
            raise ResultError(f"{path}: {unreadable(error)}") from None
        except msgspec.DecodeError:
            raise ResultError(f"{path}: damaged; no sweep can go on from it") from None
        if wrong := [entry.name for entry in found.runs if not is_file_name(entry.name)]:
            raise ResultError(f"{path}: damaged; {wrong[0]!r} cannot be the name of a run and its file")
        return found

    @contextlib.contextmanager
    def at_work(self) -> Iterator[None]:
        """Let no other process work on this sweep meanwhile.

        Raises:
            ResultError: another one does, or the folder cannot be made.
        """
        try:
            self.path.mkdir(exist_ok=True)
            handle = os.open(self.path / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            raise ResultError(f"{self.path}: {unwritable(error)}") from None
        try:
            if not _locked(handle, patience=1.0):
                raise OccupiedError(f"{self.path}: another process is at work on this sweep")
            yield
        finally:
            if not (self.path / MANIFEST).exists():  # nothing has begun
                with contextlib.suppress(OSError):
                    (self.path / LOCK).unlink()
                    self.path.rmdir()
            os.close(handle)

    def busy(self) -> bool:
        """Whether a process is at work on this sweep."""
        try:
            handle = os.open(self.path / LOCK, os.O_RDWR)
        except OSError:
            return False
        try:
            return not _locked(handle, patience=0.0)
        finally:
            os.close(handle)

    def begin(self, plan: Plan, device: str, began: Mapping[str, str] | None = None) -> Manifest:
        """Put down what the sweep consists of, or find that it goes on with an earlier one, perhaps with further runs.

        Args:
            device: kind, cpu or cuda. began: when, where and by which commit, by default now and here.

        Raises:
            ResultError: it is another sweep, or on another kind of device, or nothing can be written.
        """
        entries = entries_of(plan)
        if (self.path / MANIFEST).exists():
            earlier = self.manifest()
            self._compare(earlier, entries, plan)
            if earlier.device != device:
                raise ResultError(
                    f"{self.path}: this sweep began on {earlier.device}, and on {device} its costs would differ in the "
                    f"last bits; go on there (--device), or remove the folder to begin anew"
                )
            if len(entries) == len(earlier.runs):
                return earlier
            manifest = msgspec.structs.replace(earlier, text=plan.text, runs=entries)
        else:
            begun = origin() if began is None else dict(began)
            manifest = Manifest(plan.name, plan.text, secrets.token_hex(8), device, entries, plan.trains, begun)
        try:
            replace_file(self.path / MANIFEST, msgspec.json.format(msgspec.json.encode(manifest)))
        except SceneError as error:
            raise ResultError(str(error)) from None
        return manifest

    def _compare(self, earlier: Manifest, entries: Sequence[RunEntry], plan: Plan) -> None:
        """Raise ResultError if a run of earlier is another now, or gone, or nothing but their order has changed."""
        before, now = ({entry.name: entry.digest for entry in runs} for runs in (earlier.runs, entries))
        older = OlderDigests()
        for run in plan.runs:
            known = before.get(run.name, now[run.name])
            if known != now[run.name]:
                if not older.have(run, known):
                    break
                now[run.name] = known
        if list(before.items()) == list(now.items()):
            return
        gone = [name for name in before if name not in now]
        other = [name for name in now if name in before and now[name] != before[name]]
        if not gone and not other and len(now) > len(before):
            return
        what = f"run {other[0]!r} is another" if other else (
            f"run {gone[0]!r} is gone" if gone else "the order of its runs is another"
        )  # fmt: skip
        raise ResultError(
            f"{plan.file}: this sweep, or its scene, has changed since it began: {what}; take the earlier one to go "
            f"on, or another --output, or remove {self.path} to begin anew"
        )

    def states(self, manifest: Manifest) -> list[RunState]:
        """What all runs have come to, read without disturbing those who write; of trainings see `trainings`."""
        return self.states_of(manifest.runs)

    def states_of(self, entries: Sequence[RunEntry]) -> list[RunState]:
        """What some runs have come to."""
        known, there, rounds = self._index().runs, self._files(), known_of(self.path)
        finished = FinishedRuns(self.path)
        found = []
        for entry in entries:
            name = f"{entry.name}.h5"
            mark = known.get(entry.name)
            if mark is not None and mark.file == there.get(name) and f"{name}.journal" not in there:
                best = np.inf if mark.best is None else mark.best
                found.append(RunState(entry.name, True, mark.ended, mark.evaluated, entry.candidates, best))
            elif f"{name}.journal" not in there and (state := finished.state(entry.name, there.get(name))) is not None:
                found.append(RunState(entry.name, True, state[0], state[1], entry.candidates, state[2]))
            else:
                begun = name in there or f"{name}.journal" in there
                found.append(self.state(entry) if begun else _in_rounds(entry, rounds.get(entry.name)))
        return found

    def is_gathered(self, manifest: Manifest, states: Sequence[RunState], output: Path, command: str) -> bool:
        """Whether a file holds all that these runs have come to, and nothing has been touched since it was written."""
        index = self._index()
        names = {state.name for state in states}
        return (
            all(state.ended for state in states) and names == set(index.runs) and index.output == _mark(output)
            and index.made == _made(manifest, output, command)
        )  # fmt: skip

    def remember(self, manifest: Manifest, states: Sequence[RunState], output: Path, command: str) -> None:
        """Put down what runs that have ended have come to, and that a file holds it, so that nobody has to look again.

        It saves time and no more: if it is lost, or files have changed since, they are looked into.
        """
        there = self._files()
        marks = {}
        for state in states:
            file = there.get(f"{state.name}.h5")
            if state.ended and file is not None:
                best = float(state.best) if np.isfinite(state.best) else None
                marks[state.name] = _Mark(file, state.ended, state.evaluated, best)
        index = _Index(marks, _mark(output), _made(manifest, output, command))
        with contextlib.suppress(SceneError):
            replace_file(self.path / INDEX, msgspec.json.encode(index))

    def _index(self) -> _Index:
        try:
            return msgspec.json.decode((self.path / INDEX).read_bytes(), type=_Index)
        except (OSError, msgspec.DecodeError):
            return _Index()

    def _files(self) -> dict[str, tuple[int, int]]:
        """Size and time of all files of runs, by name."""
        try:
            with os.scandir(self.path) as entries:
                return {entry.name: _stamp(entry.stat()) for entry in entries if entry.name.endswith(ENDINGS)}
        except OSError:
            return {}

    def state(self, entry: RunEntry) -> RunState:
        """What a run has come to; a file that cannot be read counts as one that has not begun."""
        path = self.result(entry.name)
        if not path.exists() and not journal_path(path).exists():
            return _in_rounds(entry, known_of(self.path, [entry.name]).get(entry.name))
        try:
            found = glance(path)
        except ResultError:
            return RunState(entry.name, False, "", 0, entry.candidates, np.inf)
        columns = [found.cost, found.generation, found.stage]
        known = {int(number): [column[columns[1] == number] for column in columns] for number in np.unique(columns[1])}
        beside = found.evaluated - len(found.cost)  # evaluated, but not in the file
        for part in Journal.look(journal_path(path)):
            number = int(part.generation[0])
            if number not in known or len(known[number][0]) <= len(part):
                known[number] = [part.cost, part.generation, part.stage]
        cost, stage = (np.concatenate([np.zeros(0), *(parts[k] for parts in known.values())]) for k in (0, 2))
        best = float(cost[stage == stage.max()].min()) if len(cost) else np.inf
        over = found.ended not in GOES_ON and not journal_path(path).exists()
        return RunState(entry.name, True, found.ended if over else "", len(cost) + beside, entry.candidates, best)


def entries_of(plan: Plan) -> tuple[RunEntry, ...]:
    """The runs of a plan as a manifest has them."""
    texts: Texts = {}
    folder = plan.file.absolute().parent

    def text(scene: Scene) -> bytes:
        return msgspec.msgpack.encode(named_from(folder, scene))

    return tuple(
        RunEntry(run.name, digest(run, texts, text), run.candidates, run.seed, dict(run.axes), dict(run.units))
        for run in plan.runs
    )


def _in_rounds(entry: RunEntry, known: Known | None) -> RunState:
    """What a run without a file of its own has come to."""
    costs = np.concatenate([part.cost for part in known.generations.values()]) if known is not None else np.zeros(0)
    best = float(costs.min()) if len(costs) else np.inf
    return RunState(entry.name, known is not None, "", len(costs), entry.candidates, best, kept=False)


def _stamp(found: os.stat_result) -> tuple[int, int]:
    return found.st_size, found.st_mtime_ns


def _mark(path: Path) -> tuple[int, int] | None:
    """Size and time of a file; None if there is none."""
    try:
        return _stamp(path.stat())
    except OSError:
        return None


def _made(manifest: Manifest, output: Path, command: str) -> str:
    """A digest of what a gathered file holds besides its runs."""
    order = [entry.name for entry in manifest.runs]
    return hashlib.sha256(repr((manifest.text, output.name, command, order)).encode()).hexdigest()[:32]


def has_ended(path: Path) -> bool:
    """Whether a result file is that of an optimisation that has finished, and is complete."""
    try:
        return glance(path).ended not in GOES_ON and not journal_path(path).exists()
    except ResultError:
        return False


def folder_of(file: Path) -> Folder:
    """The folder of a sweep by its sweep file or its gathered results; raises Error if there is none."""
    if file.is_dir():
        return Folder(file)
    folder = Folder.of(file)
    if not folder.path.is_dir() and file.suffix == ".toml":
        folder = Folder.of(Path(file.name))  # where the output is by default: in the current folder
    if not (folder.path / MANIFEST).exists():
        raise Error(
            f"{file}: no sweep of it has begun here: there is no {folder.path / MANIFEST}; "
            "name its output if it has another name"
        )
    return folder


def _locked(handle: int, patience: float) -> bool:
    """Whether a lock could be taken, within so many seconds; a file system without locks counts as one."""
    if sys.platform == "win32":
        return True
    end = time.monotonic() + patience
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            if time.monotonic() >= end:
                return False
            time.sleep(0.05)
        except OSError:
            return True
