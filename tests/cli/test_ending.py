import subprocess
import sys

import pytest

from patience import PATIENCE
from warpmuscle.cli.ending import run_to_end
from warpmuscle.cli.program import app, asked_for
from warpmuscle.core.interruption import INTERRUPTED

BROKEN_LOCK = """
from warpmuscle.cli.ending import run_to_end

def work():
    try:
        raise {raised}
    finally:
        raise RuntimeError("release unlocked lock")

run_to_end(work)
"""


def ended(raised: str) -> subprocess.CompletedProcess[str]:
    code = BROKEN_LOCK.format(raised=raised)
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE)


def test_what_an_interruption_has_broken_ends_as_interrupted():
    done = ended("KeyboardInterrupt")
    assert done.returncode == INTERRUPTED
    assert done.stderr == "interrupted\n"


def test_an_error_that_nobody_expected_shows_where_it_came_from():
    done = ended("ValueError")
    assert done.returncode == 1
    assert "RuntimeError: release unlocked lock" in done.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["inverse", "a.osim", "b.mot", "--power", "5"], "'--power': Input should be less than or equal to 4"),
        (["inverse", "a.osim", "b.mot", "--power", "two"], "'--power': Input should be a valid integer"),
        (["inverse", "a.osim"], "missing argument 'MOTION...'"),
        (["inverse", "a.osim", "b.mot", "--power"], "option '--power' requires an argument"),
        (["plot", "a.h5", "--replay", "-1"], "'--replay': Input should be greater than or equal to 0"),
        (["inverse", "--n\x1b[31mo"], "no such option: --n\\x1b[31mo"),
        (["nothing"], "no such command 'nothing'"),
    ],
)
def test_wrong_words_of_a_command_are_one_line(words, said, monkeypatch, capfd):
    monkeypatch.setattr(sys, "argv", ["warpmuscle", *words])
    with pytest.raises(SystemExit) as ended:
        run_to_end(lambda: asked_for(app)(prog_name="warpmuscle", standalone_mode=False))
    told = capfd.readouterr().err
    assert ended.value.code == 2
    assert told.startswith("error: ")
    assert told.count("\n") == 1
    assert said in told


ENDS = """
import atexit, sys, threading
from warpmuscle.cli.ending import end_process
{before}
gate = threading.Event()
atexit.register(lambda: print("registered"))
print("last", end="")
threading.Thread(target=lambda: (gate.wait(0.05), print("thread"))).start()
try:
    end_process(SystemExit({code}))
finally:
    print("Python's own end")
"""


def process(code: int, before: str = "") -> subprocess.CompletedProcess[str]:
    text = ENDS.format(code=code, before=before)
    return subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=PATIENCE)


def test_a_process_ends_with_its_threads_and_what_is_registered_and_at_once_after_that():
    done = process(3)
    assert (done.returncode, done.stderr) == (3, "")
    assert done.stdout == "lastthread\nregistered\n"


def test_a_process_that_is_traced_is_left_to_python():
    done = process(3, "sys.settrace(lambda *_: None)")
    assert (done.returncode, done.stderr) == (3, "")
    assert done.stdout.startswith("last")
    assert {"thread", "registered"} < set(done.stdout.replace("last", "last\n").splitlines())
    assert "Python's own end" in done.stdout
