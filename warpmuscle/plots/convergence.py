"""How the cost fell during a search."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import number_of
from warpmuscle.plots import learning_curve
from warpmuscle.plots.style import GRAY, PALETTE, grid, heading
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.results.records import Evaluations, Fit, History, Result

_MARGIN = 1.6  # the axis ends at so many times the greatest cost worth showing


def draw(subject: Subject) -> Any:
    """Costs of the candidates and the least so far, a panel a stage, and how widely the searches still sample."""
    evaluations, searched = subject.result.evaluations, subject.result.searched
    if evaluations is None and subject.result.learned is not None:
        return learning_curve.draw(subject, subject.result.learned)
    if evaluations is None and subject.result.fit is not None:
        return _of_fit(subject, subject.result.fit)
    if evaluations is None or len(evaluations) == 0:
        raise Absent(f"{subject.source} holds no search; `warpmuscle optimize` writes files that do")
    stages = [int(k) for k in np.unique(evaluations.stage)]
    has_spread = searched is not None and len(searched.history.generation) > 1
    figure, panels = grid(len(stages) + has_spread, 2, 2.6)
    for axes, stage in zip(panels, stages, strict=False):
        title = f"Stage {stage + 1}: {searched.stages[stage].name}" if searched and searched.stages else "Cost"
        if subject.result.is_brief:
            _generations(axes, subject.result)
        else:
            _costs(axes, evaluations.rows(evaluations.stage == stage), subject.scene.objective.failure_cost)
        axes.set(title=title, xlabel="candidates evaluated", ylabel="cost (unit of the objective)")
    if has_spread:
        assert searched is not None
        _spread(panels[-1], searched.history)
    best = subject.result.best
    note = f"{number_of(subject.result.evaluated, 'candidate')}" + (
        f", lowest cost {best.cost:.6g}" if best is not None else ""
    )
    if searched is not None:
        note += "" if searched.stages else f"; {searched.options.searches} x {searched.options.strategy}"
        note += f"; ended: {searched.ended}" if searched.ended else ""
    heading(figure, f"{subject.scene.name}: convergence", note)
    return figure


def _of_fit(subject: Subject, fit: Fit) -> Any:
    """What the fit of each joint lacks after every stage: the median of all motions, and the worst one."""
    figure, panels = grid(len(fit.joints), 3, 2.9, sharey=True)
    stages = np.arange(len(fit.stages))
    lacking = np.maximum(1.0 - fit.r2, 1e-6)
    for k, (axes, joint) in enumerate(zip(panels, fit.joints, strict=True)):
        if lacking.shape[1] > 1:
            axes.plot(stages, lacking[:, :, k].max(axis=1), ".--", color=PALETTE[1], label="worst motion")
        axes.plot(stages, np.median(lacking[:, :, k], axis=1), "o-", color=PALETTE[0], label="median of the motions")
        axes.axhline(1.0, color=GRAY, lw=0.6, zorder=0)
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.set_xticks(stages, fit.stages, rotation=30, ha="right")
        axes.set(title=joint, xlabel="stage of the fit", ylabel="1 - r2 of the angle (1)" if k == 0 else "")
    handles = panels[0].get_legend_handles_labels()
    if len(handles[1]) > 1:
        figure.legend(*handles, loc="outside lower center", ncols=2)
    count = lacking.shape[1]
    note = f"{number_of(count, 'motion')}, {fit.seconds[-1]:.1f} s; at 1 no better than the mean angle"
    heading(figure, f"{subject.scene.name}: convergence of the fit", note)
    return figure


def _costs(axes: Any, evaluations: Evaluations, failure_cost: float) -> None:
    """Every candidate as a dot, failures at the upper edge; the least cost so far, and of each search."""
    cost, count = evaluations.cost.astype(float), np.arange(1, len(evaluations) + 1)
    least = np.minimum.accumulate(cost)
    worth = cost[cost < failure_cost] if np.any(cost < failure_cost) else cost
    bottom = float(least[-1])
    top = max(_MARGIN * float(np.percentile(worth, 98)), bottom + (0.1 * abs(bottom) or 1.0))
    log = bottom > 0.0 and top > 5.0 * bottom
    beyond = cost > top
    axes.plot(count[~beyond], cost[~beyond], ".", color="#BBBBBB", ms=2.5, label="candidate", rasterized=True)
    searches = [k for k in np.unique(evaluations.search) if k >= 0]
    if 1 < len(searches) <= len(PALETTE) + 5:
        for k in searches:
            own = evaluations.search == k
            axes.plot(count[own], np.minimum.accumulate(cost[own]), color=PALETTE[5], lw=0.8, drawstyle="steps-post",
                      label="least of each search" if k == searches[0] else None)  # fmt: skip
    axes.plot(count, least, color=PALETTE[0], lw=1.8, drawstyle="steps-post", label="least so far")
    if log:
        from matplotlib.ticker import LogFormatter, LogLocator

        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter(LogFormatter(minor_thresholds=(9.0, 9.0)))
        axes.yaxis.minorticks_off()
        span = (bottom / 1.1, top)
    else:
        span = (bottom - 0.05 * (top - bottom), top)
    axes.set_ylim(*span)
    if np.any(beyond):
        axes.plot(count[beyond], np.full(beyond.sum(), span[1]), "|", color=PALETTE[1], ms=4.0, mew=0.6, clip_on=False,
                  label=f"{beyond.sum()} above", rasterized=True)  # fmt: skip
    axes.set_xlim(0, len(cost) + 1)
    axes.legend(loc="upper right", ncols=2, handlelength=1.2, markerscale=1.6, frameon=True, edgecolor="none")


def generations_of(result: Result) -> tuple[Floats, Floats]:
    """Candidates up to the end of each generation, about, and the least cost of each: of a brief result."""
    assert result.searched is not None
    least = result.searched.history.best
    return result.evaluated * np.arange(1, len(least) + 1) / max(len(least), 1), np.asarray(least, dtype=float)


def _generations(axes: Any, result: Result) -> None:
    """The least cost so far and the median, by generation: of a result without most of its candidates."""
    assert result.searched is not None
    count, least = generations_of(result)
    if not len(count):
        return
    median = np.asarray(result.searched.history.median, dtype=float)
    axes.plot(count, median, ".", color="#BBBBBB", ms=3.0, label="median of a generation")
    axes.plot(count, np.minimum.accumulate(least), color=PALETTE[0], lw=1.8, drawstyle="steps-post",
              label="least so far")  # fmt: skip
    bottom = float(least.min())
    height = _MARGIN * max(float(np.percentile(least, 98)) - bottom, 0.1 * abs(bottom), 1e-9)
    axes.set_ylim(bottom - 0.05 * height, bottom + height)  # medians of generations that mostly fell are far above
    axes.set_xlim(0, result.evaluated + 1)
    axes.legend(loc="upper right", frameon=True, edgecolor="none")


def _spread(axes: Any, history: History) -> None:
    """How widely each search samples, over its generations; a line ends where its stage does."""
    for stage in np.unique(history.stage):
        for k in np.unique(history.search):
            own = (history.search == k) & (history.stage == stage)
            axes.plot(
                history.generation[own],
                history.spread[own],
                color=PALETTE[2],
                lw=0.9,
                alpha=0.8,
                marker="." if own.sum() == 1 else None,
            )
    axes.set_ylim(bottom=0.0)
    axes.set(title="Spread of the candidates", xlabel="generation", ylabel="standard deviation\n(part of the interval)")
    axes.locator_params(axis="x", integer=True)
    axes.annotate("a line a search", (1.0, 1.0), xycoords="axes fraction", ha="right", va="top", color=GRAY, size=8.0)
