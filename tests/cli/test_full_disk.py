"""Commands that write, where they cannot: a code that is not 0, one line, the older file as it was, nothing left."""

import ctypes
import errno
import os
import re
import resource
import subprocess
from pathlib import Path

import numpy as np
import pytest

from child_signals import PROGRAM
from environment import NO_BYTE_CODE
from patience import PATIENCE
from small_disk import disk_of
from small_result import search_result, walk_result
from synergy.synthetic_emg import raw_emg, write_csv
from warpmuscle.cli import program
from warpmuscle.optimization import best_scene
from warpmuscle.results.result import write

OLDER = b"what was there before"
ROOM = 64  # bytes that a file may have, fewer than any of these
SWEEP = 'scene = "fwalk"\n[set]\nduration = 0.02\n[search]\ncandidates = 2\n[grid]\nseed = [1]\n'
FILM = ("--size", "64x64", "--rate", "4")
COMMANDS = {
    "simulate": ("simulate", "fwalk", "--duration", "0.02", "-o", "out.h5"),
    "simulate --plot": ("simulate", "fwalk", "--duration", "0.02", "--plot", "out.png"),
    "optimize": ("optimize", "fwalk", "--candidates", "2", "--duration", "0.02", "-o", "out.h5"),
    "sweep": ("sweep", "sweep.toml", "-o", "out.h5"),
    "apply": ("apply", "best.h5", "-o", "out.toml"),
    "apply --on": ("apply", "best.h5", "--on", "walk56", "-o", "out.toml"),
    "report": ("report", "best.h5", "-o", "out.html"),
    "view": ("view", "walk.h5", "--export", "out.html"),
    "plot": ("plot", "walk.h5", "--what", "joints", "-o", "out.png"),
    "video .mp4": ("video", "walk.h5", *FILM, "-o", "out.mp4"),
    "video .gif": ("video", "walk.h5", *FILM, "-o", "out.gif"),
    "video .webp": ("video", "walk.h5", *FILM, "-o", "out.webp"),
    "export .mot": ("export", "walk.h5", "-o", "out.mot"),
    "export .sto": ("export", "walk.h5", "-o", "out.sto"),
    "export .csv": ("export", "walk.h5", "-o", "out.csv"),
    "convert .toml": ("convert", "fwalk", "-o", "out.toml"),
    "convert .rbs": ("convert", "fwalk", "-o", "out.rbs"),
    "convert .xml": ("convert", "fwalk", "-o", "out.xml"),
    "fit-muscles": ("fit-muscles", "elbow_simplified", "--duration", "0.5", "-o", "out.toml"),
    "fit-paths": ("fit-paths", "elbow_simplified", "--order", "2", "-o", "out.toml"),
    "scale": ("scale", "fwalk", "--height", "1.7", "-o", "out.toml"),
    "walking-task": ("walking-task", "gait2392", "-o", "out.toml"),
    "synergies": ("synergies", "extract", "emg.csv", "-n", "2", "--restarts", "1", "-o", "out.h5"),
    "synergies --plot": ("synergies", "extract", "emg.csv", "-n", "2", "--restarts", "1", "--plot", "out.png"),
}
# Compiling takes room on the disk, too.
COMPILING = ("simulate", "simulate --plot", "optimize", "sweep", "fit-muscles", "fit-paths", "report")


@pytest.fixture(scope="module")
def inputs(tmp_path_factory) -> Path:
    """A folder with what the commands read."""
    folder = tmp_path_factory.mktemp("inputs")
    write(folder / "best.h5", search_result())
    write(folder / "walk.h5", walk_result())
    write_csv(folder / "emg.csv", raw_emg(4.0, seed=0))
    (folder / "sweep.toml").write_text(SWEEP)
    return folder


@pytest.fixture
def run(inputs, monkeypatch, capsys):
    """Runs a command in this process; its inputs are in one folder, its output in another. Code and errors."""
    monkeypatch.chdir(inputs)
    monkeypatch.setenv("COLUMNS", "400")

    def call(command: tuple[str, ...], folder: Path, room: int | None = None) -> tuple[int, list[str]]:
        arguments = [str(folder / part) if part.startswith("out.") else part for part in command]
        monkeypatch.setattr("sys.argv", ["warpmuscle", *arguments])
        with pytest.raises(SystemExit) as left, disk_of(room or resource.RLIM_INFINITY):
            program.main()
        return int(left.value.code or 0), [line for line in capsys.readouterr().err.splitlines() if line.strip()]

    return call


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long if name == "report" else ()) for name in COMMANDS]
)
def test_full_disk_leaves_the_older_file_and_nothing_else(name, run, tmp_path):
    command = COMMANDS[name]
    if name in COMPILING:
        (tmp_path / "first").mkdir()
        assert run(command, tmp_path / "first")[0] == 0
        assert files(tmp_path)
    output = tmp_path / next(part for part in command if part.startswith("out."))
    older = (tmp_path / "first" / output.name).read_bytes() if name == "sweep" else OLDER  # else it is not replaced
    for ending in (".rbs", ".sbc", ".rs") if output.suffix == ".rbs" else (output.suffix,):
        output.with_suffix(ending).write_bytes(older)
    before = files(tmp_path)
    code, lines = run(command, tmp_path, ROOM)
    assert code != 0
    assert len(lines) == 1, lines
    assert lines[0].startswith(f"error: {tmp_path}/out.")
    assert "cannot be written: file too large" in lines[0]
    assert files(tmp_path) == before
    assert not list(tmp_path.glob("*.sweep"))


