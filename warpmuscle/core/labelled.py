"""Arrays with names along their axes as tables of pandas and xarray, which the extra `data` of the package brings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.extras import imported

if TYPE_CHECKING:
    import pandas
    import xarray


class Labelled(NamedTuple):
    """An array whose axes have names."""

    name: str
    axes: tuple[str, ...]  # one an axis, along which `Labels` may have something
    values: NDArray[Any]
    attributes: Mapping[str, str] = {}  # such as units


Labels = Mapping[str, Sequence[str]]  # by axis, what stands along it


def to_xarray(index: Labelled, arrays: Sequence[Labelled], labels: Labels) -> xarray.Dataset:
    """All arrays in one set, by name.

    Args:
        index: what stands along the axis of its name.

    Raises:
        Error: xarray is not installed.
    """
    along = {axis: ((axis,), np.array(words, dtype=str)) for axis, words in labels.items()}
    along[index.name] = ((index.name,), index.values, dict(index.attributes))  # type: ignore[assignment]
    variables = {one.name: (one.axes, one.values, dict(one.attributes)) for one in arrays}
    found: xarray.Dataset = imported("xarray").Dataset(variables, coords=along)
    return found


def to_dataframe(index: Labelled, arrays: Sequence[Labelled], labels: Labels) -> pandas.DataFrame:
    """A row for each entry of the index, a column for each number: `com.x`, `muscle_force.rSOL`.

    Args:
        index: one number a row. arrays: their first axis is that of the index.

    Raises:
        Error: pandas is not installed.
    """
    package = imported("pandas")
    columns = [column for one in arrays for column in _columns(one, labels)]
    table = dict(zip((name for name, _ in columns), (values for _, values in columns), strict=True))
    found: pandas.DataFrame = package.DataFrame(table, index=package.Index(index.values, name=index.name))
    return found


def _columns(one: Labelled, labels: Labels) -> Iterator[tuple[str, NDArray[Any]]]:
    """Names and values of the columns that an array becomes."""
    words = [labels[axis] for axis in one.axes[1:]]
    for place in np.ndindex(*map(len, words)):
        name = ".".join([one.name, *(along[k] for along, k in zip(words, place, strict=True))])
        yield name, one.values[(slice(None), *place)]
