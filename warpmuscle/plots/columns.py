"""What recordings of people give, such as moments or activations: a panel a quantity, left and right together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.plots.names import curves_named, pairs
from warpmuscle.plots.style import GRAY, SIDE_COLORS, grid, heading, style
from warpmuscle.scene.validation.checks import near

COLUMNS = 4  # of panels
HEIGHT = 1.6  # inches, of a panel
TOP = 0.05  # of a panel's height, above an activation of 1


class Columns(NamedTuple):
    """Quantities over time, by name."""

    what: str
    times: Floats  # (F,) s
    values: dict[str, Floats]  # (F,) each
    units: dict[str, str]


def columns_of(source: Any) -> Columns | None:
    """The columns of a table over time, such as `wm.inverse_dynamics` gives; None of what is none."""
    times = getattr(source, "times", None)
    if not isinstance(times, np.ndarray):
        return None
    what = type(source).__name__
    if callable(columns := getattr(source, "columns", None)):
        return Columns(what, times, dict(columns()), {})
    for values, names in (("values", "names"), ("values", "muscles"), ("activation", "muscles")):
        found, called = getattr(source, values, None), getattr(source, names, None)
        if isinstance(found, np.ndarray) and called is not None and found.shape == (len(times), len(called)):
            units = getattr(source, "units", None) or ["activation" if names == "muscles" else ""] * len(called)
            return Columns(what, times, dict(zip(called, found.T, strict=True)), dict(zip(called, units, strict=True)))
    return None


def draw(table: Columns, kinds: Sequence[str]) -> Any:
    """A panel a quantity and the same of the other side.

    Args:
        kinds: names of quantities, or words in them; all without any.

    Raises:
        Error: no quantity is called so.
    """
    listed = list(table.values)
    wanted: list[str] = []
    for kind in kinds:
        found = curves_named(kind, listed)
        if not found:
            few = ", ".join(listed[:12]) + (", ..." if len(listed) > 12 else "")
            raise Error(f"nothing is called {kind!r}{near(kind, listed)}; there are {few}")
        wanted += found
    rows = pairs(list(dict.fromkeys(wanted)) or listed)
    with style():
        columns = min(COLUMNS, len(rows))
        figure, panels = grid(len(rows), columns, HEIGHT if len(rows) > 1 else 2.0 * HEIGHT, sharex=True)
        for axes, row in zip(panels, rows, strict=True):
            both = row.left != row.right
            for side, name in (("left", row.left), ("right", row.right))[: 1 + both]:
                axes.plot(
                    table.times, table.values[name], color=SIDE_COLORS[side], lw=1.2, label=side if both else None
                )
            unit = table.units.get(row.left, "")
            axes.axhline(0.0, color=GRAY, lw=0.6, zorder=0)
            axes.set(title=row.label, ylabel=unit)
            axes.margins(x=0.0)
            if unit == "activation":
                axes.set_ylim(-TOP, 1.0 + TOP)
        for axes in panels[-columns:]:
            axes.set_xlabel("time (s)")
            axes.tick_params(labelbottom=True)
        paired = next((axes for axes, row in zip(panels, rows, strict=True) if row.left != row.right), None)
        if paired is not None:
            paired.legend()
        heading(figure, f"{table.what} over time")
    return figure
