"""Measure some rows of the tables of judged gaits anew, by the long run alone, and write them into the pages.

    python tools/judged_rows.py docs/explanation/gaits.md docs/explanation/gait-tables.md \\
        --rows "maximum braking force" "maximum driving force"

For each column of the pages' tables the gait walks as `warpmuscle judge` has it walk first, 60 s undisturbed; the cells
of these rows become what the motion tells, and rows that a judgement has and a table lacks get their place. All other
rows stay as they are: pushes, slopes, loads and commands are not tried. Rows of a run at 3.5 m/s are measured where a
gait takes that speed. Policies are read from the folder in which the command runs: `warpmuscle example policies`,
`course` and `everyday` write those of both pages.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from judge_table import BESIDES, MEASURE, cell, ends_in_words

from warpmuscle.cli.walkers import walker_of
from warpmuscle.core.shipped import shipped_scenes
from warpmuscle.core.status import Status
from warpmuscle.simulation.perturbations import none
from warpmuscle.studies.hard_trials import run
from warpmuscle.studies.judge import COMMANDED, LONG
from warpmuscle.studies.judge_recording import judge_recording
from warpmuscle.studies.verdicts import AT_RUNNING, FURTHER_RUN, FURTHER_WALK, RUN, WALK, Bar, Verdict

TABLE = re.compile(rf"^\| ({MEASURE}|{BESIDES}) \| unit \| must \| goal \|.*\n(?:\|.*\n)+", re.MULTILINE)
Table = list[list[str]]
Cells = dict[str, dict[str, str]]  # by gait and row


def main() -> int:
    """Measure, and write the pages."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("pages", nargs="+", type=Path, help="Markdown files with tables of judged gaits")
    parser.add_argument("--rows", nargs="+", required=True, help="names of rows")
    parser.add_argument("--device", help="as of warpmuscle judge")
    parser.add_argument("--threads", type=int, help="as of warpmuscle judge")
    given = parser.parse_args()
    known = {bar.name for bars in (WALK, RUN, FURTHER_WALK, FURTHER_RUN) for bar in bars}
    if unknown := [name for name in given.rows if name not in known]:
        parser.error(f"no judgement has the row {unknown[0]!r}; it has {', '.join(sorted(known))}")
    texts = {page: page.read_text("utf-8") for page in given.pages}
    gaits = dict.fromkeys(gait for text in texts.values() for table in tables(text) for gait in table[0][4:])
    if missing := [name for gait in gaits if source_of(name := gait.strip("`")) is None]:
        parser.error(f"neither a shipped scene nor a file here: {', '.join(missing)}; run `warpmuscle example` first")
    cells: Cells = {}
    for number, gait in enumerate(gaits, 1):
        cells[gait] = measured(source_of(gait.strip("`")) or gait, given.rows, given.device, given.threads)
        for page, text in texts.items():  # after each, so that one that is interrupted has not been for nothing
            new = TABLE.sub(lambda found: written(renewed(parsed(found[0]), given.rows, cells)), text)
            page.write_text(new, "utf-8")
        print(f"{number} of {len(gaits)}: {gait}", file=sys.stderr, flush=True)
    return 0


def source_of(gait: str) -> str | None:
    """A gait's policy here, or its scene, shipped or here; None if there is neither."""
    here = next((file for file in (f"{gait}.h5", f"{gait}.toml") if Path(file).exists()), None)
    return here or (gait if gait in shipped_scenes() else None)


def measured(source: str, rows: Sequence[str], device: str | None, threads: int | None) -> dict[str, str]:
    """Cells of these rows, as many as the gait's motion tells."""
    _, walker = walker_of([source], device=device, threads=threads)
    walks = walker.walk(LONG, none(1), record=True)
    judged = judge_recording(walks.recordings[0], walker.scene(), Status(walks.status[0]))
    found = {one.bar.name: one for one in (*judged.verdicts, *judged.further)}
    if set(rows) & set(AT_RUNNING):
        findings = run(walker, COMMANDED, judged.measures)
        found |= {
            name: Verdict(found[name].bar, *finding, void=judged.impossible)
            for name, finding in findings.items()
            if name in found
        }
    return {name: cell(_numbers(found[name])) for name in rows if name in found}


def _numbers(one: Verdict) -> dict[str, Any]:
    return {"value": one.value, "reached": one.reached, "note": one.note}


def tables(text: str) -> list[Table]:
    """Cells of the tables of judged gaits on a page, heads first."""
    return [parsed(found[0]) for found in TABLE.finditer(text)]


def parsed(text: str) -> Table:
    return [[one.strip() for one in line.strip().strip("|").split("|")] for line in text.splitlines()]


def written(table: Table) -> str:
    return "".join(f"| {' | '.join(line)} |\n" for line in table)


def renewed(table: Table, rows: Sequence[str], cells: Cells) -> Table:
    """A table with these rows as the gaits' cells have them, in the order that a judgement has."""
    head, rule, *body = table
    there = {line[0]: line for line in body}
    last = [there.pop("fells it")] if "fells it" in there else []
    order = _order(head[0], there)
    for name in rows:
        bar = next((bar for bar in order if bar.name == name), None)
        of_gaits = [cells.get(gait, {}).get(name) for gait in head[4:]]
        if bar is None or (name not in there and not any(of_gaits)):
            continue
        before = there.get(name, [name, bar.unit, "", "", *("" for _ in of_gaits)])
        new = [one if one is not None else old for one, old in zip(of_gaits, before[4:], strict=True)]
        there[name] = [name, bar.unit, ends_in_words(bar.must), ends_in_words(bar.goal), *new]
    return [head, rule, *(there[bar.name] for bar in order if bar.name in there), *last]


def _order(head: str, there: dict[str, list[str]]) -> tuple[Bar, ...]:
    """Rows of the judgement that has those of a table."""
    kinds = (WALK, RUN) if head == MEASURE else (FURTHER_WALK, FURTHER_RUN)
    return max(kinds, key=lambda bars: len(there.keys() & {bar.name for bar in bars}) - 0.01 * len(bars))


if __name__ == "__main__":
    sys.exit(main())
