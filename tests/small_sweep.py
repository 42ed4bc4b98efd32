"""A sweep of small runs, for tests."""

from pathlib import Path

import h5py
import numpy as np

RUNS = 8
SMALL = """
keep = "{keep}"
scene = "{scene}"
[set]
duration = {duration}
[search]
strategy = "cma"
population = 6
candidates = {candidates}
[grid]
seed = [1, 2]
"character.bodies.torso.mass" = [20, 30]
"objective.torque" = [1, 2]
"""


def small_sweep(
    folder: Path, candidates: int = 20, duration: float = 0.1, scene: str = "fwalk", keep: str = "all"
) -> Path:
    """A sweep file of 8 runs."""
    path = folder / "small.toml"
    path.write_text(SMALL.format(scene=scene, candidates=candidates, duration=duration, keep=keep))
    return path


OF_NOW = ("began", "commit", "host")
LINKS = ("DIMENSION_LIST", "REFERENCE_LIST")  # places in the file, of dimension scales


def contents(path: Path) -> dict[str, object]:
    """All datasets and attributes of an HDF5 file, by path."""
    found: dict[str, object] = {}

    def visit(name, item):
        found.update({f"{name}@{key}": value for key, value in item.attrs.items() if key not in (*LINKS, *OF_NOW)})
        if isinstance(item, h5py.Dataset):
            found[name] = item[()]

    with h5py.File(path) as file:
        visit("", file)
        file.visititems(visit)
    return found


def assert_same_file(path: Path, other: Path) -> None:
    """Two HDF5 files hold the same, to the last bit."""
    one, two = contents(path), contents(other)
    assert one.keys() == two.keys()
    for name in one:
        np.testing.assert_array_equal(one[name], two[name], err_msg=name)
