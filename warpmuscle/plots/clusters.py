"""A figure of the synergies that people have in common; needs matplotlib, the extra `plot`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.plots.style import GRAY, PALETTE, legible, page, save, style
from warpmuscle.synergy.clusters import Clusters

ROW = 1.3  # inches


def draw_clusters(path: str | Path, clusters: Clusters, people: Sequence[str]) -> None:
    """Draw the mean module of each cluster as bars, its members as dots, and beside it which people have it.

    Args:
        people: names of the persons.

    Raises:
        Error: matplotlib is not installed, or the file cannot be written.
    """
    count, muscles = clusters.count, clusters.muscles
    with style():
        figure: Any = page(1.0 + ROW * count)
        panels = figure.subplots(count, 2, sharex="col", squeeze=False, width_ratios=[2.5, 1.0])
        for k in range(count):
            axes, color = panels[k, 0], PALETTE[k % len(PALETTE)]
            members = clusters.modules[:, clusters.label == k]
            axes.bar(range(len(muscles)), clusters.centre[:, k], color=color, width=0.75, alpha=0.8)
            spots = np.linspace(-0.25, 0.25, members.shape[1]) if members.shape[1] > 1 else np.zeros(1)
            for spot, member in zip(spots, members.T, strict=True):
                axes.plot(np.arange(len(muscles)) + spot, member, ".", color=GRAY, ms=3)
            axes.set(ylim=(0.0, 1.05), yticks=[0.0, 0.5, 1.0], ylabel=f"m{k + 1}")
            held = [int(np.sum((clusters.person == p) & (clusters.label == k))) for p in range(len(people))]
            panels[k, 1].bar(range(len(people)), held, color=color, width=0.75)
            panels[k, 1].set(ylim=(0, max(2, *held) + 0.2), yticks=range(max(2, *held) + 1))
        panels[0, 0].set_title("Modules (bars: mean, dots: each person's)")
        panels[0, 1].set_title("how many a person has")
        panels[-1, 0].set_xticks(
            range(len(muscles)), [legible(name) for name in muscles], rotation=90 if len(muscles) > 8 else 0
        )
        panels[-1, 1].set_xticks(range(len(people)), [legible(name) for name in people], rotation=90)
        save(figure, path)
