"""What a browser may send to a viewer: new values of its controls, within their bounds, and where its camera is."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import msgspec

LARGEST = 1 << 16  # bytes of a message
MEASURES = 1e9  # greatest number that a camera says
Value = bool | float | str


class _Updates(msgspec.Struct, forbid_unknown_fields=True):
    value: bool | int | float | str


class _Control(msgspec.Struct, tag_field="type", tag="GuiUpdateMessage", forbid_unknown_fields=True):
    """A control was used."""

    uuid: str
    updates: _Updates


class _Camera(msgspec.Struct, tag_field="type", tag="ViewerCameraMessage", forbid_unknown_fields=True):
    """The camera was moved."""

    wxyz: tuple[float, float, float, float]
    position: tuple[float, float, float]
    fov: float
    near: float
    far: float
    image_height: float
    image_width: float
    look_at: tuple[float, float, float]
    up_direction: tuple[float, float, float]


_decoder = msgspec.msgpack.Decoder(_Control | _Camera)


def checked(raw: str | bytes, control_of: Callable[[str], Any]) -> bytes | None:
    """A message of the same meaning that can do no harm; None if there is none.

    Args:
        control_of: viser's handle of the control with an identifier, or None.
    """
    try:
        message = _decoder.decode(raw.encode() if isinstance(raw, str) else raw)
    except (msgspec.MsgspecError, ValueError, OverflowError, RecursionError):
        return None
    if isinstance(message, _Control):
        control = control_of(message.uuid)
        value = None if control is None else bounded(control, message.updates.value)
        if value is None:
            return None
        message.updates.value = value
    elif not all(abs(number) <= MEASURES for number in _numbers(message)):  # not so for what is no number
        return None
    return msgspec.msgpack.encode(message)


def bounded(control: Any, value: Value) -> Value | None:
    """The value that a control takes for one that was sent: the nearest of a slider; None if it takes no such one."""
    if getattr(control, "disabled", False):
        return None
    options = getattr(control, "options", None)
    if options is not None:
        return value if isinstance(value, str) and value in options else None
    if isinstance(control.value, bool):
        return value if isinstance(value, bool) else None
    if isinstance(value, bool | str) or not math.isfinite(value):
        return None
    return min(max(float(value), float(control.min)), float(control.max))


def _numbers(camera: _Camera) -> list[float]:
    found: list[float] = []
    for value in msgspec.structs.astuple(camera):
        found += value if isinstance(value, tuple) else [value]
    return found
