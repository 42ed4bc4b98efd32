"""Motions as files, of the kind that a name's ending says."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike

from warpmuscle.core.arguments import as_path
from warpmuscle.core.errors import ArgumentError
from warpmuscle.formats import sto
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.results.partial_motion import motion_of
from warpmuscle.results.records import Result
from warpmuscle.results.result import write
from warpmuscle.view.page import Page

RESULTS = (".h5", ".hdf5")
PAGES = (".html", ".htm")
FILMS = (".mp4", ".gif", ".webp")
OTHERS = {
    ".nc": "; a run's to_xarray().to_netcdf(path) writes one",
    ".parquet": "; a run's to_dataframe().to_parquet(path) writes one",
    ".xlsx": "; a run's to_dataframe().to_excel(path) writes one",
    ".toml": "; wm.save(run.scene, path) writes the scene",
    ".json": "; a run's to_dataframe().to_json(path) writes one",
    ".pkl": "; .h5 keeps all of it",
    ".npz": "; .h5 keeps all of it",
}
PICTURES = (".png", ".svg", ".pdf", ".jpg")


def keep(result: Result, path: str | PathLike[str], page: Callable[[], Page]) -> None:
    """Write a result to an HDF5 file, or its motion to a page, a table that OpenSim reads, or a film.

    Args:
        page: makes the page.

    Raises:
        ArgumentError: another ending of the name. Error: there is no motion, or the file cannot be written.
    """
    place = as_path(path, "path")
    suffix = place.suffix.lower()
    if suffix in RESULTS:
        write(place, result)
    elif suffix in PAGES:
        page().save(place)
    elif suffix in sto.SUFFIXES:
        sto.write(motion_of(result, "this result", 0), scene_in(result), place)
    elif suffix in FILMS:
        from warpmuscle.video import check_film, make_film
        from warpmuscle.video import write as write_film

        check_film(place)
        write_film(make_film(motion_of(result, "this result", 0), scene_in(result)), place)
    else:
        known = ", ".join((RESULTS[0], PAGES[0], *sto.SUFFIXES, *FILMS))
        hint = f"; plot(kind, {str(place)!r}) draws a figure" if suffix in PICTURES else ""
        hint = hint or OTHERS.get(suffix, "")
        raise ArgumentError(f"path must end in {known}, not {place.suffix!r}{hint}")
