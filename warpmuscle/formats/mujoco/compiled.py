"""A file as MuJoCo's compiler reads it, after a look at what it names."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from warpmuscle.core.errors import SceneError, shortened
from warpmuscle.formats.mujoco.look import Look, look
from warpmuscle.formats.mujoco.urdf import mimicking, without_files

NEEDED = "reading a model of MuJoCo needs the mujoco package: pip install 'warpmuscle[mujoco]'"
URDF = ".urdf"


def mujoco_package() -> Any:
    """The module `mujoco`.

    Raises:
        SceneError: it is not installed.
    """
    try:
        import mujoco
    except ImportError:
        raise SceneError(NEEDED) from None
    return mujoco


def compiled(path: Path) -> Any:
    """MuJoCo's compiled model of a file.

    It follows what the file includes and attaches, and meshes, by paths from its folder. Of a URDF the skeleton is
    compiled, without meshes and what else it names.

    Raises:
        SceneError: it is no model of MuJoCo, names files by paths from the root of the disk, or brings plugins; the
            compiler's own errors; or the package is not installed.
    """
    skeleton = path.suffix.lower() == URDF
    looked = _look_at_skeleton(path) if skeleton else None
    if not skeleton:
        look(path)
    mujoco = mujoco_package()
    try:
        with _without_log(mujoco):
            if looked is None:
                return mujoco.MjModel.from_xml_path(str(path))
            model = mujoco.MjModel.from_xml_string(looked)
    except (ValueError, RuntimeError, OSError) as error:
        text = " ".join(str(error).split()).removeprefix("Error: ").removeprefix("XML Error: ")
        line = re.search(r"\bline (\d+)\b", text)
        message = f"MuJoCo cannot compile it: {shortened(text)}"
        raise SceneError(message, file=path, line=int(line.group(1)) if line and not skeleton else 0) from None
    if model.neq == 0 and (names := mimicking(looked)):
        old = f"which MuJoCo {mujoco.__version__} does not know, and would leave free: pip install -U mujoco"
        raise SceneError(f"joint {names[0]!r} mimics another, {old}", file=path)
    return model


@contextlib.contextmanager
def _without_log(mujoco: Any) -> Iterator[None]:
    """Keep MuJoCo from writing its warnings, as of a muscle's range of lengths, to a file in the working folder."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _look_at_skeleton(path: Path) -> str:
    """The text of a URDF that names no file."""
    text = Look(path, "robot", "a URDF").text
    try:
        return without_files(text)
    except ValueError as error:
        raise SceneError(shortened(str(error)), file=path) from None