@pytest.mark.parametrize("name", [*COMMANDS, "throw"])
def test_folder_that_only_can_be_read_is_one_line(name, run, read_only):
    code, lines = run({**COMMANDS, "throw": ("throw", "goal", "--angle", "40", "-o", "out.h5")}[name], read_only)
    assert code != 0
    assert len(lines) == 1, lines
    assert lines[0].startswith(f"error: {read_only}/out.")
    assert "cannot be written: " in lines[0]
    assert ("read-only file system" in lines[0]) or ("permission denied" in lines[0])


@pytest.fixture(scope="module")
def read_only(tmp_path_factory):
    """A folder that only can be read, also by root."""
    folder = tmp_path_factory.mktemp("read_only")
    if os.geteuid() != 0:
        folder.chmod(0o555)
        yield folder
        folder.chmod(0o755)
        return
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mount(b"none", os.fsencode(folder), b"tmpfs", 1, None) != 0:  # MS_RDONLY
        pytest.skip(f"root may write anywhere, and mount nothing here: {errno.errorcode[ctypes.get_errno()]}")
    yield folder
    libc.umount(os.fsencode(folder))


@pytest.mark.parametrize("name", ["video .mp4", "convert .rbs", "export .csv"])
def test_full_file_system_is_named_as_the_cause(name, run, tmp_path):
    """Files that shared what is left would otherwise each be written in part."""
    libc = ctypes.CDLL(None, use_errno=True)
    if os.geteuid() != 0 or libc.mount(b"none", os.fsencode(tmp_path), b"tmpfs", 0, b"size=64k") != 0:
        pytest.skip("mounts need root")
    try:
        command = COMMANDS[name]
        output = tmp_path / next(part for part in command if part.startswith("out."))
        output.write_bytes(OLDER)
        (tmp_path / "other").write_bytes(bytes(56 * 1024))
        code, lines = run(command, tmp_path)
        assert code != 0
        assert len(lines) == 1, lines
        assert "cannot be written: no space left on device" in lines[0]
        assert output.read_bytes() == OLDER
        assert set(files(tmp_path)) == {output.name, "other"}
    finally:
        libc.umount(os.fsencode(tmp_path))


def limited(*arguments, cwd, shell="", **environment):
    """A command in a process of its own, after shell commands such as `ulimit`; its code and errors.

    What it says meanwhile, where kernels are to be compiled first, is no error.
    """
    script = f'{shell}\nexec "$@"'
    command = ["sh", "-c", script, "sh", *PROGRAM, *map(str, arguments)]
    done = subprocess.run(
        command,
        cwd=cwd,
        env=os.environ | environment | {NO_BYTE_CODE: "1"},  # Python would leave it cut off, for others to read
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    return done.returncode, [line for line in lines if not re.search(r"^(simulating|compiling )|, \d+ s$", line)]


@pytest.mark.parametrize(
    ("shell", "environment", "said"),
    [
        ("ulimit -v 400000", {}, "failed to map segment"),
        ("ulimit -n 5", {}, "too many open files"),
        ("exec > /dev/full", {}, "the standard output cannot be written: no space left on device"),
        ("", {"WARP_CACHE_PATH": "/proc/nowhere"}, "/proc/nowhere"),
        (
            "touch kernels",
            {"WARP_CACHE_PATH": "HERE/kernels"},
            "what should be its folder is a file; set WARP_CACHE_PATH",
        ),
        ("ulimit -f 8", {"WARP_CACHE_PATH": "HERE/cache"}, "compiled kernels cannot be written: file too large"),
    ],
    ids=["memory", "open files", "standard output", "no cache", "cache is a file", "full cache"],
)
def test_what_the_system_refuses_is_one_line(shell, environment, said, tmp_path):
    environment = {name: value.replace("HERE", str(tmp_path)) for name, value in environment.items()}
    code, lines = limited("simulate", "fwalk", "--duration", "0.02", cwd=tmp_path, shell=shell, **environment)
    assert code == 2
    assert len(lines) == 1, lines
    assert lines[0].startswith("error: ")
    assert said.lower() in lines[0].lower()


def test_devices_and_pipes_are_not_replaced_by_files(run, tmp_path):
    pipe = tmp_path / "out.csv"
    os.mkfifo(pipe)
    code, lines = run(COMMANDS["export .csv"], tmp_path)
    assert (code, len(lines)) == (2, 1)
    assert "this is a pipe or a device" in lines[0]
    assert pipe.is_fifo()


def test_what_ffmpeg_left_unfinished_is_no_film(tmp_path):
    from warpmuscle.video.files import _is_complete

    box = b"\x00\x00\x00\x10mdat" + bytes(8)
    index = b"\x00\x00\x00\x08moov"
    film = tmp_path / "a.mp4"
    for content, whole in (
        (box + index, True),
        (box, False),
        (index + box[:-1], False),
        (b"", False),
        (bytes(16), False),
    ):
        film.write_bytes(content)
        assert _is_complete(film) == whole


def test_no_room_for_memory_is_one_line(run, inputs, tmp_path, monkeypatch):
    monkeypatch.setattr(best_scene, "best_scene", lambda *_: np.zeros(2**58))
    code, lines = run(COMMANDS["apply"], tmp_path)
    assert (code, len(lines)) == (2, 1)
    assert "there is not enough memory: unable to allocate" in lines[0].lower()
