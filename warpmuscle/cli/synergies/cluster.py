"""The command that finds what synergies of several people have in common."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from warpmuscle.cli.common import Figure, writable
from warpmuscle.cli.console import out
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from warpmuscle.synergy.clusters import Clusters

AUTO = "auto"


def cluster(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="SYNERGIES...", help="HDF5 files of `synergies extract`, one for each person."),
    ],
    number: Annotated[
        str, typer.Option("--number", "-n", help="How many clusters; auto: the number that separates them best.")
    ] = AUTO,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="CSV to write, with a line for each module.")
    ] = None,
    plot: Figure = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the starts of k-means.")] = 0,
) -> None:
    """Sort the synergies of several people by likeness: k-means on their modules, the columns of W.

    Example: warpmuscle synergies cluster anna.h5 ben.h5 cem.h5 -o modules.csv --plot modules.png
    """
    from warpmuscle.core.extras import need
    from warpmuscle.synergy.clusters import cluster_modules
    from warpmuscle.synergy.files import read

    writable(output, plot)
    need("sklearn", "clusters need")
    if number != AUTO and not (number.isdecimal() and int(number) > 0):
        raise Error(f"a number of clusters is at least 1, or {AUTO}, not {number!r}")
    results = [read(path) for path in files]
    found = cluster_modules(
        [result.synergies.weights for result in results], [result.activations.muscles for result in results],
        None if number == AUTO else int(number), seed,
    )  # fmt: skip
    _print(found, len(files))
    if output is not None:
        _write(output, found, files)
        out.print(f"wrote {output}")
    if plot is not None:
        from warpmuscle.plots.clusters import draw_clusters

        draw_clusters(plot, found, [path.stem for path in files])
        out.print(f"wrote {plot}")


def _print(found: Clusters, people: int) -> None:
    """Print the clusters' centres, and how many people have them."""
    modules = len(found.label)
    scores = ", ".join(f"{k}: {score:.3f}" for k, score in found.silhouette.items())
    out.print(
        f"{number_of(modules, 'module')} of {people} people in {number_of(found.count, 'cluster')}; mean "
        f"silhouette by number {scores}"
    )
    table = Table(f"{number_of(found.count, 'cluster')}", *(f"m{k + 1}" for k in range(found.count)))
    for row, muscle in enumerate(found.muscles):
        table.add_row(muscle, *(f"{value:.3f}" for value in found.centre[row]))
    table.add_row("people", *(f"{found.people(k)}" for k in range(found.count)), style="italic")
    table.add_row("modules", *(f"{(found.label == k).sum()}" for k in range(found.count)), style="italic")
    least = [found.cosine[found.label == k].min() for k in range(found.count)]
    table.add_row("lowest cosine", *(f"{value:.3f}" for value in least), style="italic")
    out.print(table)


def _write(path: Path, found: Clusters, files: Sequence[Path]) -> None:
    """A line a module: its file, number, cluster, likeness and weights."""
    from warpmuscle.core.files import replace_result

    memory = io.StringIO()
    table = csv.writer(memory, lineterminator="\n")
    table.writerow(["file", "synergy", "cluster", "cosine", *found.muscles])
    for k in range(len(found.label)):
        start = [str(files[found.person[k]]), found.number[k] + 1, found.label[k] + 1, f"{found.cosine[k]:.6f}"]
        table.writerow([*start, *(f"{weight:.6f}" for weight in found.modules[:, k])])
    replace_result(path, memory.getvalue().encode())
