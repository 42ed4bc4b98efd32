"""What the package raises when an input or a request cannot be used."""

from __future__ import annotations

from pathlib import Path


class Error(Exception):
    """Base of every error that warpmuscle raises on purpose; its text is one line, fit for a user."""


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
        super().__init__(" ".join(f"{place}{key + ': ' if key else ''}{message}".split()))

    def at(self, file: str | Path, line: int = 0) -> SceneError:
        """The same error with its place in a file."""
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
        super().__init__(" ".join(f"{place}{f'channel {channel!r}: ' if channel else ''}{message}".split()))


class Interrupted(Error):
    """A search was interrupted before there was anything new to keep."""


class RolloutError(Error):
    """A batch of simulations was asked for something it cannot do."""


class ResultError(Error):
    """A result file, or a file with a motion, cannot be read or written."""


class OccupiedError(ResultError):
    """Another process is at work on the same files."""
