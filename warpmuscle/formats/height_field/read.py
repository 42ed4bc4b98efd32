"""Heights on a grid from a file: grey PNG, numbers in `.npy` or `.csv`, or the hfield of a MuJoCo model."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from tokenize import TokenError
from typing import NamedTuple
from xml.parsers import expat

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.files import named_file, read_file, unreadable
from warpmuscle.core.limits import LIMITS
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.height_field.grey_png import grey_values
from warpmuscle.scene import Scene
from warpmuscle.scene.terrain.packing import packed
from warpmuscle.scene.terrain.tiles import HeightField

# What NumPy raises of damaged files.
NOT_NUMPY = ValueError, TypeError, EOFError, MemoryError, AttributeError, OverflowError, SyntaxError, TokenError
READ = (".png", ".npy", ".csv", ".xml")


class Heights(NamedTuple):
    """What a file says."""

    heights: Floats  # (points along z, points along x), both increasing, in m or for a factor
    size: tuple[float, float] | None = None  # m, along x and z, where the file says it


def with_height_fields(scene: Scene, folders: Sequence[Path]) -> Scene:
    """The scene with the heights of the files that its tiles name.

    Args:
        folders: where they may lie, the first one first.

    Raises:
        SceneError: with file and key.
    """
    terrain = scene.ground.terrain
    if terrain is None:
        return scene
    tiles = list(terrain.tiles)
    for index, tile in enumerate(tiles):
        if isinstance(tile, HeightField) and tile.file and not tile.packed:
            tiles[index] = _with_file(tile, folders, f"ground.terrain.tiles.{index}")
    terrain = msgspec.structs.replace(terrain, tiles=tiles)
    return msgspec.structs.replace(scene, ground=msgspec.structs.replace(scene.ground, terrain=terrain))


def _with_file(tile: HeightField, folders: Sequence[Path], key: str) -> HeightField:
    path = named_file(tile.file, folders, f"{key}.file")
    try:
        found = read_heights(path)
    except (OSError, ValueError) as error:
        text = unreadable(error) if isinstance(error, OSError) else str(error)
        raise SceneError(f"{path}: {text}", f"{key}.file") from None
    points, text = packed(found.heights * tile.height)
    size = tile.size if any(tile.size) or found.size is None else found.size
    return msgspec.structs.replace(tile, points=points, packed=text, size=size)


def read_heights(path: Path) -> Heights:
    """The heights of a file.

    Raises:
        OSError: it cannot be read.
        ValueError: it is damaged, too large, or of another kind.
    """
    kinds: dict[str, Callable[[Path], Heights]] = {".png": _png, ".npy": _npy, ".csv": _csv, ".xml": _hfield}
    if path.suffix.lower() not in kinds:
        raise ValueError(f"heights are read from {', '.join(READ)}")
    found = kinds[path.suffix.lower()](path)
    _check(found.heights)
    return found


def _check(heights: Floats) -> None:
    most = LIMITS["heights"].most
    if heights.ndim != 2 or min(heights.shape) < 2:
        raise ValueError("heights are a table of at least 2 rows and 2 columns")
    if heights.size > most:
        raise ValueError(
            f"a grid of {heights.shape[1]} x {heights.shape[0]} has more points than {most}, the limit `heights`"
        )
    if not np.isfinite(heights).all():
        row, column = np.argwhere(~np.isfinite(heights))[0]
        raise ValueError(f"row {row + 1}, column {column + 1} is not a finite number")


def _png(path: Path) -> Heights:
    picture = grey_values(read_file(path, "model"), LIMITS["heights"].most)
    return Heights(picture[::-1, ::-1])  # from the last row, forward; from right to left, as x goes


def _npy(path: Path) -> Heights:
    try:
        table = np.load(io.BytesIO(read_file(path, "model")), allow_pickle=False)
        if np.iscomplexobj(table):
            raise TypeError
        return Heights(np.asarray(table, dtype=np.float64))
    except NOT_NUMPY:
        raise ValueError("this is not a table of numbers of NumPy") from None


def _csv(path: Path) -> Heights:
    lines = read_file(path, "model").decode("utf-8-sig", errors="replace").splitlines()
    table: list[list[float]] = []
    for number, line in enumerate(lines, 1):
        words = [word for word in line.replace(",", " ").replace(";", " ").split() if word]
        if not words or words[0].startswith("#"):
            continue
        try:
            table.append([float(word) for word in words])
        except ValueError:
            raise ValueError(f"line {number} is not of numbers alone") from None
        if len(table[-1]) != len(table[0]):
            raise ValueError(
                f"line {number} has {number_of(len(table[-1]), 'number')}, and others have {len(table[0])}"
            )
    return Heights(np.array(table, dtype=np.float64))


def _hfield(path: Path) -> Heights:
    """The height field of a MuJoCo model, whose x is forward, y to the left and z up; see `_attributes`."""
    found, folder = _attributes(read_file(path, "model"))
    try:
        radius_x, radius_y, elevation, _ = (float(word) for word in found.get("size", "").split())
    except ValueError:
        raise ValueError("the hfield has no size of four numbers") from None
    if "file" in found:
        file = path.parent / folder / found["file"]
        try:
            data = read_file(file, "model")
        except OSError as error:
            raise ValueError(f"{Path(folder) / found['file']}: {unreadable(error)}") from None
        is_png = file.suffix.lower() == ".png"
        table = grey_values(data, LIMITS["heights"].most)[::-1] if is_png else _binary(data)
    else:
        table = _elevation(found)
    span = float(np.ptp(table))
    table = (table - table.min()) / (span or 1.0) * elevation  # as MuJoCo normalises it
    return Heights(table.T, (2.0 * radius_y, 2.0 * radius_x))


def _binary(data: bytes) -> Floats:
    """Numbers (rows, columns) of MuJoCo's own file: both counts as int32, then float32 row by row along y."""
    rows, columns = np.frombuffer(data[:8].ljust(8, b"\0"), "<i4").tolist()
    if rows < 1 or columns < 1 or len(data) != 8 + 4 * rows * columns:
        raise ValueError("the file of an hfield is neither a PNG picture nor MuJoCo's own with two counts and numbers")
    numbers: Floats = np.frombuffer(data, "<f4", offset=8).astype(np.float64).reshape(rows, columns)
    if not np.isfinite(numbers).all():
        raise ValueError("an elevation of the hfield is not a finite number")
    return numbers


