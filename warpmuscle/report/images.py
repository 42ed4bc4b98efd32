"""Figures as images within a page, as large as a page has room for."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

from warpmuscle.plots.compact_svg import compact_svg
from warpmuscle.plots.style import picture

ROOM = 850_000  # bytes of a page of less than a megabyte that figures may take
RESOLUTIONS = 130, 90, 60  # dots an inch of a figure that would be too large as lines


def data_uri(drawn: Any) -> str:
    """A figure of matplotlib as the source of an image in a page."""
    return data_uris([drawn])[0]


def data_uris(drawn: Sequence[Any], room: int = ROOM) -> list[str]:
    """Figures of matplotlib as sources of images in a page: as lines, but the largest as dots where room is short.

    Args:
        room: bytes of all of them together.
    """
    found = [_uri("svg+xml", compact_svg(picture(one, ".svg"))) for one in drawn]
    for dots in RESOLUTIONS:
        for k in sorted(range(len(found)), key=lambda k: -len(found[k])):
            if sum(map(len, found)) <= room:
                return found
            found[k] = min(found[k], _uri("webp", picture(drawn[k], ".webp", dots)), key=len)
    return found


def _uri(kind: str, content: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"
