"""What is said now and then ends with the work, whenever that ends."""

import threading

from patience import PATIENCE, until
from warpmuscle.core.repeating import Repeating


def test_it_is_said_again_and_again_and_not_after_the_end():
    said = []
    repeating = Repeating(lambda: said.append(1), lambda: 0.0)
    until(lambda: len(said) > 2)
    repeating.end(lambda: said.append("last"))
    assert said[-1] == "last"
    repeating.end()
    assert said.count("last") == 1
    assert said[-1] == "last"


def test_the_end_waits_for_what_is_just_said():
    begun, go_on, said = threading.Event(), threading.Event(), []

    def say() -> None:
        begun.set()
        go_on.wait(PATIENCE)
        said.append("a line")

    repeating = Repeating(say, lambda: 0.0)
    assert begun.wait(PATIENCE)
    ending = threading.Thread(target=repeating.end, args=(lambda: said.append("last"),))
    ending.start()
    go_on.set()
    ending.join(PATIENCE)
    assert said[-2:] == ["a line", "last"]


def test_the_pause_is_asked_for_before_each_time():
    pauses, said = [], []
    repeating = Repeating(lambda: said.append(len(pauses)), lambda: pauses.append(0.0) or 0.0)
    until(lambda: len(said) > 2)
    repeating.end()
    assert said[:3] == [1, 2, 3]
