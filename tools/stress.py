"""Runs tests that wait for others as on other machines: with pages, servers, simulations or threads out of step.

A test of a live page, a server, a thread or a process may pass by chance: because a picture came before it looked, or
a simulation had gone just far enough. Each kind of stress shifts one of them, by chances that `--seed` repeats. What
fails under it waits for the wrong thing, or the product has a fault. Try what you change of such tests with all:

python tools/stress.py tests/view                      all kinds, one after the other
python tools/stress.py --only coarse --only "late page" --seed 3 tests/view/test_viewers.py -k push -n 0
python tools/stress.py --list                          what kinds there are

What it does not know is for pytest, of which it is a plug-in: `STRESS=coarse python -m pytest -p stress tests/view`.
A quick machine finds other faults than a busy one: try both.
"""

from __future__ import annotations

import importlib
import os
import random
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import pytest
import typer

ROOT = Path(__file__).resolve().parents[1]
CHANCE = random.Random(int(os.environ.get("STRESS_SEED", "1")))
LIVE, SERVER, BROWSER = "warpmuscle.view.live", "warpmuscle.view.server", "playwright.sync_api"
# A page in which pictures and timers, and also its messages if it is so asked for, are late by chance, in their order.
LATE_PAGE = """(() => {
  let seed = %d, asked = [];
  const late = (most) => most * ((seed = (seed * 16807) %% 2147483647) / 2147483647);
  const wait = window.setTimeout.bind(window), frame = window.requestAnimationFrame.bind(window);
  const draw = (now) => asked.splice(0).forEach((act) => act(now));
  window.requestAnimationFrame = (act) => {
    if (asked.push(act) === 1) wait(() => frame(draw), late(400));
    return asked.length;
  };
  window.setTimeout = (act, time = 0, ...given) => wait(act, time + late(400), ...given);
  if (!%d) return;
  // Timers of the same moment may go off in another order, so each does what has waited longest.
  const inOrder = (last = 0, acts = []) => (act) => {
    const now = performance.now();
    acts.push(act);
    wait(() => acts.shift()(), (last = Math.max(last, now + late(300))) - now);
  };
  const Plain = WebSocket;
  window.WebSocket = class extends Plain {
    set onmessage(act) {
      const later = inOrder();
      super.onmessage = (event) => later(() => act.call(this, event));
    }
    send(data) {
      (this.later ??= inOrder())(() => this.readyState === Plain.OPEN && super.send(data));
    }
  };
})()"""
DONE_TO_PAGES = (
    "click", "dblclick", "evaluate", "press", "fill", "check", "uncheck", "select_option", "hover", "move", "up",
    "down", "input_value", "inner_text", "goto",
)  # fmt: skip


def replaced(module: str, name: str, make: Callable[[Any], Any]) -> None:
    """Replace something of a module, such as `Live.advance`, by what is made of it."""
    owner: Any = importlib.import_module(module)
    *path, last = name.split(".")
    for part in path:
        owner = getattr(owner, part)
    setattr(owner, last, make(getattr(owner, last)))


def wrapped(module: str, name: str, call: Callable[..., Any]) -> None:
    """Replace a function by a call that is given it first."""
    replaced(module, name, lambda plain: lambda *given, **named: call(plain, *given, **named))


def late(most: float, chance: float = 1.0) -> Callable[..., Any]:
    """A call that first waits for up to so many seconds, in one of some cases."""

    def call(plain: Callable[..., Any], *given: Any, **named: Any) -> Any:
        if CHANCE.random() < chance:
            time.sleep(most * CHANCE.random())
        return plain(*given, **named)

    return call


def pictures(rate: float) -> None:
    """Send pages so many pictures a second."""
    replaced(LIVE, "PICTURES", lambda _: rate)


def bursts(count: int) -> None:
    """Send so many of them at once, each as far from the one before as a slow machine may come."""

    def burst(advance: Callable[..., None], live: Any, passed: float) -> None:
        for _ in range(count):
            advance(live, passed)

    wrapped(LIVE, "Live.advance", burst)


def pace(factor: float) -> None:
    """Let a live simulation's clock run so many times as fast."""
    clock = SimpleNamespace(**{one: lambda: factor * time.monotonic() for one in ("monotonic", "perf_counter")})
    replaced(LIVE, "time", lambda _: clock)


def late_server() -> None:
    """Let what a server tells pages, and what they say, come late and in order."""

    def tell(plain: Callable[..., None], server: Any, message: Any) -> None:
        before = getattr(server, "stressed", 0.0) + 1e-6  # at the same moment the order would be any
        server.stressed = max(before, server._loop.time() + 0.3 * CHANCE.random())
        server._loop.call_at(server.stressed, plain, server, message)

    def stop(plain: Callable[..., None], server: Any) -> None:
        time.sleep(0.3)  # in which it tells the last
        plain(server)

    wrapped(SERVER, "PageServer._tell", tell)
    wrapped(SERVER, "PageServer.stop", stop)
    wrapped(LIVE, "Live._hear", late(0.3, 0.05))  # of hundreds not all


