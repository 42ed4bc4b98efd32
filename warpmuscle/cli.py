"""The command line."""

from __future__ import annotations

import shlex
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from warpmuscle.errors import Error

if TYPE_CHECKING:
    from warpmuscle.gait import Gait
    from warpmuscle.progress import Progress
    from warpmuscle.recording import Recording
    from warpmuscle.results import Result
    from warpmuscle.scene import Scene

app = typer.Typer(
    help="Simulate and optimise muscle-actuated bipeds, thousands at once.\n\n"
    "A SCENE is the name of a shipped one (see `warpmuscle scenes`), a TOML file, or .rbs and .sbc files of the "
    "Simbicon Controller Editor Framework, and a .rs file if the .sbc names none.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
out = Console(soft_wrap=True, highlight=False)
log = Console(stderr=True, soft_wrap=True, highlight=False)

INTERRUPTED = 130  # exit code after Ctrl-C where there is nothing to keep

Sources = Annotated[list[str], typer.Argument(metavar="SCENE...", help="Scene name, TOML file, or .rbs .sbc [.rs].")]
Device = Annotated[str | None, typer.Option(help="cpu, cuda:0, ...; by default a GPU if there is one.")]
Threads = Annotated[int | None, typer.Option(min=1, help="CPU threads; by default one a core.")]
Duration = Annotated[float | None, typer.Option(help="Simulated time, s; by default the scene's.")]
TimeStep = Annotated[float | None, typer.Option(help="Time step, s; by default the scene's.")]


@app.command()
def scenes() -> None:
    """List the shipped scenes."""
    from warpmuscle.formats import load, scene_names

    for name in scene_names():
        out.print(f"[bold]{name}[/]  {load(name).description}")


@app.command()
def info(sources: Sources) -> None:
    """Show what a scene holds: bodies, degrees of freedom, mass, muscles, free parameters.

    Muscles whose moment arm about a joint that they cross stays under 1 mm over its range are pointed out.
    """
    from warpmuscle.arrays import rows
    from warpmuscle.parameters import free_parameters, start_values, substitute
    from warpmuscle.topology import topology

    scene = _load(sources)
    parameters = free_parameters(scene)
    numeric, names = substitute(scene, start_values(scene)), topology(scene.character)
    mass = rows([body.mass for body in numeric.character.bodies.values()]).sum()
    root = names.speed_start[1]
    out.print(f"[bold]{scene.name}[/]  {scene.description}")
    out.print(
        f"{len(names.bodies)} bodies, {len(names.joints)} joints, {names.speeds - root} joint degrees of freedom "
        f"and {root} of the root, {mass:.6g} kg"
    )
    out.print(f"{scene.duration:g} s in steps of {scene.time_step:g} s, {len(parameters)} free parameters")
    bodies = Table("body", "mass, kg", "joint", "type", "parent")
    for i, name in enumerate(names.bodies):
        joint = scene.character.joints[names.joints[i - 1]] if i > 0 else None
        row = ["-", scene.character.root_joint, "world"]
        if joint is not None:
            row = [names.joints[i - 1], joint.type, joint.parent]
        bodies.add_row(name, f"{numeric.character.bodies[name].mass:g}", *row)
    out.print(bodies)
    if numeric.character.muscles:
        _print_muscles(numeric)
    width = max((len(p.name) for p in parameters), default=0)
    for p in parameters:
        step = f" step {p.step:g}" if p.step else ""
        out.print(f"{p.name:{width}}  {p.value:g}  in {p.min:g}..{p.max:g}{step} {p.unit}".rstrip(), markup=False)


@app.command()
def simulate(
    sources: Sources,
    duration: Duration = None,
    time_step: TimeStep = None,
    implicit_pd: Annotated[
        bool | None, typer.Option("--implicit-pd/--explicit-pd", help="PD linearised over the step, or not.")
    ] = None,
    legacy: Annotated[
        bool, typer.Option("--legacy", help="Muscles as the original program computed them, without bounds.")
    ] = False,
    device: Device = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="HDF5 file to write.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Stick figures to draw, .png, .svg or .pdf.")] = None,
    rate: Annotated[float, typer.Option(min=1.0, help="Recorded frames per second.")] = 100.0,
) -> None:
    """Run a scene once, and print how it walks.

    Examples: warpmuscle simulate fwalk --plot walk.png -o walk.h5;
    warpmuscle simulate bipV2.rbs fWalk.sbc --duration 60
    """
    _writable(output, plot)
    scene = _changed(_load(sources), duration, time_step, implicit_pd)
    if legacy:
        scene = _as_legacy(scene)
    _start_warp()
    from warpmuscle.optimize import parameter_table
    from warpmuscle.results import Result, write
    from warpmuscle.rollout import Rollout
    from warpmuscle.status import Status

    with log.status("simulating; the first run compiles for some seconds"):
        rollout = Rollout(scene, 1, device, record=[0], record_rate=rate)
        begin = time.perf_counter()
        rollout.run()
    status = Status(rollout.status()[0])
    recording = rollout.recording()
    out.print(
        f"{scene.name}: {status.meaning}; {rollout.end_time()[0]:.4g} s simulated in "
        f"{time.perf_counter() - begin:.2f} s on {rollout.device}, cost {rollout.cost()[0]:.6g}"
    )
    gait = _print_gait(scene, recording)
    if output is not None:
        from warpmuscle.formats import toml

        table = parameter_table(rollout.parameters)
        write(output, Result(toml.dumps(scene), str(rollout.device), _command(), 0, table, replays=(recording,)))
        out.print(f"wrote {output}")
    if plot is not None:
        from warpmuscle.plot import stick_figures

        stick_figures(recording, scene, plot, gait)
        out.print(f"wrote {plot}")


