"""Times both fits, as published and the better one, of all motions in some files.

Example: python tools/bench_throw.py throws/*.csv --threads 2
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from warpmuscle.formats import load
from warpmuscle.throw.job import Job, JobOptions


def main() -> None:
    """Print a table of stages, seconds, and what they came to."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path, help="motions, as `warpmuscle throw fit` takes them")
    parser.add_argument("--scene", default="throw", help="the arm")
    parser.add_argument("--number", type=int, help="of synergies")
    parser.add_argument("--device", help="cpu, cuda:0, ...")
    parser.add_argument("--threads", type=int, help="CPU threads")
    parser.add_argument("--only", choices=["published", "better"], help="one of the two fits")
    given = parser.parse_args()
    begin = time.perf_counter()
    options = JobOptions(count=given.number, device=given.device, threads=given.threads)
    job = Job(load(given.scene), given.files, options)
    prepared = time.perf_counter()
    job.follower.load()
    loaded = time.perf_counter()
    print(f"{len(job.motions)} motions of {job.motions.time[-1]:.3g} s on {given.device or 'cpu'}")
    print(f"reading and synergies {prepared - begin:6.2f} s, kernels {loaded - prepared:6.2f} s")
    total, started = 0.0, time.process_time()
    if given.only != "published":
        fitted = job.fit()
        total += fitted.stages[-1].seconds
        a, weights = fitted.agreement, job.follower.synergies.weights
        print(
            f"{job.count} synergies, VAF {job.follower.synergies.explained:.4f}, share of the largest muscle "
            f"{(weights.max(axis=0) / weights.sum(axis=0)).max():.2f}, {time.process_time() - started:.0f} s of CPU"
        )
        print(
            f"better fit            {fitted.stages[-1].seconds:6.2f} s, {sum(s.simulations for s in fitted.stages)} "
            f"simulations, all bars on {a.good().sum()} of {len(a.r2)}, held out {a.good()[job.held_out].sum()} of "
            f"{len(job.held_out)}; lowest r2 {a.r2.min():.5f}, velocity {a.velocity_r2.min():.4f}, hand "
            f"{100.0 * a.hand_error.max():.2f} cm, correlation {a.correlation.min():.3f}"
        )
    if given.only != "better":
        result = job.publish()
        total += result.stages[-1].seconds
        middle = ", ".join(f"{value:.3f}" for value in np.median(result.stages[-1].r2, axis=0))
        print(
            f"as published          {result.stages[-1].seconds:6.2f} s, {result.stages[-1].simulations} simulations, "
            f"median r2 at its end {middle}"
        )
    print(f"fits in all           {total:6.2f} s")


if __name__ == "__main__":
    main()
