"""How the viewer bears time and numbers: pace and memory of live, and pictures a second of many bipeds.

    .venv/bin/python tools/bench_viewer.py pace --scene walk56_commands  # simulated seconds a CPU second
    .venv/bin/python tools/bench_viewer.py live --minutes 30     # memory of server and page, which is not to grow
    .venv/bin/python tools/bench_viewer.py many --bipeds 60 --against other.html

Chromium draws without a graphics card here, unless `--gpu`. Memory is that of the server's process and of the page's
JavaScript after its garbage was collected. A page given with `--against` is measured in turn with ours, so that a busy
machine is as busy for both.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from warpmuscle.formats import load
from warpmuscle.view.crowd import Facts
from warpmuscle.view.live import PICTURES, Live
from warpmuscle.view.live_run import LiveRun
from warpmuscle.view.sources import of_scene, page_of_sights

SETTLED = 0.2  # of the time, after which memory is compared
ROUNDS = 3
CORES = 2
SPARING = "const soon = requestAnimationFrame; requestAnimationFrame = (f) => setTimeout(() => soon(f), %f)"
WINDOW = {"width": 1280, "height": 800}  # px


def main() -> None:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["pace", "live", "many"])
    parser.add_argument("--scene", default="walk56")
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--bipeds", type=int, default=60)
    parser.add_argument("--seconds", type=float, default=6.0, help="of each measurement of pictures")
    parser.add_argument("--against", type=Path, help="another page, to be measured in turn")
    parser.add_argument("--drawn", type=float, help="pictures a second at most of a live page, to spare a busy machine")
    parser.add_argument("--gpu", action="store_true", help="let Chromium use a graphics card")
    given = parser.parse_args()
    if given.what == "pace":
        print_pace(given.scene, given.seconds)
        return
    from playwright.sync_api import sync_playwright

    flags = [] if given.gpu else ["--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with sync_playwright() as driver:
        browser = driver.chromium.launch(
            executable_path=shutil.which("chromium"),
            args=["--no-sandbox", "--enable-precise-memory-info", "--js-flags=--expose-gc", *flags],
        )
        if given.what == "live":
            watch_memory(browser, given.scene, given.minutes, given.drawn)
        else:
            count_pictures(browser, given)
        browser.close()


def print_pace(scene: str, seconds: float) -> None:
    """Print simulated seconds for one second of one core: simulation, frames and messages to pages, without drawing.

    Commands go to one end of their range and to the other in turn, two seconds each way.
    """
    viewer = Live(LiveRun(load(scene)), port=0)
    run, commands = viewer.run, viewer.run.scene.commands
    paced(viewer, 2.0)
    print(f"{scene}: {paced(viewer, seconds):.2f} simulated seconds a CPU second")
    if commands:
        begin, spent = run.time, time.process_time()
        for turn in range(max(round(seconds / 4.0), 1) * 2):
            run.asked = {name: one.max if turn % 2 == 0 else one.min for name, one in commands.items()}
            paced(viewer, 2.0)
        pace = (run.time - begin) / (time.process_time() - spent)
        print(f"{scene}, its {', '.join(commands)} changing: {pace:.2f}; it {run.status.meaning}")


def paced(viewer: Live, seconds: float) -> float:
    """Let a viewer go on as its thread would, without waiting; simulated seconds a CPU second."""
    begin, spent = viewer.run.time, time.process_time()
    for _ in range(round(seconds * PICTURES)):
        viewer.advance(1.0 / PICTURES)
    return (viewer.run.time - begin) / (time.process_time() - spent)


def watch_memory(browser: Any, scene: str, minutes: float, drawn: float | None) -> None:
    """Print memory once in a while, and how much it grew since it had settled."""
    viewer = Live(LiveRun(load(scene)), port=0)
    viewer.start()
    page = browser.new_page(viewport={"width": 900, "height": 700})
    if drawn is not None:
        page.add_init_script(SPARING % (1000.0 / drawn))
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", lambda message: problems.append(message.text) if message.type == "error" else None)
    page.goto(viewer.url)
    page.evaluate("warpmuscle.ready")
    begin, rows = time.monotonic(), []
    print("  minutes  server MB  page MB  pictures/s  simulated/real")
    while (passed := time.monotonic() - begin) < 60.0 * minutes:
        shown, simulated = page.evaluate("warpmuscle.state().pictures"), viewer.run.time
        page.wait_for_timeout(min(15_000.0, 60_000.0 * minutes / 20.0))
        spent = time.monotonic() - begin - passed
        rate = (page.evaluate("warpmuscle.state().pictures") - shown) / spent
        used = page.evaluate("(gc(), performance.memory.usedJSHeapSize)") / 1e6
        rows.append((passed / 60.0, resident(), used))
        ratio = (viewer.run.time - simulated) / spent
        print(f"{passed / 60.0:9.1f} {rows[-1][1]:10.1f} {used:8.2f} {rate:11.1f} {ratio:15.2f}", flush=True)
    settled = np.array([row for row in rows if row[0] >= SETTLED * minutes])
    slopes = [np.polyfit(settled[:, 0], settled[:, k], 1)[0] for k in (1, 2)]
    print(f"growth since then, MB a minute: server {slopes[0]:+.3f}, page {slopes[1]:+.3f}")
    print(f"console errors: {len(problems)}", *problems[:5], sep="\n")
    viewer.stop()


def resident() -> float:
    """Memory of this process, MB."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return float(line.split()[1]) / 1e3
    return float("nan")


