"""A look at a file for MuJoCo's compiler, and at all that it includes and attaches, before any of it is compiled."""

from __future__ import annotations

import math
import re
from pathlib import Path, PurePosixPath, PureWindowsPath
from xml.parsers import expat

from warpmuscle.core.errors import SceneError, shortened
from warpmuscle.core.files import read_file, unreadable
from warpmuscle.core.limits import check_size
from warpmuscle.formats.osim.elements import mended

FOLDERS = ("meshdir", "texturedir", "assetdir")  # attributes that name folders; those of files begin with "file"
REFUSED = {"extension": "plugins", "plugin": "plugins"}  # elements that run code, by what they bring
CLOSE = re.compile(r"""=\s*("[^"<]*"|'[^'<]*')(?=[A-Za-z_])""")  # a value right before the next attribute
MOST_FILES = 1000  # that a model consists of
A_MODEL = "a model of MuJoCo"

# Attributes by which an element asks for memory: as if it were so many elements, and as a grid or a list of numbers.
MANY = {"flexcomp": ("count",), "composite": ("count",), "size": ("nkey",)}
GRIDS = {"hfield": ("nrow", "ncol"), "texture": ("width", "height")}
LISTS = {"numeric": ("size",), "user": ("dim",), "size": ("nuserdata", "njmax", "nconmax")}
OF_ACTUATORS = ("actdim", "nsample")
OF_EACH, EACH = "nuser_", 1000.0  # numbers of each element of a kind, of which a model may have so many


def look(path: Path) -> None:
    """Raise SceneError unless a file, and all that it includes and attaches, is such as `compiled.compiled` takes."""
    _Files().elements(path, ())


def as_mujoco_takes(text: bytes) -> str:
    """The text of a model as MuJoCo's parser takes it: also with attributes that no blank parts."""
    return CLOSE.sub(r"\g<0> ", mended(text.decode("utf-8", "replace")))


class _Files:
    """All files that a model consists of."""

    def __init__(self) -> None:
        self._known: dict[Path, float] = {}
        self._seen = 0

    def elements(self, path: Path, chain: tuple[Path, ...]) -> float:
        """How many elements a model comes to, with those that it includes and attaches, each as often as it is used.

        Args:
            chain: models that attach one another, the last one this model.
        """
        own = path.resolve()
        if own in chain:
            raise SceneError("it attaches itself, or a model that attaches it", file=path)
        check_size("nesting", len(chain), lambda message: SceneError(message, file=path))
        if own not in self._known:
            self._known[own] = self._sum(path, (*chain, own))
        return self._known[own]

    def _sum(self, path: Path, chain: tuple[Path, ...]) -> float:
        left: list[tuple[Path, float, tuple[Path, ...]]] = [(path, 1.0, (path,))]
        seen, looks = set[Path](), list[tuple[Look, float]]()
        while left:
            file, times, way = left.pop()
            if file in way[:-1]:  # MuJoCo 3.2 crashes of it
                names = " includes ".join(repr(one.name) for one in way[way.index(file) :])
                raise SceneError(f"files include each other: {names}", file=way[-2])
            if file in seen:
                continue
            seen.add(file)
            self._seen += 1
            if self._seen > MOST_FILES:
                raise SceneError(f"it consists of more than {MOST_FILES} files", file=path)
            found = Look(file, "mujoco" if len(way) == 1 else "", A_MODEL)
            looks.append((found, times))
            for name, more in found.included:
                near = [base / name for base in (path.parent, file.parent) if (base / name).is_file()]
                left += [(one, times * more, (*way, one)) for one in near[:1]]  # the compiler tells what is not there
        folders = [path.parent / folder for found, _ in looks for folder in found.folders]
        sizes: dict[str, float] = {}
        for found, _ in looks:
            for name, model in found.models:
                bases = (path.parent, found.path.parent, *folders)
                there = dict.fromkeys((base / model).resolve() for base in bases if (base / model).is_file())
                size = max((self.elements(one, chain) for one in there), default=0.0)
                sizes[name] = max(sizes.get(name, 0.0), size)
        total = sum(found.count * times for found, times in looks)
        for found, times in looks:  # a model without a name in the list has the one that its own file gives it
            total += sum(times * more * sizes.get(name, sizes.get("", 0.0)) for name, more in found.attached)
        check_size("elements", total, lambda message: SceneError(message, file=path))
        return total


