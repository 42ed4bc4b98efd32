"""Files read and written whole, with errors in plain words; numbers as text."""

from __future__ import annotations

import contextlib
import math
import os
import secrets
import shutil
import stat
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from warpmuscle.core.errors import Error, ResultError, SceneError
from warpmuscle.core.limits import check_size

NOT_REGULAR = "this is a pipe or a device, not a file"


def unreadable(error: Exception) -> str:
    """Why a file could not be read or written, in plain words."""
    if isinstance(error, FileNotFoundError):
        return "there is no such file or folder"
    if isinstance(error, IsADirectoryError):
        return "this is a folder, not a file"
    if isinstance(error, OSError) and error.strerror:
        return f"cannot be opened: {error.strerror.lower()}"
    return f"cannot be opened: {error}"


def read_file(path: str | Path, limit: str = "text") -> bytes:
    """The content of a file.

    Args:
        limit: name of the limit of its size, see `limits.py`.

    Raises:
        OSError: it cannot be read, or is a pipe or a device, which may have no end; see `unreadable`.
        ValueError: no file can have this name. SceneError: it is too large.
    """
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0))
    with open(handle, "rb") as file:
        found = os.fstat(handle)
        if stat.S_ISDIR(found.st_mode):
            raise IsADirectoryError
        if not stat.S_ISREG(found.st_mode):
            raise OSError(0, NOT_REGULAR)
        check_size(limit, found.st_size, lambda text: SceneError(text, file=path))
        return file.read(found.st_size)


def named_file(name: str, folders: Sequence[Path], key: str) -> Path:
    """The file that a scene names by a key, in the first folder that has it, else where it should be in the first one.

    Raises:
        SceneError: no file can have this name.
    """
    if "\0" in name:
        raise SceneError(f"no file can be called {name!r}", key)
    places = [folder / name for folder in folders]
    return next((place for place in places if place.exists()), places[0])


def check_regular(path: str | Path) -> None:
    """Raise OSError if what is to be opened by a library is a pipe or a device, which may have no end."""
    mode = os.stat(path).st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise OSError(0, NOT_REGULAR)


def unwritable(error: Exception) -> str:
    """Why a file could not be written, in plain words."""
    if isinstance(error, FileNotFoundError):
        return "cannot be written: its folder does not exist"
    if isinstance(error, IsADirectoryError):
        return "cannot be written: this is a folder"
    if isinstance(error, NotADirectoryError):
        return "cannot be written: what should be its folder is a file"
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return f"cannot be written: {reason.lower()}"


@contextlib.contextmanager
def replacing(path: Path, suffix: str = "", synchronised: bool = True) -> Iterator[Path]:
    """A name beside `path` for a file to be written within, which takes the place of `path` at the end.

    Args:
        suffix: of that name, for programs that go by it.
        synchronised: whether it is on the disk by then; otherwise a machine that goes down may lose it.

    Raises:
        SceneError: the file cannot be written, or OSError came from within; then `path` is as it was, and nothing is
            left behind.
    """
    temporary = None
    try:
        target = _target(path)
        temporary = target.with_name(f".{target.name}.{secrets.token_hex(4)}{suffix}")
        yield temporary
        if synchronised:
            _synchronise(temporary)
        if target.exists():
            shutil.copymode(target, temporary)
        os.replace(temporary, target)
    except OSError as error:
        raise SceneError(unwritable(error), file=path) from None
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)


def replace_file(path: Path, content: str | bytes, synchronised: bool = True) -> None:
    """Write a file whole or not at all: under another name first, which then takes the place of `path`.

    Args:
        synchronised: see `replacing`.

    Raises:
        SceneError: the file cannot be written; nothing is left behind then.
    """
    replace_files({path: content}, synchronised)


def replace_result(path: str | Path, content: str | bytes) -> None:
    """`replace_file` of what is no scene: ResultError where the file cannot be written."""
    try:
        replace_file(Path(path), content)
    except SceneError as error:
        raise ResultError(f"{path}: {error.message}") from None


def replace_files(contents: Mapping[Path, str | bytes], synchronised: bool = True) -> None:
    """Write several files; none takes its place before all are on the disk.

    Args:
        synchronised: see `replacing`.

    Raises:
        SceneError: one cannot be written; nothing is left behind then.
    """
    with contextlib.ExitStack() as places:
        for path, content in contents.items():
            temporary = places.enter_context(replacing(path, synchronised=False))
            try:
                data = content.encode() if isinstance(content, str) else content
                with open(temporary, "xb") as file:
                    file.write(data)
                    if synchronised:
                        file.flush()
                        os.fsync(file.fileno())
            except (OSError, ValueError) as error:
                raise SceneError(unwritable(error), file=path) from None


def check_writable(path: Path) -> None:
    """Raise SceneError now, rather than after hours of work, if a file of this name cannot be written."""
    try:
        target = _target(path)
        if not target.parent.is_dir():
            raise FileNotFoundError
        trial = target.with_name(f".{target.name}.{secrets.token_hex(4)}")
        with open(trial, "xb"):
            trial.unlink()
    except OSError as error:
        raise SceneError(unwritable(error), file=path) from None


def check_output(path: Path, what: str, endings: Sequence[str]) -> None:
    """Raise Error now, rather than after the work, if something cannot be written to a file of this name.

    Args:
        what: as "a figure", for the message. endings: of names of files that it can be written to, as ".png".
    """
    if path.suffix.lower() not in endings:
        raise Error(f"{path}: {what} is written as {', '.join(endings)}")
    check_writable(path)


def files_beside(output: Path, suffixes: Sequence[str]) -> list[Path]:
    """Files of the output's name that are written beside it, one of each suffix.

    Raises:
        Error: it has such a suffix itself, and would be lost; or one of all cannot be written.
    """
    check_writable(output)
    if output.suffix.lower() in suffixes:
        raise Error(f"{output}: another file of this name is written beside it; name an output that ends in .h5")
    paths = [output.with_suffix(suffix) for suffix in suffixes]
    for path in paths:
        check_writable(path)
    return paths


def _target(path: Path) -> Path:
    """The file that is to be replaced: what a link points to, not the link; raises OSError if no file can be there."""
    try:
        os.fsencode(path)
        target = path.resolve()
        mode = os.stat(target).st_mode if target.exists() else stat.S_IFREG
    except (ValueError, RuntimeError):
        raise OSError(0, "no file can have this name") from None
    if stat.S_ISDIR(mode):
        raise IsADirectoryError
    if not stat.S_ISREG(mode):
        raise OSError(0, NOT_REGULAR)
    return target


def _synchronise(path: Path) -> None:
    """Have a file on the disk."""
    handle = os.open(path, os.O_RDWR | getattr(os, "O_BINARY", 0))
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def shown(number: float) -> str:
    """The shortest text that reads back as the same number, without a needless fraction."""
    number = float(number)
    if number.is_integer() and abs(number) < 1e15 and not (number == 0.0 and math.copysign(1.0, number) < 0.0):
        return str(int(number))
    return repr(number)
