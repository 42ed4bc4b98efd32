"""How many of 20 runs with everything at once a gait survives under draws that its judge does not use.

For docs/tutorials/learn.md.

python tools/research/held_out_draws.py gait2392_arms_by_policy.h5 --seeds 101 102 103
"""

import argparse

from warpmuscle.cli.walkers import walker_of
from warpmuscle.studies import hard_trials

DURATION = 10.0  # s, as the judge's


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", help="a scene, or a file of a search or of `learn`")
    parser.add_argument("--seeds", type=int, nargs="+", default=[101, 102, 103])
    parser.add_argument("--device", default="cpu")
    given = parser.parse_args()
    name, walker = walker_of([given.file], device=given.device)
    for seed in given.seeds:
        hard_trials.SEED = seed
        found = hard_trials.all_at_once(walker, DURATION)
        print(f"{name}, seed {seed}: {found.value:.0f} of 20, {found.note}", flush=True)


if __name__ == "__main__":
    main()
