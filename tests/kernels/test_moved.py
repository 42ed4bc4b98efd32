"""Modules of kernels answer to the names that they had before they lay in rooms, with a warning of the new one."""

import importlib
import sys
from pathlib import Path

import pytest

from warpmuscle.kernels import moved


@pytest.mark.parametrize("name", sorted(moved.ROOM_OF))
def test_a_module_is_found_by_the_name_that_it_had(name: str):
    now = importlib.import_module(f"warpmuscle.kernels.{moved.ROOM_OF[name]}.{name}")
    if name in moved.ROOMS:  # a room has that name: it answers for the module
        room = importlib.import_module(f"warpmuscle.kernels.{name}")
        public = next(key for key, value in vars(now).items() if getattr(value, "__module__", "") == now.__name__)
        assert getattr(room, public) is getattr(now, public)
        return
    former = f"warpmuscle.kernels.{name}"
    sys.modules.pop(former, None)
    with pytest.warns(DeprecationWarning, match=f"^{former} is {now.__name__} now$"):
        assert importlib.import_module(former) is now
    assert now.__spec__ is not None
    assert now.__spec__.name == now.__name__


@pytest.mark.parametrize(("former", "now"), moved.RENAMED.items())
def test_a_renamed_module_is_found_with_the_name_of_what_it_has(former: str, now: str):
    sys.modules.pop(former, None)
    with pytest.warns(DeprecationWarning, match=f"^{former} is {now} now$"):
        module = importlib.import_module(former)
    assert module is importlib.import_module(now)
    with pytest.warns(DeprecationWarning, match="is called batch_scene now"):
        assert module.together is module.batch_scene


def test_names_that_were_never_there_are_not_found():
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("warpmuscle.kernels.nothing")
    room = importlib.import_module("warpmuscle.kernels.muscle")
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        _ = room.nothing


def test_rooms_are_small_enough_to_look_through():
    root = importlib.import_module("warpmuscle.kernels").__path__[0]
    folders = {Path(root), *(path.parent for path in Path(root).rglob("*.py"))}
    assert {folder.name: n for folder in folders if (n := len(list(folder.glob("*.py")))) > 21} == {}
