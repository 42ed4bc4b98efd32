"""Scenes as TOML files."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import SceneError
from warpmuscle.core.files import read_file, replace_file, unreadable
from warpmuscle.core.limits import check_size
from warpmuscle.core.shipped import moved_scene, shipped_file
from warpmuscle.formats.height_field.read import with_height_fields
from warpmuscle.formats.recorded.start import with_recorded_start
from warpmuscle.formats.toml_layout import layout
from warpmuscle.formats.toml_lines import key_lines
from warpmuscle.scene import Character, Scene
from warpmuscle.scene.controller import SIMBICON
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.scene.validation.start import doubts_of

TEXT = "<text>"  # what errors call a text that is in no file


def read(path: str | Path, doubts: list[SceneError] | None = None) -> Scene:
    """Read and check a scene.

    Its `character` is a table, or the path of another TOML file, relative to the scene's own folder, that holds a
    character's tables at its top level. It may be a list of such paths: tables of later files add to those of earlier
    ones, key by key, so that muscles, or just new properties of them, can stand in a file of their own. `base` may name
    another scene, likewise, from which this one takes all that it does not say itself. What is not in the scene's
    folder may be a shipped file.

    Args:
        path: the file.
        doubts: gets what is probably a mistake, see `doubts_of`, with file and line.

    Raises:
        SceneError: with file, line and key.
    """
    path = Path(path)
    return _scene(Source.read(path), path.parent, doubts)


def loads(text: str, folder: Path = Path(), name: str = TEXT) -> Scene:
    """A checked scene from TOML text; files that it names, such as its `base`, are taken from a folder.

    Raises:
        SceneError: with key and line, the file being `name`.
    """
    return _scene(Source(Path(name), text), folder)


def write(scene: Scene, path: str | Path) -> None:
    """Write a scene, whole or not at all; `read` gives an equal one.

    Raises:
        SceneError: the scene is not sound, or the file cannot be written.
    """
    check_scene(scene)
    replace_file(Path(path), dumps(scene))


def dumps(scene: Scene, character: str | Sequence[str] = "") -> str:
    """A scene as TOML text.

    Args:
        scene: what to write; what equals its default is left out.
        character: path or paths of the files that hold the character's tables, put in their place.
    """
    return layout(scene, {"character": character} if character else {})


def _scene(source: Source, folder: Path, doubts: list[SceneError] | None = None) -> Scene:
    """The scene of a TOML text, with what it takes from other files in the folder."""
    layers = _layers(source, folder, ())
    data: dict[str, Any] = {}
    characters: list[Source] = []
    for layer, place in layers:
        named = layer.data.get("character")
        if isinstance(named, str) or (named and isinstance(named, list) and all(isinstance(n, str) for n in named)):
            names = [named] if isinstance(named, str) else named
            characters = [Source.read(_found(layer, "character", place, name), prefix="character.") for name in names]
            data.pop("character", None)
            for file in characters:
                merge(data, {"character": file.data})
            merge(data, {key: value for key, value in layer.data.items() if key != "character"})
        else:
            merge(data, layer.data)
    data.pop("base", None)
    sources = [*(layer for layer, _ in layers), *characters]
    try:
        if characters:
            to_type(data["character"], Character, key="character")  # first, for errors of its own
        places = [place for _, place in reversed(layers)]
        scene = with_recorded_start(with_height_fields(to_type(data, Scene), places), places)
        check_scene(scene)
    except SceneError as error:
        raise _placed(error, sources) from None
    if doubts is not None:
        doubts.extend(_placed(doubt, sources) for doubt in doubts_of(scene))
    return scene


def _placed(error: SceneError, sources: Sequence[Source]) -> SceneError:
    """The error with its place in the text that has most of its key, the last of several."""
    return max(reversed(sources), key=lambda file: file.depth(error.key)).placed(error)


def _layers(source: Source, folder: Path, above: tuple[Path, ...]) -> list[tuple[Source, Path]]:
    """A scene's text and those that it is based on, the lowest first, each with its folder."""
    base = source.data.get("base")
    if base is None:
        return [(source, folder)]
    if not isinstance(base, str):
        raise source.placed(SceneError("the base is the path of another scene", key="base"))
    path = _found(source, "base", folder, base)
    if path.resolve() in above:
        raise source.placed(SceneError(f"scenes are based on each other: {base!r}", key="base"))
    place = source.placed
    check_size("bases", len(above) + 1, lambda text: place(SceneError(text, key="base")))
    lower = Source.read(path)
    return [*_layers(lower, path.parent, (*above, path.resolve())), (source, folder)]


