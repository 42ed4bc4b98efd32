"""Judge gaits one after another, and write Markdown tables of all of them.

    python tools/judge_table.py walk56_person run56 policy.h5 --device cuda:0 -o table.md

Numbers of each gait are kept as JSON in a folder beside the table. What is there already is not judged again, so that
an interrupted run goes on; remove a file, or the folder, to judge anew after a change.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

RUNS = 20  # with each disturbance
WIDEST = 7  # gaits of a table
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
        if subprocess.run(command, stdout=sys.stderr, check=False).returncode or not kept.exists():
            return None
    found: dict[str, Any] = json.loads(kept.read_text())
    return found


def table(gaits: dict[str, dict[str, Any]]) -> str:
    """A row a measure and a column a gait, in Markdown; one table each for gaits of the same bars, such as runs.

    A value says if it is missed, does not count, since the gait is impossible, or is no judge at its speed.
    """
    kinds: dict[tuple[tuple[str, ...], ...], list[str]] = {}
    for gait, found in gaits.items():
        kinds.setdefault(tuple(_bar(one) for one in found["verdicts"]), []).append(gait)
    parts = [
        _table(bars, {gait: gaits[gait] for gait in names[first : first + WIDEST]})
        for bars, names in kinds.items()
        for first in range(0, len(names), WIDEST)
    ]
    return "\n".join([*parts, *(_commands(gait, found) for gait, found in gaits.items() if _takes_speed(found))])


def _table(bars: Sequence[tuple[str, ...]], gaits: dict[str, dict[str, Any]]) -> str:
    lines = [["measure", "unit", "must", "goal", *(f"`{Path(gait).stem}`" for gait in gaits)]]
    lines += [["---"] * len(lines[0])]
    lines += [[*bar, *(_cell(found["verdicts"][k]) for found in gaits.values())] for k, bar in enumerate(bars)]
    lines.append(["fells it", f"of {RUNS}", "", "", *(_fells(found["felled_by"]) for found in gaits.values())])
    return _markdown(lines)


def _takes_speed(found: dict[str, Any]) -> bool:
    return any("speed" in one["command"] for one in found["commanded"])


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
    return one["name"], one["unit"], _ends(one["must"]), _ends(one["goal"])


def _ends(ends: Sequence[float | None]) -> str:
    low, high = ends
    if low is None:
        return f"up to {high:g}"
    return f"{low:g} or more" if high is None else f"{low:g} to {high:g}"


def _cell(one: dict[str, Any]) -> str:
    note = str(one["note"])
    if one["value"] is None:
        return f"{note or 'falls'} (missed)" if one["reached"] == "missed" else note or "-"
    told = {"goal": "", "must": "", "does not count": " (void)", "no judge": " (no judge)"}
    return f"{one['value']:.3g}" + told.get(one["reached"], " (missed)")


def _fells(by: dict[str, int]) -> str:
    return ", ".join(f"{what} {number}" for what, number in by.items() if number) or "none of these"


def main() -> int:
    """Judge, and write the table; 1 if a gait could not be judged."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("sources", nargs="+", help="names of scenes, or files of scenes and policies")
    parser.add_argument("-o", "--output", type=Path, required=True, help="Markdown file")
    parser.add_argument("--device", help="as of warpmuscle judge")
    parser.add_argument("--pushes", type=int, help="as of warpmuscle judge")
    given = parser.parse_args()
    further = [
        word
        for name in ("device", "pushes")
        if (value := getattr(given, name)) is not None
        for word in (f"--{name}", str(value))
    ]
    folder = given.output.with_suffix(".judged")
    folder.mkdir(parents=True, exist_ok=True)
    found: dict[str, dict[str, Any]] = {}
    failed = []
    for source in given.sources:
        one = judged(source, folder, further)
        if one is None:
            failed.append(source)
        else:
            found[source] = one
        if found:
            given.output.write_text(table(found))
    if failed:
        print(f"could not be judged: {', '.join(failed)}; the errors are above", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
