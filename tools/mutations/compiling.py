"""Plugin of pytest for sessions that compile kernels and run them once.

Warp compiles its headers anew in each process that compiles a kernel, for two seconds, which is as long as the kernels
of most tests take. They are kept from one session of a worker to the next; it runs one at a time, so that no two write
them at once.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option."""
    parser.addoption("--unoptimized", action="store_true", help="compile all kernels without optimisation")


def pytest_configure(config: pytest.Config) -> None:
    """Have Warp look for its headers in the folder that the worker names."""
    import warp as wp
    from warp._src import context

    if config.option.unoptimized:
        wp.config.optimization_level = 0
    folder = os.environ.get("MUTATIONS_HEADERS")
    runtime = getattr(context, "Runtime", None)
    if folder and hasattr(runtime, "get_clang_pch_dir"):  # it is Warp's own affair
        Path(folder).mkdir(exist_ok=True)
        runtime.get_clang_pch_dir = lambda self: folder
