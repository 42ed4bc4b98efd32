"""Files of parameters (.par) as SCONE writes them: a line each with name, best value, mean and standard deviation."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from warpmuscle.core.errors import SceneError, shortened
from warpmuscle.core.files import replace_file
from warpmuscle.core.limits import GREATEST_NUMBER, check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.lines import NUMBER, read_text


class Parameter(NamedTuple):
    """A parameter of a search of SCONE."""

    name: str
    best: float
    mean: float
    std: float
    line: int = 0  # in its file


def read_parameters(path: str | Path) -> dict[str, Parameter]:
    """The parameters of a .par file by name, in its order.

    Raises:
        SceneError: the file cannot be read, or a line of it is no parameter; with file and line.
    """
    path = Path(path)
    found: dict[str, Parameter] = {}
    for number, line in enumerate(read_text(path).splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if len(words) != 4:
            message = f"a line has a name, its best value, mean and spread, not {number_of(len(words), 'word')}"
            raise SceneError(message, file=path, line=number)
        best, mean, std = (_number(word, path, number) for word in words[1:])
        if std < 0.0:
            raise SceneError(f"the spread of {shortened(words[0])} is below 0", file=path, line=number)
        if words[0] in found:
            message = f"{shortened(words[0])} stands in line {found[words[0]].line} already"
            raise SceneError(message, file=path, line=number)
        found[words[0]] = Parameter(words[0], best, mean, std, number)
        check_size("elements", len(found), lambda text, at=number: SceneError(text, file=path, line=at))  # type: ignore[misc]
    if not found:
        raise SceneError("there is no parameter in it", file=path)
    return found


def write_parameters(path: str | Path, parameters: Iterable[Parameter]) -> None:
    """Write a .par file, whole or not at all.

    Raises:
        SceneError: there are none, a name is empty or has blanks, a number is not finite, a spread is below 0, or the
            file cannot be written.
    """
    path = Path(path)
    rows = list(parameters)
    if not rows:
        raise SceneError("there is no parameter to write: none of the free numbers has a name in SCONE", file=path)
    for one in rows:
        if len(one.name.split()) != 1 or one.name.split()[0] != one.name or one.name.startswith("#"):
            raise SceneError(f"{one.name!r} cannot be the name of a parameter: it is one word", file=path)
        if not all(math.isfinite(value) for value in one[1:4]) or one.std < 0.0:
            raise SceneError(f"{one.name} needs finite numbers and a spread of at least 0", file=path)
    width = max((len(one.name) for one in rows), default=0)
    text = "".join(f"{one.name:<{width}}\t{one.best:.8g}\t{one.mean:.8g}\t{one.std:.8g}\t\n" for one in rows)
    replace_file(path, text)


def _number(word: str, path: Path, line: int) -> float:
    value = float(word) if NUMBER.fullmatch(word) else math.nan
    if not abs(value) <= GREATEST_NUMBER:
        raise SceneError(f"{shortened(repr(word))} is not a finite number", file=path, line=line)
    return value + 0.0
