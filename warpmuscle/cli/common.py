"""What several commands share: their options, and the scene that these make."""

from __future__ import annotations

import contextlib
import re
import shlex
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, Annotated, Any

import typer

from warpmuscle.cli.console import log, print_ignored, print_warnings, tell_of_compiling
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import readable

if TYPE_CHECKING:
    from warpmuscle.scene import Scene


def scene_names_like(incomplete: str) -> list[str]:
    """Shipped scenes whose names begin so, for completion; where none does, shells go on with files."""
    from warpmuscle.core.shipped import shipped_scenes

    return list(shipped_scenes(incomplete))


Sources = Annotated[
    list[str],
    typer.Argument(
        metavar="SCENE...",
        help="Scene name, TOML file, .rbs .sbc [.rs], .osim, .xml, .urdf, .hfd, or .scone [.par].",
        autocompletion=scene_names_like,
    ),
]
SceneFile = Annotated[Path, typer.Option("--output", "-o", help="TOML file to write.")]
ResultFile = Annotated[Path | None, typer.Option("--output", "-o", help="HDF5 file to write.")]
Figure = Annotated[Path | None, typer.Option(help="Figure to draw, .png, .svg or .pdf.")]
JsonFile = Annotated[Path | None, typer.Option("--json", help="File for all numbers.")]
Device = Annotated[
    str | None, typer.Option(help="cpu, cuda:0, cuda:all, cuda:0,cuda:2, ...; by default a GPU if there is one.")
]
LimitStiffness = Annotated[
    float,
    typer.Option("--limit-stiffness", min=0.0, help="Stiffness of .osim ranges that no force holds, N m/rad or N/m."),
]
Threads = Annotated[int | None, typer.Option(min=1, help="CPU threads, no effect on GPUs; by default one per core.")]
Population = Annotated[
    int | None, typer.Option(min=1, help="Candidates in each generation of a search; by default the strategy's own.")
]
Duration = Annotated[float | None, typer.Option(help="Simulated time, s; by default the scene's.")]
TimeStep = Annotated[float | None, typer.Option(help="Time step, s; by default the scene's.")]

Policy = Annotated[
    Path | None, typer.Option(help="HDF5 file of `warpmuscle learn`, whose policy moves the scene; needs no PyTorch.")
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a value in a scene: objective.target_speed=1.25, or 'character.muscles.?SOL.f_max={factor=0.5}'.",
    ),
]
FreeNumbers = Annotated[
    list[str] | None,
    typer.Option(
        "--free",
        metavar="PATTERN=INTERVAL",
        help="More numbers to search for: 'character.muscles.?SOL.* = 20 %', around their values, or '= [0.5, 2]'.",
    ),
]
Commands = Annotated[
    list[str] | None,
    typer.Option(
        "--command", "-c", metavar="NAME=VALUE", help="Command to the scene or to the policy: speed=1.5, slope=3."
    ),
]
Quantities = Annotated[
    str | None,
    typer.Option(
        metavar="NAME,...", callback=lambda given: _quantities(given),
        help="Keep only these quantities of the motions, such as com,muscle_force, and the time.",
    ),
]  # fmt: skip
Single = Annotated[bool, typer.Option("--single", help="Keep motions in single precision, which takes half the space.")]
BoardFolder = Annotated[
    Path | None,
    typer.Option(
        "--tensorboard", metavar="FOLDER", help="Also write the progress into this folder, as files of TensorBoard."
    ),
]
Trust = Annotated[
    bool,
    typer.Option(
        "--trust", callback=lambda given: _trust(given), help="Run code that the scene names, as module:function."
    ),
]


def start_warp() -> None:
    """Start Warp; commands call it where they begin to need it, since to import it takes a while."""
    if log.working is not None:
        _start()
        return
    with log.status("starting Warp"):
        _start()


def _start() -> None:
    from warpmuscle.core.warp_start import start_warp as start
    from warpmuscle.kernels.known_kernels import remember
    from warpmuscle.simulation.kernel_cache import tell_of_compiling as tell

    start()
    tell(tell_of_compiling)
    if _files_alone.is_set():
        remember()


_files_alone = Event()  # whether no other code has run in this process: files say what kernels are


def begin_process() -> None:
    """Say that this process has begun with the command line."""
    _files_alone.set()


