"""What becomes of a search whose output nobody takes, or that a signal ends: its work is kept."""

import contextlib
import os
import pty
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from child_signals import PROGRAM, hear_signals, running
from patience import PATIENCE, until
from warpmuscle.cli.streams import _Steady
from warpmuscle.results.result import read

SHORT = [*PROGRAM, "optimize", "fwalk", "--candidates", "2", "--duration", "0.02", "-o", "out.h5"]
LONG = [*PROGRAM, "optimize", "fwalk", "--duration", "0.02", "--search", "random", "--until", "1h", "-o", "out.h5"]


def in_shell(script: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a script in which "$@" is a short search."""
    command = ["bash", "-c", f"set -o pipefail; {script}", "bash", *SHORT]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=PATIENCE, check=False)


@pytest.mark.parametrize(
    ("script", "code"),
    [
        pytest.param(
            '{ until [ -e gone ]; do sleep 0.02; done; "$@"; } 2>&1 | { exec <&-; touch gone; }', 141, id="reader gone"
        ),
        pytest.param('"$@" <&- >&- 2>&-', 0, id="all closed", marks=pytest.mark.long),
        pytest.param('"$@" 2>/dev/full', 0, id="no room for errors", marks=pytest.mark.long),
    ],
)
def test_a_search_whose_output_nobody_takes_comes_to_its_result(script, code, tmp_path):
    done = in_shell(script, tmp_path)
    assert (done.returncode, done.stderr) == (code, "")
    assert read(tmp_path / "out.h5").replays


def begun(folder: Path) -> bool:
    """Whether a search has evaluated something."""
    journal = folder / "out.h5.journal"
    return journal.exists() and journal.stat().st_size > 10_000


def test_a_hangup_keeps_what_was_found_and_says_so_in_a_file(tmp_path):
    """Shells repeat the hangup of their terminal; the second one must not end the writing of the result."""
    with (tmp_path / "log").open("w") as log, running(LONG, cwd=tmp_path, stdout=log, stderr=log) as process:
        until(lambda: begun(tmp_path), process)
        process.send_signal(signal.SIGHUP)
        process.send_signal(signal.SIGHUP)
        assert process.wait(timeout=PATIENCE) == 128 + signal.SIGHUP
    said = (tmp_path / "log").read_text()
    assert "ended by SIGHUP" in said
    assert "wrote out.h5" in said
    result = read(tmp_path / "out.h5")
    assert result.replays
    assert result.searched.ended == "interrupted"


@pytest.mark.long
def test_a_terminal_that_vanishes_does_not_take_the_work_with_it(tmp_path):
    pid, terminal = pty.fork()
    if pid == 0:
        hear_signals()
        os.chdir(tmp_path)
        os.execv(LONG[0], LONG)
    os.set_blocking(terminal, False)

    def read_on() -> bool:
        with contextlib.suppress(BlockingIOError):
            os.read(terminal, 65536)
        return begun(tmp_path)

    until(read_on)
    os.close(terminal)
    _, status = os.waitpid(pid, 0)
    assert os.waitstatus_to_exitcode(status) == 128 + signal.SIGHUP
    assert read(tmp_path / "out.h5").replays


def test_a_terminal_that_another_program_made_non_blocking_gets_all_of_it():
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    data = b"x" * 300_000
    child = subprocess.Popen(
        [sys.executable, "-c", "import sys, time; time.sleep(0.3); print(len(sys.stdin.buffer.read()))"],
        stdin=reader, stdout=subprocess.PIPE,
    )  # fmt: skip
    os.close(reader)
    stream, sent = _Steady(writer, "w"), 0
    while sent < len(data):
        sent += stream.write(data[sent:])
    stream.close()
    assert child.communicate(timeout=PATIENCE)[0].split() == [b"300000"]
