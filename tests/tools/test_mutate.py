"""Mutations are such changes as they say, and are tried on a copy by the tests that may see them."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from patience import PATIENCE

ROOT = Path(__file__).parents[2]
if str(ROOT / "tools") not in sys.path:
    sys.path.append(str(ROOT / "tools"))

from mutations.changes import all_mutations, mutations_of, sample  # noqa: E402
from mutations.equal import EQUAL, EQUAL_CHANGES  # noqa: E402
from mutations.sessions import Sessions  # noqa: E402
from mutations.tests_of import Order  # noqa: E402
from mutations.trial import Trial, _batches, _Run  # noqa: E402

SOURCE = b'''"""No 1.0 + 2.0 of a docstring."""
HALF: float = 0.5
SMALLEST_PART = 1.0e-12


def force(a: float, b: float) -> float:
    if a < 0.0:
        raise ValueError(f"a is {a - 1.0}")
    return a - b * cos(a)


def title(a: float) -> str:
    return "m" * int(a + 1.0)


def numbers(a: float) -> dict[str, float]:
    return {"a": -a}
'''

SMALL = """
def lever(force: float, arm: float) -> float:
    return force * arm + 0.0 * arm
"""

TEST = """
import pytest

from warpmuscle.gait.lever import lever


def test_failing_anyway():
    assert lever(0.0, 0.0) == 1.0


@pytest.mark.parametrize("force", [2.0], ids=["of two - newtons"])
def test_lever(force):
    assert lever(force, 3.0) == 6.0
