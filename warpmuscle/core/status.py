"""What became of the instances of a batch, in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from warpmuscle.kernels.status import Status as Status


def words(numbers: Iterable[int]) -> tuple[str, ...]:
    """The status of each instance in a word, from its number."""
    known = {int(status): status.word for status in Status}
    return tuple(known.get(number, f"status {number}") for number in map(int, numbers))


def counted(numbers: Iterable[int]) -> str:
    """How many instances have which status, such as `98 completed, 2 fell`."""
    counts = Counter(words(numbers))
    return ", ".join(f"{count} {word}" for word, count in counts.items())
