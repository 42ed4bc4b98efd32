"""What the processes of tests find in their environment, and those that they start."""

import os
import shutil
import sys
import tempfile
from pathlib import Path

from threadpoolctl import threadpool_limits

NO_BYTE_CODE = "PYTHONDONTWRITEBYTECODE"
THREADS = "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"


def keep_byte_code(root: Path) -> None:
    """Keep byte code in pytest's cache where Python is told to keep none, as images of containers often do.

    Else each of some hundred processes would compile the whole package again, for a second and more.
    """
    if not os.environ.pop(NO_BYTE_CODE, ""):
        return
    folder = root / ".pytest_cache" / "byte_code"
    temporary = Path(tempfile.gettempdir()).resolve()
    shutil.rmtree(folder / temporary.relative_to(temporary.anchor), ignore_errors=True)  # of an earlier session
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix = str(folder)
    sys.dont_write_bytecode = False


def one_thread() -> None:
    """Let linear algebra take one thread unless the environment says how many.

    Workers have a processor each; with more threads they would mostly wait for one another, busily.
    """
    for name in THREADS:
        os.environ.setdefault(name, "1")
    threadpool_limits(int(os.environ[THREADS[0]]), user_api="blas")