class Look:
    """Goes through the elements of one file.

    Attributes:
        text: as it is sound. count: how many elements it comes to. included: files, and how often each is.
        models: names and files of models to attach. attached: names of these, and how often each is.
        folders: in which files are.
    """

    def __init__(self, path: Path, root: str, what: str) -> None:
        """Look.

        Args:
            root: tag of the first element; empty: any. what: what the file is.

        Raises:
            SceneError: what `look` raises.
        """
        self.path, self._root, self._what = path, root, what
        try:
            text = read_file(path, "model")
        except (OSError, ValueError) as error:
            raise SceneError(unreadable(error), file=path) from None
        self.text: bytes | str = text
        try:
            self._go_through(text)
        except expat.ExpatError as error:
            try:
                self.text = as_mujoco_takes(text)
                self._go_through(self.text)
            except expat.ExpatError:
                raise self._error(f"not sound XML: {expat.ErrorString(error.code)}", error.lineno) from None

    def _go_through(self, text: bytes | str) -> None:
        self.included: list[tuple[str, float]] = []
        self.models: list[tuple[str, str]] = []
        self.attached: list[tuple[str, float]] = []
        self.folders: list[str] = []
        self.count = 0.0
        self._times = [1.0]  # how often what is in the elements above is
        self._expat = expat.ParserCreate()
        self._expat.StartElementHandler = self._start
        self._expat.EndElementHandler = self._end
        self._expat.StartDoctypeDeclHandler = self._doctype
        self._expat.Parse(text, True)

    def _error(self, message: str, line: int = 0) -> SceneError:
        return SceneError(message, file=self.path, line=line or self._expat.CurrentLineNumber)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if self._root and len(self._times) == 1 and tag != self._root:
            raise self._error(f"{self._what} begins with <{self._root}>, not <{shortened(tag)}>")
        times = self._times[-1]
        self._times.append(times * (max(_product(attributes, ("count",)), 1.0) if tag == "replicate" else 1.0))
        self.count += times * max(_product(attributes, MANY.get(tag, ())), 1.0)
        check_size("elements", self.count, self._error)
        check_size("nesting", len(self._times) - 1, self._error)
        if self._root == "robot":
            return  # files and programmes are left out of it
        if tag in REFUSED:
            raise self._error(f"<{tag}> brings {REFUSED[tag]}, which are not run; remove it")
        self._check_sizes(tag, attributes)
        for name, value in attributes.items():
            if name in FOLDERS or name.startswith("file"):
                if PurePosixPath(value).is_absolute() or PureWindowsPath(value).drive or "://" in value:
                    message = f"{name} {shortened(value)!r} is not a path from the model's folder; copy it there"
                    raise self._error(message)
                if tag == "include":
                    self.included.append((value, times))
                elif tag == "model":
                    self.models.append((attributes.get("name", ""), value))
                elif name in FOLDERS:
                    self.folders.append(value)
        if tag == "attach":
            self.attached.append((attributes.get("model", ""), times))

    def _check_sizes(self, tag: str, attributes: dict[str, str]) -> None:
        asked = _product(attributes, GRIDS.get(tag, ()))
        for name in attributes:
            if name in (*LISTS.get(tag, ()), *OF_ACTUATORS):
                asked = max(asked, _product(attributes, (name,)))
            elif name.startswith(OF_EACH):
                asked = max(asked, EACH * _product(attributes, (name,)))
        check_size("asked", self._times[-2] * asked, self._error)

    def _end(self, tag: str) -> None:
        self._times.pop()

    def _doctype(self, *_: object) -> None:
        raise self._error("a model has no document type; remove <!DOCTYPE>")


def _product(attributes: dict[str, str], names: tuple[str, ...]) -> float:
    """The product of numbers in attributes; 0 where there are none, or words, which the compiler refuses."""
    words = [word for name in names for word in attributes.get(name, "").split()]
    try:
        return math.prod(map(float, words)) if words else 0.0
    except ValueError:
        return 0.0
