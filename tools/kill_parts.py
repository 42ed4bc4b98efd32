"""A sweep in a hundred parts, some of which are killed and begun again, joined, beside one process that runs all of it.

    .venv/bin/python tools/kill_parts.py                                # 10^4 simulations: 1000 runs of 10
    .venv/bin/python tools/kill_parts.py --runs 1000 --candidates 1000 --duration 0.005 --strategy random \\
        --population 100                                               # 10^6

Parts that are killed are processes of their own, which SIGKILL ends as soon as they have evaluated something; others
run in this one. Both files must hold the same, to the last bit, but for when and where they began.
"""

from __future__ import annotations

import argparse
import hashlib
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.sweep.join import join
from warpmuscle.sweep.part import Part
from warpmuscle.sweep.plan import read
from warpmuscle.sweep.run import sweep
from warpmuscle.sweep.status import states_of

TEXT = """scene = "fwalk"
[set]
duration = {duration}
[search]
strategy = "{strategy}"
population = {population}
candidates = {candidates}
{sigma}
[grid]
seed = {seeds}
"controller.pd.root.kp" = {gains}
"""
OF_NOW = ("began", "commit", "host")
LINKS = ("DIMENSION_LIST", "REFERENCE_LIST")  # places in the file, of dimension scales


def main() -> None:
    """Run both and compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--candidates", type=int, default=10)
    parser.add_argument("--strategy", default="cma", help="random has no work but simulations")
    parser.add_argument("--population", type=int, default=5)
    parser.add_argument("--duration", type=float, default=0.05, help="of a simulation, s")
    parser.add_argument("--parts", type=int, default=100)
    parser.add_argument("--killed", type=int, default=5)
    parser.add_argument("--device", default="cpu")
    given = parser.parse_args()
    gains = [1000.0 + 10.0 * k for k in range(10)]
    seeds = list(range(1, given.runs // len(gains) + 1))
    text = TEXT.format(
        duration=given.duration, candidates=given.candidates, seeds=seeds, gains=gains, strategy=given.strategy,
        population=given.population, sigma="sigma = 0.05" if given.strategy == "cma" else "",
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as name:
        folders = [Path(name) / word for word in ("parts", "whole")]
        for folder in folders:
            folder.mkdir()
            (folder / "many.toml").write_text(text)
        file, output = folders[0] / "many.toml", folders[0] / "many.h5"
        step = max(given.parts // given.killed, 1)
        killed = [number for number in range(1, given.parts + 1) if number % step == 0][: given.killed]
        begin = time.perf_counter()
        ended = [kill(folders[0], Part(number, given.parts), given.device) for number in killed]
        for number in range(1, given.parts + 1):
            sweep(file, output, device=given.device, part=f"{number}/{given.parts}", command="test")
        join(read(file), output, command="test")
        print(
            f"{given.parts} parts, {len(killed)} killed after {ended} candidates: {time.perf_counter() - begin:.0f} s"
        )
        begin = time.perf_counter()
        sweep(folders[1] / "many.toml", folders[1] / "many.h5", device=given.device, command="test")
        print(f"one process: {time.perf_counter() - begin:.0f} s")
        one, other = (digest(folder / "many.h5") for folder in folders)
    simulations = given.runs * given.candidates
    print(f"{simulations} simulations: {'the same' if one == other else 'NOT the same'}, {one[:16]} and {other[:16]}")
    sys.exit(one != other)


def kill(folder: Path, part: Part, device: str) -> int:
    """Start a part and kill it once it has evaluated something; how many candidates it had evaluated."""
    words = ["sweep", "many.toml", "--part", str(part), "--device", device]
    process = subprocess.Popen(
        [sys.executable, "-m", "warpmuscle", *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    found = 0
    while process.poll() is None and not found:
        time.sleep(0.02)
        try:
            place = part.folder(folder / "many.h5")
            found = sum(state.evaluated for state in states_of(place, place.manifest()))
        except Error:
            continue
    process.kill()
    process.wait()
    return found


def digest(path: Path) -> str:
    """A digest of all datasets and attributes of an HDF5 file but when and where it began."""
    found: list[tuple[str, bytes]] = []

    def visit(name: str, item: h5py.Group | h5py.Dataset) -> None:
        for key, value in item.attrs.items():
            if key not in (*LINKS, *OF_NOW):
                found.append((f"{name}@{key}", repr(value).encode()))
        if isinstance(item, h5py.Dataset):
            value = item[()]
            texts = item.dtype.kind == "O"
            found.append((name, repr(np.asarray(value, dtype=object).tolist()).encode() if texts else value.tobytes()))

    with h5py.File(path) as file:
        visit("", file)
        file.visititems(visit)
    whole = hashlib.sha256()
    for name, content in sorted(found):
        whole.update(name.encode() + b"\0" + content + b"\0")
    return whole.hexdigest()


if __name__ == "__main__":
    main()
