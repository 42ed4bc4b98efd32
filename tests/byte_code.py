"""Byte code for the processes of tests, also where Python is told to keep none, as images of containers often do."""

import os
import shutil
import sys
import tempfile
from pathlib import Path

FORBIDDEN = "PYTHONDONTWRITEBYTECODE"


def keep(root: Path) -> None:
    """Keep what this process and those that it starts compile in pytest's cache, if it is not kept beside the files.

    Else each of some hundred processes would compile the whole package again, for a second and more.
    """
    if not os.environ.pop(FORBIDDEN, ""):
        return
    folder = root / ".pytest_cache" / "byte_code"
    temporary = Path(tempfile.gettempdir()).resolve()
    shutil.rmtree(folder / temporary.relative_to(temporary.anchor), ignore_errors=True)  # of an earlier session
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix = str(folder)
    sys.dont_write_bytecode = False
