"""A disk that is nearly full."""

import resource
from contextlib import contextmanager


@contextmanager
def disk_of(size: int):
    """No file can grow beyond so many bytes, like on a full disk."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
