"""Motions of which only some quantities are kept, and those in single precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.arguments import as_texts
from warpmuscle.core.errors import ArgumentError, ResultError
from warpmuscle.core.plain_text import number_of
from warpmuscle.results.recorded_quantities import INTEGER_QUANTITIES, QUANTITIES, is_missing
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result
from warpmuscle.scene.validation.checks import near


def with_less(result: Result, quantities: Sequence[str] | None = None, single: bool = False) -> Result:
    """A result whose motions have less in them, see `reduced`."""
    chosen = None if quantities is None else checked_quantities(quantities)
    return replace(result, replays=tuple(reduced(one, chosen, single) for one in result.replays))


def reduced(motion: Recording, quantities: Sequence[str] | None = None, single: bool = False) -> Recording:
    """The same motion with less in it.

    Args:
        quantities: names of those to keep, all by default; the time is always kept.
        single: floating-point numbers in single precision, but for the time.

    Raises:
        ArgumentError: an unknown name, or a quantity that is missing already.
    """
    kept, gone = checked_quantities(quantities), motion.missing
    if quantities is not None and (wanted := [name for name in kept if name in gone]):
        raise ArgumentError(f"quantities: the motion has no {', '.join(wanted)}")
    changed: dict[str, NDArray[Any]] = {}
    for name in QUANTITIES:
        array = motion[name] if name in (*kept, "time") else motion[name][:0]
        whole = name in INTEGER_QUANTITIES or name == "time"
        changed[name] = array.astype(np.float32) if single and not whole else array
    return motion.changed(**changed)


def demanding(motion: Recording, source: str) -> Recording:
    """The same motion, but where a missing quantity is used it raises ResultError with this source and the quantity.

    Where nothing is missing it is the motion itself.
    """
    if not motion.missing or isinstance(motion, _Demanding):
        return motion
    found = object.__new__(_Demanding)
    found.__dict__.update(motion.__dict__, _source=source)
    return found


def motion_of(result: Result, source: str, replay: int) -> Recording:
    """One motion of a result that was read from a file, see `demanding`.

    Raises:
        ResultError: it has none there, or one without frames.
    """
    if replay >= len(result.replays):
        raise ResultError(f"{source} has {number_of(len(result.replays), 'motion')}, none with number {replay}")
    if not result.replays[replay].frames:
        raise ResultError(f"{source}: its motion {replay} has no frames, as it ended at once")
    return demanding(result.replays[replay], source)


def checked_quantities(quantities: Sequence[str] | None) -> list[str]:
    """Names of quantities in the order of `QUANTITIES`, all if None; raises ArgumentError for an unknown one."""
    if quantities is None:
        return list(QUANTITIES)
    wanted = as_texts(quantities, "quantities")
    for name in wanted:
        if name not in QUANTITIES:
            raise ArgumentError(
                f"quantities: no quantity is called {name!r}{near(name, QUANTITIES)}; there are {', '.join(QUANTITIES)}"
            )
    return [name for name in QUANTITIES if name in wanted]


class _Demanding(Recording):
    """A motion that lacks quantities, and says so where one of them is used."""

    _source: str

    def __getattribute__(self, name: str) -> Any:
        if name in QUANTITIES:
            held = object.__getattribute__(self, "__dict__")
            if is_missing(held[name], len(held["time"])):
                raise ResultError(
                    f"{held['_source']}: the motion has no {name}: it was written without, or its controller has none"
                )
        return object.__getattribute__(self, name)

    def changed(self, **arrays: NDArray[Any]) -> Self:
        plain = object.__new__(Recording)
        plain.__dict__.update({name: value for name, value in self.__dict__.items() if name != "_source"})
        return demanding(plain.changed(**arrays), self._source)  # type: ignore[return-value]
