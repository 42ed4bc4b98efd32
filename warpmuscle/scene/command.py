"""What is asked of a character while it moves, such as a speed; numbers of the scene follow it, see `number.Free`."""

from __future__ import annotations

from warpmuscle.scene.part import Part


class Command(Part):
    """A number that a user gives at run time. Numbers of the scene with `per` follow it.

    Its unit is its own: that of `min`, `max`, `reference` and `value`.
    """

    reference: float  # where numbers that follow it have their own value
    min: float
    max: float
    value: float | None = None  # what is asked for; by default the reference
    unit: str = ""  # such as "m/s" or "deg"
    description: str = ""

    @property
    def asked(self) -> float:
        """The value, or the reference."""
        return self.reference if self.value is None else self.value
