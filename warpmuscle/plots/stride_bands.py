"""Curves over the gait cycle of groups of walks, one a seed, before the band that a person's own strides lie in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.plots.style import BAND_COLOR, GRAY, PALETTE, all_handles, cycle_axis, grid, legible, top_legend

LEGEND = 0.3  # in, above all panels
INK = "#202020"


@dataclass(frozen=True)
class Group:
    """Curves of walks that belong together."""

    label: str
    curves: Floats  # (N, 101)
    quiet: bool = False  # drawn as what is left behind


@dataclass(frozen=True)
class Panel:
    """A quantity of a side."""

    title: str
    unit: str
    mean: Floats | None  # (101,) of the person
    spread: Floats | None  # (101,) half the width of the band; None draws the mean alone
    groups: tuple[Group, ...]


def draw_strides(panels: Sequence[Panel], columns: int, person: str, band: str) -> Any:
    """The figure, a panel a quantity; every walk is a thin line, the median of a group a thick one.

    Args:
        person, band: what the legend calls the person's mean and band.
    """
    figure, places = grid(len(panels), columns, 2.05)
    for axes, panel in zip(places, panels, strict=True):
        if panel.mean is not None:
            if panel.spread is not None:
                low, high = panel.mean - panel.spread, panel.mean + panel.spread
                axes.fill_between(PERCENT, low, high, color=BAND_COLOR, lw=0.0, label=band)
            axes.plot(PERCENT, panel.mean, color=INK, lw=1.2, ls=(0, (4, 2)), label=person)
        colored = [group for group in panel.groups if not group.quiet]
        for group in panel.groups:
            color = GRAY if group.quiet else PALETTE[colored.index(group) % len(PALETTE)]
            if not len(group.curves):
                continue
            if len(group.curves) > 1:
                axes.plot(PERCENT, group.curves.T, color=color, lw=0.5, alpha=0.45)
            middle = np.median(group.curves, axis=0)
            axes.plot(PERCENT, middle, color=color, lw=1.2 if group.quiet else 2.0, ls=":" if group.quiet else "-",
                      label=group.label)  # fmt: skip
        axes.axhline(0.0, color=GRAY, lw=0.5, zorder=0)
        axes.set_title(legible(panel.title), size=9.0)
        axes.set_ylabel(panel.unit, size=8.0)
        cycle_axis(axes)
    for axes in places[-columns:]:
        axes.set_xlabel("% of the gait cycle", size=8.0)
    shown = all_handles(places)
    figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - LEGEND / figure.get_figheight()))
    top_legend(figure, list(shown.values()), [legible(text) for text in shown])
    return figure
