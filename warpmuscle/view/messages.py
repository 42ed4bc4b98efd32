"""What a page may send to a viewer: that a control, by its number, has a value, that the scene is edited, a push."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import msgspec

from warpmuscle.core.limits import GREATEST_NUMBER

LARGEST = 1 << 12  # bytes of a message
LONGEST = 1000  # letters of a value
PAGES = 64  # whose messages are counted
NaturalNumber = Annotated[int, msgspec.Meta(ge=0, le=1 << 53)]  # that JavaScript counts without an error


class Counted(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    """Which message of which page it is: from 1 on, and a number that the page has drawn; 0 where it does not count."""

    page: NaturalNumber = 0
    count: NaturalNumber = 0


class Used(Counted, forbid_unknown_fields=True):
    """A control was used; whether it takes the value is the control's to say."""

    control: int
    value: bool | int | float | str


class Edit(Counted, forbid_unknown_fields=True):
    """A change of the scene's numbers; whether it can be made is for `view.editor` to say.

    Attributes:
        edit: number: gives it a value, or back its own. move, insert, remove: a point of a curve; straighten: gives a
            curve back its own points. back: gives all back. save: asks for the scene as a file,
            settings: for the changes as options of a command, points: for a curve as TOML.
        target: the number or the curve. point: of the curve, or before which one a new one comes.
        at: place of a point, along phase or time. value: its value, or the number's.
    """

    edit: Literal[
        "number", "move", "insert", "remove", "straighten", "back", "undo", "redo", "save", "settings", "points"
    ]
    target: int = 0
    point: int = 0
    at: float | None = None
    value: float | None = None


class Pushed(Counted, forbid_unknown_fields=True):
    """The body was pushed by hand, by an impulse in the world, N s."""

    push: tuple[float, float, float]


class Heard:
    """How many messages of each page were used: by this it knows what it is told that is older than its words."""

    def __init__(self) -> None:
        self._counts: dict[int, int] = {}

    def note(self, message: Counted) -> None:
        """A message was used, or refused."""
        if message.page:
            self._counts[message.page] = max(self._counts.pop(message.page, 0), message.count)
            while len(self._counts) > PAGES:
                del self._counts[next(iter(self._counts))]

    def for_page(self) -> dict[str, Any]:
        """What pages are told of it."""
        return {"heard": dict(self._counts)} if self._counts else {}


_decoder = msgspec.json.Decoder(Used)
_edits = msgspec.json.Decoder(Edit)
_pushes = msgspec.json.Decoder(Pushed)


def read_message(raw: str | bytes, controls: int) -> Used | None:
    """What a page says of one of so many controls; None for all else."""
    try:
        message = _decoder.decode(raw)
    except (msgspec.MsgspecError, ValueError, OverflowError, RecursionError):
        return None
    too_long = isinstance(message.value, str) and len(message.value) > LONGEST
    return message if 0 <= message.control < controls and not too_long else None


def read_edit(raw: str | bytes) -> Edit | None:
    """What a page says of the scene's numbers; None for all else."""
    try:
        return _edits.decode(raw)
    except (msgspec.MsgspecError, ValueError, OverflowError, RecursionError):
        return None


def read_push(raw: str | bytes) -> Pushed | None:
    """What a page says of a push by hand, of finite numbers; None for all else."""
    try:
        message = _pushes.decode(raw)
    except (msgspec.MsgspecError, ValueError, OverflowError, RecursionError):
        return None
    return message if all(math.isfinite(number) and abs(number) <= GREATEST_NUMBER for number in message.push) else None
