"""What commands print: results on the standard output, all else on the error stream."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Collection, Iterable, Sequence
from importlib import import_module
from threading import Thread
from typing import TYPE_CHECKING, Any

from rich.console import Console, JustifyMethod, OverflowMethod
from rich.status import Status
from rich.style import StyleType
from rich.text import Text

from warpmuscle.cli.streams import started
from warpmuscle.core.plain_text import number_of, printable
from warpmuscle.core.repeating import Repeating

if TYPE_CHECKING:
    from warpmuscle.gait.measures import Gait
    from warpmuscle.results.recording import Recording
    from warpmuscle.scene import Scene


LINES = 10.0  # s between two lines of progress where there is no terminal to draw it in
SILENCE, BRIEF = 1.3, 0.5  # s, the same of a work's first minutes, whose reader waits
AWAITED = 300.0  # s since the program's start, which those minutes are
_BEGIN = time.monotonic()


def between_lines() -> float:
    """Seconds between two lines of progress where there is no terminal to draw it in."""
    return SILENCE if time.monotonic() - _BEGIN < AWAITED else LINES


class _Lines:
    """Lines that say now and then what is going on, until `end` is called."""

    def __init__(self, text: Callable[[], str], console: PlainConsole) -> None:
        self._text, self._console, self._begin = text, console, time.monotonic()
        self.end = Repeating(self._say, self._pause).end

    def _pause(self) -> float:
        left = between_lines() - (time.monotonic() - self._console.said)
        return max(left, min(BRIEF, between_lines()))

    def _say(self) -> None:
        self._console.print(f"{self._text()}, {time.monotonic() - self._begin:.0f} s")


class _Timed:
    """A text that tells how long what it says has gone on, from the second second."""

    def __init__(self, text: str) -> None:
        self.text, self._begin = text, time.monotonic()

    def __rich__(self) -> Text:
        seconds = int(time.monotonic() - self._begin)
        return Text(printable(self.text) + (f", {seconds} s" if seconds else ""))


class _Status(Status):
    """Of a work, with plain text beside the spinner, and the time that it has taken so far."""

    _lines: _Lines | None = None

    def __init__(self, status: str, console: PlainConsole, **options: Any) -> None:
        self.text, self._console, self._line = status, console, time.monotonic()
        super().__init__(_Timed(status), console=console, **options)

    def update(self, status: Any = None, **options: Any) -> None:
        if isinstance(status, str):
            if not self._console.is_terminal and time.monotonic() - self._line > between_lines():
                self._line = time.monotonic()
                self._console.print(status)
            self.text, status = status, _Timed(status)
        super().update(status, **options)

    def __enter__(self) -> Status:
        self._console.working = self
        if self._console.is_terminal:
            started.set()
        else:
            self._lines = _Lines(lambda: self.text, self._console)
        return super().__enter__()

    def __exit__(self, *error: Any) -> None:
        self._console.working = None
        if self._lines is not None:
            self._lines.end()
        super().__exit__(*error)


class PlainConsole(Console):
    """A console for which text is text: names in it can neither be styles nor emoji, nor steer the terminal.

    What is to have a style is given as `marked` gives it, or as a style of its own.

    Attributes:
        working: the status that is shown now.
        said: when it printed last, s of the monotonic clock.
    """

    working: _Status | None = None
    said = _BEGIN

    def render_str(
        self, text: str, *, style: StyleType = "", justify: JustifyMethod | None = None,
        overflow: OverflowMethod | None = None, **_: Any,
    ) -> Text:  # fmt: skip
        """See `Console.render_str`."""
        return Text(printable(text), style=style, justify=justify, overflow=overflow)

    def print(self, *objects: Any, **options: Any) -> None:
        """See `Console.print`."""
        started.set()
        self.said = time.monotonic()
        super().print(*objects, **options)

    def status(self, status: Any, **options: Any) -> Status:
        """See `Console.status`."""
        return _Status(str(status), self, **options)


def marked(word: str, style: str, rest: str = "") -> Text:
    """Text that begins with a word of a style."""
    return Text.assemble((printable(word), style), printable(rest))


out = PlainConsole(soft_wrap=True, highlight=False)
log = PlainConsole(stderr=True, soft_wrap=True, highlight=False)


def tell_of_compiling(what: str) -> Callable[[], None]:
    """Say in the status that is shown what is compiled, until what this returns is called."""
    working = log.working
    if working is None:
        return _Lines(lambda: f"compiling {what}, once", log).end
    before = working.text
    working.update(f"compiling {what}, once (usually 5 to 20 s)")
    return lambda: working.update(before)


def suggest(what: str) -> None:
    """Say on a terminal what may be done next."""
    if log.is_terminal:
        log.print(f"next: {what}", style="dim")


def print_table(
    headings: Sequence[str], rows: Iterable[Sequence[str]], words: Collection[str] = (), title: str = ""
) -> None:
    """Aligned text, as wide as it has to be: a table of many columns is of no use squeezed into a narrow console.

    Args:
        words: headings of columns of words, which are aligned on the left; others are of numbers.
    """
    lines = [headings, *rows]
    widths = [max(len(line[k]) for line in lines if k < len(line)) for k in range(len(headings))]
    if title:
        out.print()
        out.print(marked(title, "bold"))
    for number, line in enumerate(lines):
        columns = zip(line, headings, widths, strict=False)
        text = "  ".join(cell.ljust(w) if name in words else cell.rjust(w) for cell, name, w in columns).rstrip()
        out.print(marked(text, "" if number or title else "bold"))


def print_ignored(ignored: list[Any], heading: str) -> None:
    """On the error stream, what was not used, a line for each file and reason."""
    from warpmuscle.formats.load import summary

    if ignored:
        log.print(marked(summary(ignored, heading), "yellow"))


def print_warnings(doubts: Iterable[object]) -> None:
    """On the error stream, what is probably a mistake, a line each."""
    for doubt in doubts:
        log.print(marked("warning:", "yellow", f" {doubt}"))


class GaitPrinter:
    """What `print_gait` needs, imported and compiled by a thread beside other work.

    Args:
        others: modules to be imported besides.
    """

    def __init__(self, scene: Scene, others: Sequence[str] = ()) -> None:
        self._scene, self._others = scene, others
        self._thread: Thread | None = None

    def begin(self) -> None:
        """Begin, once; nothing happens for a scene without feet, nor where there is no core for it."""
        from warpmuscle.core.machine import cores

        if self._thread is None and self._scene.feet is not None and cores() > 1:
            self._thread = Thread(target=self._prepare, name="printing", daemon=True)
            self._thread.start()

    def end(self) -> None:
        """Wait until it is done, since nothing is to be compiled twice."""
        if self._thread is not None:
            self._thread.join()

    def _prepare(self) -> None:
        with contextlib.suppress(Exception):  # whoever needs it says what is wrong
            import_module("warpmuscle.gait.muscle_effort").load_kernel(self._scene)
            for name in ("warpmuscle.gait.measures", *self._others):
                import_module(name)


def print_gait(scene: Scene, recording: Recording) -> Gait | None:
    """Print speed, step length, cadence and cost of transport of a scene with feet."""
    from warpmuscle.gait.measures import measure
    from warpmuscle.scene.ground import LIFTED

    if scene.feet is None or recording.frames == 0:
        return None
    gait = measure(recording, scene)
    text = f"speed {gait.speed_forward:.3f} m/s"
    if gait.step_length is not None and gait.cadence is not None:
        text += f", step length {gait.step_length:.3f} m, cadence {gait.cadence:.1f} steps/min"
    rule = "" if gait.steps else f"; feet make one that land in turn, each after {LIFTED:g} s off the ground or more"
    out.print(f"{text} (from {gait.start:.3g} s to {gait.end:.3g} s, {number_of(gait.steps, 'step')}{rule})")
    _print_cost(scene, recording.window(gait.start), gait.speed_horizontal)
    return gait


def _print_cost(scene: Scene, steady: Recording, speed: float) -> None:
    """Print what the muscles of a steady gait spend, and how that is counted; nothing if that is not known."""
    from warpmuscle.gait.muscle_effort import BHARGAVA_NET, BHARGAVA_STRICT, bhargava_costs, cost_of_transport, spent
    from warpmuscle.scene.accounting import accounting
    from warpmuscle.scene.anatomy import straight_legs
    from warpmuscle.scene.masses import COMMON_TENSION
    from warpmuscle.scene.norms import REFERENCES
    from warpmuscle.scene.parameters import at_start

    plain = at_start(scene)
    with log.status("adding up what its muscles spend"):
        effort = spent(steady, plain)
        cost = None if effort is None else cost_of_transport(effort.power, speed)
        if effort is None or cost is None:
            return
        two = bhargava_costs(steady, plain, speed)
    common = f"{effort.common_power / speed:.2f}"
    beside = "" if common == f"{cost:.2f}" else f" ({common} at {COMMON_TENSION / 1e6:g} MPa)"
    words = accounting(plain, steady.muscle_names)
    out.print(f"cost of transport {cost:.2f} J/(kg m){beside}: {words}", markup=False)
    net, strict = two.get(BHARGAVA_NET), two.get(BHARGAVA_STRICT)
    if net is not None and strict is not None:
        known = REFERENCES["cost of transport"]
        people = f" (people who walk: {known.low:.2f} to {known.high:.2f})" if straight_legs(plain) else ""
        out.print(f"cost of transport by Bhargava {net:.2f} J/(kg m) net, {strict:.2f} strict{people}")
