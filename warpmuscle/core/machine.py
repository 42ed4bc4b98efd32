"""What the last bits of linear algebra depend on besides the program: the processor, and the BLAS that NumPy uses."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
from threadpoolctl import ThreadpoolController  # type: ignore[import-untyped]

from warpmuscle.core.plain_text import number_of

MACHINE = ("processor", "blas")


@cache
def this_machine() -> dict[str, str]:
    """This machine's processor and BLAS in words, by the names of `MACHINE`."""
    return {"processor": _processor(Path("/proc/cpuinfo")), "blas": _blas()}


def in_words(machine: Mapping[str, str]) -> str:
    """A machine on one line."""
    return f"{machine['processor']} with {machine['blas']}"


def _processor(described: Path) -> str:
    """Architecture and model; family and model numbers too, since virtual machines call many models by one name."""
    fields: dict[str, str] = {}
    try:
        for line in described.read_text(encoding="utf-8", errors="replace").splitlines():
            name, _, value = line.partition(":")
            fields.setdefault(name.strip(), " ".join(value.split()))
    except OSError:
        pass  # not Linux
    numbers = [f"{name.removeprefix('cpu ')} {fields[name]}" for name in ("cpu family", "model") if fields.get(name)]
    model = fields.get("model name") or platform.processor()
    return ", ".join(dict.fromkeys(filter(None, (platform.machine(), model, *numbers)))) or "unknown"


def _blas() -> str:
    """Name and version of NumPy's BLAS, and of OpenBLAS and BLIS the kernels that it chose for this processor."""
    loaded = [entry for entry in ThreadpoolController().info() if entry["user_api"] == "blas"]
    loaded.sort(key=lambda entry: "numpy" not in str(entry.get("filepath")))  # SciPy may bring one of its own
    if not loaded:
        built = np.show_config(mode="dicts")["Build Dependencies"]["blas"]
        return f"{built.get('name', 'an unknown BLAS')} {built.get('version', '')}".strip()
    name, version = loaded[0]["internal_api"], loaded[0].get("version") or "of unknown version"
    kernels = loaded[0].get("architecture")
    return f"{name} {version}" + (f", {number_of(kernels, 'kernel')}" if kernels else "")


def cores() -> int:
    """How many cores this process may use, which on a shared host are fewer than there are."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
