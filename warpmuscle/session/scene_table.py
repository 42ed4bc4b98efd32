"""The shipped scenes as a table."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, overload

from warpmuscle.core.arguments import answering, as_text
from warpmuscle.core.errors import ArgumentError, lacking
from warpmuscle.core.extras import imported
from warpmuscle.core.html_table import html_table
from warpmuscle.formats import load, scene_names
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.validation.checks import near

if TYPE_CHECKING:
    import pandas


INSTEAD = {
    **dict.fromkeys(("head", "tail", "loc", "iloc", "sort_values", "query", "columns"), "to_dataframe() has it"),
    **dict.fromkeys(("show", "plot", "print"), "print(wm.scenes()) lists them, wm.show('walk56') shows one"),
    **dict.fromkeys(("to_pandas", "df"), "to_dataframe() is a table of pandas"),
    **dict.fromkeys(("keys", "list"), "names has the names of all"),
    **dict.fromkeys(("search", "find", "filter"), "wm.scenes('stairs') are those with this word"),
}  # by what is often tried


@dataclass(frozen=True, order=True)
class SceneRow:
    """A shipped scene."""

    name: str
    description: str
    bodies: int
    muscles: int
    free: int  # numbers that a search may change
    duration: float  # s


class SceneTable(Sequence[SceneRow]):
    """Shipped scenes, sorted by name; notebooks show a table."""

    def __init__(self, rows: Sequence[SceneRow]) -> None:
        self._rows = tuple(rows)

    @overload
    def __getitem__(self, index: int) -> SceneRow: ...
    @overload
    def __getitem__(self, index: slice) -> SceneTable: ...
    @overload
    def __getitem__(self, index: str) -> SceneRow: ...
    def __getitem__(self, index: int | slice | str) -> SceneRow | SceneTable:
        """A row by its number or its scene's name, or a table of some.

        Raises:
            ArgumentError: no scene of the table is called so.
        """
        if isinstance(index, str):
            if index not in self.names:
                raise ArgumentError(f"no scene is called {index!r}{near(index, self.names)}")
            return self._rows[self.names.index(index)]
        return SceneTable(self._rows[index]) if isinstance(index, slice) else self._rows[index]

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Say what to type instead of what is often tried."""
            known = () if name.startswith("_") else self.names
            row = {name: f"scenes()[{name!r}] is its row, wm.load({name!r}) reads it"} if name in known else {}
            raise lacking("a table of scenes", name, dir(type(self)), INSTEAD | row)

    def __len__(self) -> int:
        """Number of scenes."""
        return len(self._rows)

    def __iter__(self) -> Iterator[SceneRow]:
        """Row by row."""
        return iter(self._rows)

    def __contains__(self, name: object) -> bool:
        """Whether a scene of this name is among them, or this row is."""
        return name in self.names or name in self._rows

    @property
    def names(self) -> tuple[str, ...]:
        """What `load` and `simulate` take."""
        return tuple(row.name for row in self._rows)

    def to_dataframe(self) -> pandas.DataFrame:
        """The table as a `pandas.DataFrame`, a row a scene."""
        package = imported("pandas", "a table of scenes as a DataFrame needs")
        return package.DataFrame([vars(row) for row in self._rows], columns=[one.name for one in fields(SceneRow)])

    def __repr__(self) -> str:
        width = max((len(name) for name in self.names), default=0)
        return "\n".join(f"{row.name:{width}}  {row.description}" for row in self._rows)

    def _repr_html_(self) -> str:
        rows = [
            (row.name, row.description, str(row.bodies), str(row.muscles), str(row.free), f"{row.duration:g}")
            for row in self._rows
        ]
        return html_table(("scene", "what it is", "bodies", "muscles", "free numbers", "duration, s"), rows)


@answering(
    {
        **dict.fromkeys(
            ("muscles", "bodies", "n", "filter"), "wm.scenes('56') are those with this word; to_dataframe() sorts"
        ),
        **dict.fromkeys(("name", "search", "pattern", "query"), "words='stairs' are those with this word"),
    }
)
def scenes(words: str = "") -> SceneTable:
    """The scenes that come with the package; `scenes().names` are what `load` and `simulate` take.

    Args:
        words: only scenes with all of these in their names or descriptions, such as "walk hills".
    """
    asked = as_text(words, "words").lower().split()
    rows = [_row(name) for name in scene_names()]
    return SceneTable([row for row in rows if all(word in f"{row.name} {row.description}".lower() for word in asked)])


@functools.cache
def _row(name: str) -> SceneRow:
    scene = load(name)
    character = scene.character
    return SceneRow(
        name, scene.description, len(character.bodies), len(character.muscles), len(free_parameters(scene)),
        scene.duration,
    )  # fmt: skip
