"""Scenes as TOML files."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from warpmuscle.errors import SceneError
from warpmuscle.formats.files import replace_file, unreadable
from warpmuscle.formats.toml_layout import layout
from warpmuscle.formats.toml_lines import key_lines
from warpmuscle.scene import Character, Scene
from warpmuscle.typed import to_type
from warpmuscle.validate import check_scene


def read(path: str | Path) -> Scene:
    """Read and check a scene.

    Its `character` is a table, or the path of another TOML file, relative to the scene's own folder, that holds a
    character's tables at its top level.

    Raises:
        SceneError: with file, line and key.
    """
    path = Path(path)
    return _scene(_Source(path, _read_utf8(path)), path.parent)


def loads(text: str) -> Scene:
    """A checked scene from TOML text; its `character`, if it is a path, is taken from the current folder.

    Raises:
        SceneError: with key and line, the file being `<text>`.
    """
    return _scene(_Source(Path("<text>"), text), Path())


def is_scene(path: Path) -> bool:
    """Whether a TOML file claims to be a scene and not, say, a character that scenes share."""
    try:
        return "name" in _Source(path, _read_utf8(path)).data
    except SceneError:
        return False


def write(scene: Scene, path: str | Path) -> None:
    """Write a scene, whole or not at all; `read` gives an equal one.

    Raises:
        SceneError: the scene is not sound, or the file cannot be written.
    """
    check_scene(scene)
    replace_file(Path(path), dumps(scene))


def dumps(scene: Scene, character: str = "") -> str:
    """A scene as TOML text.

    Args:
        scene: what to write; what equals its default is left out.
        character: path of the file that holds the character's tables, put in their place.
    """
    return layout(scene, {"character": character} if character else {})


def _scene(source: _Source, folder: Path) -> Scene:
    """The scene of a TOML text, with a character from another file in the folder if it names one."""
    data = dict(source.data)
    named = data.get("character")
    character = source
    if isinstance(named, str):
        character = _Source(folder / named, _read_utf8(folder / named), prefix="character.")
    try:
        if character is not source:
            to_type(character.data, Character, key="character")  # first, for errors of its own
            data["character"] = character.data
        scene = to_type(data, Scene)
        check_scene(scene)
    except SceneError as error:
        raise (character if f"{error.key}.".startswith("character.") else source).placed(error) from None
    return scene


class _Source:
    """A TOML text: its data, and where its keys stand."""

    def __init__(self, path: Path, text: str, prefix: str = "") -> None:
        self._path, self._text, self._prefix = path, text, prefix
        self.data = _parsed(text, path)

    def placed(self, error: SceneError) -> SceneError:
        """The error with file and line of its key, or of the innermost table around it."""
        if error.file is not None:
            return error
        try:
            lines = {".".join(names): line for names, line in key_lines(self._text).items()}
        except RecursionError:  # values nested so deeply that tomllib could just bear it
            lines = {}
        key = f"{error.key}.".removeprefix(self._prefix).rstrip(".")
        while key and key not in lines:
            key = key.rpartition(".")[0]
        return error.at(self._path, lines.get(key, 0))


def _read_utf8(path: Path) -> str:
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = path.read_bytes()[: error.start].count(b"\n") + 1
        raise SceneError("not UTF-8 text", file=path, line=line) from None
    except (OSError, ValueError) as error:
        raise SceneError(unreadable(error), file=path) from None


def _parsed(text: str, path: Path) -> dict[str, Any]:
    """The data of a TOML text; what tomllib says about lines goes into the error."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise SceneError("tables or lists are nested too deeply", file=path) from None
    except ValueError as error:
        match = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", str(error), re.DOTALL)
        message = match[1] if match else str(error)
        line = int(match[2]) if match and match[2] else text.rstrip().count("\n") + 1 if match else 0
        column = f" (column {match[3]})" if match and match[3] else ""
        raise SceneError(f"not valid TOML: {message[:1].lower()}{message[1:]}{column}", file=path, line=line) from None
