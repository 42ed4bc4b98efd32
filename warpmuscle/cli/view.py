"""The command that shows motions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import (
    Device,
    Duration,
    Policy,
    Settings,
    Trust,
    changed,
    load_scene,
    scene_names_like,
    start_warp,
    writable,
)
from warpmuscle.cli.console import INTERRUPTED, log, out
from warpmuscle.cli.results import Run
from warpmuscle.core.errors import Error

if TYPE_CHECKING:
    from warpmuscle.view.sources import Sight
    from warpmuscle.view.viewer import Viewer


def view(
    sources: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE...|SCENE...", help="HDF5 files, or a scene to run.", autocompletion=scene_names_like
        ),
    ],
    live: Annotated[
        bool, typer.Option("--live", help="Run the scene in real time, to push it and to change it.")
    ] = False,
    export: Annotated[Path | None, typer.Option(help="HTML file to write instead; it opens without a network.")] = None,
    candidates: Annotated[
        int | None,
        typer.Option(min=1, max=64, help="Run so many of the best candidates of a file again, side by side."),
    ] = None,
    replay: Annotated[int | None, typer.Option(min=0, help="Which motion of a file; by default all.")] = None,
    run: Run = None,
    policy: Policy = None,
    duration: Duration = None,
    settings: Settings = None,
    device: Device = None,
    host: Annotated[
        str, typer.Option(help="Address to listen at; 0.0.0.0 lets others watch who have the address with its token.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port to listen at, or the next free one.")] = 8080,
    no_open: Annotated[bool, typer.Option("--no-open", help="Open no browser, only print the address.")] = False,
    trust: Trust = False,
) -> None:
    """Show motions in the browser: of result files side by side, or of a scene that is run for it.

    Needs pip install "warpmuscle\\[view]", but for --export. Ctrl-C ends it. Examples: warpmuscle view walk56.h5;
    warpmuscle view walk56.h5 --candidates 8; warpmuscle view fwalk --live; warpmuscle view walk56
    --live --policy policy.h5; warpmuscle view walk56 --export walk.html
    """
    from warpmuscle.view.sources import is_result

    writable(export)
    files = [is_result(source) for source in sources]
    if any(files) and not all(files):
        raise Error("view takes either result files or one scene, not both")
    if live:
        _refuse(
            {"--export": export, "--candidates": candidates, "--replay": replay, "--run": run, "--duration": duration},
            "--live",
        )
        if any(files):
            raise Error(f"--live takes a scene; `warpmuscle apply {sources[0]} -o best.toml` makes one of a result")
        viewer = _live_viewer(sources, settings, device, host, port, policy)
    else:
        _refuse({"--policy": policy}, "what is not --live")
        sights = _sights(sources, all(files), candidates, replay, run, duration, settings, device)
        if export is not None:
            from warpmuscle.view.sources import page_of_sights

            page_of_sights(sights).save(export)
            out.print(f"wrote {export}")
            return
        viewer = _replay_viewer(sights, host, port)
    _serve(viewer, no_open)


def _refuse(given: dict[str, object], option: str) -> None:
    for name, value in given.items():
        if value is not None:
            raise Error(f"{option} takes no {name}")


def _sights(
    sources: list[str], are_files: bool, candidates: int | None, replay: int | None, run: str | None,
    duration: float | None, settings: list[str] | None, device: str | None,
) -> list[Sight]:  # fmt: skip
    """What is to be seen in files, or in a scene after it has been run."""
    from warpmuscle.view.sources import of_results, of_scene

    if are_files:
        _refuse({"--duration": duration, "--set": settings or None}, "a result file")
        if candidates is not None:
            start_warp()
        with log.status("reading" if candidates is None else "simulating"):
            return of_results(sources, replay, candidates, run, device)
    _refuse({"--candidates": candidates, "--replay": replay, "--run": run}, "a scene")
    scene = changed(load_scene(sources, settings=settings), duration, None, None)
    start_warp()
    with log.status("simulating"):
        return of_scene(scene, device)


def _live_viewer(
    sources: list[str], settings: list[str] | None, device: str | None, host: str, port: int, policy: Path | None
) -> Viewer:
    scene = load_scene(sources, settings=settings)
    start_warp()
    from warpmuscle.view.live import Live
    from warpmuscle.view.live_run import LiveRun

    with log.status("preparing"):
        if policy is None:
            run = LiveRun(scene, device or "cpu")
        else:
            from warpmuscle.learning.player import learned_in
            from warpmuscle.view.policy_run import PolicyRun

            run = PolicyRun(scene, learned_in(policy), device or "cpu")
        return Live(run, host=host, port=port)


def _replay_viewer(sights: list[Sight], host: str, port: int) -> Viewer:
    from warpmuscle.view.sources import page_of_sights
    from warpmuscle.view.viewer import replay_viewer

    return replay_viewer(page_of_sights(sights).text, host, port)


def _serve(viewer: Viewer, no_open: bool) -> None:
    """Show it until Ctrl-C."""
    import webbrowser

    viewer.start()
    out.print(f"{viewer.url}  (Ctrl-C ends it)")
    if not no_open:
        webbrowser.open(viewer.url)
    try:
        viewer.wait()
    except KeyboardInterrupt:
        raise typer.Exit(INTERRUPTED) from None
    finally:
        viewer.stop()
