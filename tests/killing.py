"""Ends a run at any of its accesses to the disk, as a kill of the process would."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

FUNCTIONS = {name: getattr(os, name) for name in ("fsync", "replace", "ftruncate", "write", "unlink")}


class Killed(BaseException):
    """Stands for the end of the process, of which no code takes notice."""


@contextmanager
def killed_at(moment: int) -> Iterator[list[bool]]:
    """Run what is inside up to that access to the disk, counted from 1; the list then holds whether it got that far."""
    calls, killed = 0, []

    def killing(name):
        def function(*arguments, **named):
            nonlocal calls
            calls += 1
            if calls == moment:
                raise Killed
            return FUNCTIONS[name](*arguments, **named)

        return function

    with pytest.MonkeyPatch.context() as patch:
        for name in FUNCTIONS:
            patch.setattr(os, name, killing(name))
        try:
            yield killed
        except Killed:
            killed.append(True)
