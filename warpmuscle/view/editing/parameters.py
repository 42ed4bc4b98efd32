"""Sliders of a scene's free parameters, with the names and in the units that people know."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import Parameter
from warpmuscle.view.controls import Slider
from warpmuscle.view.editing.names import called, shown_unit


class ParameterSliders:
    """A slider for each free parameter whose bounds leave it room.

    Attributes:
        sliders: by the name of the parameter, in the order of the scene.
    """

    def __init__(self, scene: Scene, parameters: Sequence[Parameter], change: Callable[[str, float], None]) -> None:
        """Make them; `change` is called with a parameter's name and its new value, in the unit of the scene."""
        self.sliders: dict[str, Slider] = {}
        self._factors: dict[str, float] = {}
        for one in parameters:
            low, high = float(one.min), float(one.max)
            if not high > low:
                continue
            of, (unit, factor) = called(tuple(one.name.split(".")), scene), shown_unit(one.unit)
            self._factors[one.name] = factor
            self.sliders[one.name] = Slider(
                of.full, low * factor, high * factor, float(one.value) * factor, _changing(change, one.name, factor),
                unit, one.name, "Parameters", of.group, one.step * factor,
            )  # fmt: skip

    def follow(self, values: Mapping[str, float]) -> None:
        """Show other values, in the units of the scene; sliders that were moved farther reach farther now."""
        for name, slider in self.sliders.items():
            if name in values:
                value = values[name] * self._factors[name]
                slider.min, slider.max, slider.value = min(slider.min, value), max(slider.max, value), value


def _changing(change: Callable[[str, float], None], name: str, factor: float) -> Callable[[float], None]:
    def changed(value: float) -> None:
        change(name, value / factor)

    return changed