def count_pictures(browser: Any, given: argparse.Namespace) -> None:
    """Print pictures a second of our page, and of another one."""
    sight = of_scene(msgspec.structs.replace(load(given.scene), duration=3.0), "cpu")[0]
    with tempfile.TemporaryDirectory() as folder:
        own = Path(folder) / "many.html"
        crowd = [replace(sight, facts=Facts(cost=float(k))) for k in range(given.bipeds)]
        page_of_sights(crowd).save(own)
        pages = [own] + ([given.against.resolve()] if given.against else [])
        found: dict[Path, list[tuple[float, float, float]]] = {page: [] for page in pages}
        for _ in range(ROUNDS):
            for path in pages:
                found[path].append(rate_of(browser, path, given.seconds))
        for path, rows in found.items():
            rates, scripts, spent = np.transpose(rows)
            print(f"{path.name}: {np.median(rates):.1f} pictures/s ({', '.join(f'{rate:.1f}' for rate in rates)}), "
                  f"{np.median(scripts):.1f} ms of JavaScript and {np.median(spent):.0f} ms of processors a picture, "
                  f"so {CORES * 1000.0 / np.median(spent):.0f} pictures/s at most on {CORES} free ones")  # fmt: skip
        if given.against:
            ratios = np.divide([row[0] for row in found[pages[0]]], [row[0] for row in found[pages[1]]])
            print(f"ours over the other: {np.median(ratios):.2f} ({', '.join(f'{ratio:.2f}' for ratio in ratios)})")


def processor_time() -> float:
    """Seconds of processors that all processes have taken that this one has started, and that they have started."""
    parents, spent = {}, {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:  # it has ended
            continue
        parents[int(folder.name)], spent[int(folder.name)] = int(fields[1]), int(fields[11]) + int(fields[12])

    def ours(one: int) -> bool:
        while one in parents and one != os.getpid():
            one = parents[one]
        return one == os.getpid()

    return sum(ticks for one, ticks in spent.items() if ours(one)) / os.sysconf("SC_CLK_TCK")


def rate_of(browser: Any, path: Path, seconds: float) -> tuple[float, float, float]:
    """Pictures a second that a page draws once it has found its resolution, and ms of JavaScript and of all each."""
    page = browser.new_page(viewport=WINDOW)
    page.set_default_timeout(120_000)
    page.goto(path.as_uri())
    page.evaluate("warpmuscle.ready")
    page.wait_for_timeout(1000.0 * seconds)
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")

    def counted() -> tuple[float, float, float]:
        now, pictures = page.evaluate("[performance.now(), warpmuscle.state().pictures]")
        metrics = {each["name"]: each["value"] for each in session.send("Performance.getMetrics")["metrics"]}
        return now, pictures, 1000.0 * metrics["ScriptDuration"]

    before, began = counted(), processor_time()
    page.wait_for_timeout(1000.0 * seconds)
    passed, pictures, script = np.subtract(counted(), before)
    spent = 1000.0 * (processor_time() - began)
    page.close()
    return tuple(
        float(one) for one in (1000.0 * pictures / passed, script / max(pictures, 1.0), spent / max(pictures, 1.0))
    )


if __name__ == "__main__":
    main()
