"""What a page may send to a viewer: that a control, by its number, was given a value."""

from __future__ import annotations

import msgspec

LARGEST = 1 << 12  # bytes of a message
LONGEST = 1000  # letters of a value


class Used(msgspec.Struct, forbid_unknown_fields=True):
    """A control was used; whether it takes the value is the control's to say."""

    control: int
    value: bool | int | float | str


_decoder = msgspec.json.Decoder(Used)


def read_message(raw: str | bytes, controls: int) -> Used | None:
    """What a page says of one of so many controls; None for all else."""
    try:
        message = _decoder.decode(raw)
    except (msgspec.MsgspecError, ValueError, OverflowError, RecursionError):
        return None
    too_long = isinstance(message.value, str) and len(message.value) > LONGEST
    return message if 0 <= message.control < controls and not too_long else None
