"""The page of a study from its table of runs, without their motions: where what is expected has changed since they ran.

For docs/how-to/run-a-study.md.

Measures that the table lacks are not in the page either.

    .venv/bin/python tools/research/study_page.py brace brace.csv -o brace.html --seeds 20 --candidates 6000
"""

import argparse
import csv
from pathlib import Path

from warpmuscle.cli.sweep import study_file
from warpmuscle.core.errors import Error
from warpmuscle.core.files import replace_file
from warpmuscle.report.tables import aligned
from warpmuscle.sweep.plan import Plan, read
from warpmuscle.sweep.study import page as study_page
from warpmuscle.sweep.study.measured import MeasuredRun, StudyResult, _held, _rows


def main() -> None:
    """Write the page and print the study."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=Path, help="file of a study, or the name of a shipped one")
    parser.add_argument("runs", type=Path, help="the table that `warpmuscle study` wrote")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--seeds", type=int, help="as the study was run")
    parser.add_argument("--candidates", type=int, help="as the study was run")
    parser.add_argument("--command", default="", help="what the page says that made the runs")
    given = parser.parse_args()
    options = {} if given.candidates is None else {"candidates": given.candidates}
    plan = read(study_file(given.study), seeds=given.seeds, options=options)
    found = from_table(plan, given.runs)
    replace_file(given.output, study_page.page(found, plan, given.command or f"from {given.runs.name}"))
    rows = study_page.lines(found)
    print("\n".join([*aligned(rows, texts=rows[0].index("unit") + 1), *study_page.held_lines(found)]))


def from_table(plan: Plan, file: Path) -> StudyResult:
    """The study of a plan from the measures of its runs in a table; raises Error if there are others."""
    study = plan.study
    if study is None:
        raise Error(f"{plan.file}: no [study]")
    with file.open(newline="") as stream:
        heads, *lines = csv.reader(stream)
    rows = {line[0]: dict(zip(heads, line, strict=True)) for line in lines}
    if missing := [run.name for run in plan.runs if run.name not in rows]:
        raise Error(f"{file}: has no run {missing[0]!r}; give --seeds as it was run")
    heads = heads[heads.index("walked") + 1 :]
    units = dict(map(_split, heads))
    runs = []
    for run in plan.runs:
        row = rows[run.name]
        measures = {_split(head)[0]: float(row[head]) if row[head] else None for head in heads}
        condition, series = study.condition_of(run.axes), study.series_of(run.axes)
        runs.append(MeasuredRun(run, condition, series, row["walked"] == "yes", measures, units=units))
    table = _rows(study, runs)
    return StudyResult(study, tuple(runs), table, _held(study, table))


def _split(head: str) -> tuple[str, str]:
    """A measure and its unit, of a heading such as `speed (m/s)`."""
    name, bracket, unit = head.rpartition(" (")
    return (name, unit.removesuffix(")")) if bracket else (head, "")


if __name__ == "__main__":
    main()
