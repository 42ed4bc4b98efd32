"""What several processes do comes back in order, and few tasks start no processes."""

import os
from functools import partial
from operator import add

import pytest

from warpmuscle.sweep.processes import SHARE, in_processes


def test_many_tasks_are_done_by_several_processes_in_order():
    count = 2 * SHARE + 1
    assert list(in_processes(2, partial(add, 1), range(count))) == list(range(1, count + 1))
    assert os.getpid() not in in_processes(2, _process, range(count))


def test_few_tasks_and_one_process_are_done_here():
    assert set(in_processes(2, _process, range(2 * SHARE - 1))) == {os.getpid()}
    assert set(in_processes(1, _process, range(3 * SHARE))) == {os.getpid()}


def test_what_a_task_raises_is_raised():
    with pytest.raises(TypeError):
        list(in_processes(2, partial(add, ""), range(2 * SHARE)))


def _process(task: int) -> int:
    return os.getpid()
