"""The command that shows motions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
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
    doubts_printed,
    load_scene,
    scene_names_like,
    start_warp,
    writable,
)
from warpmuscle.cli.console import log, out
from warpmuscle.cli.results import Run
from warpmuscle.core.errors import Error
from warpmuscle.core.interruption import INTERRUPTED

if TYPE_CHECKING:
    from warpmuscle.scene import Scene
    from warpmuscle.view.page import Page
    from warpmuscle.view.server import PageServer
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
        typer.Option(min=1, max=64, help="Run this many of the best candidates of a file again, side by side."),
    ] = None,
    replay: Annotated[int | None, typer.Option(min=0, help="Which motion of a file; by default all.")] = None,
    over: Annotated[bool, typer.Option("--over", help="Motions over one another, rather than side by side.")] = False,
    meshes: Annotated[
        Path | None,
        typer.Option(
            help="Folder with the .vtp, .stl or .obj files that a model is drawn with; by default the model's."
        ),
    ] = None,
    run: Run = None,
    policy: Policy = None,
    duration: Duration = None,
    settings: Settings = None,
    device: Device = None,
    host: Annotated[
        str, typer.Option(help="Address to listen at; 0.0.0.0 lets other machines watch that have the whole address.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port to listen at, or the next free one.")] = 8080,
    no_open: Annotated[bool, typer.Option("--no-open", help="Open no browser, only print the address.")] = False,
    trust: Trust = False,
) -> None:
    """Show motions in the browser: of result files side by side, or of a scene that it runs.

    Needs pip install "warpmuscle\\[view]", except with --export. Ctrl-C ends it. Examples: warpmuscle view walk56.h5;
    warpmuscle view walk56.h5 --candidates 8; warpmuscle view fwalk --live; warpmuscle view walk56
    --live --policy policy.h5; warpmuscle view walk56 --export walk.html
    """
    from warpmuscle.view.sources import is_result

    writable(export)
    files = [is_result(source) for source in sources]
    if any(files) and not all(files):
        raise Error("view takes either result files or one scene, not both")
    of_files: dict[str, object] = {"--candidates": candidates, "--replay": replay, "--run": run, "--over": over or None}
    if live:
        _refuse(of_files | {"--export": export, "--duration": duration, "--meshes": meshes}, "--live")
        if any(files):
            raise Error(f"--live takes a scene; `warpmuscle apply {sources[0]} -o best.toml` makes one of a result")
        scene = load_scene(sources, settings=settings)
        with _at_once(scene, host, port, no_open) as server:
            _serve(_live_viewer(scene, device, policy, server))
        return
    _refuse({"--policy": policy}, "what is not --live")
    if all(files):
        _refuse({"--duration": duration, "--set": settings or None}, "a result file")
        sights = _sights_in(sources, candidates, replay, run, device)
    else:
        _refuse(of_files, "a scene")
        scene = changed(load_scene(sources, settings=settings), duration, None, None)
        if export is None:
            with _at_once(scene, host, port, no_open) as server:
                _serve(_replay_viewer(_sights_of(scene, device), server, meshes, _folder_of(sources)))
            return
        sights = _sights_of(scene, device)
    from warpmuscle.view.sources import page_of_sights

    with doubts_printed():
        page = page_of_sights(sights, meshes=meshes, beside=_folder_of(sources), over=over)
    if export is not None:
        _save(page, export)
        return
    from warpmuscle.view.viewer import replay_viewer

    viewer = replay_viewer(page.text, host, port)
    _open(viewer.server, no_open)
    _serve(viewer)


def _save(page: Page, path: Path) -> None:
    page.save(path)
    size = len(page.text.encode()) / 1e6
    out.print(f"wrote {path}" + (f" ({size:.1f} MB: fewer motions or seconds make it smaller)" if size > 1.0 else ""))


def _refuse(given: dict[str, object], option: str) -> None:
    for name, value in given.items():
        if value is not None:
            raise Error(f"{option} takes no {name}")


def _sights_in(
    files: list[str], candidates: int | None, replay: int | None, run: str | None, device: str | None
) -> list[Sight]:
    """What is to be seen in files."""
    from warpmuscle.view.sources import of_results

    if candidates is not None:
        start_warp()
    with log.status("reading" if candidates is None else "simulating"):
        return of_results(files, replay, candidates, run, device)


def _sights_of(scene: Scene, device: str | None) -> list[Sight]:
    """What is to be seen of a scene, which is run."""
    from warpmuscle.view.sources import of_scene

    start_warp()
    with log.status("simulating"):
        return of_scene(scene, device)


@contextmanager
def _at_once(scene: Scene, host: str, port: int, no_open: bool) -> Iterator[PageServer]:
    """A server whose page is open while its motion is made ready, and that learns what goes wrong."""
    from warpmuscle.simulation.kernel_cache import tell_of_compiling
    from warpmuscle.view.waiting import Waiting

    waiting = Waiting(scene, host, port)

    def compiling(what: str) -> Callable[[], None]:
        waiting.say(f"compiling {what}, once (usually 5 to 20 s)")
        return lambda: waiting.say("simulating")

    tell_of_compiling(compiling)
    _open(waiting.server, no_open)
    try:
        yield waiting.server
    except KeyboardInterrupt:
        raise typer.Exit(INTERRUPTED) from None
    except Exception as failure:
        waiting.fail(f"There is nothing to show: {failure}")
        raise
    finally:
        waiting.server.stop()


def _live_viewer(scene: Scene, device: str | None, policy: Path | None, server: PageServer) -> Viewer:
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
        return Live(run, server=server)


def _folder_of(sources: list[str]) -> Path | None:
    """The folder of a scene's file, where meshes may be; None of a scene by name."""
    path = Path(sources[0])
    return path.absolute().parent if len(sources) == 1 and path.suffix and path.is_file() else None


def _replay_viewer(sights: list[Sight], server: PageServer, meshes: Path | None, beside: Path | None) -> Viewer:
    from warpmuscle.view.sources import page_of_sights
    from warpmuscle.view.viewer import replay_viewer

    with doubts_printed():
        page = page_of_sights(sights, meshes=meshes, beside=beside)
    return replay_viewer(page.text, server=server)


def _open(server: PageServer, no_open: bool) -> None:
    """Tell its address, and open it in the browser."""
    import webbrowser

    out.print(f"{server.url}  (Ctrl-C ends it)")
    if not no_open:
        webbrowser.open(server.url_once)


def open_page(path: Path) -> bool:
    """Open a file in the browser where somebody sits before a screen; whether it does."""
    import os
    import sys
    import webbrowser

    own_screen = sys.platform in ("win32", "darwin") or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))
    if not own_screen or os.environ.get("SSH_CONNECTION"):
        return False
    return webbrowser.open(path.absolute().as_uri())


def _serve(viewer: Viewer) -> None:
    """Show it until Ctrl-C."""
    viewer.start()
    try:
        viewer.wait()
    except KeyboardInterrupt:
        raise typer.Exit(INTERRUPTED) from None
    finally:
        viewer.stop()
