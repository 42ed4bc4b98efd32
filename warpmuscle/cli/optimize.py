"""The command that searches for parameters."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import (
    BoardFolder,
    Device,
    Duration,
    FreeNumbers,
    Population,
    Quantities,
    Settings,
    Single,
    Threads,
    TimeStep,
    Trust,
    board_too,
    changed,
    command_line,
    doubts_printed,
    load_scene,
    quantities_in,
    refuse_besides,
    scene_names_like,
    search_notes_printed,
    seconds,
    start_warp,
    with_free,
    writable,
)
from warpmuscle.cli.console import GaitPrinter, log, out, print_gait, print_warnings, suggest
from warpmuscle.cli.progress_bar import ProgressBar
from warpmuscle.core.errors import Error
from warpmuscle.core.interruption import received
from warpmuscle.core.plain_text import number_of
from warpmuscle.simulation.cuda_warmup import start_driver

if TYPE_CHECKING:
    from warpmuscle.gait.measures import Gait
    from warpmuscle.optimization.progress import Progress
    from warpmuscle.results.records import Result
    from warpmuscle.scene import Scene

STILL = 0.05  # m/s, below which nobody walks
BEST = "warpmuscle.optimization.best_scene"
PAGE = "warpmuscle.report.before_after"  # imported for a page of the walk before and after

Strategy = Annotated[
    str | None,
    typer.Option(
        help="Strategy: islands, cma, cma:ipop, cma:bipop, random, or nlopt:ALGORITHM such as LN_BOBYQA; by default "
        "islands that fill a GPU, or cma on a CPU."
    ),
]


def optimize(
    context: typer.Context,
    sources: Annotated[
        list[str] | None, typer.Argument(metavar="SCENE...", help="As for simulate.", autocompletion=scene_names_like)
    ] = None,
    candidates: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="How many sets of parameters to try, in all searches and stages; how many more with --resume. "
            "By default any number with --until, else 5000 a search, or on a GPU 100 generations that fill it.",
        ),
    ] = None,
    seed: Annotated[
        int, typer.Option(min=0, help="Seed of the search; the same seed gives the same result on equal machines.")
    ] = 1,
    search: Strategy = None,
    searches: Annotated[int, typer.Option(min=1, help="Independent searches at the same time, in one batch.")] = 1,
    population: Population = None,
    sigma: Annotated[float | None, typer.Option(help="First step, as a fraction of each parameter's interval.")] = None,
    restarts: Annotated[str, typer.Option(help="Restarts of a converged cma: none, ipop or bipop.")] = "none",
    until: Annotated[
        str | None, typer.Option(help="End after this wall time for all stages together: 90s, 30m, 2h, 1h30m.")
    ] = None,
    target: Annotated[float | None, typer.Option(help="End when the last stage reaches this cost.")] = None,
    duration: Duration = None,
    time_step: TimeStep = None,
    settings: Settings = None,
    free: FreeNumbers = None,
    device: Device = None,
    threads: Threads = None,
    trust: Trust = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="HDF5 file to write and to replace; by default the scene's name and .h5."),
    ] = None,
    resume: Annotated[Path | None, typer.Option(help="Go on with the search of this HDF5 file instead.")] = None,
    quantities: Quantities = None,
    single: Single = False,
    tensorboard: BoardFolder = None,
    no_open: Annotated[
        bool, typer.Option("--no-open", help="Do not open the page of the walk before and after in the browser.")
    ] = False,
) -> None:
    """Search for the values of a scene's free parameters that cost least, with many candidates simulated at once.

    Every evaluation is saved at once: Ctrl-C ends the search and writes its result, and after a kill or a failure
    --resume FILE goes on. Examples: warpmuscle optimize fwalk --candidates 5000;
    warpmuscle optimize walk56 --search cma --searches 16 --until 2h; warpmuscle optimize --resume walk56.h5
    """
    limit, scene = None if until is None else seconds(until), None
    if resume is not None:
        refuse_besides(context, {"candidates", "until", "target", "device", "threads", "resume", "trust", "quantities",
                                 "single", "tensorboard", "no_open"})  # fmt: skip
        output = resume
        start_warp()
        with log.status("getting ready"):  # imports take a second
            from warpmuscle.optimization.resume import resume as go_on
        with search_notes_printed(), _kept(output), ProgressBar() as bar, board_too(bar.update, tensorboard) as tell:
            result = go_on(
                resume, candidates, device, until=limit, target=target, threads=threads, command=command_line(),
                progress=tell, quantities=quantities_in(quantities), single=single,
            )  # fmt: skip
    elif sources:
        start_driver(device)
        scene = _with_objective(
            changed(load_scene(sources, settings=settings), duration, time_step, None), free, settings
        )
        from warpmuscle.core.names import file_name
        from warpmuscle.optimization.usual_search import CANDIDATES

        count = candidates or (CANDIDATES * searches if scene.stages else None)
        output = output if output is not None else Path(f"{file_name(scene.name)}.h5")
        writable(output)
        start_warp()
        with log.status("getting ready"):  # imports take a second
            from warpmuscle.optimization.optimize import optimize as begin
        printer = GaitPrinter(scene, (BEST, PAGE) if scene.objective.norms else (BEST,))
        with search_notes_printed(), _kept(output), ProgressBar() as bar, board_too(bar.update, tensorboard) as board:
            result = begin(
                scene, count, seed, device, search=search, searches=searches, population=population, sigma=sigma,
                restarts=restarts, until=limit, target=target, output=output, threads=threads, command=command_line(),
                progress=_printing(board, printer, device), quantities=quantities_in(quantities), single=single,
            )  # fmt: skip
        printer.end()
    else:
        raise Error("optimize takes a scene, or --resume and a file")
    _print_all(result, bar, scene, output, device, threads, no_open)


def _print_all(
    result: Result, bar: ProgressBar, begun: Scene | None, output: Path, device: str | None, threads: int | None,
    no_open: bool,
) -> None:  # fmt: skip
    """Print what was found and where it is, last what to look at; `begun` as of `_print_result`."""
    from warpmuscle.cli.view import open_page
    from warpmuscle.optimization.best_scene import recorded_scene

    plain = recorded_scene(result)
    if begun is None and bar.simulated == 0.0:
        log.print("nothing was left to do: --candidates says how many more to try, --until for how long to go on")
    _print_result(result, bar, begun, plain)
    out.print(f"wrote {output}")
    # Who was interrupted may have little time left.
    page = None if received() else _show_walks(result, plain, output, device, threads)
    suggest(f"`warpmuscle report {output}` says what it found")
    if page is not None:
        opened = not no_open and log.is_terminal and open_page(page)
        out.print(f"{page} shows both walks side by side: {'it opens' if opened else 'open it'} in a browser")


def _with_objective(scene: Scene, free: list[str] | None, settings: list[str] | None) -> Scene:
    """A scene to search, with more numbers free, and with the usual objective if it has none."""
    from warpmuscle.optimization.usual_objective import warn_of_speed_in_vain, weighs_nothing, with_usual_objective

    scene = with_free(scene, free) if free else scene
    with doubts_printed():
        warn_of_speed_in_vain(scene, [text.partition("=")[0].strip() for text in settings or []])
    if weighs_nothing(scene):
        scene = with_usual_objective(scene)
        log.print(
            f"{scene.name} weighs no term: the search is for a gait at {scene.objective.target_speed:g} m/s with "
            "little effort, see docs/reference/objective.md"
        )
    return scene


def _printing(tell: Callable[[Progress], None], printer: GaitPrinter, device: str | None) -> Callable[[Progress], None]:
    """Who is told of a search; what will print its walk is prepared meanwhile.

    That is done while a kernel is compiled, which takes one thread, and while the processor waits for a GPU.
    """
    from warpmuscle.simulation.devices import find_devices

    on_gpu = not find_devices(device)[0].is_cpu

    def report(progress: Progress) -> None:
        if progress.compiling or (on_gpu and progress.alive):
            printer.begin()
        tell(progress)

    return report


@contextmanager
def _kept(output: Path) -> Iterator[None]:
    """Say how to go on with a search that was interrupted before it could write its result."""
    try:
        yield
    except KeyboardInterrupt:
        from warpmuscle.results.journal import journal_path

        if journal_path(output).exists():
            again = shlex.join(["warpmuscle", "optimize", "--resume", str(output)])
            log.print(f"what was evaluated is kept: `{again}` goes on")
        raise


def _print_result(result: Result, bar: ProgressBar, begun: Scene | None, plain: Scene) -> None:
    """Print what became of the candidates, and the best one.

    Args:
        begun: the scene of a search that was not resumed. plain: that of its motion.
    """

    from warpmuscle.core.status import Status
    from warpmuscle.scene.masses import mass_warnings

    assert result.evaluations is not None
    assert result.best is not None
    assert result.searched is not None
    evaluations, options = result.evaluations, result.searched.options
    tried = number_of(len(evaluations.cost), "candidate")
    if len(evaluations.cost) < options.candidates and options.limited:
        tried = f"{len(evaluations.cost)} of {number_of(options.candidates, 'candidate')}"
    rate = f"{bar.simulated / max(bar.elapsed, 1e-9):.0f} s of motion per second on {result.device}"
    if bar.computed > 0.0:
        rate += f", which computed {100.0 * bar.computed:.0f} % of the time"
    earlier = f", {bar.recalled} of them earlier" if bar.recalled else ""
    out.print(f"{tried} in {bar.elapsed:.1f} s{earlier}, {rate}")
    generations = int(evaluations.generation[-1]) + 1
    several = f"{number_of(options.searches, 'search')}, " if options.searches > 1 else ""
    if result.searched.stages:
        _print_stages(result)
    else:
        size = "" if options.population is None else f" of {number_of(options.population, 'candidate')}"
        out.print(f"{options.strategy}: {several}{number_of(generations, 'generation')}{size}; {result.searched.ended}")
        if options.strategy != "random" and len(result.searched.history.generation) == 0:
            out.print("not one generation is complete, so that nothing has been learnt: give it more candidates")
    for status in Status:
        if count := int((evaluations.status == status).sum()):
            out.print(f"  {count:6d} {status.meaning}")
    _print_best(result)
    gait = print_gait(plain, result.replays[0])
    if gait is not None and stands_still(plain, gait):
        out.print(
            f"the best one stands still: it goes {gait.speed_horizontal:.2g} m/s; weigh speed more in the objective, "
            "or begin with a scene that walks"
        )
    if begun is None or not mass_warnings(begun):  # else it was said at the beginning
        print_warnings(mass_warnings(plain))


def _print_best(result: Result) -> None:
    """Print which candidate is the best one, and what to do where that is the scene as given."""
    import numpy as np

    assert result.evaluations is not None
    assert result.best is not None
    assert result.searched is not None
    evaluations, best = result.evaluations, result.best
    given = ""
    if np.array_equal(evaluations.params[0], result.parameters.value) and not result.searched.stages:
        given = f" (scene as given: {evaluations.cost[0]:.6g})"
    search = int(evaluations.search[best.index])
    found = f", found by search {search}" if result.searched.options.searches > 1 and search >= 0 else ""
    out.print(
        f"best: candidate {best.index} of generation {evaluations.generation[best.index]}{found}, "
        f"cost {best.cost:.6g}{given}"
    )
    if np.array_equal(best.params, result.parameters.value) and len(evaluations) > 1 and _takes_usual_steps(result):
        out.print(
            "nothing is better than the scene as given; if that works already, begin with small steps: --sigma 0.05"
        )


def _takes_usual_steps(result: Result) -> bool:
    """Whether the first steps of a search, or of its last stage, are those of who was told nothing."""
    assert result.searched is not None
    stages = result.searched.stages
    options = stages[-1].options if stages else result.searched.options
    return options.strategy != "random" and options.sigma is None


def _show_walks(result: Result, plain: Scene, output: Path, device: str | None, threads: int | None) -> Path | None:
    """Print what a search for a person's walk began with beside what it found, and write a page of both; its path."""
    from warpmuscle.optimization.best_scene import is_to_walk

    if not is_to_walk(result, plain):
        return None
    with log.status("looking at what was found"):  # imports take a second
        from warpmuscle.core.files import replace_file
        from warpmuscle.report.before_after import before_and_after, lines, page

    with log.status("walking as before and after"):
        walks = before_and_after(result, device=device, threads=threads)
        text = page(*walks, result.command)
    out.print("")
    for line in lines(*walks):
        out.print(line, markup=False)
    path = output.with_name(f"{output.stem}_before_after.html")
    replace_file(path, text)
    return path


def stands_still(scene: Scene, gait: Gait) -> bool:
    """Whether what is to walk does not: its speed is next to none, and no speed of 0 is asked for."""
    return scene.objective.target_speed != 0.0 and gait.speed_horizontal < STILL


def _print_stages(result: Result) -> None:
    """Print how each stage went that has begun."""
    assert result.evaluations is not None
    assert result.searched is not None
    searched = result.searched
    for number, stage in enumerate(searched.stages[: searched.stage + 1]):
        count = int((result.evaluations.stage == number).sum())
        cost = f"{stage.best.cost:.6g}" if stage.best is not None else "-"
        ended = stage.ended or searched.ended
        out.print(
            f"stage {number + 1}, {stage.name}: {stage.options.strategy}, {number_of(len(stage.free), 'parameter')}, "
            f"{number_of(count, 'candidate')}, best {cost}; {ended}"
        )
