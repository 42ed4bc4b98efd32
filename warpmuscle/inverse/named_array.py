"""An array of a result with names along its axes."""

from __future__ import annotations

from typing import Any, NamedTuple


class NamedArray(NamedTuple):
    """An array over time; `over` is the name of its times."""

    name: str
    axes: tuple[str, ...]  # behind time
    units: str
    values: Any
    description: str
    over: str = "time"
