"""Compiles what many test files use, before parallel workers start, on all cores: workers then find it in Warp's cache.

What a few files share or one needs is compiled by the worker that is first to need it.
"""

import os
import subprocess
import sys

import warp as wp

from warpmuscle.kernels import stages
from warpmuscle.kernels.contraction import RIGID
from warpmuscle.kernels.curves import LEE
from warpmuscle.kernels.hill_law import HILL
from warpmuscle.kernels.muscle_kind import MuscleKind
from warpmuscle.kernels.scratch import capacity_of
from warpmuscle.kernels.step import step_kernel

PULLING = MuscleKind(LEE, RIGID, HILL, pulls_at_hand=True, mixed=False, conditions=False)
STEPS = [(15, None), (15, PULLING), (9, None), (2, None)]  # bodies, one a size class, and muscles
MODULES = [lambda k=k: step_kernel(capacity_of(k[0]), 1, 1, k[1]).module for k in STEPS] + [
    lambda: stages.muscle_paths_of().module,
    lambda: wp.get_module(stages.__name__),
]


def settings() -> None:
    """Keep Warp quiet, and have it compile no derivatives of small kernels, which nothing here takes."""
    wp.config.log_level, wp.config.enable_backward = wp.LOG_WARNING, False
    wp.init()


def compile_all() -> None:
    """Compile what is not in the cache, in a process a core."""
    cores = min(len(os.sched_getaffinity(0)), len(MODULES))
    started = [subprocess.Popen([sys.executable, __file__, str(k), str(cores)]) for k in range(cores)]
    for process in started:
        if process.wait():
            raise SystemExit("kernels that tests share could not be compiled, see above")


if __name__ == "__main__":
    settings()
    for module in MODULES[int(sys.argv[1]) :: int(sys.argv[2])]:
        module().load("cpu", block_dim=1)  # as launches on a CPU do
