"""Packages that only some commands need, asked for before their work begins."""

from __future__ import annotations

import importlib
import importlib.util
from pathlib import Path
from typing import Any

from warpmuscle.core.errors import Error
from warpmuscle.core.files import check_output

# What an extra of the installation is for, by the module that comes with it.
EXTRAS = {
    "sklearn": ("scikit-learn", "synergies"),
    "matplotlib": ("matplotlib", "plot"),
    "jinja2": ("jinja2", "plot"),
    "tensorboard": ("TensorBoard", "tensorboard"),
    "imageio_ffmpeg": ("imageio-ffmpeg", "video"),
    "pandas": ("pandas", "data"),
    "xarray": ("xarray", "data"),
}
BY_SUFFIX = {".png": "matplotlib", ".svg": "matplotlib", ".pdf": "matplotlib", ".mp4": "imageio_ffmpeg"}


def need(module: str, what: str) -> None:
    """Raise Error, which says how to install it, unless a module is there; nothing is imported."""
    if importlib.util.find_spec(module) is None:
        raise _lacking(module, what)


def imported(module: str, what: str = "this needs") -> Any:
    """A module of an extra, or of a package within; raises Error, which says how to install it, if it is not there."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise _lacking(module.partition(".")[0], what) from None


def _lacking(module: str, what: str) -> Error:
    package, extra = EXTRAS[module]
    return Error(f"{what} {package}: pip install 'warpmuscle[{extra}]'")


def need_for(suffix: str) -> None:
    """Raise Error unless what files with a suffix such as .png are drawn by is there."""
    module = BY_SUFFIX.get(suffix.lower())
    if module is not None:
        need(module, "an .mp4 needs" if module == "imageio_ffmpeg" else "figures need")


def need_for_page() -> None:
    """Raise Error unless what pages with figures are made by is there."""
    for module in ("jinja2", "matplotlib"):
        need(module, "a report page needs")


def check_report(path: Path) -> None:
    """Raise Error now, rather than after the work, if no report can be made, or written to a file of this name."""
    check_output(path, "a report", (".html", ".htm"))
    need_for_page()
