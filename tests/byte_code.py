"""Byte code for the processes of tests, also where Python is told to keep none, as images of containers often do."""

import os
import sys
from pathlib import Path

FORBIDDEN = "PYTHONDONTWRITEBYTECODE"


def keep(root: Path) -> None:
    """Keep what this process and those that it starts compile in pytest's cache, if it is not kept beside the files.

    Else each of some hundred processes would compile the whole package again, for a second and more.
    """
    if not os.environ.pop(FORBIDDEN, ""):
        return
    folder = str(root / ".pytest_cache" / "byte_code")
    os.environ["PYTHONPYCACHEPREFIX"], sys.pycache_prefix = folder, folder
    sys.dont_write_bytecode = False