def _trust(given: bool) -> bool:
    """Let code run that scenes name, if the user says so."""
    if given:
        _files_alone.clear()
        from warpmuscle.scene.trusted_code import trust_everything

        trust_everything()
    return given


def load_scene(
    sources: list[str],
    keyword_rule: bool = False,
    settings: list[str] | None = None,
    ball_joints: bool = False,
    hard_points: bool = False,
    commands: list[str] | None = None,
    merge_welds: bool = False,
    limit_stiffness: float = 0.0,
) -> Scene:
    """The scene with what `--set` and `--command` change; what its files hold that is not used, on the error stream."""
    from warpmuscle.formats import Ignored, load
    from warpmuscle.scene.validation.muscles import SceneWarning
    from warpmuscle.scene.validation.start import doubts_of

    ignored: list[Ignored] = []
    with doubts_printed():
        with warnings.catch_warnings():
            if settings:  # then only what they leave of the scene is in doubt
                warnings.simplefilter("ignore", SceneWarning)
            scene = load(
                *sources, ignored=ignored, keyword_rule=keyword_rule, ball_joints=ball_joints, hard_points=hard_points,
                merge_welds=merge_welds, limit_stiffness=limit_stiffness,
            )  # fmt: skip
        if settings:
            scene = with_settings(scene, settings)
            for doubt in doubts_of(scene):
                warnings.warn(str(doubt), SceneWarning, stacklevel=2)
    print_ignored(ignored, "notes on what was read:")
    return with_commands(scene, commands) if commands else scene


def with_commands(scene: Scene, commands: list[str]) -> Scene:
    """The scene as commanded, each command given as NAME=VALUE in the unit that the scene gives it."""
    import msgspec

    from warpmuscle.scene.validation.checks import near

    asked = dict(scene.commands)
    for text in commands:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not name or not equals:
            raise Error(f"--command {text!r}: write NAME=VALUE, such as speed=1.5")
        if name not in asked:
            known = near(name, asked) or (f"; it takes {', '.join(asked)}" if asked else ", nor any other")
            raise Error(f"--command {text!r}: {scene.name} takes no command {name!r}{known}")
        one = asked[name]
        try:
            number = float(value)
        except ValueError:
            raise Error(f"--command {text!r}: {value!r} is not a number") from None
        if not one.min <= number <= one.max:
            raise Error(f"--command {text!r}: {name} is {one.min:g} to {one.max:g} {one.unit}".rstrip())
        asked[name] = msgspec.structs.replace(one, value=number, over=[])
    return msgspec.structs.replace(scene, commands=asked)


def with_settings(scene: Scene, settings: list[str]) -> Scene:
    """The scene with values in place of its own, each given as KEY=VALUE, the value in TOML or as plain text."""
    from warpmuscle.formats.overrides import Override, overridden

    return overridden(scene, [Override(key, value) for key, value in settings_in(settings)])


def settings_in(settings: list[str]) -> list[tuple[str, Any]]:
    """Keys and values of settings that are given as KEY=VALUE, the value in TOML or as plain text."""
    import tomllib

    found: list[tuple[str, Any]] = []
    for text in settings:
        key, equals, value = text.partition("=")
        if not key.strip() or not equals:
            raise Error(f"--set {text!r}: write KEY=VALUE, such as objective.target_speed=1.25")
        try:
            found.append((key.strip(), tomllib.loads(f"value = {value}")["value"]))
        except tomllib.TOMLDecodeError:
            found.append((key.strip(), value.strip()))
        except RecursionError:
            raise Error(f"--set {key.strip()}: its value is nested too deeply") from None
    return found


def with_free(scene: Scene, free: list[str]) -> Scene:
    """The scene with more numbers free, each given as PATTERN = 20 % or PATTERN = [min, max]; see `free_numbers`."""
    from warpmuscle.core.errors import SceneError
    from warpmuscle.sweep.free_numbers import read_interval, with_free_numbers

    try:
        scene, notes = with_free_numbers(scene, [read_interval(text) for text in free])
    except SceneError as error:
        raise Error(f"--free: {error}") from None
    for note in notes:
        log.print(f"note: {note}", markup=False)
    return scene