"""


def changed(source: bytes) -> dict[str, set[tuple[str, str]]]:
    found: dict[str, set[tuple[str, str]]] = {}
    for m in mutations_of("a.py", source):
        found.setdefault(m.kind, set()).add((m.before, m.after))
    return found


def reads(source: bytes) -> bool:
    try:
        ast.parse(source)
    except SyntaxError:
        return False
    return True


def test_what_computes_is_changed_and_nothing_else():
    assert changed(SOURCE) == {
        "number": {("0.5", "0.625"), ("0.5", "0.4"), ("0.0", "1.0")},
        "comparison": {("a < 0.0", "a > 0.0")},
        "operator": {("a - b * cos(a)", "a + (b * cos(a))"), ("b * cos(a)", "b / cos(a)")},
        "term dropped": {
            ("a - b * cos(a)", "a"), ("a - b * cos(a)", "(-(b * cos(a)))"), ("b * cos(a)", "b"),
            ("b * cos(a)", "cos(a)"),
        },
        "term doubled": {("a - b * cos(a)", "(a - (b * cos(a)) - (b * cos(a)))")},
        "swapped": {("a - b * cos(a)", "((b * cos(a)) - a)")},
        "function": {("cos", "sin")},
        "sign": {("-a", "(a)")},
    }  # fmt: skip


def test_what_is_the_same_both_ways_is_left_out():
    assert "swapped" not in changed(b"x = wp.max(a, b)")
    assert changed(b"x = wp.clamp(a, a, b)")["swapped"] == {("a, b", "b, a")}
    assert changed(b"x = wp.clamp(a, low, high)")["swapped"] == {("low, high", "high, low")}  # min(max(low, a), high)
    assert changed(b"x = a.clip(low, high)")["swapped"] == {("low, high", "high, low")}
    assert "statement" not in changed(b"know_model(character)")
    assert changed(b'wp.set_module_options({"enable_backward": False, "max_unroll": 1})') == {}
    assert changed(b"if n < 3: n += 1")["comparison"] == {("n < 3", "n > 3"), ("n < 3", "n <= 3")}


def test_what_goes_on_in_a_second_line_keeps_its_brackets():
    for sign in "+-*/@":
        source = f"x = a {sign} (\n    b\n    + c\n)\ny = (\n    b\n    + c\n) {sign} a\nx += (\n    a\n    * b\n)\n"
        assert not [m for m in mutations_of("a.py", source.encode()) if not reads(m.applied(source.encode()))]


def test_bounds_of_what_is_a_number_are_left_out_and_bounds_of_the_physics_are_not():
    source = b"far = wp.abs(x) < wp.static(1.0e30)\nnear = wp.max(x, 1.0e-9)\nTHIN = 1.0e-9\nstiff = 1.0e7 * x\n"
    assert changed(source)["number"] == {("1.0e7", "12500000.0"), ("1.0e7", "8000000.0")}
    assert changed(b"late = x < 2.5")["number"] == {("2.5", "3.125"), ("2.5", "2.0")}


def test_flags_that_kernels_have_by_default_are_left_out():
    source = b"def stage_of(implicit: bool = False):\n    return made(implicit, True)\n"
    found = {
        path: {m.before for m in mutations_of(path, source)}
        for path in ("warpmuscle/kernels/a.py", "warpmuscle/model/a.py")
    }
    assert "False" not in found["warpmuscle/kernels/a.py"]
    assert {"True"} <= found["warpmuscle/kernels/a.py"]
    assert {"False", "True"} <= found["warpmuscle/model/a.py"]


@pytest.mark.parametrize(("path", "line"), EQUAL)
def test_lines_that_change_nothing_are_there_and_not_mutated(path: str, line: str):
    source = (ROOT / path).read_bytes()
    numbers = {k for k, text in enumerate(source.decode().splitlines(), 1) if text.strip() == line}
    assert numbers
    assert not numbers & {m.line for m in mutations_of(path, source)}


@pytest.mark.parametrize(("path", "line", "after"), EQUAL_CHANGES)
def test_changes_that_change_nothing_are_left_out_and_others_of_their_lines_are_not(path: str, line: str, after: str):
    source = (ROOT / path).read_bytes()
    numbers = {k for k, text in enumerate(source.decode().splitlines(), 1) if text.strip() == line}
    assert numbers
    others = [m for m in mutations_of(path, source) if m.line in numbers]
    assert others
    assert after not in {m.after for m in others}


def test_every_mutation_of_the_physics_is_a_change_that_python_reads():
    mutations = all_mutations(ROOT)
    assert len(mutations) > 10000
    assert {"/".join(m.path.split("/")[:2]) for m in mutations} == {
        "warpmuscle/kernels", "warpmuscle/model", "warpmuscle/gait", "warpmuscle/studies",
    }  # fmt: skip
    for mutation in sample(mutations, 200, 3):
        source = (ROOT / mutation.path).read_bytes()
        assert ast.dump(ast.parse(mutation.applied(source))) != ast.dump(ast.parse(source)), mutation


def test_a_seed_gives_the_same_mutations_a_line_each():
    mutations = all_mutations(ROOT, "gait/")
    chosen = sample(mutations, 30, 5)
    assert chosen == sample(mutations, 30, 5) != sample(mutations, 30, 6)
    assert len({(m.path, m.line) for m in chosen}) == 30


def test_a_line_that_is_left_out_changes_no_other_choice():
    mutations = all_mutations(ROOT, "gait/")
    chosen = sample(mutations, 30, 5)
    out = chosen[7].path, chosen[7].line
    others = sample([m for m in mutations if (m.path, m.line) != out], 30, 5)
    assert others[:29] == [m for m in chosen if (m.path, m.line) != out]
    assert others[29] not in chosen


def test_a_file_that_has_changed_is_not_mutated():
    mutation = mutations_of("a.py", SOURCE)[0]
    with pytest.raises(ValueError, match=r"^a\.py: changed since its mutations were listed; run again$"):
        mutation.applied(SOURCE + b"\n")


@pytest.fixture(scope="module")
def order() -> Order:
    return Order(ROOT)


def test_the_mirror_comes_first_then_what_imports_the_module(order: Order):
    tests = order.of("warpmuscle/kernels/muscle/activation.py")
    assert tests[0] == "tests/kernels/muscle/test_activation.py"
    near, far = tests.index("tests/kernels/muscle/test_muscle_control.py"), tests.index("tests/search/test_random.py")
    assert near < far
    assert not any(test.startswith(("tests/docs", "tests/tools")) for test in tests)


def test_files_called_as_the_changed_function_come_before_what_only_imports_it(order: Order):
    path = "warpmuscle/model/couplings.py"
    source = (ROOT / path).read_text().splitlines()
    line = next(k for k, text in enumerate(source, 1) if text.startswith("def constraints_struct"))
    assert "tests/kernels/constraint/test_constraints.py" in order.of(path, line + 2)[:2]


def test_all_files_run_once_in_their_order_the_first_ones_by_themselves():
    files = [f"tests/test_{k}.py" for k in range(100)]
    batches = list(_batches(files))
    assert [test for batch in batches for test in batch] == files
    assert [len(batch) for batch in batches] == [1, 3, 8, 16, 32, 32, 8]
    assert list(_batches([])) == []


@pytest.mark.parametrize("name", ["tests/a/test_a.py::test_it", "tests/a/test_a.py::test_it[of two - newtons]"])
def test_the_test_in_which_a_process_ends_is_told_apart_from_what_it_writes(name: str):
    begin = "tests/a/test_a.py::test_before PASSED   [ 50%]\n"
    for rest in ("", " ", " Fatal Python error: Segmentation fault\n", " double free or corruption\n"):
        run = _Run(-11, begin + name + rest, 1.0, 1.0, 0.0)
        assert (run.running, run.failed) == (name, "")
    assert _Run(1, begin + name + " FAILED  [100%]\n", 1.0, 1.0, 0.0).failed == name


@pytest.mark.long
def test_a_session_tells_its_code_and_is_stopped_when_its_time_is_over(tmp_path: Path):
    (tmp_path / "test_one.py").write_text("import os, time\ndef test_it():\n    {}\n")
    sessions = Sessions(tmp_path, {**os.environ, "PYTHONPATH": str(ROOT / "tools")})
    found = []
    for line, limit in (
        ("pass", PATIENCE),
        ("assert False", PATIENCE),
        ("os.abort()", PATIENCE),
        ("time.sleep(9e3)", 4.0),
    ):
        (tmp_path / "test_one.py").write_text(f"import os, time\ndef test_it():\n    {line}\n")
        arguments = ["-p", "no:cacheprovider", "-p", "no:faulthandler", str(tmp_path / "test_one.py")]
        found.append(sessions.run(arguments, tmp_path / "output", limit)[0])
    sessions.close()
    assert found == [0, 1, -6, None]


@pytest.mark.long
def test_a_mutation_is_caught_by_a_test_that_passes_without_it(tmp_path: Path):
    for name in ("warpmuscle", "warpmuscle/gait", "tests", "tests/gait"):
        (tmp_path / "root" / name).mkdir(parents=True)
    root = tmp_path / "root"
    for name in ("warpmuscle", "warpmuscle/gait"):
        (root / name / "__init__.py").touch()
    (root / "pyproject.toml").write_text("[tool.pytest.ini_options]\naddopts = '--import-mode importlib'\n")
    (root / "warpmuscle/gait/lever.py").write_text(SMALL)
    (root / "tests/gait/test_lever.py").write_text(TEST)
    (root / "tests/gait/test_lacking.py").write_text("import nowhere\nimport warpmuscle.gait.lever\n")
    trial = Trial(root, tmp_path / "copy", tmp_path / "kernels")
    outcomes = {
        (m.before, m.after): trial.try_one(m, PATIENCE)
        for m in all_mutations(root)
        if (m.before, m.after) in {("force * arm", "force / arm"), ("0.0", "1.0"), ("0.0 * arm", "0.0")}
    }
    assert {change: (o.status, o.by) for change, o in outcomes.items()} == {
        ("force * arm", "force / arm"): ("caught", "tests/gait/test_lever.py::test_lever[of two - newtons]"),
        ("0.0", "1.0"): ("caught", "tests/gait/test_lever.py::test_lever[of two - newtons]"),
        ("0.0 * arm", "0.0"): ("survived", ""),
    }
    assert (trial.folder / "warpmuscle/gait/lever.py").read_text() == SMALL


def test_the_tool_lists_and_refuses():
    command = [sys.executable, str(ROOT / "tools/mutate.py"), "--list", "--only"]
    listed = subprocess.run([*command, "gait/cycles", "--sample", "4"], capture_output=True, text=True)
    assert [line.split(":")[0] for line in listed.stdout.splitlines()] == ["warpmuscle/gait/cycles.py"] * 4
    refused = subprocess.run([*command, "nowhere"], capture_output=True, text=True)
    assert refused.returncode == 2
    assert "nowhere" in refused.stderr


def test_tests_that_cannot_run_at_all_are_told_before_mutations_count_as_caught(tmp_path: Path):
    """With an interpreter that has no pytest, every mutation seemed to be caught."""
    root = tmp_path / "root"
    for name in ("warpmuscle", "tests"):
        (root / name).mkdir(parents=True)
    with pytest.raises(RuntimeError, match="no test can run here"):
        Trial(root, tmp_path / "worker", tmp_path / "kernels").check()
