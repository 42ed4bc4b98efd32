"""Packages that only some commands need, asked for before their work begins."""

from __future__ import annotations

import importlib.util

from warpmuscle.core.errors import Error

# What an extra of the installation is for, by the module that comes with it.
EXTRAS = {
    "sklearn": ("scikit-learn", "synergies"),
    "matplotlib": ("matplotlib", "plot"),
    "jinja2": ("jinja2", "plot"),
    "tensorboard": ("TensorBoard", "tensorboard"),
    "imageio_ffmpeg": ("imageio-ffmpeg", "video"),
}
BY_SUFFIX = {".png": "matplotlib", ".svg": "matplotlib", ".pdf": "matplotlib", ".mp4": "imageio_ffmpeg"}


def need(module: str, what: str) -> None:
    """Raise Error, which says how to install it, unless a module is there; nothing is imported."""
    if importlib.util.find_spec(module) is None:
        package, extra = EXTRAS[module]
        raise Error(f"{what} {package}: pip install 'warpmuscle[{extra}]'")


def need_for(suffix: str) -> None:
    """Raise Error unless what files with a suffix such as .png are drawn by is there."""
    module = BY_SUFFIX.get(suffix.lower())
    if module is not None:
        need(module, "an .mp4 needs" if module == "imageio_ffmpeg" else "figures need")
