"""Python looks for garbage only once a program has started."""

import gc
from collections.abc import Iterator

import pytest

from warpmuscle import __main__ as program


@pytest.fixture
def collector() -> Iterator[None]:
    threshold, callbacks = gc.get_threshold(), list(gc.callbacks)
    yield
    gc.set_threshold(*threshold)
    gc.callbacks[:] = callbacks
    gc.unfreeze()


@pytest.mark.usefixtures("collector")
def test_garbage_is_first_looked_for_when_much_has_been_made_and_sooner_after_that():
    gc.unfreeze()
    program.collect_late()
    assert gc.get_threshold()[0] == program.MADE
    assert gc.get_freeze_count() == 0
    gc.collect(0)
    assert gc.get_threshold()[0] == program.LATER
    kept = gc.get_freeze_count()
    assert kept > 10_000
    gc.collect(0)
    assert 10_000 < gc.get_freeze_count() <= kept  # some of them may have gone by themselves
