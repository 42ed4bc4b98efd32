"""What all figures share: colours, sizes of text, headings, curves with their spread, and how they become files."""

from __future__ import annotations

import contextlib
import io
import sys
import unicodedata
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.extras import imported
from warpmuscle.core.files import check_output, replace_file
from warpmuscle.core.sequences import rising
from warpmuscle.gait.cycles import PERCENT

# Okabe and Ito's palette: told apart with any kind of colour vision.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#404040")
SIDE_COLORS = {"left": "#0072B2", "right": "#D55E00", "middle": "#404040"}
GRAY, BAND_COLOR = "#707070", "#DDDDDD"
LONGEST, LONGEST_NAME = 240, 100  # letters of a line of a figure's text, and of one at its axes
UNSEEN = ("Cc", "Cf", "Cs", "Zl", "Zp")  # categories of what is no letter, and what turns the order of others
MAP = "viridis"  # of numbers without a middle
WIDTH = 9.0  # inches
ENDINGS = (".png", ".svg", ".pdf")
_DPI = 160
_FONTS, _FONTS_ELSEWHERE = b"'DejaVu Sans', sans-serif", b"'DejaVu Sans', Verdana, sans-serif"  # as wide
_LEADER = {
    "arrowstyle": "-",
    "lw": 0.5,
    "shrinkA": 0.0,
    "shrinkB": 0.0,
    "relpos": (0.0, 0.5),
}  # from a name to its curve
_STYLE = {
    "font.size": 9.0,
    "font.family": ["DejaVu Sans", "sans-serif"],
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.prop_cycle": None,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.linewidth": 1.5,
    "lines.solid_capstyle": "round",
    "lines.solid_joinstyle": "round",
    "text.parse_math": False,  # a name with dollars is no formula
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "warpmuscle",  # the same figure gives the same bytes
}


def matplotlib() -> Any:
    """The module, without pyplot and its windows; raises Error if it is not installed.

    When first imported here it forgets what a `matplotlibrc`, which may lie in the current folder, says: such a file
    can have text typeset by other programs.
    """
    is_new = "matplotlib" not in sys.modules
    module = imported("matplotlib", "figures need")
    imported("matplotlib.figure", "figures need")
    if is_new:
        module.rcdefaults()
    return module


@contextlib.contextmanager
def style() -> Iterator[None]:
    """Draw in the package's style within, whatever a `matplotlibrc` of the user or the current folder says."""
    module = matplotlib()
    from cycler import cycler  # comes with matplotlib

    with module.rc_context():
        module.rcdefaults()
        module.rcParams.update(_STYLE | {"axes.prop_cycle": cycler(color=PALETTE)})
        yield


def page(height: float, width: float = WIDTH) -> Any:
    """An empty figure of this height and width, inches, whose panels keep clear of each other."""
    return empty_figure(figsize=(width, height), layout="constrained")


def empty_figure(**options: Any) -> Any:
    """A figure that notebooks show; options are those of matplotlib's."""
    matplotlib()
    from warpmuscle.plots.inline_figure import InlineFigure

    return InlineFigure(**options)


def grid(count: int, columns: int, row_height: float, **further: Any) -> tuple[Any, list[Any]]:
    """A figure and `count` panels, row by row."""
    columns = min(columns, count)
    rows = -(-count // columns)
    figure = page(row_height * rows + 0.75)
    panels = list(figure.subplots(rows, columns, squeeze=False, **further).flat)
    for spare in panels[count:]:
        spare.remove()
    return figure, panels[:count]


def heading(figure: Any, title: str, note: str = "") -> None:
    """A bold title at the top left, and below it a line that says what the figure shows."""
    height = figure.get_figheight()
    figure.text(0.008, 1.0 - 0.06 / height, title, weight="bold", size=11.0, va="top")
    if note:
        figure.text(0.008, 1.0 - 0.28 / height, note, color=GRAY, size=8.0, va="top")
    figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - (0.48 if note else 0.3) / height))


def mean_and_spread(axes: Any, x: Floats, curves: Floats, side: str) -> None:
    """The mean of curves (S, n) of one side, and around it one standard deviation; right lies thin over left."""
    mean, deviation, color = curves.mean(axis=0), curves.std(axis=0), SIDE_COLORS[side]
    axes.fill_between(x, mean - deviation, mean + deviation, color=color, alpha=0.25, lw=0.0)
    axes.plot(x, mean, color=color, label=side, lw=1.1 if side == "right" else 2.2)


