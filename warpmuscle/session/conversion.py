"""A file of one kind into one of another, in a line of Python."""

from __future__ import annotations

import warnings
from os import PathLike
from pathlib import Path

from warpmuscle.core.arguments import as_path
from warpmuscle.core.errors import ArgumentError
from warpmuscle.formats import Ignored, SceneLike, mjcf, save, scene_of
from warpmuscle.formats.load import summary
from warpmuscle.scene import Scene


def convert(source: SceneLike, target: str | PathLike[str]) -> Scene:
    """Write a scene as `.toml`, `.osim`, `.xml` of MuJoCo, or the original program's `.rbs`, `.sbc` and `.rs`.

    Args:
        source: a scene, its name, or its file; options of reading are those of `load`.

    Returns:
        The scene that was written.

    Warns:
        UserWarning: what the target cannot hold.

    Raises:
        SceneError: the source cannot be read. Error: the target cannot be written, or is what is read.
    """
    scene, path = scene_of(source, "source"), as_path(target, "target")
    if not isinstance(source, Scene) and path.exists() and Path(source).exists() and path.samefile(source):
        raise ArgumentError(f"{path} is the input, which would be lost; name another output file")
    if path.suffix == ".xml":
        mjcf.write(scene, path)
        return scene
    lost: list[Ignored] = []
    save(scene, path, lost)
    if lost:
        warnings.warn(summary(lost, "not all was written:"), stacklevel=2)
    return scene