@app.command()
def optimize(
    context: typer.Context,
    sources: Annotated[list[str] | None, typer.Argument(metavar="SCENE...", help="As of simulate.")] = None,
    candidates: Annotated[
        int, typer.Option(min=1, help="How many sets of parameters to try; how many more with --resume.")
    ] = 5000,
    seed: Annotated[int, typer.Option(min=0, help="Of the search; the same seed gives the same result.")] = 1,
    search: Annotated[
        str, typer.Option(help="Strategy: random, cma, cma:ipop, cma:bipop, or nlopt:ALGORITHM such as LN_BOBYQA.")
    ] = "random",
    searches: Annotated[int, typer.Option(min=1, help="Independent searches at the same time, in one batch.")] = 1,
    population: Annotated[
        int | None, typer.Option(min=1, help="Candidates a generation of each search; by default the strategy's own.")
    ] = None,
    sigma: Annotated[float | None, typer.Option(help="First step, as a part of each parameter's interval.")] = None,
    restarts: Annotated[str, typer.Option(help="Of a converged cma: none, ipop or bipop.")] = "none",
    until: Annotated[str | None, typer.Option(help="End after this wall time: 90s, 30m, 2h, 1h30m.")] = None,
    target: Annotated[float | None, typer.Option(help="End at this cost.")] = None,
    duration: Duration = None,
    time_step: TimeStep = None,
    device: Device = None,
    threads: Threads = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="HDF5 file to write and to replace; by default the scene's name and .h5."),
    ] = None,
    resume: Annotated[Path | None, typer.Option(help="Go on with the search of this HDF5 file instead.")] = None,
) -> None:
    """Search for the scene's free parameters of least cost, all candidates in batched simulations.

    What was evaluated is on the disk at any moment: Ctrl-C ends the search and keeps it, and after a kill or a failure
    --resume FILE goes on. Examples: warpmuscle optimize fwalk --candidates 5000;
    warpmuscle optimize walk56 --search cma --searches 6 --until 2h; warpmuscle optimize --resume walk56.h5
    """
    limit = None if until is None else _seconds(until)
    if resume is not None:
        given = {name for name in context.params if _is_given(context, name)}
        for name in sorted(given - {"candidates", "until", "target", "device", "threads", "resume"}):
            word = "scene" if name == "sources" else f"--{name.replace('_', '-')}"
            raise Error(f"--resume takes no {word}: the file says what to go on with")
        more = candidates if "candidates" in given else None
        output = resume
        _start_warp()
        from warpmuscle.optimize import resume as go_on

        with _ProgressBar() as bar:
            result = go_on(
                resume, more, device, until=limit, target=target, threads=threads, command=_command(),
                progress=bar.update,
            )  # fmt: skip
    elif sources:
        scene = _changed(_load(sources), duration, time_step, None)
        output = output if output is not None else Path(f"{scene.name}.h5")
        _writable(output)
        _start_warp()
        from warpmuscle.optimize import optimize as begin

        with _ProgressBar() as bar:
            result = begin(
                scene, candidates, seed, device, search=search, searches=searches, population=population, sigma=sigma,
                restarts=restarts, until=limit, target=target, output=output, threads=threads, command=_command(),
                progress=bar.update,
            )  # fmt: skip
    else:
        raise Error("optimize takes a scene, or --resume and a file")
    _print_result(result, bar)
    out.print(f"wrote {output}")


