"""How a policy was learnt: what an episode gains, how long it lasts, how fast it goes, and how the learner did."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.plain_text import number_of
from warpmuscle.plots.style import GRAY, PALETTE, grid, heading
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.results.learned import CURVE, Learned

TITLES = {
    "gain": "Rewards of an episode",
    "upright": "An episode lasts",
    "speed": "Speed",
    "deviation": "Deviation of actions",
    "divergence": "Divergence of policies",
    "value_loss": "Loss of the critic",
}
OF_STANDING = {"speed": ("reward", "Reward of a decision")}  # what is shown instead where nothing goes anywhere
LOGARITHMIC = ("value_loss",)


def draw(subject: Subject, learned: Learned) -> Any:
    """Panels over the decisions that were made; raises Absent where nothing was learnt yet."""
    curve = learned.curve
    if not len(curve["iteration"]):
        raise Absent(f"{subject.source} holds a policy that has learnt nothing yet")
    figure, panels = grid(len(TITLES), 3, 2.4)
    decisions = curve["decisions"] / 1e6
    goes = bool(np.any(curve["speed"]))
    titles = dict(item if goes else OF_STANDING.get(item[0], item) for item in TITLES.items())
    for axes, (name, title) in zip(panels, titles.items(), strict=True):
        values = curve[name]
        log = name in LOGARITHMIC and bool(np.all(values > 0.0))
        axes.plot(decisions, values, color=PALETTE[0], lw=1.2, marker="." if len(values) == 1 else None)
        if log:
            axes.set_yscale("log")
        unit = CURVE[name].unit
        axes.set(title=title, xlabel="decisions (million)", ylabel=unit)
    panels[0].axhline(0.0, color=GRAY, lw=0.6, zorder=0)
    count, wall = int(curve["iteration"][-1]), curve["wall_time"][-1]
    note = f"{number_of(count, 'iteration')}, {decisions[-1]:.3g} million decisions, {wall:.0f} s"
    heading(figure, f"{subject.scene.name}: learning", note + (f"; ended: {learned.ended}" if learned.ended else ""))
    return figure
