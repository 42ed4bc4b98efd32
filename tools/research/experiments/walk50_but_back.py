"""All joints but the back on muscles (report, fig. 17c).

For docs/explanation/muscles.md.

python tools/research/experiments/walk50_but_back.py [--folder FOLDER]
"""

from pathlib import Path

from common import main

from walking import walk


def experiment(folder: Path) -> None:
    """The walk beside the same one on torques."""
    walk("walk50_but_back", "report, fig. 17c", folder)


if __name__ == "__main__":
    main(experiment)
