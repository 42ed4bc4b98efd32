"""What became of an instance of a batch."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from enum import IntEnum


class Status(IntEnum):
    """Outcome of one simulation; kernels and result files use these numbers."""

    RUNNING = 0
    COMPLETED = 1
    FELL = 2
    TURNED = 3
    TOUCHED = 4
    DIVERGED = 5
    CROSSED = 6
    COLLIDED = 7

    @property
    def meaning(self) -> str:
        """One line for a user."""
        return _MEANINGS[self]

    @property
    def word(self) -> str:
        """The status in one word, such as `fell`."""
        return self.name.lower()


def words(numbers: Iterable[int]) -> tuple[str, ...]:
    """The status of each instance in a word, from its number."""
    known = {int(status): status.word for status in Status}
    return tuple(known.get(number, f"status {number}") for number in map(int, numbers))


def counted(numbers: Iterable[int]) -> str:
    """How many instances have which status, such as `98 completed, 2 fell`."""
    counts = Counter(words(numbers))
    return ", ".join(f"{count} {word}" for word, count in counts.items())


_MEANINGS = {
    Status.RUNNING: "still running: the simulated time has not come to its end",
    Status.COMPLETED: "came to the end of the simulated time",
    Status.FELL: "fell: the centre of mass sank below its limit",
    Status.TURNED: "turned away from its heading by more than its limit",
    Status.TOUCHED: "touched the ground with a body other than the feet",
    Status.CROSSED: "crossed its legs: a foot went beyond the other one to its side by more than its limit",
    Status.COLLIDED: "collided with itself: two bodies penetrated each other by more than their limit",
    Status.DIVERGED: "diverged: a speed exceeded its limit, or a number grew beyond all bounds or was none",
}