@contextlib.contextmanager
def doubts_printed() -> Iterator[None]:
    """Print on the error stream, after the work within, what is probably a mistake in scenes."""
    from warpmuscle.scene.validation.muscles import SceneWarning

    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always", SceneWarning)
        yield
    print_warnings(doubt.message for doubt in doubts)


@contextlib.contextmanager
def search_notes_printed() -> Iterator[None]:
    """Print on the error stream, at once, what a search has to say of itself, such as parameters that it leaves."""
    from warpmuscle.core.errors import ResumeWarning, UnusedParameterWarning, UserPartWarning

    with warnings.catch_warnings():
        for kind in (ResumeWarning, UnusedParameterWarning, UserPartWarning):
            warnings.simplefilter("always", kind)
        warnings.showwarning = lambda message, *_: log.print(f"note: {message}")
        yield


def changed(scene: Scene, duration: float | None, time_step: float | None, implicit_pd: bool | None) -> Scene:
    """The scene with what the command line overrides."""
    import msgspec

    from warpmuscle.scene.validation.scene import check_scene

    changes = {"duration": duration, "time_step": time_step, "implicit_pd": implicit_pd}
    scene = msgspec.structs.replace(scene, **{name: value for name, value in changes.items() if value is not None})
    check_scene(scene)
    return scene


def writable(*paths: Path | None) -> None:
    """Raise an error now rather than after the work if a file cannot be written, or lacks the package that draws it."""
    from warpmuscle.core.extras import need_for
    from warpmuscle.core.files import check_writable

    for path in paths:
        if path is not None:
            need_for(path.suffix)
            check_writable(path)


def writable_folder(path: Path | None, option: str) -> None:
    """The same of a folder that an option names: it is there, or can be made where it is to be."""
    if path is None or path.is_dir():
        return
    if path.exists():
        raise Error(f"{option}: {path} is not a folder")
    if not path.absolute().parent.is_dir():
        raise Error(f"{option}: {path} cannot be made: {path.parent} is not a folder; make that first")
    writable(path)


def writable_beside(sources: list[str], *paths: Path) -> None:
    """The same of files that a scene is written to, none of which may be one that it is read from."""
    for path in paths:
        if any(Path(source).exists() and path.exists() and path.samefile(source) for source in sources):
            raise Error(f"{path} is the input, which would be lost; name another output file")
    writable(*paths)


def command_line() -> str:
    """The command as it was typed, quoted so that a shell takes it again."""
    return shlex.join(["warpmuscle", *map(readable, sys.argv[1:])])


def seconds(text: str) -> float:
    """A time such as 90, 90s, 30m or 1h30m, in seconds; raises Error."""
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


def refuse_besides(context: typer.Context, allowed: set[str]) -> None:
    """Raise Error for an argument or option besides --resume that its file already says."""
    given = {name for name in context.params if _is_given(context, name)}
    words = {parameter.name: max(parameter.opts, key=len) for parameter in context.command.params}
    for name in sorted(given - allowed):
        word = "a scene" if name == "sources" else words[name]
        raise Error(f"{word} cannot be given with --resume: the file already has it")


def _is_given(context: typer.Context, name: str) -> bool:
    """Whether an argument or option stands on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE" and context.params[name] not in (None, [], ())


def _quantities(given: str | None) -> str | None:
    """The names of quantities that are to be kept, after they have been checked, before any work."""
    if given is not None:
        from warpmuscle.core.errors import ArgumentError
        from warpmuscle.results.partial_motion import checked_quantities

        try:
            checked_quantities(quantities_in(given))
        except ArgumentError as error:
            raise ArgumentError(f"--{error}") from None
    return given


def quantities_in(given: str | None) -> list[str] | None:
    """The names in `com,muscle_force`; None if all quantities are kept."""
    return None if given is None else [name.strip() for name in given.split(",") if name.strip()]


@contextlib.contextmanager
def board_too(tell: Callable[[Any], None], folder: Path | None) -> Iterator[Callable[[Any], None]]:
    """What is to be told of progress: a bar, and within a folder TensorBoard's files, if one is named."""
    if folder is None:
        yield tell
        return
    from warpmuscle.report.scalar_log import TensorBoard

    with TensorBoard(folder) as board:

        def both(progress: Any) -> None:
            tell(progress)
            board(progress)

        yield both
