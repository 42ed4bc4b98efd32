"""Linear algebra in one thread: it rounds the same on equal processors, and is the fastest for small matrices."""

from __future__ import annotations

from typing import Any

from threadpoolctl import ThreadpoolController  # type: ignore[import-untyped]

_LIBRARIES = ThreadpoolController()


def one_thread() -> Any:
    """A context in which BLAS has one thread."""
    return _LIBRARIES.limit(limits=1, user_api="blas")
