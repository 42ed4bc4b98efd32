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
    from warpmuscle.optimize import Progress
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
    sources: Sources,
    candidates: Annotated[int, typer.Option(min=1, help="How many sets of parameters to try.")] = 5000,
    seed: Annotated[int, typer.Option(help="Of the search; the same seed gives the same result.")] = 1,
    duration: Duration = None,
    time_step: TimeStep = None,
    device: Device = None,
    threads: Threads = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="HDF5 file to write; by default the scene's name and .h5.")
    ] = None,
) -> None:
    """Search for the scene's free parameters of least cost: random search, all candidates in batched simulations.

    Ctrl-C ends the search and keeps what was evaluated by then. Example: warpmuscle optimize fwalk --candidates 5000
    """
    from warpmuscle import optimize as job
    from warpmuscle.results import write

    scene = _changed(_load(sources), duration, time_step, None)
    output = output if output is not None else Path(f"{scene.name}.h5")
    _writable(output)
    _start_warp()
    with _ProgressBar(candidates) as bar:
        begin = time.perf_counter()
        result = job(scene, candidates, seed, device, threads=threads, command=_command(), progress=bar.update)
        wall = time.perf_counter() - begin
    write(output, result)
    _print_result(scene, result, candidates, wall)
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
        raise ResultError(f"{result} holds no optimisation, only a simulation")
    save(with_values(toml.loads(content.scene), np.asarray(content.best.params, dtype=np.float64)), output)
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


def _print_result(scene: Scene, result: Result, candidates: int, wall: float) -> None:
    """Print what became of the candidates, and the best one."""
    import numpy as np

    from warpmuscle.status import Status

    assert result.evaluations is not None
    assert result.best is not None
    evaluations, best = result.evaluations, result.best
    rate = evaluations.end_time.sum() / wall
    of = "" if len(evaluations.cost) == candidates else f" of {candidates}"
    out.print(
        f"{len(evaluations.cost)}{of} candidates in {wall:.1f} s, {rate:.0f} s of motion per second on {result.device}"
    )
    for status in Status:
        if count := int((evaluations.status == status).sum()):
            out.print(f"  {count:6d} {status.meaning}")
    given = ""
    if np.array_equal(evaluations.params[0], result.parameters.value):
        given = f" (scene as given: {evaluations.cost[0]:.6g})"
    out.print(f"best: candidate {best.index}, cost {best.cost:.6g}{given}")
    _print_gait(scene, result.replays[0])


class _ProgressBar:
    """Progress of an optimisation: candidates done, alive, best cost, simulated seconds per second, time left."""

    def __init__(self, candidates: int) -> None:
        from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
        from rich.progress import Progress as Bars

        self._bars = Bars(
            TextColumn("{task.fields[done]}/{task.fields[candidates]}"),
            BarColumn(),
            TextColumn("{task.fields[alive]} alive, best {task.fields[best]}, {task.fields[rate]} s/s"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=log,
            transient=True,
        )
        self._task = self._bars.add_task("", total=1.0, done=0, candidates=candidates, alive=0, best="-", rate="-")
        self._begin = time.perf_counter()

    def __enter__(self) -> _ProgressBar:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bars.live.is_started:
            self._bars.stop()

    def update(self, progress: Progress) -> None:
        """Show this progress; the first one shows the bar."""
        self._bars.start()
        rate = progress.simulated / (time.perf_counter() - self._begin)
        self._bars.update(
            self._task,
            completed=progress.fraction,
            done=progress.done,
            alive=progress.alive if progress.simulated else "compiling, 0",
            best=f"{progress.best:.5g}" if progress.done else "-",
            rate=f"{rate:.0f}",
        )