def late_page(socket: bool) -> None:
    """Let pages of a browser draw late, and with `socket` hear and say late, too."""

    def opened(new: Callable[..., Any], *given: Any, **named: Any) -> Any:
        page = new(*given, **named)
        page.add_init_script(LATE_PAGE % (CHANCE.randrange(1, 1 << 30), socket))
        return page

    for name in ("new_page", "new_context"):
        wrapped(BROWSER, f"Browser.{name}", opened)


def late_tester() -> None:
    """Let what a test does to a page come late, and what it reads be old."""
    for kind in ("Page", "Locator", "Keyboard", "Mouse", "Frame"):
        for name in DONE_TO_PAGES:
            if hasattr(getattr(importlib.import_module(BROWSER), kind), name):
                wrapped(BROWSER, f"{kind}.{name}", late(1.0, 0.3))


def late_threads() -> None:
    """Let threads begin late, and take turns at any moment."""
    sys.setswitchinterval(1e-6)
    wrapped("threading", "Thread.run", late(0.3))


def other_order(items: list[Any]) -> None:
    """Shuffle the tests of each file, and the files."""
    files: dict[Path, list[Any]] = {}
    for item in items:
        files.setdefault(item.path, []).append(item)
    shuffled = list(files.values())
    CHANCE.shuffle(shuffled)
    for tests in shuffled:
        CHANCE.shuffle(tests)
    items[:] = [item for tests in shuffled for item in tests]


KINDS: dict[str, tuple[str, list[Callable[[], None]]]] = {
    "coarse": ("few pictures a second, three at once", [partial(pictures, 1.5), partial(bursts, 3)]),
    "fine": ("very many pictures a second", [partial(pictures, 300.0)]),
    "quick": ("a live simulation four times as fast", [partial(pace, 4.0), partial(pictures, 60.0)]),
    "slow": ("a live simulation that hardly goes on", [partial(pace, 0.1)]),
    "hesitant": ("one that waits by chance", [partial(wrapped, LIVE, "Live.advance", late(0.5))]),
    "late server": ("a server that tells and hears pages late", [late_server]),
    "late page": ("a browser that draws late", [partial(late_page, socket=False)]),
    "late socket": ("a browser that draws, hears and says late", [partial(late_page, socket=True)]),
    "late tester": ("a test that acts on a page and reads it late", [late_tester]),
    "late threads": ("threads that begin late, and take turns at any moment", [late_threads]),
    "patient threads": ("threads that seldom take turns", [partial(sys.setswitchinterval, 0.5)]),
    "shuffled": ("files, and the tests of a file, in another order", []),
}


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[Any]) -> None:
    """Change the order, where that is the stress."""
    if "shuffled" in os.environ.get("STRESS", ""):
        other_order(items)


def pytest_collection_finish() -> None:
    """Begin with what STRESS names, separated by commas, and with less patience."""
    if (patience := os.environ.get("STRESS_PATIENCE")) is not None:  # with what will never come
        for module in [*sys.modules.values()]:
            if "PATIENCE" in vars(module) and not module.__name__.endswith("test_patience"):
                module.PATIENCE = float(patience)  # type: ignore[attr-defined]
    for name in filter(None, os.environ.get("STRESS", "").split(",")):
        for act in KINDS[name][1]:
            act()


def stress(
    context: typer.Context,
    only: Annotated[list[str] | None, typer.Option(help="Kinds of stress; by default all.")] = None,
    seed: Annotated[int, typer.Option(help="Of all chances.")] = 1,
    patience: Annotated[float, typer.Option(min=1.0, help="Seconds after which a test waits no longer.")] = 120.0,
    listing: Annotated[bool, typer.Option("--list", help="Only print the kinds.")] = False,
) -> None:
    """Run tests under stress; exit code 1 if one fails."""
    if unknown := set(only or ()) - set(KINDS):
        raise typer.BadParameter(f"no kind of stress: {', '.join(sorted(unknown))}; there are {', '.join(KINDS)}")
    failed = []
    for kind in only or KINDS:
        print(f"{kind}: {KINDS[kind][0]}", flush=True)
        if not listing:
            given = {"STRESS": kind, "STRESS_SEED": str(seed), "STRESS_PATIENCE": str(patience)}
            path = os.pathsep.join(filter(None, [str(ROOT / "tools"), os.environ.get("PYTHONPATH")]))
            command = [sys.executable, "-m", "pytest", "-p", "stress", "-q", *context.args]
            run = subprocess.run(command, cwd=ROOT, env=os.environ | given | {"PYTHONPATH": path})
            failed += [kind] if run.returncode else []
    if failed:
        print(f"failed: {', '.join(failed)}")
        raise typer.Exit(1)


def program() -> typer.Typer:
    """The command line, which leaves to pytest what it does not know."""
    app = typer.Typer(add_completion=False)
    app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(stress)
    return app


if __name__ == "__main__":
    program()()
