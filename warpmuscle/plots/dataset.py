"""Any numbers of a result file by their name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np

from warpmuscle.core.array_checks import HUGE
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.plots.style import MAP, PALETTE, grid, heading, legible, page, top_legend
from warpmuscle.plots.subject import Subject
from warpmuscle.results.result import opened
from warpmuscle.scene.validation.checks import near

_LINES = 7  # in one panel; more become rows of a map
_PANELS = 36


@dataclass(frozen=True)
class Data:
    """A dataset as it is drawn: first its axis along the page."""

    values: Floats  # (n, ...), at most three axes
    x: Floats  # (n,)
    x_label: str
    label: str  # of the values, with their unit
    names: list[list[str]]  # of the members of each further axis
    description: str
    mixed: bool = False  # whether members of the second axis have units of their own


def draw(subject: Subject, name: str) -> Any:
    """Curves over the dataset's first axis: lines, a map if there are many, or a panel a member of the second axis.

    Raises:
        Error: no such dataset, or one without numbers to draw.
    """
    data = _read(subject, name)
    if data.values.ndim == 3:
        figure = _panels(subject, data)
    elif data.values.ndim == 2 and data.values.shape[1] > _LINES:
        figure = _map(data)
    else:
        figure = page(3.2)
        axes = figure.subplots()
        _lines(axes, data.x, data.values.reshape(len(data.x), -1), data.names[0] if data.names else [""])
        axes.set(xlabel=data.x_label, ylabel=data.label)
        if data.names:
            figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=_LINES)
    heading(figure, f"{subject.scene.name}: {name}", data.description)
    return figure


def _read(subject: Subject, name: str) -> Data:
    if subject.path is None:
        raise Error("a dataset is drawn from a file")
    with opened(subject.path, subject.run) as root:
        numeric: list[str] = []
        root.visititems(lambda path, item: numeric.append(f"/{path}") if _drawable(item) else None)
        wanted = "/" + name.strip("/")
        found = root.get(wanted[1:]) if wanted != "/" else None
        row: int | None = None
        if found is None:
            found, row = _of_instance(root, wanted)
        if found is None:
            raise Error(f"{subject.path} has no dataset {name!r}{near(wanted, numeric)}; {_listed(numeric)}")
        if not _drawable(found, 4 if row is not None else 3):
            raise Error(f"{subject.path}: {wanted} is {_kind(found)}; {_listed(numeric)}")
        values = np.asarray(found[()] if row is None else found[row], dtype=float)
        axes = [axis.strip() for axis in str(found.attrs.get("axes", "")).split(",")][0 if row is None else 1 :]
        axes += [""] * (values.ndim - len(axes))
        if "sample" in axes[1:]:  # of recorded motions, the first axis of whose datasets counts them
            values, axes = np.moveaxis(values, axes.index("sample"), 0), ["sample", *(a for a in axes if a != "sample")]
        if row is not None:
            values = values[: found.parent["frames"][row]]
        if np.any(np.abs(values) > HUGE):
            raise Error(f"{subject.path}: {wanted} holds numbers too large to draw, beyond {HUGE:g}")
        x, x_label = np.arange(len(values), dtype=float), axes[0] or "row"
        if axes[0] == "frame" and "time" in found.parent:
            x, x_label = found.parent["time"][: len(values)].astype(float), "time (s)"
        elif axes[0] == "sample" and len(values) == len(root["motions/time"]):
            x, x_label = root["motions/time"][()].astype(float), "time (s)"
        names = [_members(root, found, axis, size) for axis, size in zip(axes[1:], values.shape[1:], strict=True)]
        unit = str(found.attrs.get("units", "1"))
        label = wanted.rsplit("/", 1)[1].replace("_", " ") + (f" ({unit})" if unit != "1" else "")
        return Data(values, x, x_label, label, names, str(found.attrs.get("description", "")), "parameter" in axes[1:])


def _of_instance(root: Any, wanted: str) -> tuple[Any, int | None]:
    """The array and the row of `/replay/<k>/com` in a file whose motions are arrays over instances; else nothing."""
    parts = wanted.split("/")[1:]
    if len(parts) == 3 and parts[0] == "replay" and parts[1].isdigit() and "replay/frames" in root:
        found, row = root.get(f"replay/{parts[2]}"), int(parts[1])
        if isinstance(found, h5py.Dataset) and found.ndim > 1 and row < len(found):
            return found, row
    return None, None


def _drawable(item: Any, most: int = 3) -> bool:
    """Whether an object of the file holds numbers along one to three axes, or as many as are drawn."""
    return isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu" and 1 <= item.ndim <= most and item.size > 0


def _kind(item: Any) -> str:
    if not isinstance(item, h5py.Dataset):
        return "a group"
    if item.dtype.kind not in "fiu":
        return "text"
    return "empty" if item.size == 0 else f"the number {item[()]:g}" if item.ndim == 0 else "of too many axes"


def _listed(names: list[str]) -> str:
    """Datasets by their groups; of several motions or searches, which hold the same, only the first."""
    groups: dict[str, list[str]] = {}
    for name in names:
        group, _, member = name.rpartition("/")
        groups.setdefault(group, []).append(member)
    shown = [group for group in groups if not group.rpartition("/")[2].isdigit() or group.endswith("/0")]
    return "there are " + " ".join(f"{group}/{{{','.join(groups[group])}}}" for group in shown)


def _members(root: Any, dataset: Any, axis: str, size: int) -> list[str]:
    """Names along an axis: those of its own table, the words of its own name, or numbers."""
    for group in (dataset.parent, root.get("parameters", {}) if axis == "parameter" else {}):
        for table in (f"{axis}_names", "name"):
            if table in group and (axis == "parameter") == (table == "name"):
                return [str(text) for text in group[table].asstr()[()]]
    if axis in ("motion", "joint") and (table := {"motion": "names", "joint": "joints"}[axis]) in root.get(
        "motions", {}
    ):
        return [str(text) for text in root["motions"][table].asstr()[()]]
    words = axis.split()
    return words if len(words) == size else [str(k) for k in range(size)]


def _lines(axes: Any, x: Floats, values: Floats, names: list[str]) -> None:
    for k, name in enumerate(names):
        color = PALETTE[k % len(PALETTE)]
        axes.plot(x, values[:, k], color=color, lw=1.2, label=name, ls=("-", "--")[k // len(PALETTE) % 2])
    axes.margins(x=0.0)


def _panels(subject: Subject, data: Data) -> Any:
    """A panel a member of the second axis, such as a joint."""
    members = data.names[0]
    if len(members) > _PANELS:
        raise Error(
            f"{subject.path}: this dataset would need {number_of(len(members), 'panel')}; {_PANELS} fit on a page"
        )
    figure, panels = grid(len(members), min(4, len(members)), 1.6, sharex=True)
    for k, (axes, name) in enumerate(zip(panels, members, strict=True)):
        _lines(axes, data.x, data.values[:, k], data.names[1])
        axes.set(title=name)
    for axes in panels[-min(4, len(members)) :]:
        axes.set_xlabel(data.x_label)
        axes.tick_params(labelbottom=True)
    figure.supylabel(data.label, size=9.0)
    top_legend(figure, *panels[0].get_legend_handles_labels())
    return figure


def _map(data: Data) -> Any:
    """A row a member of the second axis."""
    names = data.names[0]
    figure = page(max(0.165 * len(names), 1.2) + 1.2)
    axes = figure.subplots()
    values, label = data.values, data.label
    if data.mixed:
        low, high = np.nanmin(values, axis=0), np.nanmax(values, axis=0)
        values = (values - low) / np.where(high > low, high - low, 1.0)
        label += ", part of each row's range"
    low, high = np.nanpercentile(values, [0.0, 100.0])
    extent = (float(data.x[0]), float(data.x[-1]), len(names), 0.0)
    both = low < 0.0 < high
    limits = {"vmin": -max(-low, high), "vmax": max(-low, high), "cmap": "PuOr"} if both else {"cmap": MAP}
    image = axes.imshow(values.T, aspect="auto", interpolation="nearest", extent=extent, **limits)
    axes.set_yticks(np.arange(len(names)) + 0.5, [legible(name) for name in names], size=7.5)
    axes.tick_params(axis="y", length=0.0)
    axes.set(xlabel=data.x_label)
    figure.colorbar(image, ax=axes, shrink=0.7, aspect=25, label=label)
    return figure
