import subprocess
import sys

from patience import PATIENCE
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
