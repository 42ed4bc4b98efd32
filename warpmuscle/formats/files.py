"""Files read and written whole, with errors in plain words; numbers as text."""

from __future__ import annotations

import contextlib
import math
import os
import secrets
import shutil
from pathlib import Path

from warpmuscle.errors import SceneError


def unreadable(error: Exception) -> str:
    """Why a file could not be read or written, in plain words."""
    if isinstance(error, FileNotFoundError):
        return "there is no such file or folder"
    if isinstance(error, IsADirectoryError):
        return "this is a folder, not a file"
    if isinstance(error, OSError) and error.strerror:
        return f"cannot be opened: {error.strerror.lower()}"
    return f"cannot be opened: {error}"


def unwritable(error: Exception) -> str:
    """Why a file could not be written, in plain words."""
    if isinstance(error, FileNotFoundError):
        return "cannot be written: its folder does not exist"
    if isinstance(error, IsADirectoryError):
        return "cannot be written: this is a folder"
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return f"cannot be written: {reason.lower()}"


def replace_file(path: Path, content: str | bytes) -> None:
    """Write a file whole or not at all: under another name first, which then takes the place of `path`.

    Raises:
        SceneError: the file cannot be written; nothing is left behind then.
    """
    path = path.resolve()  # what a link points to is replaced, not the link
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        if path.is_dir():
            raise IsADirectoryError
        with open(temporary, "xb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            shutil.copymode(path, temporary)
        os.replace(temporary, path)
    except (OSError, ValueError) as error:
        with contextlib.suppress(OSError, ValueError):
            temporary.unlink(missing_ok=True)
        raise SceneError(unwritable(error), file=path) from None


def check_writable(path: Path) -> None:
    """Raise SceneError now, rather than after hours of work, if a file of this name cannot be written."""
    folder = path.resolve().parent
    if path.is_dir():
        raise SceneError(unwritable(IsADirectoryError()), file=path)
    if not folder.is_dir():
        raise SceneError(unwritable(FileNotFoundError()), file=path)
    if not os.access(folder, os.W_OK):
        raise SceneError(unwritable(PermissionError(0, "no permission in its folder")), file=path)


def shown(number: float) -> str:
    """The shortest text that reads back as the same number, without a needless fraction."""
    number = float(number)
    if number.is_integer() and abs(number) < 1e15 and not (number == 0.0 and math.copysign(1.0, number) < 0.0):
        return str(int(number))
    return repr(number)
