"""Searches that go on where they were interrupted or killed."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace as changed
from pathlib import Path

from warpmuscle.core.arguments import as_integer, as_number, as_path, as_truth
from warpmuscle.core.errors import ResultError, ResumeWarning
from warpmuscle.core.machine import in_words, this_machine
from warpmuscle.formats import scene_of
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.optimization.evaluation import BatchEvaluator, OtherCandidates
from warpmuscle.optimization.options import MakeBatches, Tell, check_options, check_other_arguments
from warpmuscle.optimization.progress import Progress, Tracker
from warpmuscle.optimization.run import make_search_loop, run_on_disk
from warpmuscle.optimization.stages import prolonged
from warpmuscle.results.checkpoint import Checkpoint
from warpmuscle.results.partial_motion import checked_quantities
from warpmuscle.results.records import ANY_NUMBER, Result, version_of
from warpmuscle.simulation.kernel_cache import progress_said


def resume(
    path: str | Path,
    candidates: int | None = None,
    device: str | None = None,
    *,
    until: float | None = None,
    target: float | None = None,
    threads: int | None = None,
    command: str = "",
    progress: Tell | None = None,
    batches: MakeBatches | None = None,
    trust: bool = False,
    quantities: Sequence[str] | None = None,
    single: bool = False,
) -> Result:
    """Continue a search that was interrupted, killed or finished, as if it had never stopped.

    Scene, seed and options are those of the file; what it holds is not evaluated again. In a search with stages the
    last one gets the candidates that are asked for besides. A random search goes on with the candidates that it would
    have had, in generations as large as those it began with. On another processor, or with another BLAS, it goes on
    from what was evaluated, with a ResumeWarning that says so: what is asked for then is not the same to the bit. The
    same warning tells of a search that another version of this program began.

    Args:
        path: result file of `optimize(output=...)`, which is kept up further.
        candidates: how many more to evaluate; by default any number with `until`, else what is left of those asked for
            first.
        device: by default that of the file; on one of another kind costs differ in their last bits.
        until: s of wall time from now, by default as many as at first.
        target: cost at which to end, of the last stage if there are any; by default the one asked for.
        threads, progress, batches, trust, quantities, single: as in `optimize`.
        command: put into the result below the earlier one.

    Raises:
        Error: the file cannot be read or written, holds no search, or was made by versions of this program or its
            libraries that ask for other candidates.
    """
    path = as_path(path, "path")
    candidates = None if candidates is None else as_integer(candidates, "candidates")
    until = None if until is None else as_number(until, "until", above=0.0)
    target = None if target is None else as_number(target, "target")
    check_other_arguments(device, threads, command, progress, batches)
    as_truth(trust, "trust")
    checked_quantities(quantities)
    as_truth(single, "single")
    checkpoint, earlier, known = Checkpoint.resume(path)
    with checkpoint, progress_said(progress, "searching", Progress.in_words) as tell:
        assert earlier.searched is not None
        evaluated = sum(map(len, known.values()))
        options = earlier.searched.options
        more = ANY_NUMBER if candidates is None and until is not None else candidates
        options = changed(
            options,
            candidates=options.candidates if more is None else min(evaluated + more, ANY_NUMBER),
            until=options.until if until is None else until,
            target=options.target if target is None else target,
        )
        options = check_options(options)
        scene = scene_of(scene_in(earlier), trust=trust)
        stages = earlier.searched.stages
        if len(stages) != len(scene.stages):
            raise ResultError(f"{path}: damaged result file: its search has other stages than its scene")
        if stages and (more is not None or target is not None):
            stages = prolonged(stages, options, target)
        elsewhere = earlier.searched.elsewhere
        _warn_of_version(path, earlier)
        if _on_another_machine(path, earlier):
            elsewhere = max(known, default=-1) + 1
        tracker = Tracker(options.candidates, options.until, tell)
        batches = batches or (lambda part: BatchEvaluator(part, device or earlier.device, threads))
        search_loop = make_search_loop(
            scene, earlier.seed, options, stages, batches, tracker, known, earlier.searched, elsewhere
        )
        commands = "\n".join(filter(None, (earlier.command, command)))
        start = Result(earlier.scene, search_loop.device, commands, earlier.seed, earlier.parameters)
        try:
            moved = elsewhere > earlier.searched.elsewhere
            return run_on_disk(scene, search_loop, start, checkpoint, moved, quantities, single)
        except OtherCandidates as error:
            made = ", ".join(f"{name} {version}" for name, version in earlier.versions.items())
            raise ResultError(f"{path}: cannot be continued here: {error}; it was made by {made}") from None


def _warn_of_version(path: Path, earlier: Result) -> None:
    """Warn if another version of this program, whose terms may count otherwise, began a search."""
    began, here = earlier.versions.get("warpmuscle"), version_of("warpmuscle")
    if began != here:
        warnings.warn(
            f"{path}: was begun by warpmuscle {began}; this is {here}, which may count terms otherwise: "
            "costs from now on need not compare with those before",
            ResumeWarning,
            stacklevel=3,
        )


def _on_another_machine(path: Path, earlier: Result) -> bool:
    """Whether a search began with another processor or BLAS, and then warn; files of before do not say."""
    began, here = dict(earlier.machine), this_machine()
    if not began or began == here:
        return False
    warnings.warn(
        f"{path}: began on {in_words(began)}; on {in_words(here)} it goes on from what was evaluated, but asks for "
        "other candidates in their last bits than it would have there",
        ResumeWarning,
        stacklevel=3,
    )
    return True
