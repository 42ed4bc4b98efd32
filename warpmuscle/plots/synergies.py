"""Figures of synergies, as figures 7 and 8 of Cruz Ruiz et al. 2015; needs matplotlib, the extra `plot`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.plain_text import number_of
from warpmuscle.plots.style import empty_figure, matplotlib, save
from warpmuscle.synergy.factorization import Account, Synergies
from warpmuscle.synergy.preparation import Activations

# From Okabe and Ito's palette: told apart with any kind of colour vision.
_COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_GREY = "#909090"
_WIDTH, _ROW, _BOTTOM = 11.0, 1.15, 3.0  # inches
_STYLE: Any = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "legend.frameon": False,
}


def draw_synergies(
    path: str | Path, activations: Activations, synergies: Synergies, accounts: Sequence[Account] = ()
) -> None:
    """Draw synergies beside their coefficients over time, and below what they account for.

    Trials stand one after the other; cycles lie upon each other with their mean.

    Args:
        path: file to write; its ending (png, pdf, svg) chooses the format.
        accounts: of other numbers of synergies, for the curve of VAF.

    Raises:
        Error: matplotlib is not installed, or the file cannot be written.
    """
    count = synergies.account.count
    with matplotlib().rc_context(_STYLE):
        figure: Any = empty_figure(figsize=(_WIDTH, 0.9 + _ROW * count + _BOTTOM), layout="constrained")
        upper, lower = figure.subfigures(2, 1, height_ratios=[0.6 + _ROW * count, _BOTTOM])
        panels = upper.subplots(count, 2, sharex="col", squeeze=False, width_ratios=[1.0, 1.7])
        for k in range(count):
            _draw_weights(panels[k, 0], activations.muscles, synergies.weights[:, k], k)
            _draw_coefficients(panels[k, 1], activations, synergies.coefficients[k], k)
        panels[0, 0].set_title("Synergies W")
        panels[0, 1].set_title("Coefficients C(t)")
        panels[-1, 1].set_xlabel(_time_label(activations))
        panels[-1, 0].tick_params(axis="x", labelrotation=90 if len(activations.muscles) > 8 else 0)
        global_axes, muscle_axes = lower.subplots(1, 2, width_ratios=[1.0, 1.7])
        _draw_vaf(global_axes, accounts or (synergies.account,), count)
        _draw_muscle_vaf(muscle_axes, activations.muscles, synergies.account)
        what = f"{number_of(count, 'synergy')} of {number_of(len(activations.muscles), 'muscle')}"
        figure.suptitle(f"{what}: VAF {synergies.account.vaf:.3f}", fontweight="bold", fontsize=12)
        save(figure, path)


def _time_label(activations: Activations) -> str:
    if activations.time_unit == "cycle":
        return "cycle (% of its points)"
    return "time (s)" if len(activations.sources) == 1 else "time, recordings one after the other (s)"


def _draw_weights(axes: Any, muscles: Sequence[str], weights: Any, k: int) -> None:
    axes.bar(range(len(muscles)), weights, color=_COLORS[k % len(_COLORS)], width=0.75)
    axes.set(ylabel=f"$w_{{{k + 1}}}$", ylim=(0.0, 1.05), yticks=[0.0, 0.5, 1.0], xlim=(-0.6, len(muscles) - 0.4))
    axes.set_xticks(range(len(muscles)), muscles)


def _draw_coefficients(axes: Any, activations: Activations, values: Any, k: int) -> None:
    color = _COLORS[k % len(_COLORS)]
    if activations.time_unit == "cycle":
        cycles = [values[activations.trial == number] for number in np.unique(activations.trial)]
        percent = np.arange(len(cycles[0])) * (100.0 / len(cycles[0]))
        for cycle in cycles:
            axes.plot(percent, cycle, color=color, lw=0.8, alpha=0.45)
        axes.plot(percent, np.mean(cycles, axis=0), color=color, lw=2.0)
        axes.set_xlim(0.0, 100.0)
    else:
        offset = 0.0
        for number in np.unique(activations.trial):
            inside = activations.trial == number
            time = activations.time[inside]
            shift = offset - time[0] if offset else 0.0
            axes.plot(time + shift, values[inside], color=color, lw=1.4)
            if offset:
                axes.axvline(offset, color=_GREY, lw=0.6)
            offset = float(time[-1] + shift + time[1] - time[0])
        axes.margins(x=0.0)
    axes.set(ylabel=f"$c_{{{k + 1}}}$", ylim=(0.0, 1.05 * max(1.0, float(values.max()))))


def _draw_vaf(axes: Any, accounts: Sequence[Account], count: int) -> None:
    numbers = [account.count for account in accounts]
    axes.plot(numbers, [account.vaf for account in accounts], "o-", color=_COLORS[0], ms=4, label="all muscles")
    worst = [account.muscle_vaf.min() for account in accounts]
    axes.plot(numbers, worst, "s-", color=_COLORS[1], ms=3.5, lw=1.0, label="worst muscle")
    axes.axvline(count, color=_GREY, lw=0.8, zorder=0)
    axes.set(title="Variance accounted for", xlabel="number of synergies", ylim=(min(0.0, *worst), 1.02))
    axes.set_xticks(numbers)
    axes.legend(loc="lower right")


def _draw_muscle_vaf(axes: Any, muscles: Sequence[str], account: Account) -> None:
    axes.bar(range(len(muscles)), account.muscle_vaf, color=_GREY, width=0.75)
    axes.axhline(account.vaf, color=_COLORS[0], lw=1.0)
    axes.set(title=f"of each muscle by {number_of(account.count, 'synergy')} (line: of all)",
             ylim=(min(0.0, account.muscle_vaf.min()), 1.02), xlim=(-0.6, len(muscles) - 0.4))  # fmt: skip
    axes.set_xticks(range(len(muscles)), muscles, rotation=90 if len(muscles) > 8 else 0)
