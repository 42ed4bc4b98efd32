"""Judge gaits one after another, and write one Markdown table of all of them.

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
    """A row a measure and a column a gait, in Markdown; a value that is missed is marked with a star.

    Nothing that an impossible gait reaches counts, so all of its values have the mark but that of its bodies.
    """
    rows: dict[tuple[str, str], dict[str, str]] = {}
    for gait, found in gaits.items():
        for one in found["verdicts"]:
            rows.setdefault((one["name"], one["unit"]), {})[gait] = _cell(one)
    lines = [["measure", "unit", *gaits], ["---"] * (2 + len(gaits))]
    lines += [[*key, *(cells.get(gait, "") for gait in gaits)] for key, cells in rows.items()]
    lines.append(["fells it", f"of {RUNS}", *(_fells(found["felled_by"]) for found in gaits.values())])
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _cell(one: dict[str, Any]) -> str:
    if one["value"] is None:
        return "falls" if one["reached"] == "missed" else "-"
    return f"{one['value']:.3g}" + ("" if one["reached"] in ("goal", "must") else " *")


def _fells(by: dict[str, int]) -> str:
    return ", ".join(f"{what}: {number}" for what, number in by.items() if number) or "none of these"


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
