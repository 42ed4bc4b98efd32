"""Notebooks of the manual run from an empty folder, and are notebooks."""

import json
import runpy
from importlib.util import find_spec
from pathlib import Path

import matplotlib
import pytest
from notebooks import SCRIPTS, notebook, notebooks

EXTRAS = {"learning": ("torch", "rsl_rl")}


def test_scripts_become_cells_and_say_what_they_need():
    cells = json.loads(notebook("# %% [markdown]\n# # Title\n# words\n\n# %%\na = 1\n\n# %%\na\n"))["cells"]
    assert [(one["cell_type"], one["source"]) for one in cells] == [
        ("markdown", "# Title\nwords"), ("code", "a = 1"), ("code", "a"),
    ]  # fmt: skip
    assert len(notebooks()) == 5
    assert all(len(text) < 5000 for text in notebooks().values())


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_notebook_runs(script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest):
    for name in EXTRAS.get(script.stem, ()):
        if find_spec(name) is None:
            pytest.skip(f"no {name}: pip install 'warpmuscle[learn]'")
    if script.stem == "your_model":  # which no other test runs
        request.getfixturevalue("unoptimized_test")
    monkeypatch.chdir(tmp_path)
    matplotlib.use("agg")
    cells = json.loads(notebook(script.read_text()))["cells"]
    code = tmp_path / "cells.py"
    code.write_text("\n".join(cell["source"] for cell in cells if cell["cell_type"] == "code"))
    runpy.run_path(str(code))
