"""What became of an instance: numbers that kernels and files use, with their meaning. Without Warp, for all to read.

What tests for a failure stands in `failure.py` and `collision.py`, its limit in `scene.Failure`.
"""

from enum import IntEnum


class Status(IntEnum):
    """Outcome of one simulation; kernels and result files use these numbers."""

    meaning: str  # one line for a user

    RUNNING = 0, "still running: the simulated time is not over"
    COMPLETED = 1, "reached the end of the simulated time"
    FELL = 2, "fell: the centre of mass sank below its limit"
    TURNED = 3, "turned away from its heading by more than its limit"
    TOUCHED = 4, "touched the ground with a body other than the feet"
    DIVERGED = 5, "diverged: a speed exceeded its limit, or a number grew beyond all bounds or was none"
    CROSSED = 6, "crossed its legs: a foot went beyond the other one to its side by more than its limit"
    COLLIDED = 7, "collided with itself: two bodies penetrated each other by more than their limit"

    FAILED = 8, "failed: it met a condition of the scene's own"
    STOPPED = 9, "made no progress: it moved more slowly than its limit"

    def __new__(cls, number: int, meaning: str = "") -> "Status":
        """A member of this number, with a meaning."""
        member = int.__new__(cls, number)
        member._value_ = number
        member.meaning = meaning
        return member

    @property
    def word(self) -> str:
        """The status in one word, such as `fell`."""
        return self.name.lower()
