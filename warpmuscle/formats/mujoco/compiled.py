"""A file as MuJoCo's compiler reads it, after a look at what it names."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any
from xml.parsers import expat

from warpmuscle.core.errors import SceneError, shortened
from warpmuscle.core.files import read_file, unreadable
from warpmuscle.core.limits import check_size
from warpmuscle.formats.mujoco.urdf import mimicking, without_files
from warpmuscle.formats.osim.elements import mended

NEEDED = "reading a model of MuJoCo needs the mujoco package: pip install 'warpmuscle[mujoco]'"
FOLDERS = ("meshdir", "texturedir", "assetdir")  # attributes that name folders; those of files begin with "file"
REFUSED = {"extension": "plugins", "plugin": "plugins"}  # elements that run code, by what they bring
CLOSE = re.compile(r"""=\s*("[^"<]*"|'[^'<]*')(?=[A-Za-z_])""")  # a value right before the next attribute
URDF = ".urdf"
MOST_FILES = 1000  # that a model consists of


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
    """MuJoCo's compiled model of a file; it follows what the file includes, and meshes, by paths from its folder.

    Of a URDF the skeleton is compiled, without meshes and what else it names.

    Raises:
        SceneError: it is no model of MuJoCo, names files by paths from the root of the disk, or brings plugins; the
            compiler's own errors; or the package is not installed.
    """
    skeleton = path.suffix.lower() == URDF
    looked = _look_at_skeleton(path) if skeleton else None
    if not skeleton:
        _look(path, path.parent)
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
    text = _Look(path, "robot", "a URDF").text
    try:
        return without_files(text)
    except ValueError as error:
        raise SceneError(shortened(str(error)), file=path) from None


def _look(path: Path, folder: Path) -> None:
    """Raise SceneError unless a file and all that it includes are such as `compiled` takes."""
    left: list[tuple[Path, tuple[Path, ...]]] = [(path, (path,))]
    seen = set[Path]()
    while left:
        file, way = left.pop()
        if file in way[:-1]:  # MuJoCo 3.2 crashes of it
            names = " includes ".join(repr(one.name) for one in way[way.index(file) :])
            raise SceneError(f"files include each other: {names}", file=way[-2])
        if file in seen:
            continue
        seen.add(file)
        if len(seen) > MOST_FILES:
            raise SceneError(f"it includes more than {MOST_FILES} files", file=path)
        for name in _Look(file, "mujoco" if file == path else "", "a model of MuJoCo").included:
            near = [base / name for base in (folder, file.parent) if (base / name).is_file()]
            left += [(one, (*way, one)) for one in near[:1]]  # the compiler tells what is not there


def as_mujoco_takes(text: bytes) -> str:
    """The text of a model as MuJoCo's parser takes it: also with attributes that no blank parts."""
    return CLOSE.sub(r"\g<0> ", mended(text.decode("utf-8", "replace")))


class _Look:
    """Goes through the elements of one file."""

    def __init__(self, path: Path, root: str, what: str) -> None:
        """Look.

        Args:
            root: tag of the first element; empty: any. what: what the file is.

        Raises:
            SceneError: what `_look` raises.
        """
        self._path, self._root, self._what = path, root, what
        try:
            text = read_file(path, "model")
        except (OSError, ValueError) as error:
            raise SceneError(unreadable(error), file=path) from None
        self.text: bytes | str = text  # as it is sound
        try:
            self._go_through(text)
        except expat.ExpatError as error:
            try:
                self.text = as_mujoco_takes(text)
                self._go_through(self.text)
            except expat.ExpatError:
                raise self._error(f"not sound XML: {expat.ErrorString(error.code)}", error.lineno) from None

    def _go_through(self, text: bytes | str) -> None:
        self.included: list[str] = []
        self._depth, self._count = 0, 0
        self._expat = expat.ParserCreate()
        self._expat.StartElementHandler = self._start
        self._expat.EndElementHandler = self._end
        self._expat.StartDoctypeDeclHandler = self._doctype
        self._expat.Parse(text, True)

    def _error(self, message: str, line: int = 0) -> SceneError:
        return SceneError(message, file=self._path, line=line or self._expat.CurrentLineNumber)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if self._root and self._depth == 0 and tag != self._root:
            raise self._error(f"{self._what} begins with <{self._root}>, not <{shortened(tag)}>")
        self._depth += 1
        self._count += 1
        check_size("elements", self._count, self._error)
        check_size("nesting", self._depth, self._error)
        if self._root == "robot":
            return  # files and programmes are left out of it
        if tag in REFUSED:
            raise self._error(f"<{tag}> brings {REFUSED[tag]}, which are not run; remove it")
        for name, value in attributes.items():
            if name in FOLDERS or name.startswith("file"):
                if PurePosixPath(value).is_absolute() or PureWindowsPath(value).drive or "://" in value:
                    message = f"{name} {shortened(value)!r} is not a path from the model's folder; copy it there"
                    raise self._error(message)
                if tag == "include":
                    self.included.append(value)

    def _end(self, tag: str) -> None:
        self._depth -= 1

    def _doctype(self, *_: object) -> None:
        raise self._error("a model has no document type; remove <!DOCTYPE>")
