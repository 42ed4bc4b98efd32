"""Tables of texts, as they are printed and written: a row of heads, then a row each."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from warpmuscle.core.files import check_output, replace_file

Row = Sequence[str]
SUFFIXES = (".csv", ".md", ".json")


def aligned(rows: Sequence[Row], texts: int = 1) -> list[str]:
    """Lines of a table in columns, the first few of them texts, the others numbers."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [
            f"{cell:{width}}" if k < texts else f"{cell:>{width}}"
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    return lines


def markdown(rows: Sequence[Row]) -> str:
    """A table in Markdown."""
    head, *body = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in (head, ["---"] * len(head), *body))


def check_table(path: Path | None) -> None:
    """Raise Error, before the work, if a table cannot be written to a file."""
    if path is not None:
        check_output(path, "a table", SUFFIXES)


def write(path: Path, rows: Sequence[Row], numbers: Mapping[str, Any]) -> None:
    """Write the table as `.csv` or `.md`, or all numbers as `.json`, where null stands for what is infinite."""
    if path.suffix.lower() == ".json":
        replace_file(path, json.dumps(numbers, indent=1, allow_nan=False) + "\n")
    elif path.suffix.lower() == ".md":
        replace_file(path, markdown(rows))
    else:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(rows)
        replace_file(path, text.getvalue())
