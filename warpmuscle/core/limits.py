"""How large inputs may be: what is beyond is refused before work starts, rather than running for hours in silence.

Everything here is far beyond what experiments need and well within what a machine bears. What a batch of simulations
needs is compared with the memory that a device has left instead (see `memory.py`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from warpmuscle.core.errors import Error


class Limit(NamedTuple):
    """The greatest size of something."""

    most: int
    of: str  # what is counted, in the plural
    why: str


LIMITS: dict[str, Limit] = {
    "text": Limit(2**23, "bytes", "of a scene, a sweep or a file of the original program: seconds to read"),
    "table": Limit(2**30, "bytes", "of a recording as a table or in C3D: some gigabytes of memory"),
    "model": Limit(2**26, "bytes", "of an OpenSim model: seconds to read"),
    "mesh": Limit(2**26, "bytes", "of a file of triangles to draw, and of what it holds unpacked"),
    "triangles": Limit(2_000_000, "triangles", "of such a file: seconds to make fewer of them"),
    "elements": Limit(500_000, "elements", "of such a model: some hundred megabytes of memory"),
    "asked": Limit(2**24, "numbers", "that one element of a MuJoCo model asks for, such as a grid of heights: memory"),
    "nesting": Limit(50, "tables, lists or elements in each other", "of a TOML file or an OpenSim model"),
    "bases": Limit(50, "scenes based on each other", "of a scene"),
    "values": Limit(500_000, "values", "of a scene, its curves and paths included: seconds to check"),
    "bodies": Limit(500, "bodies", "of a character: each adds to the working set of a step"),
    "constraints": Limit(60, "rows", "of all constraints of a character, whose equations are solved in each step"),
    "muscles": Limit(5_000, "muscles", "of a character"),
    "knots": Limit(1_000, "knots", "of a ligament's function, which are asked one after the other"),
    "heights": Limit(2**20, "points", "of the height fields of a scene, each: megabytes of text in it"),
    "profile": Limit(1_000, "points", "of a treadmill's profile, which are asked one after the other"),
    "solids": Limit(16, "objects", "of a scene, which a step moves one after the other"),
    "tiles": Limit(2**24, "points", "of all tiles of a scene together, which a device keeps"),
    "parameters": Limit(2_000, "free parameters", "of a search: CMA-ES takes their cube in time"),
    "steps": Limit(10**7, "steps", "of a simulation, duration / time_step: minutes even if it is alone"),
    "delay": Limit(2**16, "steps", "of a muscle's delay, which are kept for each instance"),
    "frames": Limit(500_000, "frames", "of a recorded motion, record rate x duration, for which there must be memory"),
    "runs": Limit(10_000, "disturbed runs", "of a candidate"),
    "candidates": Limit(10**9, "candidates", "of an optimisation"),
    "searches": Limit(1_000, "searches", "at the same time"),
    "population": Limit(10**6, "candidates a generation", "of all searches together"),
    "sweep": Limit(100_000, "runs", "of a sweep: the scene of each is checked before the first begins"),
    "threads": Limit(1_024, "threads", "of a batch on a CPU"),
    "film": Limit(50_000, "frames", "of a film: half an hour to draw"),
    "samples": Limit(10**8, "numbers", "of a recording, samples x channels, also after resampling"),
    "restarts": Limit(1_000, "factorisations", "of each number of synergies"),
    "objects": Limit(200_000, "groups and datasets", "of an HDF5 file"),
    "unpacked": Limit(
        2**32, "bytes", "of all arrays of an HDF5 file; also 100 times its size, if that is over 256 MiB"
    ),
    "names": Limit(200_000, "texts", "of a list in an HDF5 file"),
    "characters": Limit(2**26, "characters", "of such a list"),
    "archive": Limit(2**31, "bytes", "of all arrays of an `.npz` file, unpacked"),
}


GREATEST_NUMBER = 1e12  # of a scene, in its own unit: products of three are finite in single precision
LEAST_NUMBER = 1e-12  # of a scene, where it must be positive: so is what is divided by it
LEAST_MOMENT = 1e-18  # kg m^2, of a body's inertia: legs of a fly have 1e-13


def check_size(name: str, size: float, error: Callable[[str], Exception] = Error) -> None:
    """Raise an error unless a size is within the limit of this name.

    Args:
        error: makes the error from its text, such as with a key or a file.
    """
    limit = LIMITS[name]
    if not size <= limit.most:
        many = f"{size:.6g}" if -1e15 < size < 1e15 else "far too many" if size > 0 else f"{size}"
        raise error(f"{many} {limit.of} are more than {limit.most}, the limit `{name}`")
