"""The command that trains a policy."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import (
    BoardFolder,
    Device,
    Settings,
    Threads,
    Trust,
    board_too,
    command_line,
    load_scene,
    refuse_besides,
    scene_names_like,
    search_notes_printed,
    seconds,
    start_warp,
    writable,
)
from warpmuscle.cli.console import log, out
from warpmuscle.cli.progress_bar import Bar
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import many_of, number_of
from warpmuscle.simulation.cuda_warmup import start_driver

if TYPE_CHECKING:
    from warpmuscle.learning.progress import TrainingProgress
    from warpmuscle.learning.training import Trained

USUAL = 300.0  # s of a training that nothing else ends


def learn(
    context: typer.Context,
    sources: Annotated[
        list[str] | None, typer.Argument(metavar="SCENE...", help="As for simulate.", autocompletion=scene_names_like)
    ] = None,
    until: Annotated[
        str | None, typer.Option(help="End after this wall time: 90s, 5m, 2h; by default 5m if nothing else ends it.")
    ] = None,
    iterations: Annotated[
        int | None, typer.Option(min=1, help="End after this many iterations, including those before a --resume.")
    ] = None,
    target: Annotated[
        float | None,
        typer.Option(
            min=0.0, max=1.0, help="End when this share of bodies lasts its full time at the speed wanted, ± 0.1 m/s."
        ),
    ] = None,
    source: Annotated[
        Path | None, typer.Option("--from", metavar="POLICY", help="Begin with the policy of this HDF5 file.")
    ] = None,
    instances: Annotated[
        int | None, typer.Option(min=1, help="Bodies that learn at once; by default 4096 on a GPU, 64 on a CPU.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the policy and of all random numbers.")] = 1,
    option: Annotated[
        list[str] | None,
        typer.Option(
            "--option", metavar="KEY=VALUE", help="Option of the training, such as epochs=5 or 'hidden=[64,64]'."
        ),
    ] = None,
    settings: Settings = None,
    device: Device = None,
    threads: Threads = None,
    trust: Trust = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="HDF5 file to write and to replace; by default SCENE_policy.h5."),
    ] = None,
    resume: Annotated[Path | None, typer.Option(help="Go on with the training of this HDF5 file instead.")] = None,
    tensorboard: BoardFolder = None,
) -> None:
    """Learn a policy that moves the scene, thousands of bodies at once, by proximal policy optimisation.

    The scene's part `learning` says what is learnt. Ctrl-C ends the training and keeps the policy; after a kill
    --resume FILE goes on. Needs pip install "warpmuscle\\[learn]". Examples: warpmuscle learn walk56 --until 5m -o
    policy.h5; warpmuscle simulate walk56 --policy policy.h5
    """
    limit = None if until is None else seconds(until)
    if resume is not None:
        refuse_besides(
            context, {"until", "iterations", "target", "device", "threads", "resume", "trust", "tensorboard"}
        )
    elif not sources:
        raise Error("learn takes a scene, or --resume and a file")
    begin = time.monotonic()
    with search_notes_printed(), TrainingBar() as bar, board_too(bar.update, tensorboard) as tell:
        if resume is not None:
            output = resume
            _start()
            from warpmuscle.learning.training import resume as go_on

            trained = go_on(
                resume, device=device, iterations=iterations, until=limit, target=target, threads=threads,
                command=command_line(), progress=tell,
            )  # fmt: skip
        else:
            start_driver(device)
            scene = load_scene(sources or [], settings=settings)
            from warpmuscle.core.names import file_name

            output = output if output is not None else Path(f"{file_name(scene.name)}_policy.h5")
            writable(output)
            if (limit, iterations, target) == (None, None, None):
                limit = USUAL
            _start()
            from warpmuscle.learning.options import parsed
            from warpmuscle.learning.training import learn as begin_training

            values = {} if instances is None else {"instances": instances}
            trained = begin_training(
                scene, output, options=values | parsed(option or []), source=source, seed=seed, device=device,
                iterations=iterations, until=limit, target=target, threads=threads, command=command_line(),
                progress=tell,
            )  # fmt: skip
    _print_trained(trained, time.monotonic() - begin)
    out.print(f"wrote {output}")


def _start() -> None:
    """Import what takes seconds."""
    with log.status("starting"):
        start_warp()
        import warpmuscle.learning.training  # noqa: F401


class TrainingBar(Bar):
    """Progress of a training: iterations, how long and how fast bodies go, rewards, decisions a second."""

    def update(self, progress: TrainingProgress) -> None:
        """Show this progress."""
        p = progress
        if p.compiling:
            done, state = "0 iterations", "preparing; the first run compiles for some seconds"
        elif p.trying:
            done, state = f"{number_of(p.iterations, 'iteration')}", "trying the policy"
        else:
            done = f"{number_of(p.iterations, 'iteration')}, {many_of(p.decisions, 'decision')}"
            lasts = f"upright {p.upright:.2f} s, {100.0 * p.completed:.0f} % all the time, {p.speed:.2f} m/s, "
            disturbed = f"disturbed by {100.0 * p.hardness:.0f} %, " if p.hardness < 1.0 else ""
            disturbed += f"pushed by {100.0 * p.pushed:.0f} %, " if p.pushed < 1.0 else ""
            state = f"return {p.gain:.4g}, {lasts if p.speed else ''}{disturbed}{many_of(p.rate, 'decision')}/s"
        self.show(p.fraction, done, state, at_once=p.compiling)


def _print_trained(trained: Trained, passed: float) -> None:
    """Print how the training went, and how the policy does."""
    learned = trained.result.learned
    assert learned is not None
    curve = learned.curve
    if len(curve["iteration"]):
        decisions, wall = float(curve["decisions"][-1]), float(curve["wall_time"][-1])
        out.print(
            f"{number_of(int(curve['iteration'][-1]), 'iteration')}, {many_of(decisions, 'decision')} in "
            f"{wall:.1f} s of "
            f"learning ({decisions / max(wall, 1e-9):.0f}/s), {passed:.1f} s in all, on {trained.result.device}; "
            f"{learned.ended}",
            markup=False,
        )
    for one in learned.ancestors[:1]:
        out.print(f"begun with {one}", markup=False)
    out.print(str(trained.evaluation), markup=False)
