"""What ends a program from outside interrupts it as Ctrl-C does."""

import signal
import sys

import pytest

from patience import until
from warpmuscle.core import interruption
from warpmuscle.core.interruption import ENDING, end_as_by_ctrl_c, interruption_noticed, received, repeat_swallowed


@pytest.fixture(autouse=True)
def handlers(monkeypatch: pytest.MonkeyPatch):
    """Handlers as a program begins with, and as they were afterwards."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, *ENDING)}
    for number in ENDING:
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    monkeypatch.setattr(interruption, "_received", [])
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", ENDING)
def test_the_first_request_to_end_interrupts_and_the_next_are_ignored(number: int):
    end_as_by_ctrl_c()
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(number)
    signal.raise_signal(signal.SIGTERM)
    assert received() == number


def test_a_hangup_that_nohup_ignores_stays_ignored():
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    end_as_by_ctrl_c()
    signal.raise_signal(signal.SIGHUP)
    assert received() == 0


@pytest.mark.parametrize("number", [signal.SIGINT, *ENDING])
def test_where_something_must_come_to_its_end_the_first_is_only_noticed(number: int):
    end_as_by_ctrl_c()
    with interruption_noticed() as interrupted:
        assert not interrupted()
        signal.raise_signal(number)
        assert interrupted()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert received() == (0 if number == signal.SIGINT else number)


def test_an_interruption_that_is_ignored_in_the_background_of_a_script_stays_ignored():
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with interruption_noticed() as interrupted:
        signal.raise_signal(signal.SIGINT)
        assert not interrupted()


class Interrupted:
    """Interrupts while it is deleted, where Python swallows what is raised."""

    def __del__(self) -> None:
        signal.raise_signal(signal.SIGINT)


def interrupted_in_vain() -> None:
    Interrupted()
    until(lambda: False)


def test_an_interruption_that_python_swallows_comes_again(monkeypatch: pytest.MonkeyPatch):
    others = []
    monkeypatch.setattr(sys, "unraisablehook", others.append)
    repeat_swallowed()
    with pytest.raises(KeyboardInterrupt):
        interrupted_in_vain()
    assert others == []


def test_other_errors_that_python_swallows_are_told_as_before(monkeypatch: pytest.MonkeyPatch):
    class Faulty:
        def __del__(self) -> None:
            raise ValueError

    others = []
    monkeypatch.setattr(sys, "unraisablehook", lambda told: others.append(told.exc_type))
    repeat_swallowed()
    Faulty()
    assert others == [ValueError]
