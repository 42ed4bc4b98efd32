"""Judge gaits one after another, and write Markdown tables of all of them.

    python tools/judge_table.py walk56_person run56 policy.h5 --device cuda:0 -o table.md
    python tools/judge_table.py walk56_person run56 policy.h5 --device cpu -j 3 -o table.md    three at a time

Rows that are asked besides, such as all disturbances at once, stand in tables of their own. The numbers of each gait,
as JSON, and what was printed about it are kept in a folder beside the table. What is there already is not judged again,
so that an interrupted run goes on; remove a file, or the folder, to judge anew after a change.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from warpmuscle.core.status import Status
from warpmuscle.gait.cycles import NO_CYCLE

RUNS = 20  # with each disturbance
WIDEST = 7  # gaits of a table
MEASURE, BESIDES = "measure", "besides"
PARTS = {"verdicts": MEASURE, "further": BESIDES}  # of a judgement, and what the first column of each is called
COMMANDED = {  # measures of a gait at each command, and what they are called
    "speed": "speed, m/s",
    "angles outside the norms": "angles outside the norms, SD",
    "double support": "double support, % of the cycle",
    "step width": "step width, m",
    "cost of transport, Bhargava net": "cost of transport, Bhargava net, J/(kg m)",
    "cost of transport, Bhargava strict": "and strict",
}


def judged(source: str, folder: Path, further: Sequence[str]) -> dict[str, Any] | None:
    """All numbers of a gait, from its file or by `warpmuscle judge`; None if that ends with an error."""
    kept = folder / f"{source.replace('/', '_')}.json"
    if not kept.exists():
        command = [sys.executable, "-m", "warpmuscle", "judge", source, "--json", str(kept), *further]
        printed = kept.with_suffix(".txt")
        started = time.monotonic()
        with printed.open("wb") as text:
            rc = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=text, stderr=text, check=False).returncode
        if rc or not kept.exists():
            print(f"{source}: {printed.read_text(errors='replace')}", file=sys.stderr, flush=True)
            return None
        print(f"judged {source} in {time.monotonic() - started:.0f} s", flush=True)
    found: dict[str, Any] = json.loads(kept.read_text())
    return found


def table(gaits: dict[str, dict[str, Any]]) -> str:
    """A row a measure and a column a gait, in Markdown; one table each for gaits of the same bars, such as runs.

    A value says if it is missed, does not count, since the gait is impossible, or is no judge at its speed. What is
    asked besides follows in tables of the same kind.
    """
    parts = [
        _table(part, head, bars, {gait: gaits[gait] for gait in names[first : first + WIDEST]})
        for part, head in PARTS.items()
        for bars, names in _kinds(gaits, part).items()
        for first in range(0, len(names), WIDEST)
    ]
    return "\n".join([*parts, *(_commands(gait, found) for gait, found in gaits.items() if _takes_speed(found))])


def _kinds(gaits: dict[str, dict[str, Any]], part: str) -> dict[tuple[tuple[str, ...], ...], list[str]]:
    """Gaits by the bars that they have in a part of their judgements."""
    kinds: dict[tuple[tuple[str, ...], ...], list[str]] = {}
    for gait, found in gaits.items():
        if found.get(part):
            kinds.setdefault(tuple(_bar(one) for one in found[part]), []).append(gait)
    return kinds


def _table(part: str, head: str, bars: Sequence[tuple[str, ...]], gaits: dict[str, dict[str, Any]]) -> str:
    lines = [[head, "unit", "must", "goal", *(f"`{Path(gait).stem}`" for gait in gaits)]]
    lines += [["---"] * len(lines[0])]
    lines += [[*bar, *(cell(found[part][k]) for found in gaits.values())] for k, bar in enumerate(bars)]
    if part == "verdicts":
        lines.append(["fells it", f"of {RUNS}", "", "", *(_fells(found) for found in gaits.values())])
    return _markdown(lines)


def _takes_speed(found: dict[str, Any]) -> bool:
    """Whether it has numbers at several speeds, and they count."""
    return not found["impossible"] and any("speed" in one["command"] for one in found["commanded"])


def _commands(gait: str, found: dict[str, Any]) -> str:
    """A table of what the gait is like at each command."""
    lines = [["command", *COMMANDED.values()], ["---"] * (1 + len(COMMANDED))]
    for one in found["commanded"]:
        measures = one["measures"] or {}
        asked = ", ".join(f"{name} {value:.3g}" for name, value in one["command"].items()) or "as it is"
        lines.append([asked, *("-" if measures.get(name) is None else f"{measures[name]:.3g}" for name in COMMANDED)])
    return f"`{Path(gait).stem}`, as commanded:\n\n{_markdown(lines)}"


def _markdown(lines: Sequence[Sequence[str]]) -> str:
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _bar(one: dict[str, Any]) -> tuple[str, ...]:
    return one["name"], one["unit"], ends_in_words(one["must"]), ends_in_words(one["goal"])


def ends_in_words(ends: Sequence[float | None]) -> str:
    """What a row must or should reach, as a cell."""
    low, high = ends
    if low is None:
        return "" if high is None else f"up to {high:g}"
    return f"{low:g} or more" if high is None else f"{low:g} to {high:g}"


def cell(one: dict[str, Any]) -> str:
    """A value, and whether it is missed, or does not count, as a cell."""
    note = "no whole gait cycle" if NO_CYCLE in str(one["note"]) else str(one["note"])
    if one["value"] is None:
        return f"{note or 'falls'} (missed)" if one["reached"] == "missed" else note or "-"
    told = {"goal": "", "must": "", "does not count": " (void)", "no judge": " (no judge)"}
    return f"{one['value']:.3g}" + told.get(one["reached"], " (missed)")


def _fells(found: dict[str, Any]) -> str:
    """What ends the gait: nothing at all, where it does not last the long run; and each disturbance by itself."""
    told = [] if found["end"] == Status.COMPLETED.meaning else [f"undisturbed it {found['end'].partition(':')[0]}"]
    told += [f"{what} {number}" for what, number in found["felled_by"].items() if number]
    return ", ".join(told) or "none of these"


def main() -> int:
    """Judge, and write the table; 1 if a gait could not be judged."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("sources", nargs="+", help="names of scenes, or files of scenes and policies")
    parser.add_argument("-o", "--output", type=Path, required=True, help="Markdown file")
    parser.add_argument("-j", "--jobs", type=int, default=1, help="gaits at a time, which share the threads of a CPU")
    parser.add_argument("--threads", type=int, help="of a CPU for each gait, in place of an even share of them")
    parser.add_argument("--device", help="as of warpmuscle judge")
    parser.add_argument("--pushes", type=int, help="as of warpmuscle judge")
    given = parser.parse_args()
    if min(given.jobs, 1 if given.threads is None else given.threads) < 1:
        parser.error("--jobs and --threads must be 1 or more")
    jobs = min(given.jobs, len(set(given.sources)))
    threads = given.threads or (max((os.cpu_count() or 1) // jobs, 1) if jobs > 1 else None)
    options = {"device": given.device, "pushes": given.pushes, "threads": threads}
    further = [word for name, value in options.items() if value is not None for word in (f"--{name}", str(value))]
    folder = given.output.with_suffix(".judged")
    folder.mkdir(parents=True, exist_ok=True)
    found: dict[str, dict[str, Any] | None] = {}
    with ThreadPoolExecutor(jobs) as pool:
        running = {pool.submit(judged, source, folder, further): source for source in dict.fromkeys(given.sources)}
        for one in as_completed(running):
            found[running[one]] = one.result()
            if known := {source: numbers for source in running.values() if (numbers := found.get(source))}:
                given.output.write_text(table(known))
    failed = [source for source in running.values() if found[source] is None]
    if failed:
        print(f"could not be judged: {', '.join(failed)}; the errors are above", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
