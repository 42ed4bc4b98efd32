"""The documentation's recipe for a term of the objective, followed in a copy of the package, changes the cost."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import warpmuscle

FUNCTIONS = '''
@wp.func
def altitude(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Height of the centre of mass, m."""
    return work.center[0][1]


@wp.func
def kept_altitude(
    instance: int, model: ModelRef, state: StateRef, work: ScratchRef, memory: wp.array[float]
) -> float:
    """Height of the root, m, by way of a memory, and negative: what is earned counts the other way."""
    memory[0] = work.position[0][1]
    return -memory[0]


def _functions('''
TERMS = """_TERMS = (
    Term("altitude", "m s", "height of the centre of mass, over time", "instance"),
    Term("kept_altitude", "m s", "the same, kept", "instance", memory=1, stage="accelerations", sign="earned"),
"""
CASES = "nothing", "function", "term", "its scope"
PROGRAM = """
import warp as wp
wp.config.optimization_level, wp.config.use_precompiled_headers = 0, False  # for a single kernel
import warpmuscle as wm
scene = wm.load("fwalk")
scene.duration, scene.objective.torque, scene.objective.altitude = 0.1, 0.0, 2.0
scene.objective.kept_altitude = 3.0
rollout = wm.Rollout(scene, 1, "cpu")
rollout.run()
print(rollout.terms()["altitude"][0], rollout.terms()["kept_altitude"][0], rollout.cost()[0])
"""


def run(folder: Path) -> subprocess.CompletedProcess[str]:
    given = os.environ | {"PYTHONPATH": str(folder)}
    return subprocess.run([sys.executable, "-c", PROGRAM], env=given, cwd=folder, capture_output=True, text=True)


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package, of which each test replaces the two files of terms."""
    copy = tmp_path_factory.mktemp("copy") / "warpmuscle"
    shutil.copytree(Path(warpmuscle.__file__).parent, copy, ignore=shutil.ignore_patterns("__pycache__"))
    return copy


def replace_text(package: Path, file: str, old: str, new: str, number: int) -> None:
    """Have a file of the package with one text in place of another, as of a time that no other test gives it."""
    text = (Path(warpmuscle.__file__).parent / file).read_text()
    (package / file).write_text(text.replace(old, new, 1))
    os.utime(package / file, (1e9 + number, 1e9 + number))  # else byte code of another test may be taken for its own


@pytest.mark.parametrize("left_out", CASES)
def test_the_recipe_for_a_term_works_and_says_what_was_forgotten(left_out: str, package: Path):
    number = CASES.index(left_out)
    function = "\ndef _functions(" if left_out == "function" else FUNCTIONS
    replace_text(package, "kernels/objective/term_functions.py", "\ndef _functions(", function, number)
    term = TERMS.replace('"instance"', '"body"', 1) if left_out == "its scope" else TERMS
    term = "_TERMS = (" if left_out == "term" else term
    replace_text(package, "kernels/objective/objective_terms.py", "_TERMS = (", term, number)
    done = run(package.parent)
    if left_out == "nothing":
        value, kept, cost = map(float, done.stdout.split()[-3:])
        assert 0.05 < value < 0.15
        assert 0.05 < kept < 0.15
        assert cost == pytest.approx(2.0 * value + 3.0 * kept)
    else:
        missing = {
            "function": "term altitude of objective/objective_terms.py in kernels has no function",
            "term": "no attribute 'altitude'",
            "its scope": "term altitude is declared to be of each body, but takes (instance, model, state, work)",
        }
        assert missing[left_out] in done.stderr
