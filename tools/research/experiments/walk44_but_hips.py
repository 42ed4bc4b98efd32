"""All joints but the hips on muscles (report, fig. 17b).

For docs/explanation/muscles.md.

python tools/research/experiments/walk44_but_hips.py [--folder FOLDER]
"""

from pathlib import Path

from common import main

from walking import walk


def experiment(folder: Path) -> None:
    """The walk beside the same one on torques."""
    walk("walk44_but_hips", "report, fig. 17b", folder)


if __name__ == "__main__":
    main(experiment)
