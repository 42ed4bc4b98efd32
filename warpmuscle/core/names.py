"""Names of files, made of names that scenes, sweeps and results have."""

from __future__ import annotations

import re

LONGEST = 120  # bytes; file systems take 255, and endings such as `.h5.journal` come behind a name
_OTHER = re.compile(r"[^\w.,=+#~() -]")
_DEVICE = re.compile(r"(con|prn|aux|nul|com\d|lpt\d|conin\$|conout\$|clock\$)(\.|$)", re.IGNORECASE)  # of Windows


def file_name(name: str, default: str = "unnamed") -> str:
    """A name as that of a file, without an ending: within its folder, and possible on all systems.

    A name that is possible stays as it is. What separates folders, and all else that is no letter, digit or one of
    `.,=+#~() -`, becomes `_`; dots and spaces at the ends are left out.
    """
    name = _OTHER.sub("_", name).strip(". ")
    name = name.encode(errors="replace")[:LONGEST].decode(errors="ignore").strip(". ")
    return f"_{name}" if _DEVICE.match(name) else name or default


def is_file_name(name: str) -> bool:
    """Whether `file_name` leaves a name as it is, but for a number behind it that tells it from others."""
    plain = re.sub(r"~\d{1,9}$", "", name)
    return file_name(plain) == plain