@app.command()
def apply(
    result: Annotated[Path, typer.Argument(help="HDF5 file of an optimisation.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="TOML file to write.")],
) -> None:
    """Write the scene of an optimisation with its best parameters as a scene file."""
    import numpy as np

    from warpmuscle.errors import ResultError
    from warpmuscle.formats import save, toml
    from warpmuscle.parameters import with_values
    from warpmuscle.results import read

    content = read(result)
    if content.best is None:
        raise ResultError(f"{result} holds no candidates to choose the best of")
    save(with_values(toml.loads(content.scene), np.asarray(content.best.params, dtype=np.float64)), output)
    out.print(f"wrote {output}")


@app.command()
def report(result: Annotated[Path, typer.Argument(help="HDF5 file of an optimisation.")]) -> None:
    """Show what an optimisation found: outcomes, convergence, the score explained, parameters in their bounds."""
    from warpmuscle.report import report as lines_of
    from warpmuscle.results import read

    for line in lines_of(read(result)):
        out.print(line, markup=False)


@app.command()
def export(
    result: Annotated[Path, typer.Argument(help="HDF5 file with a recorded motion.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="OpenSim's .mot (angles) or .sto (muscles), or .csv.")],
    replay: Annotated[int, typer.Option(min=0, help="Which motion of the file.")] = 0,
) -> None:
    """Write a recorded motion for OpenSim or as comma-separated values."""
    from warpmuscle.errors import ResultError
    from warpmuscle.formats import sto, toml
    from warpmuscle.results import read

    content = read(result)
    if replay >= len(content.replays):
        raise ResultError(f"{result} has {len(content.replays)} motions, none with number {replay}")
    sto.write(content.replays[replay], toml.loads(content.scene), output)
    out.print(f"wrote {output}")


@app.command("fit-muscles")
def fit_muscles(
    sources: Sources,
    output: Annotated[Path, typer.Option("--output", "-o", help="TOML file to write.")],
    strength: Annotated[float, typer.Option(min=0.01, help="Factor on f_max.")] = 1.5,
    mean_length: Annotated[float, typer.Option(min=0.1, help="Fibre length over l_opt at the mean path length.")] = 1.0,
    fibre_per_arm: Annotated[float, typer.Option(min=0.0, help="Least l_opt over the mean moment arm.")] = 1.0,
    properties_only: Annotated[
        bool, typer.Option("--properties-only", help="Write f_max, l_opt and l_slack only, to add to a character.")
    ] = False,
    duration: Duration = None,
    device: Device = None,
) -> None:
    """Fit the muscles of a scene to its skeleton and to the motion that it makes on torques.

    Slack lengths follow from the mean path lengths, both sides get the same properties, and f_max grows by a factor.
    Example: warpmuscle fit-muscles walk56_legacy -o fitted.toml
    """
    from warpmuscle.fit_muscles import PropertyTable
    from warpmuscle.fit_muscles import fit_muscles as fit
    from warpmuscle.formats import save
    from warpmuscle.formats.files import replace_file
    from warpmuscle.formats.toml_layout import layout

    _writable(output)
    scene = _changed(_load(sources), duration, None, None)
    _start_warp()
    options = {"mean_length": mean_length, "fibre_per_arm": fibre_per_arm, "strength": strength}
    with log.status("simulating on torques; the first run compiles for some seconds"):
        fitted = fit(scene, **options, device=device)
    if properties_only:
        heading = "# Properties of muscles by `" + _command() + "`; tables to add to a character."
        replace_file(output, f"{heading}\n\n{layout(PropertyTable.of(fitted))}")
    else:
        save(fitted, output)
    out.print(f"wrote {output}")


@app.command()
def convert(
    sources: Sources,
    output: Annotated[Path, typer.Option("--output", "-o", help=".toml, or .rbs, .sbc or .rs for all three; or .xml.")],
    keyword_rule: Annotated[
        bool, typer.Option("--keyword-rule", help="Muscles drive only joints that a .rbs marks `actuationType muscle`.")
    ] = False,
) -> None:
    """Write a scene in another format: TOML, the original program's files, or MuJoCo's (character and ground only)."""
    from warpmuscle.formats import Ignored, mjcf, save

    scene = _load(sources, keyword_rule)
    lost: list[Ignored] = []
    if output.suffix == ".xml":
        mjcf.write(scene, output)
    else:
        save(scene, output, lost)
    _print_ignored(lost, "not all was written:")
    three = (".rbs", ".sbc", ".rs")
    files = [output.with_suffix(suffix) for suffix in three] if output.suffix in three else [output]
    out.print(f"wrote {', '.join(map(str, files))}")


def main() -> None:
    """Run the command line; an error that a user can mend is one line and exit code 2."""
    try:
        code = app(standalone_mode=False)
    except Error as error:
        log.print(f"[bold red]error:[/] {_escaped(str(error))}")
        sys.exit(2)
    except Exception as error:
        usage = getattr(error, "show", None)  # an error in the command's own arguments
        if usage is None:
            raise
        usage()
        sys.exit(2)
    if code == INTERRUPTED:
        log.print("interrupted")
    sys.exit(code)


def _start_warp() -> None:
    """Start Warp without its greeting, and without its warning that a machine without a GPU has none."""
    import os

    import warp

    warp.config.log_level = warp.LOG_WARNING
    errors = os.dup(2)
    try:
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 2)  # the warning comes from compiled code
        warp.init()
    finally:
        os.dup2(errors, 2)
        os.close(errors)


def _load(sources: list[str], keyword_rule: bool = False) -> Scene:
    """The scene, and on the error stream what its files hold that is not used."""
    import warnings

    from warpmuscle.formats import Ignored, load
    from warpmuscle.validate_muscles import SceneWarning

    ignored: list[Ignored] = []
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always", SceneWarning)
        scene = load(*sources, ignored=ignored, keyword_rule=keyword_rule)
    for doubt in doubts:
        log.print(f"[yellow]warning:[/] {_escaped(str(doubt.message))}")
    _print_ignored(ignored, "some input was ignored:")
    return scene


def _print_ignored(ignored: list[Any], heading: str) -> None:
    """On the error stream, what was not used, a line for each file and reason."""
    from warpmuscle.formats.load import summary

    if ignored:
        log.print(f"[yellow]{_escaped(summary(ignored, heading))}[/]")


def _escaped(text: str) -> str:
    from rich.markup import escape

    return escape(text)


def _changed(scene: Scene, duration: float | None, time_step: float | None, implicit_pd: bool | None) -> Scene:
    """The scene with what the command line overrides."""
    import msgspec

    from warpmuscle.validate import check_scene

    changes = {"duration": duration, "time_step": time_step, "implicit_pd": implicit_pd}
    scene = msgspec.structs.replace(scene, **{name: value for name, value in changes.items() if value is not None})
    check_scene(scene)
    return scene


def _as_legacy(scene: Scene) -> Scene:
    """The scene with the original program's muscle law in place of its own."""
    import msgspec

    from warpmuscle.scene import MuscleModel

    return msgspec.structs.replace(scene, muscle_model=MuscleModel(legacy=True, negative=scene.muscle_model.negative))


def _writable(*paths: Path | None) -> None:
    """Raise an error now rather than after the work if a file cannot be written."""
    from warpmuscle.formats.files import check_writable

    for path in paths:
        if path is not None:
            check_writable(path)


def _command() -> str:
    return shlex.join(["warpmuscle", *sys.argv[1:]])


def _print_gait(scene: Scene, recording: Recording) -> Gait | None:
    """Print speed, step length and cadence of a scene with a controller."""
    from warpmuscle.gait import measure

    if scene.controller is None or recording.frames == 0:
        return None
    gait = measure(recording, *scene.controller.feet)
    text = f"speed {gait.speed_forward:.3f} m/s"
    if gait.step_length is not None and gait.cadence is not None:
        text += f", step length {gait.step_length:.3f} m, cadence {gait.cadence:.1f} steps/min"
    out.print(f"{text} (from {gait.start:.3g} s to {gait.end:.3g} s, {gait.steps} steps)")
    return gait


def _print_muscles(scene: Scene) -> None:
    """Print the muscles of a scene without free parameters: properties, joints, and where they cannot act."""
    from warpmuscle.moment_arms import useless_muscles
    from warpmuscle.muscles import driven
    from warpmuscle.paths import joints_of_muscles
    from warpmuscle.topology import topology

    names = topology(scene.character)
    found = driven(scene, names)
    muscles = Table("muscle", "f_max, N", "l_opt, m", "l_slack, m", "delay, s", "joints", "driven")
    for name, joints in joints_of_muscles(scene.character, names).items():
        m = scene.character.muscles[name]
        numbers = [f"{number:g}" for number in (m.f_max, m.l_opt, m.l_slack, m.delay)]
        muscles.add_row(name, *numbers, " ".join(joints) or "-", "yes" if name in found.muscles else "no")
    out.print(muscles)
    for joint, words in found.drives.items():
        if joint in scene.actuation:
            out.print(f"{joint}: {', '.join(words)}")
    _start_warp()
    for name, joint, arm in useless_muscles(scene):
        out.print(f"[yellow]{name} cannot act on {joint}:[/] its moment arm stays under {1e3 * max(arm, 1e-5):.2g} mm")
    for name, joints in joints_of_muscles(scene.character, names).items():
        if not joints:
            out.print(f"[yellow]{name} cannot act at all:[/] it crosses no joint that moves")


def _seconds(text: str) -> float:
    """A time such as 90, 90s, 30m or 1h30m, in seconds; raises Error."""
    import re

    match = re.fullmatch(r"(?:([\d.]+)h)?(?:([\d.]+)m)?(?:([\d.]+)s?)?", text.replace(" ", ""))
    try:
        assert match is not None
        seconds = sum(
            float(part) * unit for part, unit in zip(match.groups(), (3600.0, 60.0, 1.0), strict=True) if part
        )
        assert seconds > 0.0
    except (AssertionError, ValueError):
        raise Error(f"{text!r} is not a time such as 90s, 30m or 2h") from None
    return seconds


def _is_given(context: typer.Context, name: str) -> bool:
    """Whether an argument or option stands on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE" and context.params[name] not in (None, [], ())


def _print_result(result: Result, bar: _ProgressBar) -> None:
    """Print what became of the candidates, and the best one."""
    import numpy as np

    from warpmuscle.status import Status

    assert result.evaluations is not None
    assert result.best is not None
    assert result.searched is not None
    evaluations, best, options = result.evaluations, result.best, result.searched.options
    of = "" if len(evaluations.cost) == options.candidates else f" of {options.candidates}"
    rate = f"{bar.simulated / max(bar.elapsed, 1e-9):.0f} s of motion per second on {result.device}"
    earlier = f", {bar.recalled} of them earlier" if bar.recalled else ""
    out.print(f"{len(evaluations.cost)}{of} candidates in {bar.elapsed:.1f} s{earlier}, {rate}")
    generations = int(evaluations.generation[-1]) + 1
    several = f"{options.searches} searches, " if options.searches > 1 else ""
    out.print(f"{options.strategy}: {several}{generations} generations; {result.searched.ended}")
    for status in Status:
        if count := int((evaluations.status == status).sum()):
            out.print(f"  {count:6d} {status.meaning}")
    given = ""
    if np.array_equal(evaluations.params[0], result.parameters.value):
        given = f" (scene as given: {evaluations.cost[0]:.6g})"
    search = int(evaluations.search[best.index])
    found = f", found by search {search}" if options.searches > 1 and search >= 0 else ""
    out.print(
        f"best: candidate {best.index} of generation {evaluations.generation[best.index]}{found}, "
        f"cost {best.cost:.6g}{given}"
    )
    _print_gait(_scene_of(result), result.replays[0])


def _scene_of(result: Result) -> Scene:
    from warpmuscle.formats import toml

    return toml.loads(result.scene)


class _ProgressBar:
    """Progress of an optimisation: candidates done, alive, generation, costs, seconds simulated, time left.

    Attributes:
        recalled: candidates that were evaluated before.
        simulated: s of motion computed.
    """

    def __init__(self) -> None:
        from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
        from rich.progress import Progress as Bars

        self._bars = Bars(
            TextColumn("{task.fields[done]}/{task.fields[candidates]}"),
            BarColumn(),
            TextColumn("{task.fields[alive]} alive, {task.fields[costs]}, {task.fields[rate]} s/s"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=log,
            transient=True,
        )
        self._task = self._bars.add_task("", total=1.0, done=0, candidates="-", alive=0, costs="", rate="-")
        self._begin = time.perf_counter()
        self.simulated, self.recalled = 0.0, 0

    @property
    def elapsed(self) -> float:
        """Wall time so far, s."""
        return time.perf_counter() - self._begin

    def __enter__(self) -> _ProgressBar:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bars.live.is_started:
            self._bars.stop()

    def update(self, progress: Progress) -> None:
        """Show this progress; the first one shows the bar."""
        self._bars.start()
        self.simulated, self.recalled = progress.simulated, progress.recalled
        median = f", median {progress.median:.5g}" if progress.generation > 0 else ""
        self._bars.update(
            self._task,
            completed=progress.fraction,
            done=progress.done,
            candidates=progress.candidates,
            alive=progress.alive if progress.simulated else "compiling, 0",
            costs=f"generation {progress.generation}, best "
            + (f"{progress.best:.5g}" if progress.done else "-")
            + median,
            rate=f"{progress.simulated / self.elapsed:.0f}",
        )
