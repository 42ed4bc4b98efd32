"""Notebooks of the manual: scripts in docs/notebooks, whose cells begin with `# %%`, as .ipynb to download.

The site has them by the hook in `reference_pages`. `python tools/notebooks.py FOLDER` writes them instead.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

SCRIPTS = sorted((Path(__file__).parents[1] / "docs" / "notebooks").glob("*.py"))
MARK = "# %%"


def notebook(script: str) -> str:
    """A script in cells as a notebook without outputs."""
    cells = [cell(part) for part in f"\n{script}".split(f"\n{MARK}")[1:]]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 4}
    return json.dumps(whole, indent=1) + "\n"


def cell(part: str) -> dict[str, Any]:
    """A cell of what stands behind its mark: text if the mark says so."""
    head, _, text = part.partition("\n")
    if head.strip() == "[markdown]":
        lines = [line.removeprefix("#").removeprefix(" ") for line in text.strip().splitlines()]
        return {"cell_type": "markdown", "metadata": {}, "source": "\n".join(lines)}
    return {"cell_type": "code", "metadata": {}, "execution_count": None, "outputs": [], "source": text.strip()}


def notebooks() -> dict[str, str]:
    """All notebooks, by their paths in the site."""
    return {f"notebooks/{one.stem}.ipynb": notebook(one.read_text(encoding="utf-8")) for one in SCRIPTS}


if __name__ == "__main__":
    for path, text in notebooks().items():
        target = Path(sys.argv[1]) / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text)
