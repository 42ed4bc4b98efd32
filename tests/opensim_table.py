"""OpenSim's storage files and comma-separated ones as tests read them."""

from pathlib import Path

import numpy as np


def table(path: Path) -> tuple[dict[str, str], list[str], np.ndarray]:
    """Header, column names and rows of a file."""
    lines = path.read_text().splitlines()
    end = lines.index("endheader") if "endheader" in lines else -1
    header = dict(line.split("=") for line in lines[1:end] if line.count("=") == 1) if end > 0 else {}
    separator = "\t" if end > 0 else ","
    rows = np.array([[float(word) for word in line.split(separator)] for line in lines[end + 2 :]])
    return header, lines[end + 1].split(separator), rows
