"""Commands about result files."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import SceneFile, Settings, Trust, scene_names_like, start_warp, with_settings
from warpmuscle.cli.console import log, out
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of, readable

if TYPE_CHECKING:
    from warpmuscle.results.recording import Recording
    from warpmuscle.scene import Scene

Replay = Annotated[int, typer.Option(min=0, help="Which motion of the file.")]
Run = Annotated[str | None, typer.Option(help="Which run, in the file of a sweep.")]


def apply(
    results: Annotated[list[Path], typer.Argument(metavar="RESULT...", help="HDF5 file of an optimisation.")],
    output: SceneFile,
    on: Annotated[
        str | None,
        typer.Option(
            metavar="SCENE",
            help="Write only what differs from this scene, as based on it.",
            autocompletion=scene_names_like,
        ),
    ] = None,
    over: Annotated[
        str | None,
        typer.Option(
            metavar="KEY",
            help="Take several results that differ in this number; all other numbers that differ follow it.",
        ),
    ] = None,
    fix: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="Numbers that are no longer to be free, such as 'character.*'."),
    ] = None,
    among: Annotated[
        int | None,
        typer.Option(
            "--most-robust", min=1, metavar="N", help="Of the N best, the one that withstands most disturbed runs."
        ),
    ] = None,
    hardiest: Annotated[int | None, typer.Option(hidden=True, callback=lambda given: _renamed(given))] = None,
    settle: Annotated[
        float | None,
        typer.Option(min=0.0, metavar="SECONDS", help="Begin in the middle of its motion, at a step after this time."),
    ] = None,
    settings: Settings = None,
    description: Annotated[
        str | None, typer.Option(help="Description of the scene; by default, that a search found it.")
    ] = None,
    run: Run = None,
    trust: Trust = False,
) -> None:
    """Write the scene of an optimisation with its best parameters as a scene file.

    Examples: warpmuscle apply walk56.h5 -o best.toml; warpmuscle apply speeds.h5 --on walk56_human --settle 4
    --over objective.target_speed -o walk56_speeds.toml
    """
    from warpmuscle.core.files import replace_file
    from warpmuscle.formats import save

    sources = [(path, name) for path in results for name in _runs_of(path, run, over is not None)]
    if (over is None) != (len(sources) == 1) or (over is not None and on is None):
        raise Error("apply takes one result, or with --over KEY and --on SCENE several, or all runs of a sweep")
    found = [_best_of(path, name, fix or [], settings or [], settle, among) for path, name in sources]
    if on is None:
        save(_called(found[0][0], None, description), output)
    else:
        if output.suffix.lower() != ".toml":
            raise Error(f"{output}: a scene on another one is written as .toml")
        replace_file(output, _on_another(found, on, over, readable(output.stem), description))
    out.print(f"wrote {output}")


def _runs_of(path: Path, run: str | None, every: bool) -> list[str | None]:
    """Names of the runs wanted of a file; None stands for the only one of an optimisation."""
    from warpmuscle.results.result import run_names

    return [run] if run is not None or not every else list(run_names(path)) or [None]


def _best_of(
    path: Path, run: str | None, fix: list[str], settings: list[str], settle: float | None, among: int | None
) -> tuple[Scene, str]:
    """The scene of a result with its best parameters, some of them fixed, settled, and how they were found."""
    from warpmuscle.core.errors import ResultError
    from warpmuscle.optimization.best_scene import best_scene
    from warpmuscle.results.result import read

    content = read(path, run, replay=0)
    if among is not None or settle is not None:
        start_warp()
    try:
        with log.status("simulating good candidates again") if among is not None else nullcontext():
            scene, how = best_scene(content, fix, among)
    except ResultError as error:
        raise ResultError(f"{path}: {error}") from None
    scene = with_settings(scene, settings)
    if settle is not None:
        from warpmuscle.studies.steady_state import steady_state

        with log.status("settling"):
            scene = steady_state(scene, settle)
    return scene, how


def _called(scene: Scene, name: str | None, description: str | None) -> Scene:
    """The scene by another name; what was said of it before the search, such as that it falls, is said no more."""
    import msgspec

    return msgspec.structs.replace(
        scene,
        name=scene.name if name is None else name,
        description=f"The best that a search from {scene.name} found." if description is None else description,
    )


def _on_another(found: list[tuple[Scene, str]], on: str, over: str | None, name: str, description: str | None) -> str:
    """The text of a scene based on another one, from one scene or through several."""
    from warpmuscle.formats import derived, load

    scenes = [_called(scene, name, description) for scene, _ in found]
    comment = [f"By `warpmuscle apply`, {how}" for _, how in found]
    base = on if on.endswith(".toml") else f"{on}.toml"
    if over is None:
        return derived.on_base(scenes[0], load(on), base, comment)
    return derived.over(scenes, over, load(on), base, comment)


def report(
    result: Annotated[Path, typer.Argument(help="HDF5 file of an optimisation.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help=".html page to write, with figures.")] = None,
    reference: Annotated[
        list[Path] | None, typer.Option(help="HDF5 file of another walk to put beside this one's numbers in the page.")
    ] = None,
    replay: Annotated[int, typer.Option(min=0, help="Which motion of the file is in the page.")] = 0,
    run: Run = None,
    trust: Trust = False,
) -> None:
    """Show what an optimisation found: outcomes, convergence, the score explained, parameters in their bounds.

    With -o it is one page that needs nothing but a browser, with figures, the motion to play, and the gait beside human
    walking. Example: warpmuscle report result.h5 -o report.html
    """
    from warpmuscle.report.summary import report as lines_of
    from warpmuscle.results.result import read

    if output is not None:
        _write_page(result, output, reference or [], replay, run)
        return
    for line in lines_of(read(result, run, replay=0)):
        out.print(line, markup=False)


def _write_page(result: Path, output: Path, references: list[Path], replay: int, run: str | None) -> None:
    from warpmuscle.core.extras import check_report
    from warpmuscle.core.files import replace_file
    from warpmuscle.plots.subject import Choices, Subject
    from warpmuscle.report.page import report_html
    from warpmuscle.results.result import read

    check_report(output)
    subject = Subject(read(result, run, replay=replay), Choices(replay), result, run)
    others = [Subject(read(path, replay=0), Choices(), path) for path in references]
    start_warp()
    with log.status("drawing") as shown:
        page = report_html(subject, others, lambda what: shown.update(f"drawing: {what}"))
    replace_file(output, page)
    out.print(f"wrote {output}", markup=False)


def export(
    result: Annotated[Path, typer.Argument(help="HDF5 file with a recorded motion, a sweep, a search or a policy.")],
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            help="OpenSim's .mot (angles) or .sto (muscles), or .csv; of a policy .onnx or .pt; "
            "as tables .parquet, .zarr or .nc.",
        ),
    ],
    ground_forces: Annotated[
        Path | None,
        typer.Option(help="Another .mot, for the ground forces; OpenSim's .xml about them is put beside it."),
    ] = None,
    replay: Replay = 0,
    run: Run = None,
    candidates: Annotated[
        bool, typer.Option("--candidates", help="Write a row for each candidate of a search or sweep.")
    ] = False,
    trust: Trust = False,
) -> None:
    """Write a motion for OpenSim, a motion, sweep or search as a table, or a policy as ONNX or TorchScript.

    If the scene was made from an OpenSim model, a motion has that model's coordinates, and OpenSim plays it on that.
    A policy maps unnormalised observations to actions. The table of a sweep has a row for each run; in .zarr and .nc it
    has an axis for each axis of the sweep.
    """
    from warpmuscle.formats import sto
    from warpmuscle.optimization.best_scene import scene_in
    from warpmuscle.results.partial_motion import motion_of
    from warpmuscle.results.result import read
    from warpmuscle.results.table_files import is_table, write_table

    if output.suffix.lower() in (".onnx", ".pt"):
        if ground_forces is not None or replay or run is not None:
            raise Error(f"{output}: a policy has no motions, so that there are no options about them")
        _write_policy(result, output)
        return
    if is_table(result, output, run, candidates):
        if ground_forces is not None:
            raise Error(f"{output}: tables have no ground forces beside them; --ground-forces is of .mot files")
        write_table(result, output, run, replay, candidates)
        out.print(f"wrote {output}")
        return
    content = read(result, run, replay=replay)
    motion, scene = motion_of(content, str(result), replay), scene_in(content)
    written = [output]
    if ground_forces is not None:
        written += _write_loads(motion, scene, ground_forces)
    sto.write(motion, scene, output)
    out.print(f"wrote {', '.join(map(str, written))}")


def _write_policy(result: Path, output: Path) -> None:
    """Write the policy of a file."""
    from warpmuscle.learning.player import learned_in
    from warpmuscle.learning.portable import write_policy

    policy = learned_in(result).policy
    write_policy(policy, output)
    out.print(
        f"wrote {output}: {number_of(len(policy.observation), 'observation')}, "
        f"{number_of(len(policy.action), 'action')}",
        markup=False,
    )


def _write_loads(motion: Recording, scene: Scene, path: Path) -> list[Path]:
    """Write the ground forces of a motion; the files."""
    from warpmuscle.formats.external_loads import write_loads
    from warpmuscle.studies.ground_loads import ground_loads

    start_warp()
    return [path, write_loads(ground_loads(motion, scene), motion.time, path)]


def _renamed(given: int | None) -> None:
    """Error that says what an option of before is called now."""
    if given is not None:
        raise Error(f"--hardiest is called --most-robust now: write --most-robust {given}")
