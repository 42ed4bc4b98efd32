"""From noise to a walk: wall time from the shell of `warpmuscle learn` for several seeds, and how the policies do.

For docs/benchmarks.md.

    python tools/research/learn_table.py walk56 --seeds 5 --until 90s --folder out [-- --option epochs=5]

Every policy is tried again with another seed of starts and noise: in as many bodies as learnt, from the task's own
starts, and from the scene's initial state.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

import msgspec

TRIED = 77_777  # seed of the starts in which policies are tried
HEADER = "seed  wall s  learning s  decisions  ended                     last   near   from the start"


def row_of(scene: str, seed: int, given: argparse.Namespace) -> dict[str, object]:
    """Learn with a seed, and try the policy."""
    from warpmuscle.formats import load
    from warpmuscle.learning.evaluation import evaluate
    from warpmuscle.learning.player import learned_in, task_of

    file = given.folder / f"seed{seed}.h5"
    command = ["learn", scene, "--seed", str(seed), "--until", given.until, "--target", str(given.target)]
    if given.device:
        command += ["--device", given.device]
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-m", "warpmuscle", *command, "-o", file, *given.options], check=True)
    wall = time.perf_counter() - begin
    learned = learned_in(file)
    task, curve = task_of(learned), learned.curve
    n = int(learned.options["instances"])
    variation = msgspec.structs.replace(task.variation, start_states=0)
    tried = evaluate(learned.policy, load(scene), n, given.device, task, TRIED)
    from_start = msgspec.structs.replace(task, variation=variation)
    started = evaluate(learned.policy, load(scene), n, given.device, from_start, TRIED)
    return {
        "seed": seed, "wall": wall, "learning": float(curve["wall_time"][-1]),
        "decisions": float(curve["decisions"][-1]), "ended": learned.ended,
        "tried": msgspec.to_builtins(tried), "from_start": msgspec.to_builtins(started),
        "curve": {name: values.tolist() for name, values in curve.items()},
    }  # fmt: skip


def main() -> None:
    """Print the table, and write it with the learning curves."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="?", default="walk56")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first", type=int, default=1, help="seed")
    parser.add_argument("--until", default="90s", help="after which a seed has failed")
    parser.add_argument("--target", type=float, default=0.95)
    parser.add_argument("--device", default=None)
    parser.add_argument("--folder", type=Path, default=Path("learn_table"))
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    given = parser.parse_args(sys.argv[1:split], argparse.Namespace(options=sys.argv[split + 1 :]))
    given.folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for seed in range(given.first, given.first + given.seeds):
        rows.append(row_of(given.scene, seed, given))
        (given.folder / "table.json").write_text(json.dumps(rows))
    print(HEADER)
    for r in rows:
        t, s = r["tried"], r["from_start"]
        print(f"{r['seed']:4d} {r['wall']:7.1f} {r['learning']:11.1f} {r['decisions'] / 1e6:8.1f} M  {r['ended']:24s} "
              f"{100 * t['completed']:5.1f}% {100 * t['arrived']:5.1f}%  {100 * s['arrived']:5.1f}% at "
              f"{s['speed']:.2f} m/s")  # fmt: skip


if __name__ == "__main__":
    main()