def _found(source: Source, key: str, folder: Path, name: str) -> Path:
    """A file that a scene names by a key: one in its own folder, else a shipped one, which needs no suffix."""
    if "\0" in name:
        raise SceneError(f"no file can be called {name!r}")
    beside = folder / name
    if beside.exists():
        return beside
    if Path(name).name == name:
        return shipped_file(name) or beside
    if moved := moved_scene(beside):
        raise source.placed(SceneError(f"there is no file {name!r}: {moved}", key=key))
    return beside


def merge(table: dict[str, Any], other: dict[str, Any]) -> None:
    """Put another table into a table: what both have is merged if it is a table, else replaced.

    So is a number that is free in one of them and follows another number in the other; one that is to follow commands
    keeps its value unless it gets another one. A controller of another type takes the place of the one that was. A
    table whose keys are numbers changes the items of a list: `[controller.states.0]` the first state.
    """
    for key, value in other.items():
        mine = table.get(key)
        if isinstance(value, dict) and isinstance(mine, list) and all(name.isdigit() for name in value):
            items = {str(index): item for index, item in enumerate(mine)}
            merge(items, value)
            table[key] = list(items.values())
        elif (
            isinstance(value, dict)
            and isinstance(mine, dict)
            and not (_turns(mine, value) or (key == "controller" and _other_type(mine, value)))
        ):
            table[key] = dict(mine)
            merge(table[key], value)
        elif isinstance(value, dict) and "per" in value and isinstance(mine, int | float):
            table[key] = {"value": mine} | value
        else:
            table[key] = value


def _turns(mine: dict[str, Any], value: dict[str, Any]) -> bool:
    """Whether a free number is to follow another one now, or one that follows to be free."""
    return ("same_as" in value and "value" in mine) or ("value" in value and "same_as" in mine)


def _other_type(mine: dict[str, Any], value: dict[str, Any]) -> bool:
    """Whether a controller is to be of another type, which takes nothing of what this one does."""
    return "type" in value and value["type"] != mine.get("type", SIMBICON)


class Source:
    """A TOML text: its data, and where its keys stand."""

    def __init__(self, path: Path, text: str, prefix: str = "") -> None:
        self._path, self.text, self._prefix = path, text, prefix
        self.data = _parsed(text, path)
        self._lines: dict[str, int] | None = None

    @classmethod
    def read(cls, path: Path, prefix: str = "") -> Source:
        """The text of a file; raises SceneError with file and line."""
        return cls(path, _read_utf8(path), prefix)

    def line(self, key: str) -> int:
        """Line of a key, or of the innermost table around it; 0 if unknown."""
        if self._lines is None:
            try:
                self._lines = {".".join(names): line for names, line in key_lines(self.text).items()}
            except RecursionError:  # values nested so deeply that tomllib could just bear it
                self._lines = {}
        while key and key not in self._lines:
            key = key.rpartition(".")[0]
        return self._lines.get(key, 0)

    def depth(self, key: str) -> int:
        """How many parts of a key this text has, from the front; -1 if it can have none."""
        if not f"{key}.".startswith(self._prefix):
            return -1
        depth = int(bool(self._prefix))
        table: Any = self.data
        for name in key.split(".")[depth:]:
            if isinstance(table, list) and name.isdigit() and int(name) < len(table):
                table = table[int(name)]
            elif isinstance(table, dict) and name in table:
                table = table[name]
            else:
                break
            depth += 1
        return depth

    def placed(self, error: SceneError) -> SceneError:
        """The error with file and line of its key, or of the innermost table around it."""
        if error.file is not None:
            return error
        return error.at(self._path, self.line(f"{error.key}.".removeprefix(self._prefix).rstrip(".")))


def _read_utf8(path: Path) -> str:
    try:
        content = read_file(path)
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise SceneError("not UTF-8 text", file=path, line=line) from None
    except (OSError, ValueError) as error:
        raise SceneError(unreadable(error), file=path) from None


def _depth(data: Any) -> int:
    """How many tables and lists are in each other at most, found without a call in a call."""
    depth, level = 0, [data]
    while level:
        level = [
            inner
            for one in level
            for inner in (one.values() if isinstance(one, dict) else one)
            if isinstance(inner, dict | list)
        ]
        depth += 1
    return depth


def _parsed(text: str, path: Path) -> dict[str, Any]:
    """The data of a TOML text; what tomllib says about lines goes into the error."""
    try:
        data = tomllib.loads(text)
        check_size("nesting", _depth(data), lambda text: SceneError(text, file=path))
        return data
    except RecursionError:
        raise SceneError("tables or lists are nested too deeply", file=path) from None
    except ValueError as error:
        match = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", str(error), re.DOTALL)
        message = match[1] if match else str(error)
        line = int(match[2]) if match and match[2] else text.rstrip().count("\n") + 1 if match else 0
        column = f" (column {match[3]})" if match and match[3] else ""
        raise SceneError(f"not valid TOML: {message[:1].lower()}{message[1:]}{column}", file=path, line=line) from None
