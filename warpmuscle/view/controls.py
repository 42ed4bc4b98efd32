"""What can be moved in a live viewer: sliders, switches, menus and buttons, whose values reach functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from warpmuscle.core.errors import ArgumentError
from warpmuscle.view.packing import encodable

Value = bool | float | str
STEPS = 200  # of a slider


def nothing(_: Any) -> None:
    """What a control does of which nothing was said."""


@dataclass
class Slider:
    """A number between two others.

    Attributes:
        changed: is called with each new value, a finite number within the bounds, by one thread at a time.
        section: heading under which it stands. group: a smaller one, within a section.
    """

    name: str
    min: float
    max: float
    value: float
    changed: Callable[[float], None] = nothing
    unit: str = ""
    hint: str = ""
    section: str = "Commands"
    group: str = ""
    step: float = 0.0  # 0: in 200 steps

    def __post_init__(self) -> None:
        if not (math.isfinite(self.min) and math.isfinite(self.max) and self.min < self.max):
            raise ArgumentError(f"a slider needs two bounds, the second above the first: {self.min}, {self.max}")
        self.value = min(max(float(self.value), self.min), self.max)

    def bounded(self, value: object) -> float | None:
        """The nearest value that it takes, None for what is no number."""
        if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
            return None
        return min(max(float(value), self.min), self.max)

    def for_page(self) -> dict[str, Any]:
        """What the page is sent about it besides its name."""
        step = self.step or (self.max - self.min) / STEPS
        return {
            "min": self.min,
            "max": self.max,
            "step": step,
            "unit": encodable(self.unit),
            "group": encodable(self.group),
        }


@dataclass
class Toggle:
    """A switch."""

    name: str
    value: bool
    changed: Callable[[bool], None] = nothing
    hint: str = ""
    section: str = "Commands"

    def bounded(self, value: object) -> bool | None:
        """The value if it is one."""
        return value if isinstance(value, bool) else None

    def for_page(self) -> dict[str, Any]:
        """What the page is sent about it besides its name."""
        return {}


@dataclass
class Choice:
    """A menu."""

    name: str
    options: Sequence[str]
    value: str
    changed: Callable[[str], None] = nothing
    hint: str = ""
    section: str = "Commands"

    def bounded(self, value: object) -> str | None:
        """The value if it is one of the options."""
        return value if isinstance(value, str) and value in self.options else None

    def for_page(self) -> dict[str, Any]:
        """What the page is sent about it besides its name."""
        return {"options": [encodable(option) for option in self.options]}


@dataclass
class Button:
    """Something to press; it has no value that stays."""

    name: str
    changed: Callable[[bool], None] = nothing
    hint: str = ""
    section: str = "Commands"
    value: bool = field(default=False, init=False)

    def bounded(self, value: object) -> bool | None:
        """True if it was pressed."""
        return True if value is True else None

    def for_page(self) -> dict[str, Any]:
        """What the page is sent about it besides its name."""
        return {}


Control = Slider | Toggle | Choice | Button


def use(control: Control, value: object) -> Value | None:
    """Give a control a value that a page sent: the nearest one that it takes; returns it, or None if there is none."""
    anything: Any = control  # whose own value its function takes
    taken: Value | None = anything.bounded(value)
    if taken is None:
        return None
    if not isinstance(control, Button):
        anything.value = taken
    anything.changed(taken)
    return taken


def for_page(controls: Sequence[Control]) -> list[dict[str, Any]]:
    """What the page is sent about controls, by their number."""
    return [
        {"kind": type(one).__name__.lower(), "name": encodable(one.name), "value": one.value,
         "hint": encodable(one.hint), "section": encodable(one.section), **one.for_page()}
        for one in controls
    ]  # fmt: skip
