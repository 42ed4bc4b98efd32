"""A sweep of many short simulations in parts, some of them killed, beside the same sweep in one process.

    .venv/bin/python tools/research/parts_table.py FOLDER --runs 1000 --candidates 1000 --parts 100 --kill 5

Every part is a process of its own; a killed one gets SIGKILL as soon as it has evaluated something, and its command is
given again. What is compared is every dataset and attribute of both files, but when, where and with which commit they
began.

For docs/how-to/use-a-cluster.md.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import h5py
import numpy as np

TEXT = """scene = "reflex_planar"

[search]
strategy = "random"
candidates = {candidates}

[set]
duration = {duration}

[grid]
seed = {seeds}
"objective.target_speed" = [0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7]
"""
OF_NOW = {"began", "commit", "host"}
LINKS = {"DIMENSION_LIST", "REFERENCE_LIST"}  # places in the file, of dimension scales
COMMAND = (sys.executable, "-m", "warpmuscle")
POLL = 0.02  # s


def items(path: Path) -> Iterator[tuple[str, bytes]]:
    """Names and bytes of all datasets and attributes of a file, in the order of their names."""
    with h5py.File(path) as file:
        names: list[str] = []
        file.visit(names.append)
        for name in ["/", *sorted(names)]:
            item = file[name]
            for key in sorted(set(item.attrs) - OF_NOW - LINKS):
                yield f"{name}@{key}", _bytes(item.attrs[key])
            if isinstance(item, h5py.Dataset):
                yield name, _bytes(item[()])


def _bytes(value: object) -> bytes:
    array = np.asarray(value)
    return repr(array.tolist()).encode() if array.dtype.hasobject else array.tobytes()


def digest(path: Path) -> str:
    """A hash of all that a file holds."""
    total = hashlib.sha256()
    for name, content in items(path):
        total.update(name.encode() + b"\0" + content)
    return total.hexdigest()


def run(folder: Path, *arguments: str) -> None:
    """A command of warpmuscle on the CPU; raises where it fails."""
    done = subprocess.run([*COMMAND, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(arguments)} ended with {done.returncode}: {done.stderr[-300:]}")


def run_part(folder: Path, parts: int, threads: int, killed: set[int], number: int) -> int:
    """Run a part to its end, one that is to be killed twice; how many bytes its folder had when it was killed."""
    arguments = ["sweep", "many.toml", "--device", "cpu", "--threads", str(threads), "--part", f"{number}/{parts}"]
    left = 0
    if number in killed:
        own = folder / f"many.part-{number}-of-{parts}.sweep"
        with subprocess.Popen([*COMMAND, *arguments], cwd=folder, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL) as process:  # fmt: skip
            while process.poll() is None and not any(own.glob("*.h5")):
                time.sleep(POLL)
            process.send_signal(signal.SIGKILL)
        left = sum(path.stat().st_size for path in own.glob("*.h5"))
        if process.returncode != -signal.SIGKILL:
            raise RuntimeError(f"part {number} ended before it was killed")
    run(folder, *arguments)
    return left


def main() -> None:
    """Print what each step took, and whether both files are the same."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--candidates", type=int, default=1000)
    parser.add_argument("--parts", type=int, default=100)
    parser.add_argument("--kill", type=int, default=5)
    parser.add_argument("--duration", type=float, default=0.05)
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    chosen = parser.parse_args()
    seeds = list(range(1, chosen.runs // 10 + 1))
    text = TEXT.format(candidates=chosen.candidates, duration=chosen.duration, seeds=seeds)
    folders = [chosen.folder / name for name in ("whole", "parts")]
    for folder in folders:
        folder.mkdir(parents=True)
        (folder / "many.toml").write_text(text)
    whole, parts = folders
    step = chosen.parts // chosen.kill if chosen.kill else chosen.parts + 1
    killed = set(range(step, chosen.parts + 1, step))
    print(f"{len(seeds) * 10} runs of {chosen.candidates} candidates, {chosen.parts} parts, {len(killed)} killed")
    one = partial(run_part, parts, chosen.parts, 1, killed)

    def timed(name: str, work: partial[object]) -> None:
        begin = time.perf_counter()
        work()
        children = resource.getrusage(resource.RUSAGE_CHILDREN)
        print(f"{name}: {time.perf_counter() - begin:.1f} s; a process took {children.ru_maxrss / 1024:.0f} MB at most",
              flush=True)  # fmt: skip

    def all_parts() -> None:
        with ThreadPoolExecutor(chosen.processes) as pool:
            left = [size for size in pool.map(one, range(1, chosen.parts + 1)) if size]
        print(f"killed with {', '.join(f'{size / 1e6:.1f}' for size in left)} MB of results")

    timed("parts", partial(all_parts))
    timed("join", partial(run, parts, "join", "many.toml", "-o", "many.h5"))
    timed("one process", partial(run, whole, "sweep", "many.toml", "--device", "cpu", "--threads",
                                 str(chosen.processes), "-o", "many.h5"))  # fmt: skip
    sizes = [(folder / "many.h5").stat().st_size / 1e6 for folder in folders]
    same = digest(whole / "many.h5") == digest(parts / "many.h5")
    print(f"files of {sizes[0]:.1f} and {sizes[1]:.1f} MB hold {'the same' if same else 'NOT THE SAME'}")
    sys.exit(not same)


if __name__ == "__main__":
    main()