def _elevation(found: dict[str, str]) -> Floats:
    """Numbers of an hfield (rows, columns) along y and x; the first row is the one at the back of the picture.

    An hfield of which only the size is told is level, as MuJoCo has it until a program fills it.
    """
    try:
        rows, columns = int(found["nrow"]), int(found["ncol"])
        numbers = np.array([float(word) for word in found.get("elevation", "").split()])
    except (KeyError, ValueError):
        raise ValueError("the hfield has no nrow and ncol, or its elevation is not of numbers") from None
    if not len(numbers) and 4 <= rows * columns <= LIMITS["heights"].most:
        numbers = np.zeros(rows * columns)
    if rows < 2 or columns < 2 or len(numbers) != rows * columns:
        raise ValueError(f"the hfield has {number_of(len(numbers), 'elevation')} for a grid of {rows} x {columns}")
    if not np.isfinite(numbers).all():
        raise ValueError("an elevation of the hfield is not a finite number")
    return numbers.reshape(rows, columns)[::-1]


def _attributes(data: bytes) -> tuple[dict[str, str], str]:
    """Attributes of an hfield of a model, and the folder of its files; `assetdir` is less than `meshdir`.

    It is that of the first geom that has one, or else the first one.
    """
    found: list[dict[str, str]] = []
    folders: dict[str, str] = {}
    of_geoms: list[str] = []
    others: list[str] = []  # files that it includes
    parser = expat.ParserCreate()

    def start(name: str, attributes: dict[str, str]) -> None:
        if name == "hfield":
            found.append(attributes)
        elif name == "geom" and "hfield" in attributes:
            of_geoms.append(attributes["hfield"])
        elif name == "compiler":
            folders.update(attributes)
        elif name == "include":
            others.append(attributes.get("file", ""))

    def refuse(*_: object) -> None:
        raise ValueError("models with entities are not read")

    parser.StartElementHandler, parser.EntityDeclHandler = start, refuse
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise ValueError(f"not valid XML in line {error.lineno}") from None
    if not found:
        hint = f"; name the file that it includes: {', '.join(others)}" if others else ""
        raise ValueError(f"this model has no hfield{hint}")
    used = [one for one in found if of_geoms[:1] == [_name(one)]]
    return (used or found)[0], folders.get("meshdir", folders.get("assetdir", ""))


def _name(hfield: dict[str, str]) -> str:
    """What geoms call an hfield: by its name, or by its file without the ending."""
    return hfield.get("name", Path(hfield.get("file", "")).stem)
