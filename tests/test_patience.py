"""No test depends on how quick the machine is: what must come is waited for as long as it takes, or nearly so."""

import ast
import re
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

import patience
from patience import PATIENCE, ended, until

TESTS = Path(__file__).parent
CLOCKS = {"monotonic", "perf_counter", "sleep"}  # what `until` and `for_a_moment` are there for
WORDS = re.compile(r"monotonic|perf_counter|sleep|timeout|\.(wait|join)\([0-9]", re.IGNORECASE)
LEFT = {  # what a test says by them in another way
    "tests/cli/test_console.py": {"monotonic"},  # of which the times are that it sets
    "tests/live_viewer.py": {"close_timeout"},  # of a socket that is closed anyway
    "tests/test_tiers.py": {"join"},  # which gives another thread a chance
    "tests/view/test_guard.py": {"setTimeout"},  # after which an attack that has got nothing gives up
}


def is_number(node: ast.AST) -> bool:
    """Whether a number stands there."""
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float)


def hurried(tree: ast.AST) -> Iterator[str]:
    """What in a file of tests waits for a time rather than for what must come, or not long enough."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            if name in CLOCKS or name == "wait_for_timeout":
                yield name
            for keyword in node.keywords:
                if (keyword.arg or "").endswith("timeout") and isinstance(keyword.value, ast.Constant):
                    yield str(keyword.arg)
            if name in ("wait", "join") and any(is_number(word) for word in node.args):
                yield name
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and "setTimeout(" in node.value:
            yield "setTimeout"


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("import time\ntime.sleep(0.1)\n", ["sleep"]),
        ("from time import perf_counter\nassert perf_counter() < 5\n", ["perf_counter"]),
        ("run(command, timeout=60)\nconnect(open_timeout=PATIENCE)\n", ["timeout"]),
        ("page.wait_for_timeout(200)\n", ["wait_for_timeout"]),
        ("event.wait(10.0)\nevent.wait(PATIENCE)\n", ["wait"]),
        ("page.evaluate('new Promise((done) => setTimeout(done, 300))')\n", ["setTimeout"]),
    ],
)
def test_what_depends_on_the_machine_is_found(text: str, found: list[str]):
    assert list(hurried(ast.parse(text))) == found


def test_no_test_depends_on_how_quick_the_machine_is():
    wrong = {}
    for path in sorted(TESTS.rglob("*.py")):
        name = f"tests/{path.relative_to(TESTS).as_posix()}"
        text = path.read_text(encoding="utf-8")
        found = set(hurried(ast.parse(text))) - LEFT.get(name, set()) if WORDS.search(text) else set()
        if found and path not in (TESTS / "patience.py", Path(__file__)) and not name.startswith("tests/gpu/"):
            wrong[name] = sorted(found)
    assert wrong == {}, "see tests/patience.py"


def test_what_comes_late_is_waited_for_and_what_never_comes_is_not(monkeypatch: pytest.MonkeyPatch):
    come = threading.Event()
    threading.Timer(0.05, come.set).start()
    until(come.is_set)
    assert PATIENCE >= 600.0
    monkeypatch.setattr(patience, "PATIENCE", 0.05)
    with pytest.raises(AssertionError, match="never came to that"):
        until(lambda: False)


def test_what_a_process_is_to_do_is_not_waited_for_once_it_has_ended():
    class Over:
        def poll(self) -> int:
            return 3

    until(lambda: True, Over())
    with pytest.raises(AssertionError, match="ended before, with 3"):
        until(lambda: False, Over())


def test_threads_of_a_name_are_waited_for():
    going = threading.Event()
    threading.Thread(target=going.wait, name="of this test").start()
    threading.Timer(0.05, going.set).start()
    ended("of this test")
    assert going.is_set()
