"""A disk that is nearly full."""

import os
import resource
import sys
from contextlib import contextmanager

from environment import NO_BYTE_CODE


@contextmanager
def disk_of(size: int):
    """No file can grow beyond so many bytes, like on a full disk.

    Python would leave the byte code of what is imported meanwhile cut off, for others to read: none is written.
    """
    limits, before = resource.getrlimit(resource.RLIMIT_FSIZE), sys.dont_write_bytecode
    sys.dont_write_bytecode, os.environ[NO_BYTE_CODE] = True, "1"
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        sys.dont_write_bytecode = before
        os.environ.pop(NO_BYTE_CODE, None)
