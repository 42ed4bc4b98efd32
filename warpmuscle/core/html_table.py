"""Tables that notebooks show."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence


def html_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in HTML, all of whose texts are taken as plain text."""
    head = "".join(f'<th style="text-align:left">{html.escape(text)}</th>' for text in headings)
    lines = (
        "".join(f'<td style="text-align:left">{html.escape(text)}</td>' for text in row)  # whatever a scene says
        for row in rows
    )
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
