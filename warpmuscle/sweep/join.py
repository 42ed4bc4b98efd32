"""Parts of a sweep joined into one: the files of their runs are linked or copied into its folder, and gathered."""

from __future__ import annotations

import os
import shlex
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from warpmuscle.core.errors import Error, ResultError, SceneError
from warpmuscle.core.files import check_writable, replacing
from warpmuscle.core.plain_text import number_of
from warpmuscle.results.result import glance
from warpmuscle.results.training_file import training_path
from warpmuscle.sweep.board import Tell
from warpmuscle.sweep.finished import PATTERN
from warpmuscle.sweep.folder import MANIFEST, Folder, Manifest, RunEntry, entries_of
from warpmuscle.sweep.part import Part, named_part, part_folders
from warpmuscle.sweep.plan import Plan
from warpmuscle.sweep.plan.digest import OlderDigests
from warpmuscle.sweep.run import SweepResult, check_same_study, gather_all
from warpmuscle.sweep.status import states_of

_SHOWN, _MOST_NUMBERS = 3, 10  # of runs and parts that are missing


def join(
    plan: Plan, output: Path, folders: Sequence[Path] = (), *, incomplete: bool = False, command: str = "",
    progress: Tell | None = None,
) -> SweepResult:  # fmt: skip
    """Gather what parts of a sweep have come to into one file, as if one process had run it.

    Args:
        folders: of the parts; by default those beside the output.
        incomplete: gather those runs that have ended; by default all must have.
        command: put into the results as what made them. progress: called several times a second of work.

    Raises:
        Error: there are no parts, they belong to another sweep, were begun on different kinds of device, are still at
            work, or lack runs, which are named; or the file cannot be written.
    """
    check_writable(output)
    check_same_study(output, plan.name)
    parts = [Folder(path) for path in folders] or list(part_folders(output).values())
    if not parts:
        raise Error(f"{output}: there are no parts to join beside it, such as {Part(1, 2).folder(output).path.name}")
    wanted = {entry.name: entry for entry in entries_of(plan)}
    manifests = _checked(parts, plan, wanted)
    device = _only_device(parts, manifests)
    places = _ended_in(parts, manifests)
    folder = Folder.of(output)
    known = states_of(folder, folder.manifest()) if (folder.path / MANIFEST).exists() else []
    there = {state.name for state in known if state.ended}
    missing = [name for name in wanted if name not in places and name not in there]
    if missing and not incomplete:
        raise Error(_lacking(missing, plan, parts))
    with folder.at_work():
        manifest = folder.begin(plan, device, min((m.origin for m in manifests), key=lambda o: o.get("began", "")))
        _take(folder, {name: place for name, place in places.items() if name not in there}, parts)
        gathered = gather_all(folder, manifest, output, command, progress)
    return SweepResult(manifest, folder, gathered, {})


def _checked(parts: Sequence[Folder], plan: Plan, wanted: Mapping[str, RunEntry]) -> list[Manifest]:
    """What the parts consist of; raises Error if one is not of this sweep, or still changes."""
    runs, older = {run.name: run for run in plan.runs}, OlderDigests()
    manifests = []
    for folder in parts:
        manifest = folder.manifest()
        for entry in manifest.runs:
            if entry.name not in wanted:
                what = "is not of this sweep"
            elif entry.digest != wanted[entry.name].digest and not older.have(runs[entry.name], entry.digest):
                what = "is another in this sweep"
            else:
                continue
            raise Error(f"{folder.path}: its run {entry.name!r} {what}; {plan.file} or its scene has changed since")
        if folder.busy():
            raise Error(f"{folder.path}: a process is at work on this part")
        manifests.append(manifest)
    return manifests


def _only_device(parts: Sequence[Folder], manifests: Sequence[Manifest]) -> str:
    kinds = {manifest.device: folder for folder, manifest in zip(parts, manifests, strict=True)}
    if len(kinds) > 1:
        (one, first), (two, second) = list(kinds.items())[:2]
        raise Error(
            f"{first.path} was begun on {one} and {second.path} on {two}, whose costs differ in the last bits; compute "
            "all parts on one kind of device"
        )
    return next(iter(kinds))


def _ended_in(parts: Sequence[Folder], manifests: Sequence[Manifest]) -> dict[str, Path]:
    """The file of each run that has ended in a part."""
    return {
        state.name: folder.result(state.name)
        for folder, manifest in zip(parts, manifests, strict=True)
        for state in states_of(folder, manifest)
        if state.ended
    }


def _lacking(missing: Sequence[str], plan: Plan, parts: Sequence[Folder]) -> str:
    """Which runs are missing, and in which parts they belong."""
    shown = ", ".join(repr(name) for name in missing[:_SHOWN]) + (", ..." if len(missing) > _SHOWN else "")
    counts = {part.total for folder in parts if (part := named_part(folder.path)) is not None}
    where = ""
    if len(counts) == 1:
        count = counts.pop()
        place = {run.name: number % count + 1 for number, run in enumerate(plan.runs)}
        numbers = sorted({place[name] for name in missing})
        named = ", ".join(map(str, numbers[:_MOST_NUMBERS])) + (", ..." if len(numbers) > _MOST_NUMBERS else "")
        again = f"warpmuscle sweep {shlex.quote(str(plan.file))} --part {Part(numbers[0], count)}"
        where = f"; they are of part{'s' if len(numbers) > 1 else ''} {named} of {count}: `{again}`"
    runs = number_of(len(plan.runs), "run")
    damaged = next((folder.result(name) for name in missing for folder in parts if _damaged(folder.result(name))), None)
    remedy = "" if damaged is None else f"; {damaged} is damaged: remove it first, so that its run is computed anew"
    return f"{len(missing)} of {runs} have not ended: {shown}{where}{remedy}; or join what there is with --incomplete"


def _damaged(path: Path) -> bool:
    """Whether there is a file of a run that cannot be read."""
    try:
        glance(path)
    except ResultError:
        return path.exists()
    return False


def _take(folder: Folder, places: Mapping[str, Path], parts: Sequence[Folder]) -> None:
    """Link or copy files of runs, and what is known of them, into the folder of the sweep."""
    try:
        for name, path in places.items():
            _link(path, folder.result(name))
            if training_path(path).exists():
                _link(training_path(path), training_path(folder.result(name)))
        for part in parts:
            for path in part.path.glob(PATTERN):
                _link(path, folder.path / path.name)
    except SceneError as error:
        raise ResultError(str(error)) from None


def _link(source: Path, target: Path) -> None:
    """Make a file the same as another one, with its time: by a link where there can be one."""
    with replacing(target, synchronised=False) as temporary:
        try:
            os.link(source, temporary)
        except OSError:  # such as of another disk
            shutil.copy2(source, temporary)
