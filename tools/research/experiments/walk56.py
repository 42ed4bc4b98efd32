"""All joints on 56 muscles (report, figs 16-17).

For docs/explanation/muscles.md.

python tools/research/experiments/walk56.py [--folder FOLDER]
"""

from pathlib import Path

from common import main

from walking import walk


def experiment(folder: Path) -> None:
    """The walk beside the same one on torques."""
    walk("walk56", "report, figs 16-17", folder)


if __name__ == "__main__":
    main(experiment)