def cycle_axis(axes: Any) -> None:
    """Ticks of an axis over the gait cycle."""
    axes.set(xlim=(0.0, 100.0), xticks=(0, 25, 50, 75, 100))


def all_handles(axes: Sequence[Any]) -> dict[str, Any]:
    """What the legends of several panels show, by label, each once."""
    shown: dict[str, Any] = {}
    for one in axes:
        for line, label in zip(*one.get_legend_handles_labels(), strict=True):
            shown.setdefault(label, line)
    return shown


def cycle_curves(axes: Any, sides: Mapping[str, Floats]) -> None:
    """Means and spreads of both sides over the gait cycle, where all cycles have a value, on an axis from 0."""
    for side, rows in sides.items():
        often = np.isfinite(rows).mean(axis=0) == 1.0
        mean_and_spread(axes, PERCENT, np.where(often, rows, np.nan), side)
    axes.axhline(0.0, color=GRAY, lw=0.6, zorder=0)
    cycle_axis(axes)


def top_legend(figure: Any, handles: Any, labels: Sequence[str]) -> None:
    """A legend in one row at the top right, beside the heading."""
    figure.legend(handles, labels, loc="upper right", ncols=len(labels), borderaxespad=0.1).set_in_layout(False)


def label_ends(axes: Any, labels: Sequence[tuple[float, str, Any]], size: float = 7.0) -> None:
    """Names of curves at the right edge of a panel, moved apart where they would overlap.

    Args:
        labels: height where the curve ends, name and colour of each. The panel's limits are final.
    """
    low, high = axes.get_ylim()
    inches = axes.get_position().height * axes.figure.get_figheight()
    least = (high - low) * 1.15 * size / 72.0 / max(inches, 0.1)
    ordered = sorted(labels, key=lambda entry: entry[0])
    for height, (end, name, color) in zip(apart([entry[0] for entry in ordered], least), ordered, strict=True):
        axes.annotate(
            name, (1.0, end), (1.06, height), axes.get_yaxis_transform(), color=color, size=size, va="center",
            annotation_clip=False, arrowprops=_LEADER | {"color": color},
        )  # fmt: skip


def apart(heights: Sequence[float], least: float) -> Floats:
    """Heights in ascending order, moved as little as possible so that neighbours are `least` apart."""
    steps = least * np.arange(len(heights))
    return np.asarray(rising(np.asarray(heights) - steps) + steps)


def legible(text: str, longest: int = LONGEST_NAME) -> str:
    """A text, some of which may be names, as lines that can be drawn: without control characters, and not too long."""
    lines = text.split("\n")
    seen = ["".join("\ufffd" if unicodedata.category(c) in UNSEEN else c for c in line) for line in lines]
    return "\n".join(line if len(line) <= longest else f"{line[: longest - 1]}\u2026" for line in seen)


def picture(figure: Any, ending: str, dpi: int = _DPI) -> bytes:
    """A figure as the content of a file, the same bytes for the same figure."""
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        longest = LONGEST if text in figure.texts else LONGEST_NAME
        if (drawn := legible(text.get_text(), longest)) != text.get_text():
            text.set_text(drawn)
    image = io.BytesIO()
    meta = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(ending)
    with style(), warnings.catch_warnings():
        # Letters that the font lacks are boxes in the picture, where all can see them; a terminal need not list them.
        warnings.filterwarnings("ignore", "Glyph .* missing from font", UserWarning)
        figure.savefig(image, format=ending[1:], dpi=dpi, metadata=meta)
    return image.getvalue().replace(_FONTS, _FONTS_ELSEWHERE) if ending == ".svg" else image.getvalue()


def check_picture(path: Path) -> None:
    """Raise Error now, rather than after the work, if no figure can be written to a file of this name."""
    check_output(path, "a figure", ENDINGS)


def save(figure: Any, path: str | Path) -> None:
    """Write a figure whole or not at all; the name's ending (.png, .svg, .pdf) chooses the format.

    Raises:
        Error: another ending, or the file cannot be written.
    """
    path = Path(path)
    check_picture(path)
    replace_file(path, picture(figure, path.suffix.lower()))
