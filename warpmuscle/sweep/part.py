"""Parts of a sweep, each run by a process that knows of no other, on whatever machine; `join` puts them together.

Part k of n has the runs k, k + n, k + 2 n, ... of the sweep file, and a folder of its own, `NAME.part-k-of-n.sweep`
beside the output.
"""

from __future__ import annotations

import contextlib
import re
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.sweep.folder import MANIFEST, Folder
from warpmuscle.sweep.plan import Plan

MOST_PARTS = 1_000_000
_NAMED = re.compile(r"\.part-(\d{1,9})-of-(\d{1,9})\.sweep$", re.ASCII)


class Part(NamedTuple):
    """One of several parts of a sweep."""

    number: int  # from 1
    total: int

    def __str__(self) -> str:
        return f"{self.number}/{self.total}"

    def of(self, plan: Plan) -> Plan:
        """The plan with the runs of this part only; raises Error if it has none."""
        runs = plan.runs[self.number - 1 :: self.total]
        if not runs:
            raise Error(f"{plan.file}: part {self} has no runs; the sweep has {number_of(len(plan.runs), 'run')}")
        return replace(plan, runs=runs)

    def folder(self, output: Path) -> Folder:
        """Where this part keeps its runs."""
        return Folder(output.with_name(f"{output.stem}.part-{self.number}-of-{self.total}.sweep"))


def part_of(text: str) -> Part:
    """A part as users write it, such as 3/40; raises Error if it is none."""
    found = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text, re.ASCII)
    part = Part(*map(int, found.groups())) if found else Part(0, 0)
    if not 1 <= part.number <= part.total <= MOST_PARTS:
        among = f"; the first is 1 to {part.total} here" if 1 <= part.total <= MOST_PARTS else ""
        raise Error(f"part {text!r}: takes two whole numbers, which of how many, such as 3/40{among}")
    return part


def named_part(folder: Path) -> Part | None:
    """Which part a folder is, by its name."""
    found = _NAMED.search(folder.name)
    return Part(int(found[1]), int(found[2])) if found else None


def part_folders(output: Path) -> dict[Part, Folder]:
    """Folders of parts beside the output of a sweep, in order."""
    found = {}
    with contextlib.suppress(OSError):
        for entry in output.absolute().parent.iterdir():
            part = named_part(entry)
            if part is not None and entry.name == part.folder(output).path.name and (entry / MANIFEST).is_file():
                found[part] = Folder(output.with_name(entry.name))
    return dict(sorted(found.items()))
