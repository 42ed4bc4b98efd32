"""The command that runs a scene once."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import (
    Commands,
    Device,
    Duration,
    LimitStiffness,
    Policy,
    Quantities,
    ResultFile,
    Settings,
    Single,
    Sources,
    TimeStep,
    Trust,
    changed,
    command_line,
    load_scene,
    quantities_in,
    start_warp,
    writable,
)
from warpmuscle.cli.console import GaitPrinter, log, out, print_gait, print_warnings, suggest
from warpmuscle.cli.walkers import commanded_in_words, shared_out
from warpmuscle.simulation.cuda_warmup import start_driver

if TYPE_CHECKING:
    from warpmuscle.core.status import Status
    from warpmuscle.results.recording import Recording
    from warpmuscle.scene import Scene
    from warpmuscle.scene.parameters import Parameter


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
    limit_stiffness: LimitStiffness = 0.0,
    settings: Settings = None,
    commands: Commands = None,
    device: Device = None,
    trust: Trust = False,
    output: ResultFile = None,
    plot: Annotated[Path | None, typer.Option(help="Stick figures to draw, .png, .svg or .pdf.")] = None,
    rate: Annotated[float, typer.Option(min=1.0, help="Recorded frames per second.")] = 100.0,
    policy: Policy = None,
    quantities: Quantities = None,
    single: Single = False,
) -> None:
    """Run a scene once, and print how it walks.

    Examples: warpmuscle simulate fwalk --plot walk.png -o walk.h5; warpmuscle simulate bipV2.rbs fWalk.sbc
    --duration 60; warpmuscle simulate walk56 --policy policy.h5 --command speed=1.3
    """
    writable(output, plot)
    start_driver(device)
    of_scene = commands if policy is None else None  # else some are the policy's
    scene = load_scene(sources, settings=settings, commands=of_scene, limit_stiffness=limit_stiffness)
    scene = changed(scene, duration, time_step, implicit_pd)
    if legacy:
        scene = _as_legacy(scene)
    start_warp()
    from warpmuscle.scene.muscles import law_of
    from warpmuscle.simulation.devices import find_devices

    where = str(find_devices(device)[0])
    if policy is None:
        recording, parameters, fell = _run(scene, where, rate)
        if fell and law_of(scene.muscle_model) != "legacy" and _of_original(sources) and scene.character.muscles:
            log.print("note: the muscles of these files were tuned for the original program; --legacy computes them so")
    else:
        scene, recording, parameters = _act(scene, policy, commands or [], where, rate)
    gait = print_gait(scene, recording)
    if output is not None:
        from warpmuscle.formats import toml
        from warpmuscle.results.records import Result, parameter_table
        from warpmuscle.results.result import write

        table = parameter_table(parameters)
        result = Result(toml.dumps(scene), where, command_line(), 0, table, replays=(recording,))
        write(output, result, quantities=quantities_in(quantities), single=single)
        out.print(f"wrote {output}")
        suggest(f"`warpmuscle view {output}` shows it")
    if plot is not None:
        from warpmuscle.plots.stick_figures import stick_figures

        stick_figures(recording, scene, plot, gait)
        out.print(f"wrote {plot}")


def _act(
    scene: Scene, policy: Path, commands: list[str], device: str, rate: float
) -> tuple[Scene, Recording, list[Parameter]]:
    """A scene as commanded, its motion by a policy, after it has been printed how it went, and its free parameters.

    Commands of the policy go to it; others are those of the scene, such as a slope that the policy must feel.
    """
    from warpmuscle.learning.player import beyond, commanded, commands_in_words, lasting, learned_in, replay, task_of
    from warpmuscle.scene.parameters import free_parameters

    learned = learned_in(policy)
    task = task_of(learned)
    scene, to_policy = shared_out(scene, task, commands)
    print_warnings(beyond(task, to_policy))
    task = lasting(commanded(task, to_policy))
    with log.status("simulating; the first run compiles for some seconds"):
        recording, status = replay(learned.policy, scene, device, task, rate=rate)
    out.print(
        f"{scene.name}: {_ended(status, recording, scene)}; {recording.end:.4g} s moved by the policy of {policy}",
        markup=False,
    )
    own = commanded_in_words(scene, [text for text in commands if text not in to_policy])
    if said := ", ".join(filter(None, [commands_in_words(task), *own])):
        out.print(f"commanded: {said}", markup=False)
    return scene, recording, free_parameters(scene)


def _of_original(sources: list[str]) -> bool:
    """Whether a scene was read from the original program's files."""
    return any(Path(source).suffix.lower() == ".rbs" for source in sources)


def _run(scene: Scene, device: str, rate: float) -> tuple[Recording, list[Parameter], bool]:
    """The motion of a scene, after it has been printed how it went, its free parameters, and whether it fell."""
    from warpmuscle.core.status import Status
    from warpmuscle.simulation.rollout import Rollout

    with log.status("simulating"):
        rollout = Rollout(scene, 1, device, record=[0], record_rate=rate)
        printer = GaitPrinter(scene)
        if rollout.compiles:
            printer.begin()
        rollout.load()
        begin = time.perf_counter()
        rollout.run()
        printer.end()
    status = Status(rollout.status()[0])
    recording = rollout.recording()
    ended = _ended(status, recording, scene, rollout.causes()[0])
    out.print(
        f"{scene.name}: {ended}; {rollout.end_time()[0]:.4g} s simulated in "
        f"{time.perf_counter() - begin:.2f} s on {rollout.device}, cost {rollout.cost()[0]:.6g}"
    )
    return recording, rollout.parameters, status == Status.FELL


def _ended(status: Status, recording: Recording, scene: Scene, cause: str = "") -> str:
    """How a simulation ended, in words; of bodies that ran into each other, which ones; and the scene's part if any."""
    from warpmuscle.core.status import Status
    from warpmuscle.gait.penetration import nearest_pair
    from warpmuscle.scene.parameters import at_start

    words = f"{status.meaning}: {cause}" if cause else str(status.meaning)
    if status != Status.COLLIDED:
        return words
    pair = nearest_pair(recording, at_start(scene)) if recording.frames else None
    return f"{words} ({' and '.join(pair)})" if pair else words


def _as_legacy(scene: Scene) -> Scene:
    """The scene with the original program's muscle law in place of its own."""
    import msgspec

    from warpmuscle.scene import MuscleModel

    own = scene.muscle_model
    legacy = MuscleModel(legacy=True, negative=own.negative, specific_tension=own.specific_tension)
    return msgspec.structs.replace(scene, muscle_model=legacy)
