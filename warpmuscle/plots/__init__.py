"""Figures of results; they need matplotlib, the extra `plot` of the package.

A kind of figure is a small file with a function `draw(subject)` that gives a matplotlib figure, and a line in `KINDS`.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from warpmuscle.checks import near
from warpmuscle.errors import Error
from warpmuscle.plots import (
    activation,
    angles,
    convergence,
    dataset,
    feet,
    ground_force,
    joints,
    moment_arms,
    muscle_control,
    parameters,
    stick_figures,
)
from warpmuscle.plots.style import save, style
from warpmuscle.plots.subject import Absent, Choices, Subject
from warpmuscle.records import Result

__all__ = ["KINDS", "Absent", "Choices", "Kind", "Subject", "check_kind", "draw", "plot", "save"]

DATASET = "dataset:"  # before the path of a dataset, in place of a kind


class Kind(NamedTuple):
    """A kind of figure."""

    draw: Callable[[Subject], Any]
    description: str


KINDS: dict[str, Kind] = {
    "sticks": Kind(stick_figures.draw, "stick figures over time, from the side and the front"),
    "angles": Kind(angles.draw, "hip, knee and ankle over the gait cycle beside the norm"),
    "ground_force": Kind(ground_force.draw, "ground forces over the gait cycle in body weights"),
    "feet": Kind(feet.draw, "the feet frame by frame at touch-down and toe-off"),
    "activation": Kind(activation.draw, "muscle activations over the gait cycle, or over time"),
    "control": Kind(muscle_control.draw, "desired torque, excitation and activation about a joint"),
    "joints": Kind(joints.draw, "angles of all joints over time"),
    "moment_arms": Kind(moment_arms.draw, "moment arms of muscles over joint angles"),
    "convergence": Kind(convergence.draw, "cost over the candidates of a search, and their spread"),
    "parameters": Kind(parameters.draw, "candidates of a search between the bounds of each parameter"),
}


def plot(result: Result, kind: str, path: str | Path, choices: Choices | None = None) -> None:
    """Draw a result and write the figure.

    Args:
        result: such as `warpmuscle.read` gives it.
        kind: one of `KINDS`.
        path: file to write; its ending (.png, .svg, .pdf) chooses the format.

    Raises:
        Error: an unknown kind, a result that does not hold what it shows, or the file cannot be written.
    """
    save(draw(Subject(result, choices), kind), path)


def check_kind(kind: str) -> None:
    """Raise Error, which lists what there is, for an unknown kind."""
    if kind not in KINDS and not kind.startswith(DATASET):
        raise Error(f"no figure is called {kind!r}{near(kind, KINDS)}; there are {', '.join(KINDS)}, {DATASET}/PATH")


def draw(subject: Subject, kind: str) -> Any:
    """The matplotlib figure of a kind, or of a dataset by `dataset:` and its path in the subject's file.

    Raises:
        Absent: the result does not hold what the kind shows.
        Error: matplotlib is not installed, an unknown kind, or a choice that the result does not have.
    """
    with style():
        if kind.startswith(DATASET):
            return dataset.draw(subject, kind.removeprefix(DATASET))
        check_kind(kind)
        return KINDS[kind].draw(subject)
