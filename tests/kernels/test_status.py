"""What each outcome is called: words that files and messages have."""

import pytest

from warpmuscle.kernels.status import Status


@pytest.mark.parametrize(
    ("number", "word", "begins"),
    [(1, "completed", "reached the end"), (2, "fell", "fell: "), (7, "collided", "collided with itself: ")],
)
def test_a_status_has_its_number_a_word_and_a_meaning(number: int, word: str, begins: str):
    status = Status(number)
    assert (int(status), status.word) == (number, word)
    assert status.meaning.startswith(begins)
