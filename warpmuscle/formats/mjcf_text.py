"""Numbers as attributes of MuJoCo's XML."""

from __future__ import annotations

from collections.abc import Iterable

from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.number import Number


def numbers(values: Iterable[Number]) -> tuple[float, ...]:
    """Numbers of a scene that has no free parameters."""
    return tuple(plain_number(value) for value in values)


def text(value: float) -> str:
    """Shortest text that reads back as the same number."""
    return repr(float(value))


def texts(values: Iterable[float]) -> str:
    """Several numbers in one attribute."""
    return " ".join(text(value) for value in values)
