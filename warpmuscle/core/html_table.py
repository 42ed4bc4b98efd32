"""Tables that notebooks show, and records of many numbers that say what they hold rather than all of it."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from warpmuscle.core.errors import lacking

LISTED = 6  # names of many that are shown
LONGEST = 80  # letters of a part
WRITES = ("save", "write", "to_csv", "export")  # what is tried to write a table


def html_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in HTML, all of whose texts are taken as plain text."""
    head = "".join(f'<th style="text-align:left">{html.escape(text)}</th>' for text in headings)
    lines = (
        "".join(f'<td style="text-align:left">{html.escape(text)}</td>' for text in row)  # whatever a scene says
        for row in rows
    )
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


class Tabulated:
    """A dataclass of arrays, made with `repr=False`, that shows their shapes and ranges."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}: {what}' for name, what in held_in(self))})"

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Say what to type instead of what is often tried."""
            kind, known = type(self), [one.name for one in fields(self)]
            instead = {}
            if hasattr(kind, "to_dataframe"):
                instead = dict.fromkeys(("plot", "show"), "to_dataframe().plot() draws it")
                instead |= dict.fromkeys(WRITES, "to_dataframe().to_csv('table.csv') writes it")
            found = lacking(kind.__name__, name, [*known, *dir(kind)], instead)
            raise found if ";" in str(found) else AttributeError(f"{found}; it has {', '.join(known)}")

    def _repr_html_(self) -> str:
        """What notebooks show: a line an attribute."""
        return html_table((type(self).__name__, ""), held_in(self))


def held_in(record: Any) -> list[tuple[str, str]]:
    """What the fields of a dataclass hold, by their names."""
    return [(one.name, short_text(getattr(record, one.name))) for one in fields(record)]


def short_text(value: object) -> str:
    """A value in a few words: of an array its shape and range, of many names the first ones."""
    if isinstance(value, np.ndarray) and value.ndim:
        size = " x ".join(map(str, value.shape))
        finite = value[np.isfinite(value)] if value.dtype.kind in "fiu" else np.zeros(0)
        return f"{size} from {finite.min():.4g} to {finite.max():.4g}" if finite.size else size
    if isinstance(value, tuple | list | set | frozenset | dict):
        first = [short_text(one) for one in list(value)[:LISTED]]
        return ", ".join(first) + (f", ... ({len(value)} in all)" if len(value) > len(first) else "") or "none"
    if isinstance(value, float | np.floating):
        return f"{float(value):.4g}"
    text = value if isinstance(value, str) else repr(value)
    return text if len(text) <= LONGEST else type(value).__name__
