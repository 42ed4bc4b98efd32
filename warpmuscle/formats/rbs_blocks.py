"""What files of `.rbs` are read into, and lines of their blocks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from warpmuscle.formats.lines import Line, Lines
from warpmuscle.scene import Character, Ground, InitialState
from warpmuscle.scene.joints import TYPES

Triple = tuple[float, float, float]

JOINTS = {entry.keyword: entry for entry in TYPES.values() if entry.keyword}
OPENINGS = ("RigidBody", "A_RigidBody", "ArticulatedFigure", "Muscle", *JOINTS)
UNKNOWN = "unknown keyword"
MISPLACED = "has no meaning here"


@dataclass
class Contents:
    """What a file holds."""

    character: Character | None = None
    initial: InitialState = field(default_factory=InitialState)  # of the root
    ground: Ground | None = None
    driven: dict[str, Line] = field(default_factory=dict)  # joints marked `actuationType muscle`


def attributes_of(opening: Line, end: str, lines: Lines) -> Iterator[Line]:
    """Lines of a block that holds no other; unknown ones are listed as ignored."""
    for line in lines.block(opening, end):
        if line.keyword in OPENINGS or line.keyword.startswith("/"):
            raise line.error(f"`{line.keyword}` within a {opening.keyword}; is `{end}` missing?")
        if line.keyword:
            yield line
        else:
            line.ignore(lines.notes, UNKNOWN)


def triple_of(values: Iterator[float] | tuple[float, ...] | list[float]) -> Triple:
    x, y, z = values
    return x, y, z
