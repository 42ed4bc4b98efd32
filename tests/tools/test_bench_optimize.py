"""Where the wall time of an optimisation goes, as `tools/bench_optimize.py` finds out."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_the_parts_of_an_optimisation_add_up_to_its_wall_time(tmp_path: Path):
    arguments = "fwalk --search random --population 12 --generations 2 --duration 0.1 --device cpu --json bench.json"
    command = [sys.executable, str(ROOT / "tools/bench_optimize.py"), *arguments.split()]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, env=os.environ | {"COLUMNS": "120"})
    figures = json.loads((tmp_path / "bench.json").read_text())
    assert figures["candidates"] == 24
    parts = figures["seconds"]
    assert sum(parts.values()) == pytest.approx(figures["wall_s"])
    assert min(parts.values()) > 0.0
    assert {"simulation", "files", "replay of the best"} < set(parts)
