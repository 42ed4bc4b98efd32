"""Sixteen leg muscles, six of them biarticular, and torques elsewhere (Wang 2012).

For docs/explanation/muscles.md.

python tools/research/experiments/wang2012.py [--folder FOLDER]
"""

from pathlib import Path

from common import main

from walking import walk


def experiment(folder: Path) -> None:
    """The walk beside the same one on torques."""
    walk("wang2012", "Wang 2012", folder)


if __name__ == "__main__":
    main(experiment)
