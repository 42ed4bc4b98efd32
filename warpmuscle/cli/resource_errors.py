"""What a machine that has no more memory, disk or files to give makes of a command: one line."""

from __future__ import annotations

import errno

# Of the loader of libraries and of Python's threads, which say so in words only.
_NO_ROOM = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)  # where files are written, their names are in other errors
_WORDS = ("cannot allocate memory", "failed to map segment", "too many open files", "can't start new thread")


def shortage(error: BaseException) -> str | None:
    """What the machine refused, by an error or by what caused it; None for an error that has another reason."""
    found: BaseException | None = error
    while found is not None:
        text = " ".join(str(found).split())
        if isinstance(found, MemoryError):
            return f"there is not enough memory{f': {text}' if text else ''}"
        if isinstance(found, OSError) and found.strerror:
            if not found.filename and found.errno in _NO_ROOM:
                return unwritable_output(found)
            name = f"{found.filename}: " if found.filename else ""
            return f"{name}the system refuses: {found.strerror.lower()}"
        if any(words in text.lower() for words in _WORDS):
            return f"the system refuses: {text}"
        found = found.__cause__ or found.__context__
    return None


def unwritable_output(error: OSError) -> str:
    """What to say where the standard output takes nothing more."""
    from warpmuscle.core.files import unwritable

    return f"the standard output {unwritable(error)}"
