"""What the package raises when an input or a request cannot be used."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from pathlib import Path

from warpmuscle.core.plain_text import one_line

LONGEST = 1000  # characters of a message that is shown


class Error(Exception):
    """Base class of all errors that warpmuscle raises on purpose; the message is one line for the user."""

    def __str__(self) -> str:
        return one_line(super().__str__())


class SceneError(Error):
    """A scene, or a file that describes a part of one, cannot be used.

    Attributes:
        message: what is wrong and what to do about it.
        key: path of the value within the scene, such as `character.joints.lHip.parent`; empty if unknown.
        file: the file that was read, None for a scene made in Python.
        line: line in that file, counted from 1; 0 if unknown.
    """

    def __init__(self, message: str, key: str = "", file: str | Path | None = None, line: int = 0) -> None:
        self.message, self.key, self.file, self.line = message, key, file, line
        place = "" if file is None else f"{file}:{line}: " if line else f"{file}: "
        super().__init__(f"{place}{key + ': ' if key else ''}{message}")

    def at(self, file: str | Path, line: int = 0) -> SceneError:
        """A copy of the error with file and line."""
        return SceneError(self.message, self.key, file, line)


class SignalError(Error):
    """A recording of signals, such as EMG, or a request made of it, cannot be used.

    Attributes:
        message: what is wrong and what to do about it.
        channel: name of the signal; empty if it is none in particular.
        file: the file that was read, None for signals made in Python.
        line: line in that file, counted from 1; 0 if unknown.
    """

    def __init__(self, message: str, channel: str = "", file: str | Path | None = None, line: int = 0) -> None:
        self.message, self.channel, self.file, self.line = message, channel, file, line
        place = "" if not file else f"{file}:{line}: " if line else f"{file}: "
        super().__init__(f"{place}{f'channel {channel!r}: ' if channel else ''}{message}")


def shortened(text: str) -> str:
    """A text with its middle left out if it is too long to be read, as a message that quotes a long word may be."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} ... {text[-LONGEST // 2 :]}"


def lacking(thing: str, name: str, known: Iterable[str], instead: Mapping[str, str]) -> AttributeError:
    """What is raised for an attribute that a thing does not have: what to type instead, or the nearest that it has.

    Args:
        thing: in words, such as "a run". known: what it has. instead: what to type, by names that are often tried.
    """
    hint = instead.get(name, "")
    if not hint and not name.startswith("_"):
        found = difflib.get_close_matches(name, [one for one in known if not one.startswith("_")], n=1)
        hint = f"did you mean {found[0]!r}?" if found else ""
    return AttributeError(f"{thing} has no {name!r}" + (f"; {hint}" if hint else ""))


class ArgumentError(Error, ValueError):
    """A function was given something that it cannot use; the text names the argument."""


class Interrupted(Error):
    """A search was interrupted before there was anything new to keep."""


class RolloutError(Error):
    """A batch of simulations cannot do what it was asked for."""


class ResultError(Error):
    """A result file, or a file with a motion, cannot be read or written."""


class ResumeWarning(UserWarning):
    """A search goes on elsewhere than it began: on another processor, or with another version of this program."""


class UnusedParameterWarning(UserWarning):
    """A search leaves free parameters as they are, since nothing uses them."""


class OccupiedError(ResultError):
    """Another process is at work on the same files."""


class CommandWarning(UserWarning):
    """A policy is asked for something outside of what it has learnt."""


class UserPartWarning(UserWarning):
    """A part of the scene's own ended candidates of a search, or is a reward that does not say whether it is earned."""
